//! The methods that integrate the whole chain, against the event-driven engine and against themselves.

use newtons_cradle::engine::{EngineError, Forecast, History, Pulse, Results, Simulation};
use newtons_cradle::model::{ContactModel, DampingLaw, Inputs, Parameters, SolverMethod};
use newtons_cradle::variables::{Access, Row, Variable, variables};

use crate::runs::cradle;

/// Method, tolerance and step, and the allowed difference of the results after a second over their scale. It is far
/// above the tolerance, because balls bounce dozens of times before they rest, and every bounce magnifies errors.
pub const METHODS: [(SolverMethod, f64, f64, f64); 3] = [
    (SolverMethod::Adams, 1e-13, 1e-6, 1e-4),
    (SolverMethod::Bdf, 1e-13, 1e-6, 1e-4),
    (SolverMethod::Rk4, 1e-12, 2e-6, 1e-3),
];

/// Scale of the times, s: `adams` and `bdf` then agree to a hundredth of a contact of [`lossy`], which lasts 2 ms.
const TIME: f64 = 0.2;

/// Four unequal balls with losses, drag and gaps, and contacts so soft that impacts last 2 ms.
fn lossy(model: ContactModel, damping_law: DampingLaw) -> Parameters {
    let p = cradle(
        4,
        "ball.massRatio=1,0.8,1.3,0.9 pendulum.lengthRatio=1,1.1,0.95,1.02 contact.stiffnessRatio=1,2,0.5 \
         contact.gap=0,1e-5,2e-5 pendulum.drag=0.05 contact.stiffness=1e6 ball.youngModulus=2e8 contact.damping=50 \
         contact.huntCrossley=0.3 contact.relaxationTime=5e-5 contact.restitution=0.9 contact.lossRatio=1,0.5,2",
    );
    Parameters { contact_model: model, damping_law, ..p }
}

fn inputs() -> Inputs {
    Inputs { force: vec![0.1, -0.2, 0.0, 0.3], support_acceleration: 0.05 }
}

/// Every result.
fn results(run: &dyn Results, balls: usize) -> impl Iterator<Item = (Variable, f64)> {
    let value = move |variable: Variable| match variable.row.access {
        Access::Real(get) => Some((variable, get(run, variable.index))),
        Access::Count(get) => Some((variable, get(run, variable.index) as f64)),
        Access::Flag(get) => Some((variable, get(run, variable.index).into())),
        _ => None,
    };
    variables(balls).filter_map(value)
}

/// All results of a run, bit by bit, without means and peaks over the step, and without the progress of `t_next`.
pub fn bits(run: &dyn Results, balls: usize) -> Vec<u64> {
    let of_run = |variable: &Variable| !["mean", "peak", "t_next"].iter().any(|part| variable.row.name.contains(part));
    results(run, balls).filter(|(variable, _)| of_run(variable)).map(|(_, value)| value.to_bits()).collect()
}

/// All results except counters, with their scales.
fn everything(run: &Simulation, balls: usize) -> Vec<(String, f64, f64)> {
    let scale = |row: &Row| match (row.name, row.unit()) {
        ("F_support" | "F_support_mean", _) => 1.0,
        ("F_mean", _) => 10.0,
        ("F_peak", _) => 100.0,
        (_, "m" | "rad") => 0.1,
        (_, "m/s" | "kg.m/s" | "N.s") => 0.2,
        (_, "m/s2" | "N") => 1000.0,
        (_, "J") => 0.05,
        (_, "W") => 200.0,
        (_, "s") => TIME,
        _ => 1e-9,
    };
    let told = |row: &Row| !["solver", "t_next"].iter().any(|part| row.name.starts_with(part));
    let all = results(&**run, balls).filter(|(variable, _)| told(variable.row));
    let all = all.map(|(variable, value)| (variable.to_string(), value, scale(variable.row)));
    let foreseen = run.next_onset().found().map(|onset| ("t_next".to_owned(), onset, TIME));
    all.chain(foreseen).collect()
}

