//! Strong damping, and contacts that stay closed for long: the results of explicit steps at the cost of the slow
//! motion.

use newtons_cradle::engine::{Chain, Engine, Results, Unrecorded, WorkCounters};
use newtons_cradle::model::{Inputs, Parameters};

use crate::runs::{assert_energy, cradle, energy, run, run_under, started, touching};

/// Damping at which two balls of 1 kg on a linear contact of the default stiffness just do not oscillate, N.s/m.
fn critical() -> f64 {
    2.0 * (1e10f64 / 2.0).sqrt()
}

/// The laws with dashpots.
const DASHPOTS: [&str; 2] = ["contact.dampingLaw=kelvinVoigt", "contact.dampingLaw=kelvinVoigtNoPull"];

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
    let damped = "x_start=-0.02 contact.damping=70710.67811865476";
    let mut chains = Vec::new();
    for (name, contacts) in [
        ("cubic", "contact.exponent=3"),
        ("exponent 2.3", "contact.exponent=2.3"),
        ("Hertz", "contact.model=hertz"),
        ("linear", ""),
    ] {
        for law in DASHPOTS {
            chains.push((name, format!("{damped} {contacts} {law} ball.massRatio=1,2,1.5,0.7,1")));
        }
    }
    for (name, losses) in [
        // Strong enough that it brings also such contacts to rest.
        ("Hunt-Crossley", "contact.exponent=3 contact.dampingLaw=huntCrossley contact.huntCrossley=1e4"),
        ("viscoelastic", "contact.exponent=1.5 contact.dampingLaw=viscoelastic contact.relaxationTime=1e-4"),
        ("viscoelastic", "contact.exponent=3 contact.dampingLaw=viscoelastic contact.relaxationTime=1e-4"),
    ] {
        chains.push((name, format!("x_start=-0.02 {losses}")));
    }
    let pendulums = "contact.model=hertz pendulum.lengthRatio=1,1.1,0.95,1,1.05 pendulum.drag=0.1";
    chains.push(("unequal pendulums", format!("{damped} {pendulums}")));
    chains.into_iter().map(|(name, text)| (name, cradle(5, &text))).collect()
}

