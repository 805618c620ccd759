//! The methods that integrate the whole chain, next to the event-driven engine and to themselves.

use newtons_cradle::engine::{EngineError, Next, Pulse, Simulation};
use newtons_cradle::model::{ContactModel, DampingLaw, Inputs, Parameters, SolverMethod};

/// Method, tolerance and step, and how far from the engine's the results of a second may be, in units of their scale.
/// It is far more than the tolerance because balls that come to rest on each other bounce dozens of times and every
/// bounce magnifies errors.
const METHODS: [(SolverMethod, f64, f64, f64); 3] = [
    (SolverMethod::Adams, 1e-13, 1e-6, 1e-4),
    (SolverMethod::Bdf, 1e-13, 1e-6, 1e-4),
    (SolverMethod::Rk4, 1e-12, 2e-6, 1e-3),
];

/// Scale of the times, s: `adams` and `bdf` then agree to a hundredth of a contact of [`lossy`], which lasts 2 ms.
const TIME: f64 = 0.2;

/// Four unequal balls with losses, drag and gaps, and contacts so soft that impacts last 2 ms.
fn lossy(model: ContactModel, law: DampingLaw) -> Parameters {
    let mut p = Parameters::default_for(4);
    p.mass_ratio = vec![1.0, 0.8, 1.3, 0.9];
    p.length_ratio = vec![1.0, 1.1, 0.95, 1.02];
    p.stiffness_ratio = vec![1.0, 2.0, 0.5];
    p.gap = vec![0.0, 1e-5, 2e-5];
    p.drag = 0.05;
    (p.contact_model, p.stiffness, p.young_modulus) = (model, 1e6, 2e8);
    (p.damping_law, p.damping, p.hunt_crossley, p.relaxation_time) = (law, 50.0, 0.3, 5e-5);
    p
}

fn inputs() -> Inputs {
    Inputs { force: vec![0.1, -0.2, 0.0, 0.3], support_acceleration: 0.05 }
}

/// Everything that can be read, and what it is measured by.
fn everything(run: &Simulation, n: usize) -> Vec<(String, f64, f64)> {
    let mut all = Vec::new();
    let mut add = |name: &str, value: f64, scale: f64| all.push((name.to_owned(), value, scale));
    for i in 0..n {
        add(&format!("x[{i}]"), run.x(i), 0.1);
        add(&format!("v[{i}]"), run.v(i), 0.2);
        add(&format!("a[{i}]"), run.a(i), 1000.0);
        add(&format!("E_kinetic[{i}]"), run.kinetic_energy(i), 0.05);
        add(&format!("E_gravity[{i}]"), run.gravity_energy(i), 0.05);
    }
    for i in 0..n - 1 {
        add(&format!("F[{i}]"), run.force(i), 1000.0);
        add(&format!("overlap[{i}]"), run.overlap(i), 0.1);
        add(&format!("impulse[{i}]"), run.impulse(i), 0.2);
        add(&format!("F_mean[{i}]"), run.force_mean(i), 10.0);
        add(&format!("F_peak[{i}]"), run.force_peak(i), 100.0);
        add(&format!("E_contact[{i}]"), run.contact_energy(i), 0.05);
        add(&format!("t_onset[{i}]"), run.last_onset(i), TIME);
        add(&format!("t_release[{i}]"), run.last_release(i), TIME);
        add(&format!("pulses[{i}]"), run.pulses(i) as f64, 1e-9);
        add(&format!("inContact[{i}]"), f64::from(u8::from(run.in_contact(i))), 1e-9);
    }
    add("E_total", run.total_energy(), 0.05);
    add("E_dissipated", run.dissipated_energy(), 0.05);
    add("W_external", run.external_work(), 0.05);
    add("E_residual", run.energy_residual(), 0.05);
    add("p_total", run.momentum(), 0.2);
    add("F_support", run.support_force(), 1.0);
    add("F_support_mean", run.support_force_mean(), 1.0);
    if let Some(onset) = run.next_onset().found() {
        add("t_next", onset, TIME);
    }
    all
}