/// Derivatives by time, and along forces on all balls that were held over the last step, with their scales.
fn derivatives(run: &Simulation, balls: usize) -> impl Iterator<Item = (String, f64, f64)> {
    let inputs = Inputs { force: vec![1.0; balls], ..Inputs::zero(balls) };
    let along = run.sensitivity_of_step(&History::default(), &inputs, false).unwrap();
    let all = [run.time_derivative(1), along].map(|of| [of.x, of.v, of.impulse, vec![of.momentum, of.support_force]]);
    all.concat().concat().into_iter().map(|value| ("a derivative".to_owned(), value, value.abs().max(1.0)))
}

fn pulse_numbers(pulse: &Pulse) -> [f64; 5] {
    let (onset, release) = (pulse.onset / TIME, pulse.release / TIME);
    [pulse.contact as f64 * 1e9, onset, release, 0.01 * pulse.peak.force, 5.0 * pulse.impulse]
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
                35 => run.retune(&tuned.tunables()).unwrap(),
                _ => {}
            }
            run.advance(*time, &mut pulses).unwrap();
            // Later on they magnify what differs.
            let of_early = if i < 20 { derivatives(&run, 4).collect() } else { Vec::new() };
            [of_early, everything(&run, 4)].concat()
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
fn methods_follow_every_law_as_the_engine_does() {
    use DampingLaw::{ConstantRestitution, HuntCrossley, KelvinVoigt, KelvinVoigtNoPull, Viscoelastic};
    for law in [KelvinVoigt, KelvinVoigtNoPull, HuntCrossley, Viscoelastic, ConstantRestitution] {
        compare(&lossy(ContactModel::PowerLaw, law));
    }
    for law in [HuntCrossley, Viscoelastic, ConstantRestitution] {
        compare(&lossy(ContactModel::Hertz, law));
        compare(&Parameters { exponent: 2.5, stiffness: 1e5, ..lossy(ContactModel::PowerLaw, law) });
    }
}

/// The default cradle with a method; its contacts softer for the sake of rk4.
pub fn default_by(method: SolverMethod) -> Parameters {
    Parameters { method, stiffness: 1e6, fixed_step: 1e-5, tolerance: 1e-10, ..Parameters::default_for(5) }
}

#[test]
fn methods_forecast_the_next_onset() {
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
            assert_eq!((onsets(&early), early.next_onset()), (before, Forecast::At(next)), "{method:?}");
            run.advance(next, &mut Vec::new()).unwrap();
            assert!(onsets(&run) > before && (0..4).any(|i| run.last_onset(i) == next), "{method:?} {next}");
        }
    }
}

#[test]
fn methods_forecast_no_onset_where_there_is_none() {
    for (method, ..) in METHODS {
        // Free balls that part; a single ball.
        let apart = cradle(2, "gravity=0 v_start=-0.1,0.1 x_start=0");
        for p in [apart, Parameters::default_for(1)] {
            let mut run =
                Simulation::new(&Parameters { method, fixed_step: 1e-3, ..p.clone() }, &Inputs::zero(p.balls()), 0.0)
                    .unwrap();
            run.advance(1.0, &mut Vec::new()).unwrap();
            // Without gravity the horizon is infinite: two balls that part may be looked after for ever.
            assert!(if p.balls() == 1 {
                run.next_onset() == Forecast::Never
            } else {
                run.next_onset().found().is_none()
            });
            assert!(run.energy_residual().abs() < 1e-11);
        }
    }
}

#[test]
fn methods_miss_no_touch_within_a_long_step() {
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
fn methods_jacobian_of_a_long_chain_is_banded() {
    let (n, method) = (10_000, SolverMethod::Bdf);
    let mut p = Parameters { method, tolerance: 1e-6, ..Parameters::default_for(n) };
    p.stiffness = 1e4;
    let mut run = Simulation::new(&p, &Inputs::zero(n), 0.0).unwrap();
    run.advance(0.72, &mut Vec::new()).unwrap();
    assert!(run.pulses(2) == 1 && run.energy_residual().abs() < 1e-4 * run.total_energy());
}

#[test]
fn methods_that_cannot_go_on_end_in_an_error() {
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
