//! Strong damping, and contacts that stay closed for long: the results of explicit steps at the cost of the slow
//! motion.

use newtons_cradle::engine::{Chain, Engine, Results, Unrecorded, WorkCounters};
use newtons_cradle::model::{ContactModel, DampingLaw, Inputs, Parameters};

use crate::runs::{assert_energy, energy, run, run_under, started, touching};

/// Damping at which two balls of 1 kg on a linear contact of the default stiffness just do not oscillate, N.s/m.
fn critical() -> f64 {
    2.0 * (1e10f64 / 2.0).sqrt()
}

/// Forces of `press` (N) that hold a row of balls together.
fn pressing(balls: usize, press: f64) -> Inputs {
    let mut inputs = Inputs::zero(balls);
    (inputs.force[0], inputs.force[balls - 1]) = (press, -press);
    inputs
}

/// A run under inputs with these derivatives at its start, by explicit steps only: inputs that are set anew time and
/// again, to what they are, never let the contacts come to rest.
fn followed(parameters: &Parameters, inputs: &Inputs, derivatives: &[Inputs], time: f64) -> Engine {
    let mut engine = Engine::new(parameters, inputs, 0.0).unwrap();
    let steps = (time / 1e-4).round() as u32;
    for k in 0..steps {
        let t = engine.time();
        let later = |order: usize| derivatives[order].continued(&derivatives[order + 1..], t);
        let rates: Vec<Inputs> = (0..derivatives.len()).map(later).collect();
        engine.hold(&inputs.continued(derivatives, t), &rates).unwrap();
        engine.advance(time * f64::from(k + 1) / f64::from(steps), &mut Vec::new()).unwrap();
    }
    engine
}

/// Checks that two runs of five balls have come to the same, by implicit and by explicit steps.
fn assert_same(name: &str, implicit: &Engine, explicit: &Engine) {
    let steps = |engine: &Engine| engine.work().steps;
    // Steps of Gauss collocation are long: explicit ones of Hertz contacts are fewer than those of series.
    let least = if name == "Hertz" { 2 } else { 3 };
    assert!(steps(explicit) > least * steps(implicit), "{name}: {} {}", steps(explicit), steps(implicit));
    for i in 0..5 {
        let (x, v) = (implicit.x(i) - explicit.x(i), implicit.v(i) - explicit.v(i));
        assert!(x.abs() < 1e-14 && v.abs() < 1e-13, "{name}, ball {}: {x:e} m, {v:e} m/s", i + 1);
    }
    for i in 0..4 {
        let force = implicit.force(i) / explicit.force(i) - 1.0;
        assert!(force.abs() < 1e-10, "{name}, contact {}: the force is off by {force:e}", i + 1);
    }
}

/// Five balls that swing by 0.02 m, nonlinear or unequal; only the linear ones of equal pendulums have natural modes.
fn chains() -> Vec<(&'static str, Parameters)> {
    let equal = Parameters { x_start: vec![-0.02; 5], damping: 0.5 * critical(), ..Parameters::default_for(5) };
    let unequal = Parameters { mass_ratio: vec![1.0, 2.0, 1.5, 0.7, 1.0], ..equal.clone() };
    let mut chains = Vec::new();
    for (name, contact_model, exponent) in [
        ("cubic", ContactModel::PowerLaw, 3.0),
        ("exponent 2.3", ContactModel::PowerLaw, 2.3),
        ("Hertz", ContactModel::Hertz, 1.0),
        ("linear", ContactModel::PowerLaw, 1.0),
    ] {
        for damping_law in [DampingLaw::KelvinVoigt, DampingLaw::KelvinVoigtNoPull] {
            chains.push((name, Parameters { contact_model, exponent, damping_law, ..unequal.clone() }));
        }
    }
    // Strong enough that it brings also such contacts to rest.
    let (damping_law, hunt_crossley) = (DampingLaw::HuntCrossley, 1e4);
    let no_dashpots = Parameters { damping: 0.0, exponent: 3.0, ..equal.clone() };
    chains.push(("Hunt-Crossley", Parameters { damping_law, hunt_crossley, ..no_dashpots.clone() }));
    let (damping_law, relaxation_time) = (DampingLaw::Viscoelastic, 1e-4);
    for exponent in [1.5, 3.0] {
        chains.push(("viscoelastic", Parameters { damping_law, relaxation_time, exponent, ..no_dashpots.clone() }));
    }
    let (contact_model, length_ratio) = (ContactModel::Hertz, vec![1.0, 1.1, 0.95, 1.0, 1.05]);
    chains.push(("unequal pendulums", Parameters { contact_model, length_ratio, drag: 0.1, ..equal }));
    chains
}