fn pulse_numbers(pulse: &Pulse) -> [f64; 5] {
    let (onset, release) = (pulse.onset / TIME, pulse.release / TIME);
    [pulse.contact as f64 * 1e9, onset, release, 0.01 * pulse.peak, 5.0 * pulse.impulse]
}

/// Runs `p` by the engine and by every method with changing inputs and, in the middle, other losses.
fn compare(p: &Parameters) {
    let tuned = Parameters { drag: 0.1, damping: 20.0, hunt_crossley: 0.1, relaxation_time: 2e-5, ..p.clone() };
    // Some of the points lie within contacts.
    let times: Vec<f64> = (1..=50).map(|i| 0.0217 * f64::from(i)).collect();
    let follow = |method: SolverMethod, tolerance: f64, fixed_step: f64| {
        let p = Parameters { method, tolerance, fixed_step, ..p.clone() };
        let mut run = Simulation::new(&p, &inputs(), 0.0).unwrap();
        let mut pulses = Vec::new();
        let seen = times.iter().enumerate().map(|(i, time)| {
            match i {
                20 => run.hold(&Inputs::zero(4), &[]).unwrap(),
                25 => run.hold(&inputs(), &[Inputs { force: vec![5.0; 4], support_acceleration: 3.0 }]).unwrap(),
                26 => run.hold(&inputs(), &[]).unwrap(),
                35 => run.retune(&Parameters { method, ..tuned.clone() }).unwrap(),
                _ => {}
            }
            run.advance(*time, &mut pulses).unwrap();
            everything(&run, 4)
        });
        (seen.collect::<Vec<_>>(), pulses)
    };
    let (expected, expected_pulses) = follow(SolverMethod::EventDriven, 1e-12, 1e-6);
    assert!(expected_pulses.len() >= 5);
    for (method, tolerance, step, allowed) in METHODS {
        let (seen, pulses) = follow(method, tolerance, step);
        for ((seen, expected), time) in seen.iter().zip(&expected).zip(&times) {
            for ((name, value, scale), (_, truth, _)) in seen.iter().zip(expected) {
                assert!(
                    (value - truth).abs() <= allowed * scale,
                    "{method:?} {name} at {time}: {value:e}, not {truth:e}"
                );
            }
        }
        assert_eq!(pulses.len(), expected_pulses.len(), "{method:?}");
        for (pulse, truth) in pulses.iter().zip(&expected_pulses) {
            let off = pulse_numbers(pulse).into_iter().zip(pulse_numbers(truth)).map(|(a, b)| (a - b).abs());
            assert!(off.fold(0.0, f64::max) <= allowed, "{method:?}: {pulse:?}, not {truth:?}");
        }
    }
}

#[test]
fn derivatives_are_those_of_the_engine() {
    let law = lossy(ContactModel::PowerLaw, DampingLaw::KelvinVoigtNoPull);
    let follow = |method: SolverMethod, tolerance: f64, fixed_step: f64| {
        let p = Parameters { method, tolerance, fixed_step, ..law.clone() };
        let mut run = Simulation::new(&p, &Inputs::zero(4), 0.0).unwrap();
        let pushed = Inputs { force: vec![1.0; 4], support_acceleration: 0.0 };
        let mut all = Vec::new();
        for i in 1..=10 {
            run.advance(0.05 * f64::from(i), &mut Vec::new()).unwrap();
            let along = run.last_step().along_inputs(&pushed).unwrap();
            for rates in [run.time_derivative(1), along] {
                all.push([rates.x, rates.v, rates.impulse, vec![rates.momentum, rates.support_force]].concat());
            }
        }
        all
    };
    let expected = follow(SolverMethod::EventDriven, 1e-12, 1e-6);
    for (method, tolerance, step, allowed) in METHODS {
        for (rates, truth) in follow(method, tolerance, step).iter().zip(&expected) {
            for (rate, truth) in rates.iter().zip(truth) {
                assert!(
                    (rate - truth).abs() <= allowed * truth.abs().max(1.0),
                    "{method:?}: {rates:?}, not {truth} in it"
                );
            }
        }
    }
}

