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

/// Gravity parts balls that touch, and a wave reaches them right after that: their contact does not close before.
#[test]
fn balls_that_touch_part_before_a_wave_reaches_them() {
    for (first, moving, v) in [(0, 0, 0.01466), (1, 0, 0.01466), (1, 1, 0.01466), (0, 3, -0.1001), (1, 3, -0.1001)] {
        let dead_band = 1.7922e-6;
        let mut parameters = Parameters { exponent: 2.0, dead_band, ..Parameters::default_for(5) };
        parameters.x_start = (first..first + 5).map(|i| -(f64::from(i) * dead_band)).collect();
        parameters.v_start[moving] = v;
        complete(&parameters, vec![0.0; 5], 0.1);
    }
}

/// The same where forces at the ends press.
#[test]
fn balls_that_touch_part_before_forces_press_them() {
    for exponent in [1.5, 2.0, 2.5] {
        let dead_band = 1.6529975176654166e-8;
        let mut parameters = Parameters { exponent, dead_band, stiffness: 3.3e8, ..Parameters::default_for(4) };
        parameters.x_start = (0..4).map(|i| -(f64::from(i) * dead_band)).collect();
        complete(&parameters, vec![0.06, 0.0, 0.0, -0.06], 0.008);
    }
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

/// Balls that overlap by next to nothing part by less than rounding: no step is planned to end where they do.
#[test]
fn no_release_is_planned_for_balls_at_rest_but_for_rounding() {
    let mut parameters = Parameters { gravity: 9.81, dead_band: 0.0, ..Parameters::default_for(7) };
    (parameters.mass, parameters.exponent, parameters.stiffness) = (0.18320617160920666, 2.5, 1000915.7391515343);
    parameters.drag = 0.008168440798958728;
    parameters.x_start = (0..7).map(|i| -(f64::from(i) * 2.4463804472887435e-21)).collect();
    (parameters.v_start[0], parameters.v_start[1]) = (-0.025405157448488994, -0.07375915148600602);
    complete(&parameters, vec![0.0; 7], 1.2);
}