/// Under constant inputs, and under some that are polynomials of the third degree over the whole run.
#[test]
fn implicit_steps_give_the_results_of_explicit_ones() {
    let change = |at_the_ends: f64, support: f64| {
        let force = vec![at_the_ends, -0.3 * at_the_ends, 0.1, 0.2 * at_the_ends, -at_the_ends];
        Inputs { force, support_acceleration: support }
    };
    let changing = [change(50.0, 1.0), change(-1e3, 20.0), change(1e4, -300.0)];
    let inputs = pressing(5, 10.0);
    for (name, parameters) in chains() {
        for derivatives in [&[Inputs::zero(5)][..], &changing] {
            let mut implicit = Engine::new(&parameters, &inputs, 0.0).unwrap();
            implicit.hold(&inputs, derivatives).unwrap();
            implicit.advance(0.1, &mut Vec::new()).unwrap();
            assert_same(name, &implicit, &followed(&parameters, &inputs, derivatives, 0.1));
        }
    }
}

#[test]
fn pressed_chains_swing_as_one() {
    for (name, parameters) in chains().into_iter().filter(|(name, _)| *name != "unequal pendulums") {
        let engine = run_under(&parameters, &pressing(5, 10.0), 100.0);
        let swing = -0.02 * libm::cos((9.81f64 / 1.962).sqrt() * 100.0);
        for i in 0..5 {
            // But for the dead bands, which the forces close.
            assert!((engine.x(i) - swing).abs() < 2e-5, "{name}: ball {} at {} m, not {swing}", i + 1, engine.x(i));
        }
        // Every ball is accelerated as the whole.
        let mut force = 10.0;
        for i in 0..4 {
            let mass = parameters.mass_ratio[i];
            force -= mass * (engine.a(i) + 5.0 * engine.x(i));
            let off = engine.force(i) / force - 1.0;
            assert!(off.abs() < 1e-11, "{name}, contact {}: {off:e}", i + 1);
        }
        assert_energy(&engine, 1e-12, name);
        assert!(engine.work().steps < 5000, "{name}: {} steps", engine.work().steps);
    }
}

#[test]
fn strong_damping_costs_little() {
    let work = |balls: usize, damping: f64, law: DampingLaw, dead_band: f64| -> WorkCounters {
        let mut parameters = Parameters::default_for(balls);
        (parameters.damping, parameters.damping_law, parameters.dead_band) = (damping * critical(), law, dead_band);
        run(&parameters, 10.0).work()
    };
    // Contacts that cannot pull let the balls part again and again.
    for (balls, law, often) in [
        (5, DampingLaw::KelvinVoigt, 6),
        (13, DampingLaw::KelvinVoigt, 20),
        (5, DampingLaw::KelvinVoigtNoPull, 6),
        (13, DampingLaw::KelvinVoigtNoPull, 40),
    ] {
        for dead_band in [0.0, 2.6e-6] {
            let undamped = work(balls, 0.0, law, dead_band);
            for factor in [1.0, 10.0, 100.0, 1000.0, 1e4, 1e6, 1e9] {
                let damped = work(balls, factor, law, dead_band);
                // Of a series each contact is counted, of an impact of two and of natural modes one evaluation.
                let cheap =
                    damped.evaluations <= 2 * often * undamped.evaluations && damped.steps <= often * undamped.steps;
                assert!(cheap, "{balls} balls, {law:?}, {factor}, {dead_band} m: {damped:?}, undamped {undamped:?}");
            }
        }
    }
}

#[test]
fn damping_beyond_measure_makes_the_balls_swing_as_one() {
    for damping in [1e14, 1e16, 1e18, 1e20, 1e25] {
        for law in [DampingLaw::KelvinVoigt, DampingLaw::KelvinVoigtNoPull] {
            let parameters = Parameters { damping, damping_law: law, ..Parameters::default_for(5) };
            let engine = run(&parameters, 3.0);
            // All momentum is kept; the balls are apart by no more than the dead bands that they have closed.
            let together = -0.04 * libm::cos(3.0 * (9.81 / 1.962_f64).sqrt());
            let apart = (0..5).map(|i| (engine.x(i) - together).abs()).fold(0.0, f64::max);
            assert!(apart < 1.1e-5, "{law:?}, {damping:e} N.s/m: {apart:e} m");
            assert!(engine.work().steps < 50, "{law:?}, {damping:e} N.s/m: {:?}", engine.work());
        }
    }
}