#[test]
fn every_law_is_followed_as_by_the_engine() {
    use DampingLaw::{HuntCrossley, KelvinVoigt, KelvinVoigtNoPull, Viscoelastic};
    for law in [KelvinVoigt, KelvinVoigtNoPull, HuntCrossley, Viscoelastic] {
        compare(&lossy(ContactModel::PowerLaw, law));
    }
    for law in [HuntCrossley, Viscoelastic] {
        compare(&lossy(ContactModel::Hertz, law));
        compare(&Parameters { exponent: 2.5, stiffness: 1e5, ..lossy(ContactModel::PowerLaw, law) });
    }
}

/// The default cradle with a method; its contacts softer for the sake of rk4.
fn default_by(method: SolverMethod) -> Parameters {
    Parameters { method, stiffness: 1e6, fixed_step: 1e-5, tolerance: 1e-10, ..Parameters::default_for(5) }
}

fn bits(run: &Simulation, n: usize) -> Vec<u64> {
    // Means and peaks are those of the step; how far t_next has looked depends on when it was asked for.
    let of_run = everything(run, n)
        .into_iter()
        .filter(|(name, ..)| !["mean", "peak", "t_next"].iter().any(|part| name.contains(part)));
    let work = run.work();
    of_run.map(|(_, value, _)| value.to_bits()).chain([work.steps, work.evaluations, work.events]).collect()
}

#[test]
fn communication_points_change_nothing() {
    for (method, ..) in METHODS {
        let p = default_by(method);
        let start = || Simulation::new(&p, &Inputs::zero(5), 0.0).unwrap();
        let (mut coarse, mut fine) = (start(), start());
        let (mut coarse_pulses, mut fine_pulses) = (Vec::new(), Vec::new());
        for i in 1..=4 {
            coarse.advance(0.7 * f64::from(i), &mut coarse_pulses).unwrap();
            for j in (1..=100).rev() {
                fine.advance(0.7 * f64::from(i) - 0.0069 * f64::from(j - 1), &mut fine_pulses).unwrap();
                if j % 10 == 0 {
                    fine.next_onset();
                    fine.hold(&Inputs::zero(5), &[]).unwrap();
                    fine.retune(&p).unwrap();
                }
            }
            // A copy goes on with the same bits.
            fine = fine.clone();
            assert_eq!(bits(&coarse, 5), bits(&fine, 5), "{method:?} at {}", coarse.time());
        }
        assert!(coarse_pulses.len() > 5, "{coarse_pulses:?}");
        assert_eq!(coarse_pulses, fine_pulses);
    }
}

#[test]
fn the_next_onset_comes_when_it_was_told() {
    for (method, ..) in METHODS {
        let mut run = Simulation::new(&default_by(method), &Inputs::zero(5), 0.0).unwrap();
        let onsets = |run: &Simulation| (0..4).map(|i| run.pulses(i)).sum::<u64>();
        for _ in 0..12 {
            // Look by look: a single one does not lead as far as the next impact.
            let before = onsets(&run);
            let mut looks = 0;
            let next = loop {
                let next = run.next_onset();
                let (time, is_onset) = (next.time(), next.is_settled());
                assert!(time > run.time());
                if is_onset {
                    break time;
                }
                looks += 1;
                run.advance(time, &mut Vec::new()).unwrap();
                assert!(looks < 2000 && onsets(&run) == before, "{method:?} at {time}");
            };
            // Just before it there is none.
            let mut early = run.clone();
            early.advance(next.next_down(), &mut Vec::new()).unwrap();
            assert_eq!((onsets(&early), early.next_onset()), (before, Next::At(next)), "{method:?}");
            run.advance(next, &mut Vec::new()).unwrap();
            assert!(onsets(&run) > before && (0..4).any(|i| run.last_onset(i) == next), "{method:?} {next}");
        }
    }
}

