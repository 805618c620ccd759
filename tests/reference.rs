//! The engine against results computed independently in quadruple precision (`tests/data/reference.json`).

use newtons_cradle::engine::Engine;
use newtons_cradle::model::{DampingLaw, Inputs, Parameters};
use serde_json::Value;

fn reference() -> Value {
    serde_json::from_str(include_str!("data/reference.json")).unwrap()
}

/// A number, or a string of digits.
fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| value.as_str().unwrap().parse().unwrap())
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

/// A chain in the reference's units: m = k = 1, strikers at velocity 1, all contacts exactly in touch, no gravity.
fn chain(case: &Value) -> Parameters {
    let n = case["N"].as_u64().unwrap() as usize;
    let strikers = case["strikers"].as_u64().unwrap() as usize;
    let mut p = Parameters::default_for(n);
    (p.gravity, p.stiffness, p.overlap_ref, p.dead_band) = (0.0, 1.0, 1.0, 0.0);
    p.exponent = number(&case["p"]);
    if case["masses"].is_array() {
        p.mass_ratio = numbers(&case["masses"]);
    }
    p.x_start = vec![0.0; n];
    p.v_start = (0..n).map(|i| if i < strikers { 1.0 } else { 0.0 }).collect();
    p
}

/// Velocities and the time of the last release after everything has come apart.
fn run_chain(p: &Parameters) -> (Vec<f64>, f64, Engine) {
    let n = p.balls();
    let mut engine = Engine::new(p, &Inputs::zero(n), 0.0).unwrap();
    engine.advance(50.0, &mut Vec::new()).unwrap();
    let velocities = (0..n).map(|i| engine.v(i)).collect();
    let last = (0..n - 1).map(|i| engine.last_release(i)).fold(0.0, f64::max);
    (velocities, last, engine)
}

fn assert_close(what: &str, got: &[f64], expected: &[f64], tolerance: f64) {
    for (i, (g, e)) in got.iter().zip(expected).enumerate() {
        assert!((g - e).abs() <= tolerance, "{what}: item {i} is {g:e}, expected {e:e}, off by {:e}", g - e);
    }
}

#[test]
fn free_chains() {
    for case in reference()["free_chain"].as_array().unwrap() {
        let id = case["id"].as_str().unwrap();
        let (velocities, last, engine) = run_chain(&chain(case));
        let impulses: Vec<f64> = (0..velocities.len() - 1).map(|i| engine.impulse(i)).collect();
        assert_close(id, &velocities, &numbers(&case["v_final"]), 1e-11);
        assert_close(id, &[last], &[number(&case["duration"])], 1e-10);
        assert_close(id, &impulses, &numbers(&case["impulse"]), 1e-11);
        assert!(engine.energy_residual().abs() < 1e-13, "{id}: {:e}", engine.energy_residual());
    }
}

#[test]
fn damped_chains() {
    for case in reference()["damped_chain"].as_array().unwrap() {
        let id = format!("{} N={} p={}", case["model"], case["N"], case["p"]);
        let mut p = chain(case);
        if case["alpha"].is_number() {
            (p.damping_law, p.hunt_crossley) = (DampingLaw::HuntCrossley, number(&case["alpha"]));
        } else {
            p.damping = number(&case["c"]);
            let clamped = case["clamped"].as_bool().unwrap();
            p.damping_law = if clamped { DampingLaw::KelvinVoigtNoPull } else { DampingLaw::KelvinVoigt };
        }
        let (velocities, last, engine) = run_chain(&p);
        assert_close(&id, &velocities, &numbers(&case["v_final"]), 1e-11);
        assert_close(&id, &[last], &[number(&case["duration"])], 1e-10);
        assert!(engine.energy_residual().abs() < 1e-13, "{id}: {:e}", engine.energy_residual());
        assert!(engine.dissipated_energy() > 0.0);
    }
}

#[test]
fn cradle_states() {
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
        let mut engine = Engine::new(&p, &Inputs::zero(n), 0.0).unwrap();
        engine.advance(t, &mut Vec::new()).unwrap();
        let x: Vec<f64> = (0..n).map(|i| engine.x(i)).collect();
        let v: Vec<f64> = (0..n).map(|i| engine.v(i)).collect();
        let omega = number(&case["omega2"]).sqrt();
        assert_close(id, &x, &numbers(&case["x"]), 1e-10 * amplitude);
        assert_close(id, &v, &numbers(&case["v"]), 1e-10 * amplitude * omega);
        let pulses: u64 = (0..n - 1).map(|i| engine.pulses(i)).sum();
        assert_eq!(pulses.to_string(), case["contact_pulses"].as_str().unwrap(), "{id}");
        assert!(engine.energy_residual().abs() < 1e-12 * engine.total_energy(), "{id}: {:e}", engine.energy_residual());
    }
}
