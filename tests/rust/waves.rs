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