#[test]
fn there_may_be_no_next_onset() {
    for (method, ..) in METHODS {
        // Free balls that part; a single ball.
        let apart =
            Parameters { gravity: 0.0, v_start: vec![-0.1, 0.1], x_start: vec![0.0; 2], ..Parameters::default_for(2) };
        for p in [apart, Parameters::default_for(1)] {
            let mut run =
                Simulation::new(&Parameters { method, fixed_step: 1e-3, ..p.clone() }, &Inputs::zero(p.balls()), 0.0)
                    .unwrap();
            run.advance(1.0, &mut Vec::new()).unwrap();
            // Without gravity the horizon is infinite: two balls that part may be looked after for ever.
            assert!(if p.balls() == 1 { run.next_onset() == Next::Never } else { run.next_onset().found().is_none() });
            assert!(run.energy_residual().abs() < 1e-11);
        }
    }
}

#[test]
fn a_touch_within_a_long_step_is_not_missed() {
    // The first ball touches the second where it turns, 1.4 s on.
    for (depth, method) in
        [1e-4, 1e-7].into_iter().flat_map(|d| [SolverMethod::Adams, SolverMethod::Bdf].map(|m| (d, m)))
    {
        let mut p =
            Parameters { tolerance: 1e-10, gap: vec![0.1 - depth], dead_band: 0.0, ..Parameters::default_for(2) };
        let mut touch = |method: SolverMethod| {
            p.method = method;
            let mut run = Simulation::new(&p, &Inputs::zero(2), 0.0).unwrap();
            let mut pulses = Vec::new();
            run.advance(1.5, &mut pulses).unwrap();
            assert_eq!(pulses.len(), 1, "{method:?} {depth}");
            (pulses[0], run.work().steps)
        };
        let ((pulse, steps), (truth, _)) = (touch(method), touch(SolverMethod::EventDriven));
        assert!((pulse.impulse / truth.impulse - 1.0).abs() < 1e-2, "{method:?} {depth}: {pulse:?}, not {truth:?}");
        assert!(steps < 2000, "{steps}");
    }
}

/// A dense Jacobian of 30,000 unknowns would take 7 GB.
#[test]
fn the_jacobian_of_a_long_chain_is_not_dense() {
    let (n, method) = (10_000, SolverMethod::Bdf);
    let mut p = Parameters { method, tolerance: 1e-6, ..Parameters::default_for(n) };
    p.stiffness = 1e4;
    let mut run = Simulation::new(&p, &Inputs::zero(n), 0.0).unwrap();
    run.advance(0.72, &mut Vec::new()).unwrap();
    assert!(run.pulses(2) == 1 && run.energy_residual().abs() < 1e-4 * run.total_energy());
}

#[test]
fn what_cannot_go_on_is_an_error() {
    let mut p = Parameters { method: SolverMethod::Rk4, fixed_step: 1e-300, ..Parameters::default_for(2) };
    let mut run = Simulation::new(&p, &Inputs::zero(2), 1.0).unwrap();
    let error = run.advance(2.0, &mut Vec::new()).unwrap_err();
    assert_eq!(error, EngineError::StepTooSmall { time: 1.0, step: 1e-300 });
    assert!(error.to_string().contains("1e-300 s"), "{error}");
    // Steps far too long for the contact: the classical method is not stable.
    (p.fixed_step, p.stiffness, p.dead_band) = (0.1, 1e30, 0.0);
    let mut run = Simulation::new(&p, &Inputs::zero(2), 0.0).unwrap();
    assert!(matches!(run.advance(100.0, &mut Vec::new()), Err(EngineError::NotFinite { .. })));
}
