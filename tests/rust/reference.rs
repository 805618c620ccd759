//! The engine and the other methods against results computed independently, in quadruple precision
//! (`tests/data/reference.json`) and in 40 digits: damped or pressed linear contacts by matrix exponentials
//! (`tests/data/strong_damping.py`), chains whose contacts are not linear by series (`tests/data/free_chains.json`);
//! and balls on arcs in quadruple precision (`tests/data/arcs.cpp`, `tests/data/random_arcs.cpp`).

use newtons_cradle::engine::{Chain, Engine, EngineError, Fault, Forecast, Results, Simulation, Unrecorded};
use newtons_cradle::model::{ContactModel, DampingLaw, Inputs, Parameters, PendulumModel, SolverMethod};
use serde_json::Value;

use crate::runs::{assert_energy, run, run_under, started, state, struck_chain};

fn reference() -> Value {
    serde_json::from_str(include_str!("../data/reference.json")).unwrap()
}

/// A number, or a string of digits.
fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| value.as_str().unwrap().parse().unwrap())
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

/// Gives contacts the law of a case, if it has one.
fn damp(p: &mut Parameters, case: &Value) {
    let Some(law) = case["law"].as_str() else { return };
    let coefficient = number(&case["coefficient"]);
    match law {
        "none" => {}
        "kelvinVoigt" => p.damping = coefficient,
        "kelvinVoigtNoPull" => (p.damping_law, p.damping) = (DampingLaw::KelvinVoigtNoPull, coefficient),
        "huntCrossley" => (p.damping_law, p.hunt_crossley) = (DampingLaw::HuntCrossley, coefficient),
        "viscoelastic" => (p.damping_law, p.relaxation_time) = (DampingLaw::Viscoelastic, coefficient),
        "constantRestitution" => (p.damping_law, p.restitution) = (DampingLaw::ConstantRestitution, coefficient),
        "rigid" => (p.contact_model, p.restitution, p.stiffness) = (ContactModel::Rigid, coefficient, 1.0),
        law => panic!("{law}"),
    }
}

/// A chain in the reference's units.
fn chain(case: &Value) -> Parameters {
    let masses = case["masses"].is_array().then(|| numbers(&case["masses"]));
    let n = case["N"].as_u64().map_or_else(|| masses.as_ref().unwrap().len(), |n| n as usize);
    let strikers = case["strikers"].as_u64().unwrap_or(1) as usize;
    let mut p = struck_chain(n, strikers, number(&case["p"]));
    if let Some(masses) = masses {
        p.mass_ratio = masses;
    }
    damp(&mut p, case);
    p
}

/// The chains of equal balls, elastic and damped.
fn equal_chains() -> Vec<Value> {
    let reference = reference();
    ["free_chain", "damped_chain"].iter().flat_map(|kind| reference[kind].as_array().unwrap().clone()).collect()
}

/// Runs a chain until everything has come apart, soon after the `duration`. Velocities and impulses, the energy, and
/// the time of the last release are off by no more than is allowed; by how much that time is.
fn assert_chain(case: &Value, p: &Parameters, [motion, energy, time]: [f64; 3]) -> f64 {
    let (n, duration, id) = (p.balls(), number(&case["duration"]), format!("{:?}, {case}", p.method));
    let mut run = Simulation::new(p, &Inputs::zero(n), 0.0).unwrap();
    run.advance(duration + 1.0, &mut Unrecorded).unwrap();
    assert!(p.method != SolverMethod::EventDriven || run.next_onset() == Forecast::Never, "{id}");
    assert_close(&id, &state(&*run, n).1, &numbers(&case["v_final"]), motion);
    if case["impulse"].is_array() {
        let impulses: Vec<f64> = (0..n - 1).map(|i| run.impulse(i)).collect();
        assert_close(&id, &impulses, &numbers(&case["impulse"]), motion);
    }
    assert!(run.energy_residual().abs() <= energy, "{id}: {:e}", run.energy_residual());
    let last = (0..n - 1).map(|i| run.last_release(i)).fold(0.0, f64::max);
    assert_close(&id, &[last], &[duration], time);
    (last - duration).abs()
}

fn assert_close(what: &str, got: &[f64], expected: &[f64], tolerance: f64) {
    for (i, (g, e)) in got.iter().zip(expected).enumerate() {
        assert!((g - e).abs() <= tolerance, "{what}: item {i} is {g:e}, expected {e:e}, off by {:e}", g - e);
    }
}