#[test]
fn balls_at_rest_against_each_other_cause_no_events() {
    // Without a dead band the balls end up in touch, swinging side by side.
    for law in [DampingLaw::KelvinVoigt, DampingLaw::KelvinVoigtNoPull] {
        for factor in [3.0, 10.0, 100.0, 1000.0] {
            let mut parameters = Parameters::default_for(5);
            (parameters.damping, parameters.damping_law, parameters.dead_band) = (factor * critical(), law, 0.0);
            let engine = run(&parameters, 100.0);
            assert!(engine.work().events < 500, "{law:?}, {factor} times critical: {:?}", engine.work());
        }
    }
}

/// A cradle that Hunt-Crossley contacts bring to rest costs less and less: restitution 0.95 at the first impact.
#[test]
fn a_settled_cradle_costs_no_more_than_a_swinging_one() {
    let mut parameters = Parameters::default_for(5);
    parameters.x_start[1] = -0.1;
    (parameters.damping_law, parameters.hunt_crossley) = (DampingLaw::HuntCrossley, 0.352_970_509);
    let mut engine = started(&parameters);
    let work = [100.0, 500.0, 600.0].map(|time| {
        engine.advance(time, &mut Vec::new()).unwrap();
        engine.work()
    });
    let (first, last) = (work[0], [work[2].steps - work[1].steps, work[2].evaluations - work[1].evaluations]);
    assert!(2 * last[0] <= 3 * first.steps && 2 * last[1] <= 3 * first.evaluations, "{first:?}, then {last:?}");
}

/// `balls` balls in touch, the first `lifted` of them lifted by 0.1 m.
fn cradle(balls: usize, lifted: usize, exponent: f64, stiffness: f64, damping: f64) -> Parameters {
    let mut parameters = Parameters { exponent, stiffness, damping, ..touching(balls) };
    parameters.x_start[..lifted].fill(-0.1);
    parameters
}

/// Fronts of waves too weak to matter, and motions that have decayed to what was rounding while the balls swung.
#[test]
fn what_hardly_moves_costs_little() {
    let together = cradle(5, 2, 3.0, 1e10, 1000.0 * critical());
    let mut settled = cradle(4, 1, 3.0, 2.4e11, 1.83e6);
    settled.drag = 3.0;
    let mut creeping = cradle(5, 1, 5.0, 1.49e11, 8.48e7);
    creeping.gap = vec![0.0, 1e-6, 1e-6, -1e-7];
    let mut unequal = cradle(5, 1, 5.0, 1.31e11, 2.14e5);
    (unequal.mass_ratio, unequal.gap) = (vec![1.3, 2.0, 1.3, 0.5, 0.5], vec![0.0, 1e-6, -1e-7, -1e-7]);
    for (name, mut parameters) in
        [("together", together), ("settled", settled), ("creeping", creeping), ("unequal", unequal)]
    {
        parameters.damping_law = DampingLaw::KelvinVoigtNoPull;
        let engine = run(&parameters, 20.0);
        let work = engine.work();
        assert!(work.steps < 5000 && work.events < 500, "{name}: {work:?}");
        assert_energy(&engine, 1e-13, name);
    }
}

/// Damping far faster than the springs: the series are in its unit of time, and contacts that close from rest stay
/// closed.
#[test]
fn energy_of_fast_damping_on_slow_springs() {
    let mut steep = cradle(4, 1, 10.0, 857307509290.0165, 362481197.9354008);
    (steep.overlap_ref, steep.dead_band) = (1.0, 1e-9);
    let mut unequal = cradle(8, 3, 2.5, 22155.981572013134, 12870.924419263727);
    (unequal.overlap_ref, unequal.drag) = (1e-6, 0.1);
    unequal.mass_ratio = vec![2.0, 0.5, 1.0, 2.0, 0.5, 1.3, 1.0, 2.0];
    let mut lossy = cradle(4, 1, 10.0, 1e6, 0.0);
    (lossy.damping_law, lossy.hunt_crossley, lossy.overlap_ref) = (DampingLaw::HuntCrossley, 1e9, 1e-6);
    let mut relaxing = cradle(4, 1, 10.0, 1e6, 0.0);
    (relaxing.damping_law, relaxing.relaxation_time) = (DampingLaw::Viscoelastic, 1e3);
    let all = [("Hunt-Crossley", lossy), ("steep", steep), ("unequal", unequal), ("viscoelastic", relaxing)];
    for (name, parameters) in all {
        assert_energy(&run(&parameters, 5.0), 1e-13, name);
    }
}