/// Under constant inputs, and under some that are polynomials of the third degree over the whole run.
#[test]
fn stiff_implicit_steps_give_the_results_of_explicit_ones() {
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
fn stiff_pressed_chains_swing_as_one() {
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
fn stiff_damping_costs_little() {
    let work = |balls: usize, damping: f64, law: &str, dead_band: f64| -> WorkCounters {
        let text = format!("contact.damping={} {law} contact.deadBand={dead_band}", damping * critical());
        run(&cradle(balls, &text), 10.0).work()
    };
    // Contacts that cannot pull let the balls part again and again.
    for (balls, law, often) in [(5, DASHPOTS[0], 6), (13, DASHPOTS[0], 20), (5, DASHPOTS[1], 6), (13, DASHPOTS[1], 40)]
    {
        for dead_band in [0.0, 2.6e-6] {
            let undamped = work(balls, 0.0, law, dead_band);
            for factor in [1.0, 10.0, 100.0, 1000.0, 1e4, 1e6, 1e9] {
                let damped = work(balls, factor, law, dead_band);
                // Of a series each contact is counted, of an impact of two and of natural modes one evaluation.
                let cheap =
                    damped.evaluations <= 2 * often * undamped.evaluations && damped.steps <= often * undamped.steps;
                assert!(cheap, "{balls} balls, {law}, {factor}, {dead_band} m: {damped:?}, undamped {undamped:?}");
            }
        }
    }
}

/// Contacts that overlap by less than rounding, and neither press nor part, must not stop the time: whether there are
/// any depends on the last digits.
#[test]
fn stiff_damping_is_not_stopped_by_last_digits() {
    for k in 0..40 {
        let gravity = 9.81 * (1.0 + f64::from(k) * 1e-14);
        let damping = 1e6 * critical();
        let text = format!("gravity={gravity} contact.deadBand=0 contact.damping={damping} {}", DASHPOTS[1]);
        let steps = run(&cradle(13, &text), 10.0).work().steps;
        assert!(steps < 20_000, "{gravity}: {steps}");
    }
}

#[test]
fn stiff_damping_without_limit_makes_the_balls_swing_as_one() {
    for damping in [1e14, 1e16, 1e18, 1e20, 1e25] {
        for law in DASHPOTS {
            let engine = run(&cradle(5, &format!("contact.damping={damping} {law}")), 3.0);
            // All momentum is kept; the balls are apart by no more than the dead bands that they have closed.
            let together = -0.04 * libm::cos(3.0 * (9.81 / 1.962_f64).sqrt());
            let apart = (0..5).map(|i| (engine.x(i) - together).abs()).fold(0.0, f64::max);
            assert!(apart < 1.1e-5, "{law}, {damping:e} N.s/m: {apart:e} m");
            assert!(engine.work().steps < 50, "{law}, {damping:e} N.s/m: {:?}", engine.work());
        }
    }
}

#[test]
fn settled_balls_cause_no_events() {
    // Without a dead band the balls end up in touch, swinging side by side.
    for law in DASHPOTS {
        for factor in [3.0, 10.0, 100.0, 1000.0] {
            let damping = factor * critical();
            let engine = run(&cradle(5, &format!("contact.damping={damping} {law} contact.deadBand=0")), 100.0);
            assert!(engine.work().events < 500, "{law}, {factor} times critical: {:?}", engine.work());
        }
    }
}

/// A cradle that Hunt-Crossley contacts bring to rest costs less and less: restitution 0.95 at the first impact.
#[test]
fn settled_cradle_costs_no_more_than_a_swinging_one() {
    let mut engine = started(&cradle(5, "contact.dampingLaw=huntCrossley contact.huntCrossley=0.352970509"));
    let work = [100.0, 500.0, 600.0].map(|time| {
        engine.advance(time, &mut Vec::new()).unwrap();
        engine.work()
    });
    let (first, last) = (work[0], [work[2].steps - work[1].steps, work[2].evaluations - work[1].evaluations]);
    assert!(2 * last[0] <= 3 * first.steps && 2 * last[1] <= 3 * first.evaluations, "{first:?}, then {last:?}");
}

/// Fronts of waves too weak to matter, and motions that have decayed to what was rounding while the balls swung.
#[test]
fn settled_waves_and_motions_cost_little() {
    for (name, balls, settings) in [
        ("together", 5, "x_start[2]=-0.1 contact.exponent=3 contact.damping=141421356.23730952"),
        ("settled", 4, "contact.exponent=3 contact.stiffness=2.4e11 contact.damping=1.83e6 pendulum.drag=3"),
        (
            "creeping",
            5,
            "contact.exponent=5 contact.stiffness=1.49e11 contact.damping=8.48e7 contact.gap=0,1e-6,1e-6,-1e-7",
        ),
        (
            "unequal",
            5,
            "contact.exponent=5 contact.stiffness=1.31e11 contact.damping=2.14e5 contact.gap=0,1e-6,-1e-7,-1e-7 \
             ball.massRatio=1.3,2,1.3,0.5,0.5",
        ),
    ] {
        let engine = run(&touching(balls, &format!("x_start[1]=-0.1 {} {settings}", DASHPOTS[1])), 20.0);
        let work = engine.work();
        assert!(work.steps < 5000 && work.events < 500, "{name}: {work:?}");
        assert_energy(&engine, 1e-13, name);
    }
}

/// Damping far faster than the springs: the series are in its unit of time, and contacts that close from rest stay
/// closed.
#[test]
fn stiff_damping_on_slow_springs_keeps_the_energy_balance() {
    for (balls, settings) in [
        (
            4,
            "contact.exponent=10 contact.stiffness=857307509290.0165 contact.damping=362481197.9354008 \
             contact.overlapRef=1 contact.deadBand=1e-9",
        ),
        (
            8,
            "x_start[2]=-0.1 x_start[3]=-0.1 contact.exponent=2.5 contact.stiffness=22155.981572013134 \
             contact.damping=12870.924419263727 pendulum.drag=0.1 ball.massRatio=2,0.5,1,2,0.5,1.3,1,2",
        ),
        (4, "contact.exponent=10 contact.stiffness=1e6 contact.dampingLaw=huntCrossley contact.huntCrossley=1e9"),
        (4, "contact.exponent=10 contact.stiffness=1e6 contact.dampingLaw=viscoelastic contact.relaxationTime=1e3"),
    ] {
        assert_energy(&run(&touching(balls, &format!("x_start[1]=-0.1 {settings}")), 5.0), 1e-13, settings);
    }
}

/// Undamped balls that forces press together rattle for ever, in a few steps for each onset or release, and no energy
/// is lost: among them onsets and releases that follow each other by nanoseconds, which leave a branch point just
/// beside a step.
#[test]
fn rattling_balls_cost_little_and_keep_their_energy() {
    for (exponent, time, most) in [(1.5, 0.02, 5.0), (2.3, 0.02, 5.0), (3.0, 0.1, 3.0), (10.0, 0.1, 6.0)] {
        for (unequal, press) in [(false, 19.0), (true, 19.0), (false, 20.0), (true, 20.0)] {
            let unequal = if unequal { "ball.massRatio[4]=2 pendulum.lengthRatio[6]=0.9" } else { "" };
            let parameters = touching(13, &format!("contact.exponent={exponent} {unequal}"));
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
fn rattling_balls_keep_their_energy_at_all_times() {
    for exponent in [1.7, 10.0] {
        let parameters = touching(5, &format!("contact.exponent={exponent}"));
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
fn clipped_contacts_overlapping_deeply_at_the_start() {
    let cradle = cradle(
        6,
        "contact.exponent=2.5 contact.stiffness=1e6 contact.dampingLaw=huntCrossley \
         contact.huntCrossley=0.9883612259175566 \
         x_start=-0.1415917421525615,-0.1,-0.1,-0.11378582961873326,0,0.07",
    );
    let engine = run(&cradle, 0.71);
    let residual = engine.energy_residual() / engine.dissipated_energy();
    let work = engine.work();
    assert!(residual.abs() < 1e-12 && work.events < 3000, "{residual:e} {work:?}");
}

/// A wave through many balls is dense with events, but over soon.
#[test]
fn wave_through_many_balls_is_not_hopeless() {
    let engine = run(&touching(5000, "contact.stiffness=1e12 gravity=0 v_start[1]=1"), 1000.0);
    assert!(engine.pulses(4998) > 0 && engine.work().events < 100_000, "{:?}", engine.work());
}

/// Free balls whose drag ends every motion sooner than the clock can tell, under a force that grows, and a short
/// pendulum that creeps back beside a long one: looking for onsets gets on.
#[test]
fn drag_without_limit_costs_little() {
    let short = "pendulum.drag=1e12 pendulum.lengthRatio=1,1e-12 x_start=-1e-3,0";
    for (balls, text, time) in [(3, "gravity=0 pendulum.drag=1.7976931348623157e308", 1e-5), (2, short, 1e4)] {
        let (inputs, mut rate) = (Inputs::zero(balls), Inputs::zero(balls));
        let mut engine = run(&cradle(balls, text), 1e-5);
        rate.force[0] = 1e-3 / time;
        engine.hold(&inputs, &[rate]).unwrap();
        engine.advance_within(2.0 * time, 1_000_000, &mut Vec::new()).unwrap();
        assert!(engine.time() == 2.0 * time && engine.work().events == 0, "{}", engine.time());
    }
}

/// Waves meet in touching balls with strong dashpots, some of which are off by rounding, or a little more; and one goes
/// through balls that move together, but for rounding.
#[test]
fn stiff_dashpots_between_balls_that_hardly_touch() {
    let patterns = [[1, -2, 0, 2, -1, 1, 0, -2, 2], [-1, 1, 2, -2, -2, 0, 1, 2, -1], [0, 0, 1, -1, 2, 1, -2, 0, 1]];
    for exponent in [1.5, 2.0, 3.0] {
        let row = touching(9, &format!("contact.stiffness=1e8 contact.damping=1e5 contact.exponent={exponent}"));
        let meeting = [0.0, 1e-17, 1e-13, 1e-9].map(|shift| {
            let mut parameters = row.clone();
            (parameters.x_start[0], parameters.x_start[4]) = (-shift, shift);
            (parameters.v_start[0], parameters.v_start[8]) = (1.0, -1.0);
            (parameters.mass_ratio[3], parameters.mass_ratio[5]) = (1.0 + 1e-9, 1.0 - 1e-6);
            parameters
        });
        let together = patterns.map(|pattern| {
            let mut parameters = Parameters { gravity: 0.0, ..row.clone() };
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
fn stiff_dashpots_let_pressed_rows_settle() {
    for (balls, press, lifted) in [(5, 1e-5, 0.0), (5, 9.41, 6.3e-4), (8, 0.0331, 4e-7)] {
        for factor in [2.0, 27.0, 6.1e4] {
            let damping = factor * critical();
            let row = touching(balls, &format!("x_start[1]={} contact.damping={damping}", -lifted));
            let work = run_under(&row, &pressing(balls, press), 600.0).work();
            assert!(work.steps < 1000, "{balls}, {press} N, {factor}: {work:?}");
        }
    }
}

/// Two balls are pressed together in equilibrium, a third one swings in: nothing changes up to the end of the step but
/// the end.
#[test]
fn pressed_pair_in_equilibrium_is_struck_by_a_third_ball() {
    let (stiffness, press) = (1e3, 1e-3);
    let pull = 20.0 / 0.2;
    // Half the overlap at rest x: k (d / d_ref)^(p - 1) d = pull x for d = press - 2 x.
    let excess = |x: f64| stiffness * (press - 2.0 * x).powi(3) / 1e-6 - pull * x;
    let (mut low, mut high) = (0.0, 0.5 * press);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if excess(middle) > 0.0 { low = middle } else { high = middle }
    }
    for off in (0..60).map(|k| 1e-13 * 1.37_f64.powi(k)) {
        let mut parameters = cradle(
            3,
            "contact.exponent=3 contact.stiffness=1e3 contact.overlapRef=1e-3 contact.deadBand=0 \
             contact.gap=-1e-3,1e-3 gravity=20 pendulum.length=0.2 pendulum.drag=1",
        );
        parameters.x_start = vec![-low, low + off, 0.05];
        let engine = run(&parameters, 0.6);
        let residual = engine.energy_residual() / engine.total_energy();
        assert!(residual.abs() < 2e-14, "{off}: {residual}");
    }
}