#[test]
fn reference_free_and_damped_chains() {
    for case in equal_chains() {
        assert_chain(&case, &chain(&case), [1e-11, 1e-13, 1e-10]);
    }
}

/// Unequal balls that meet at speed, and viscoelastic ones in touch, in contacts that are not linear: by the engine,
/// and by a method that knows nothing of where the force is not smooth.
#[test]
fn reference_unequal_free_chains() {
    let cases: Value = serde_json::from_str(include_str!("../data/free_chains.json")).unwrap();
    for case in cases.as_array().unwrap() {
        let p = Parameters { gap: numbers(&case["gaps"]), v_start: numbers(&case["v"]), ..chain(case) };
        for (method, tolerance, within) in
            [(SolverMethod::EventDriven, 1e-12, 1e-14), (SolverMethod::Adams, 1e-13, 1e-11)]
        {
            let p = Parameters { method, tolerance, ..p.clone() };
            assert_chain(case, &p, [within, within, 100.0 * within]);
        }
    }
}

#[test]
fn reference_cradle_states() {
    for case in reference()["cradle_states"].as_array().unwrap() {
        let id = case["id"].as_str().unwrap();
        let n = case["N"].as_u64().unwrap() as usize;
        let left = case["lifted_left"].as_u64().unwrap() as usize;
        let (amplitude, t) = (number(&case["amplitude"]), number(&case["t"]));
        let mut p = Parameters::default_for(n);
        (p.gravity, p.length) = (number(&case["omega2"]), 1.0);
        (p.exponent, p.stiffness, p.overlap_ref) = (number(&case["p"]), number(&case["k"]), 1.0);
        p.dead_band = number(&case["gap"]);
        p.x_start = (0..n).map(|i| if i < left { -amplitude } else { 0.0 }).collect();
        let engine = run(&p, t);
        let (x, v) = state(&engine, n);
        let omega = number(&case["omega2"]).sqrt();
        assert_close(id, &x, &numbers(&case["x"]), 1e-10 * amplitude);
        assert_close(id, &v, &numbers(&case["v"]), 1e-10 * amplitude * omega);
        let pulses: u64 = (0..n - 1).map(|i| engine.pulses(i)).sum();
        assert_eq!(pulses.to_string(), case["contact_pulses"].as_str().unwrap(), "{id}");
        assert_energy(&engine, 1e-12, id);
    }
}

#[test]
fn reference_strongly_damped_cradles() {
    let cases: Value = serde_json::from_str(include_str!("../data/strong_damping.json")).unwrap();
    for case in cases.as_array().unwrap() {
        let n = case["balls"].as_u64().unwrap() as usize;
        let pull = case["pull"].as_bool().unwrap();
        let mut p = Parameters::default_for(n);
        (p.stiffness, p.damping) = (number(&case["stiffness"]), number(&case["damping"]));
        p.dead_band = number(&case["dead_band"]);
        p.damping_law = if pull { DampingLaw::KelvinVoigt } else { DampingLaw::KelvinVoigtNoPull };
        p.x_start = numbers(&case["start"]);
        let mut inputs = Inputs::zero(n);
        if case["press"].is_number() {
            (p.mass_ratio, p.stiffness_ratio) = (numbers(&case["masses"]), numbers(&case["springs"]));
            (inputs.force[0], inputs.force[n - 1]) = (number(&case["press"]), -number(&case["press"]));
        }
        let id = format!("{n} balls from {:?}, k = {:e}, c = {:e}, pull = {pull}", p.x_start, p.stiffness, p.damping);
        let engine = run_under(&p, &inputs, number(&case["time"]));
        let (x, v) = state(&engine, n);
        let largest = |values: &[f64]| values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        assert_close(&id, &x, &numbers(&case["x"]), 1e-12 * largest(&p.x_start));
        assert_close(&id, &v, &numbers(&case["v"]), 1e-11 * largest(&v));
        assert_energy(&engine, 1e-12, &id);
        assert_eq!(engine.work().events, case["switchings"].as_u64().unwrap(), "{id}");
    }
}