/// Undamped balls that forces press together rattle for ever, in a few steps for each onset or release, and no energy
/// is lost: among them onsets and releases that follow each other by nanoseconds, which leave a branch point just
/// beside a step.
#[test]
fn balls_that_rattle() {
    for (exponent, time, most) in [(1.5, 0.02, 5.0), (2.3, 0.02, 5.0), (3.0, 0.1, 3.0), (10.0, 0.1, 6.0)] {
        for (unequal, press) in [(false, 19.0), (true, 19.0), (false, 20.0), (true, 20.0)] {
            let mut parameters = Parameters { exponent, ..touching(13) };
            if unequal {
                (parameters.mass_ratio[3], parameters.length_ratio[5]) = (2.0, 0.9);
            }
            let engine = run_under(&parameters, &pressing(13, press), time);
            let work = engine.work();
            assert!((work.steps as f64) < most * work.events as f64, "p = {exponent}, {unequal}: {work:?}");
            assert_energy(&engine, 5e-14, &format!("p = {exponent}, {unequal}, {press} N"));
        }
    }
}

/// At no time is more energy missing than a small part of the most that there has been; on steep contacts most of it
/// comes and goes. The other exponent is not a polynomial's for any stretching of the time.
#[test]
fn balls_that_rattle_keep_their_energy_at_all_times() {
    for exponent in [1.7, 10.0] {
        let parameters = Parameters { exponent, ..touching(5) };
        for press in (5..=60).step_by(5).map(f64::from) {
            let mut engine = Engine::new(&parameters, &pressing(5, press), 0.0).unwrap();
            let (mut missing, mut largest) = (0.0_f64, 0.0_f64);
            for k in 1..=1000 {
                engine.advance(1e-4 * f64::from(k), &mut Unrecorded).unwrap();
                (missing, largest) = (missing.max(engine.energy_residual().abs()), largest.max(energy(&engine)));
            }
            assert!(missing < 3e-14 * largest, "p = {exponent}, {press} N: {missing:e} of {largest:e} J");
        }
    }
}

/// Two contacts that overlap deeply at the start, with forces that are clipped at once: the sign of a force changes
/// before the first point at which it is evaluated, or after the last.
#[test]
fn deep_overlaps_at_the_start_of_lossy_contacts() {
    let mut parameters = Parameters::default_for(6);
    (parameters.exponent, parameters.stiffness) = (2.5, 1e6);
    (parameters.damping_law, parameters.hunt_crossley) = (DampingLaw::HuntCrossley, 0.9883612259175566);
    parameters.x_start = vec![-0.1415917421525615, -0.1, -0.1, -0.11378582961873326, 0.0, 0.07];
    let engine = run(&parameters, 0.71);
    let residual = engine.energy_residual() / engine.dissipated_energy();
    let work = engine.work();
    assert!(residual.abs() < 1e-12 && work.events < 3000, "{residual:e} {work:?}");
}

/// A wave through many balls is dense with events, but over soon.
#[test]
fn a_wave_through_many_balls_is_not_hopeless() {
    let mut parameters = cradle(5000, 0, 1.0, 1e12, 0.0);
    (parameters.gravity, parameters.v_start[0]) = (0.0, 1.0);
    let engine = run(&parameters, 1000.0);
    assert!(engine.pulses(4998) > 0 && engine.work().events < 100_000, "{:?}", engine.work());
}

#[test]
fn a_hopeless_step_ends_in_an_error() {
    let mut parameters = Parameters::default_for(2);
    parameters.gravity = 1e308;
    let mut engine = started(&parameters);
    let error = engine.advance(1.0, &mut Vec::new()).unwrap_err();
    assert!(error.to_string().contains("too busy to reach the end of the step"), "{error}");
}

