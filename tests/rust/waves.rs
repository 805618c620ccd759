//! Waves through balls that touch.

use newtons_cradle::engine::{Engine, Results};
use newtons_cradle::model::{Inputs, Parameters};

/// The next contact of a wave overlaps by less than rounding, and its balls move by less than that: nothing tells when it closes.
#[test]
fn balls_at_rest_but_for_rounding_do_not_stall_a_wave() {
    let (exponent, stiffness, mass) = (5.5, 1.70956e10, 0.25283);
    let mut parameters = Parameters { exponent, stiffness, mass, dead_band: 0.0, ..Parameters::default_for(9) };
    parameters.x_start.fill(0.0);
    parameters.v_start[0] = 0.59288;
    let mut engine = Engine::new(&parameters, &Inputs::zero(9), 0.0).unwrap();
    let energy = engine.total_energy();
    engine.advance(1.73e-4, &mut Vec::new()).unwrap();
    assert!(engine.energy_residual().abs() < 2e-14 * energy, "{:e}", engine.energy_residual() / energy);
    assert!(engine.work().steps < 150, "{:?}", engine.work());
}

/// Runs a cradle with these forces (N) on its balls for this time (s). Nothing but work counts and losses changes its energy.
fn complete(parameters: &Parameters, force: Vec<f64>, time: f64) {
    let inputs = Inputs { force, ..Inputs::zero(parameters.balls()) };
    let mut engine = Engine::new(parameters, &inputs, 0.0).unwrap();
    engine.advance(time, &mut Vec::new()).unwrap();
    let scale = engine.total_energy() + engine.external_work().abs() + engine.dissipated_energy();
    assert!(engine.energy_residual().abs() < 1e-13 * scale, "{:e}", engine.energy_residual() / scale);
}

/// How fast balls at rest are soon is not told by what they hold as yet: next to no energy, and speeds of next to nothing.
#[test]
fn forces_press_balls_that_overlap_by_next_to_nothing() {
    for (overlap, v) in [(7e-23, 0.0), (3e-24, 0.0), (7e-23, 3e-27)] {
        let mut parameters = Parameters { gravity: 0.0, dead_band: 0.0, ..Parameters::default_for(4) };
        (parameters.mass, parameters.exponent, parameters.stiffness) = (0.37, 2.5, 2.8e4);
        parameters.x_start = (0..4).map(|i| -(f64::from(i) * overlap)).collect();
        parameters.v_start[2] = v;
        complete(&parameters, vec![0.3, 0.0, 0.0, -0.3], 0.09);
    }
}