/// Balls of the default size on arcs; these start at rest.
fn on_arcs(x_start: Vec<f64>) -> Parameters {
    let pendulum = PendulumModel::Circular;
    let n = x_start.len();
    Parameters { pendulum, v_start: vec![0.0; n], x_start, ..Parameters::default_for(n) }
}

fn arcs() -> Value {
    serde_json::from_str(include_str!("../data/arcs.json")).unwrap()
}

/// The cradle of a case, with its inputs.
fn cradle_on_arcs(case: &Value) -> (Parameters, Inputs) {
    let mut p = on_arcs(numbers(&case["start"]));
    (p.exponent, p.overlap_ref, p.dead_band) = (number(&case["p"]), 1.0, number(&case["dead_band"]));
    (p.stiffness, p.drag) = (number(&case["k"]), number(&case["drag"]));
    // With the default of 1e-12, a wave with damping in balls that touch is no more exact than that.
    p.tolerance = 1e-13;
    let mut inputs = Inputs { support_acceleration: number(&case["a_support"]), ..Inputs::zero(p.balls()) };
    let lists = [
        (&mut p.length_ratio, "lengths"),
        (&mut p.mass_ratio, "masses"),
        (&mut p.loss_ratio, "losses"),
        (&mut p.gap, "gaps"),
        (&mut p.v_start, "v_start"),
        (&mut inputs.force, "forces"),
    ];
    for (values, key) in lists {
        let given = if case[key].is_array() { numbers(&case[key]) } else { Vec::new() };
        values.iter_mut().zip(given).for_each(|(value, given)| *value = given);
    }
    damp(&mut p, case);
    (p, inputs)
}

/// Follows a cradle to a state, which is off by no more than this part of the amplitude times the sensitivity.
fn assert_state(run: &mut Engine, amplitude: f64, state: &Value, most: f64, id: &str) {
    run.advance(number(&state["time"]), &mut Vec::new()).unwrap();
    let within = most * amplitude * number(&state["sensitivity"]);
    let id = format!("{id} at {}", state["time"]);
    for (key, value) in [("x", Engine::x as fn(&Engine, usize) -> f64), ("v", Engine::v), ("angle", Engine::angle)] {
        if !state[key].is_array() {
            continue;
        }
        let expected = numbers(&state[key]);
        let values: Vec<f64> = (0..expected.len()).map(|i| value(run, i)).collect();
        assert_close(&id, &values, &expected, within);
    }
    assert_energy(run, 2e-14, &id);
}

/// After one click and after ten. The `sensitivity` is how much a small change of all starts grows; rounding between
/// clicks moves balls one by one, which grows more, up to 1,000 times as much.
#[test]
fn reference_cradles_on_arcs() {
    for case in arcs()["cradles"].as_array().unwrap() {
        let (p, inputs) = cradle_on_arcs(case);
        let (amplitude, contacts) = (-p.x_start[0], p.contacts());
        let mut run = Engine::new(&p, &inputs, 0.0).unwrap();
        for (state, most) in case["states"].as_array().unwrap().iter().zip([1e-14, 6e-13]) {
            assert_state(&mut run, amplitude, state, most, &case.to_string());
        }
        assert!((0..contacts).map(|j| run.pulses(j)).sum::<u64>() > 8, "{case}");
    }
}

/// All laws, with drag and inputs (`tests/data/random_arcs.cpp`); the `sensitivity` is that to changes of single balls.
#[test]
fn reference_random_cradles_on_arcs() {
    let (mut states, mut faults) = (0, Vec::new());
    for line in include_str!("../data/random_arcs.json").lines() {
        let case: Value = serde_json::from_str(line).unwrap();
        let (p, inputs) = cradle_on_arcs(&case);
        let amplitude = p.x_start.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let (id, mut run) = (format!("cradle {}", case["number"]), Engine::new(&p, &inputs, 0.0).unwrap());
        for state in case["states"].as_array().unwrap() {
            let Some(ends) = state["ends"].as_str() else {
                assert_state(&mut run, amplitude, state, 1e-14, &id);
                states += 1;
                continue;
            };
            let error = run.advance(number(&state["time"]), &mut Unrecorded).unwrap_err();
            let expected = match ends {
                "across" => Fault::Sides,
                "horizontal" => Fault::Horizontal,
                _ => Fault::Slack,
            };
            assert!(matches!(error, EngineError::OffArc { fault, .. } if fault == expected), "{id}: {error}");
            faults.push(expected);
        }
    }
    let of = |fault| faults.iter().filter(|other| **other == fault).count();
    let found = [Fault::Sides, Fault::Horizontal, Fault::Slack].map(of);
    assert_eq!((states, found), (343, [9, 4, 1]));
}