/// Free balls whose drag ends every motion sooner than the clock can tell, under a force that grows, and a short
/// pendulum that creeps back beside a long one: looking for onsets gets on.
#[test]
fn drag_beyond_all_measure_costs_little() {
    let free = Parameters { gravity: 0.0, drag: f64::MAX, ..Parameters::default_for(3) };
    let (length_ratio, x_start) = (vec![1.0, 1e-12], vec![-1e-3, 0.0]);
    let short = Parameters { drag: 1e12, length_ratio, x_start, ..Parameters::default_for(2) };
    for (parameters, time) in [(free, 1e-5), (short, 1e4)] {
        let (inputs, mut rate) = (Inputs::zero(parameters.balls()), Inputs::zero(parameters.balls()));
        let mut engine = run_under(&parameters, &inputs, 1e-5);
        rate.force[0] = 1e-3 / time;
        engine.hold(&inputs, &[rate]).unwrap();
        engine.advance_within(2.0 * time, 1_000_000, &mut Vec::new()).unwrap();
        assert!(engine.time() == 2.0 * time && engine.work().events == 0, "{}", engine.time());
    }
}

/// Waves meet in touching balls with strong dashpots, some of which are off by rounding, or a little more; and one goes
/// through balls that move together, but for rounding.
#[test]
fn strong_dashpots_between_balls_that_hardly_touch() {
    let patterns = [[1, -2, 0, 2, -1, 1, 0, -2, 2], [-1, 1, 2, -2, -2, 0, 1, 2, -1], [0, 0, 1, -1, 2, 1, -2, 0, 1]];
    for exponent in [1.5, 2.0, 3.0] {
        let touching = Parameters { stiffness: 1e8, damping: 1e5, exponent, ..touching(9) };
        let meeting = [0.0, 1e-17, 1e-13, 1e-9].map(|shift| {
            let mut parameters = touching.clone();
            (parameters.x_start[0], parameters.x_start[4]) = (-shift, shift);
            (parameters.v_start[0], parameters.v_start[8]) = (1.0, -1.0);
            (parameters.mass_ratio[3], parameters.mass_ratio[5]) = (1.0 + 1e-9, 1.0 - 1e-6);
            parameters
        });
        let together = patterns.map(|pattern| {
            let mut parameters = Parameters { gravity: 0.0, ..touching.clone() };
            parameters.v_start = pattern.map(|ulps| 0.3 + f64::from(ulps) * 2.0_f64.powi(-54)).to_vec();
            parameters.v_start[0] += 1.0;
            parameters
        });
        for parameters in meeting.iter().chain(&together) {
            assert_energy(&run(parameters, 0.05), 5e-14, &format!("{parameters:?}"));
        }
    }
}

/// Rows in touch whose ends are pressed settle under strong dashpots: what rounding leaves of forces that have died out
/// opens and closes no contact.
#[test]
fn pressed_rows_settle_under_strong_dashpots() {
    for (balls, press, lifted) in [(5, 1e-5, 0.0), (5, 9.41, 6.3e-4), (8, 0.0331, 4e-7)] {
        for factor in [2.0, 27.0, 6.1e4] {
            let damping = factor * critical();
            let mut parameters = Parameters { damping, ..touching(balls) };
            parameters.x_start[0] = -lifted;
            let work = run_under(&parameters, &pressing(balls, press), 600.0).work();
            assert!(work.steps < 1000, "{balls}, {press} N, {factor}: {work:?}");
        }
    }
}

/// Two balls are pressed together in equilibrium, a third one swings in: nothing changes up to the end of the step but
/// the end.
#[test]
fn a_ball_swings_against_balls_in_equilibrium() {
    let (stiffness, exponent, press) = (1e3, 3.0, 1e-3);
    let pull = 20.0 / 0.2;
    // Half the overlap at rest x: k (d / d_ref)^(p - 1) d = pull x for d = press - 2 x.
    let excess = |x: f64| stiffness * (press - 2.0 * x).powi(3) / 1e-6 - pull * x;
    let (mut low, mut high) = (0.0, 0.5 * press);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if excess(middle) > 0.0 { low = middle } else { high = middle }
    }
    for off in (0..60).map(|k| 1e-13 * 1.37_f64.powi(k)) {
        let mut parameters =
            Parameters { exponent, stiffness, dead_band: 0.0, drag: 1.0, ..Parameters::default_for(3) };
        (parameters.gravity, parameters.length, parameters.overlap_ref) = (20.0, 0.2, 1e-3);
        parameters.gap = vec![-press, press];
        (parameters.x_start, parameters.v_start) = (vec![-low, low + off, 0.05], vec![0.0; 3]);
        let cradle = run(&parameters, 0.6);
        let residual = cradle.energy_residual() / cradle.total_energy();
        assert!(residual.abs() < 2e-14, "{off}: {residual}");
    }
}