/// Rows in touch whose contacts have a constant restitution, from nearly elastic to hardly any (`tests/data/rows.cpp`).
#[test]
fn reference_rows_of_constant_restitution() {
    let cases: Value = serde_json::from_str(include_str!("../data/rows.json")).unwrap();
    for case in cases.as_array().unwrap() {
        let (p, _) = cradle_on_arcs(case);
        let mut run = started(&Parameters { pendulum: PendulumModel::Linear, ..p });
        let id = format!("{} balls, p = {}, e = {}", numbers(&case["start"]).len(), case["p"], case["coefficient"]);
        for state in case["states"].as_array().unwrap() {
            assert_state(&mut run, 0.1, state, 1e-13, &id);
        }
    }
}

/// The energy of those whose work depends most on how well integrals know where forces are not smooth, while forces on
/// every other ball grow by 1 N/s and on the others fall by 0.7 N/s.
#[test]
fn reference_work_of_growing_forces_on_arcs() {
    let cases =
        include_str!("../data/random_arcs.json").lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    let chosen = |case: &Value| [59, 139, 221, 230].iter().any(|number| case["number"] == *number);
    let follow = |case: Value| {
        let (p, inputs) = cradle_on_arcs(&case);
        let force = (0..p.balls()).map(|i| if i % 2 == 0 { 1.0 } else { -0.7 }).collect();
        let mut run = Engine::new(&p, &inputs, 0.0).unwrap();
        run.hold(&inputs, &[Inputs { force, ..Inputs::zero(p.balls()) }]).unwrap();
        run.advance(2.0, &mut Unrecorded).unwrap();
        assert_energy(&run, 1e-14, &format!("cradle {}", case["number"]));
    };
    assert_eq!(cases.filter(chosen).map(follow).count(), 4);
}

/// Pendulums by themselves: a quarter of a period after the other, they are where they should be.
#[test]
fn reference_periods_on_arcs() {
    let [amplitudes, periods] = ["amplitudes", "periods"].map(|key| numbers(&arcs()[key]));
    for (amplitude, period) in amplitudes.into_iter().zip(periods) {
        let p = on_arcs(vec![-amplitude]);
        let mut run = started(&p);
        // That of the rounded start: the deflection tells the angle to the last digit of its tangent.
        let own = crate::arcs::period(&p, run.angle(0));
        let tangent = amplitude / (p.length.powi(2) - amplitude.powi(2)).sqrt();
        assert!((own / period - 1.0).abs() <= 1e-15 + 1e-16 * tangent, "{amplitude} m: {own} s");
        for quarters in (1..=8).chain([41, 401]) {
            let t = 0.25 * f64::from(quarters) * own;
            run.advance(t, &mut Unrecorded).unwrap();
            // The time since it was at rest, or below its pivot.
            let early = match quarters % 2 {
                1 => run.x(0) / run.v(0),
                _ => -run.v(0) / run.a(0),
            };
            assert!(early.abs() <= 1e-15 * t, "{amplitude} m, {t} s: {early:e} s");
            assert_energy(&run, 2e-14, "a pendulum");
        }
    }
}

#[test]
fn rk4_converges_as_fast_as_the_forces_are_smooth() {
    for case in equal_chains() {
        // A Kelvin-Voigt force jumps at the onset, another one bends there or, from p = 3 on, is as smooth as the
        // method asks for.
        let (smooth, most) = match number(&case["p"]) {
            _ if case["law"].as_str().is_some_and(|law| law.starts_with("kelvinVoigt")) => (false, 1e-4),
            p if p < 3.0 => (false, 1e-6),
            _ => (true, 1e-10),
        };
        let [coarse, fine] = [(1e-2, f64::INFINITY), (2.5e-3, most)].map(|(fixed_step, most)| {
            assert_chain(&case, &Parameters { method: SolverMethod::Rk4, fixed_step, ..chain(&case) }, [most; 3])
        });
        let ratio = coarse / fine;
        assert!(!smooth || (200.0..300.0).contains(&ratio), "{case}: {ratio} instead of 4^4");
    }
}
