//! Waves through balls that touch.

use newtons_cradle::engine::{Chain, Engine, Results};
use newtons_cradle::model::{DampingLaw, Inputs, Parameters};

use crate::runs::{assert_energy, cradle, run, touching};

/// The next contact of a wave overlaps by less than rounding, and its balls move by less than that: nothing tells when
/// it closes.
#[test]
fn wave_is_not_stalled_by_balls_at_rest_but_for_rounding() {
    let parameters =
        touching(9, "contact.exponent=5.5 contact.stiffness=1.70956e10 ball.mass=0.25283 v_start[1]=0.59288");
    let engine = run(&parameters, 1.73e-4);
    assert_energy(&engine, 2e-14, "a wave");
    assert!(engine.work().steps < 150, "{:?}", engine.work());
}

/// Runs a cradle with these forces (N) on its balls and their derivatives (N/s and so on) at the start, for this time
/// (s). Nothing but work and losses changes its energy, to what it may be off by, relative.
fn complete(parameters: &Parameters, forces: Vec<Vec<f64>>, time: f64, allowed: f64) -> Engine {
    let zero = Inputs::zero(parameters.balls());
    let inputs: Vec<_> = forces.into_iter().map(|force| Inputs { force, ..zero.clone() }).collect();
    let mut engine = Engine::new(parameters, &inputs[0], 0.0).unwrap();
    engine.hold(&inputs[0], &inputs[1..]).unwrap();
    engine.advance(time, &mut Vec::new()).unwrap();
    assert_energy(&engine, allowed, &format!("{parameters:?}"));
    engine
}

/// Balls of 1 kg that touch without gravity.
fn balls_that_touch(balls: usize, exponent: f64, stiffness: f64) -> Parameters {
    touching(balls, &format!("gravity=0 contact.exponent={exponent} contact.stiffness={stiffness}"))
}

/// Forces that only grow from 0 part balls at rest before a wave presses them, or press them: which of it, no
/// acceleration at the start tells.
#[test]
fn wave_beside_forces_that_grow_from_zero() {
    for (exponent, balls) in [1.0, 1.3, 1.5, 2.0, 2.5, 3.0].into_iter().flat_map(|p| [3, 4, 5].map(|n| (p, n))) {
        for (gravity, moving) in [0.0, 9.81].into_iter().flat_map(|g| (0..=balls).map(move |i| (g, i))) {
            let mut parameters = Parameters { gravity, ..balls_that_touch(balls, exponent, 1e4) };
            if let Some(v) = parameters.v_start.get_mut(moving) {
                *v = if moving * 2 < balls { 0.005 } else { -0.005 };
            }
            for (ball, slope) in (0..balls).flat_map(|ball| [60.0, -60.0, 1e-3, 1e3].map(|slope| (ball, slope))) {
                let mut slopes = vec![0.0; balls];
                slopes[ball] = slope;
                complete(&parameters, vec![vec![0.0; balls], slopes], 0.01, 1e-12);
            }
        }
    }
}

/// From rest balls are pressed by forces that grow with any power of the time.
#[test]
fn balls_at_rest_are_pressed_by_forces_of_any_degree() {
    let (first, second, third) =
        (vec![0.398, -0.557, -0.304], vec![-0.367, -0.592, -0.799], vec![-0.574, 0.0266, -0.00476]);
    for (exponent, scale) in [(1.0, 1.0), (1.5, 100.0), (2.5, 15.0), (3.0, 1e3)] {
        let of_degree = |forces: &[f64], degree| forces.iter().map(|f| f * f64::powi(scale, degree)).collect();
        let forces = vec![vec![0.0; 3], of_degree(&first, 1), of_degree(&second, 2), of_degree(&third, 3)];
        complete(&balls_that_touch(3, exponent, 1e4), forces, 1.0 / scale, 1e-12);
    }
}

/// Where damping is stiff, series follow balls from rest: their forces begin with a power of the time that lies beyond
/// the order.
#[test]
fn balls_at_rest_with_stiff_damping_are_pressed() {
    let mut parameters = balls_that_touch(3, 5.0, 1e4);
    (parameters.damping_law, parameters.hunt_crossley) = (DampingLaw::HuntCrossley, 1e5);
    let forces = [[0.0; 3], [0.0; 3], [-0.367, -0.592, -0.799], [0.574, 0.0266, -0.00476]];
    complete(&parameters, forces.map(Vec::from).to_vec(), 1.0, 1e-12);
}

/// Two balls part at a force that begins with `-a t` and come together again where its other terms have made up for
/// that: at the root of a polynomial.
#[test]
fn balls_parted_by_a_growing_force_close_where_it_brings_them_back() {
    let (a, b, c) = (0.0958 / 0.011, 0.2108 / 0.011_f64.powi(2), 0.9038 / 0.011_f64.powi(3));
    // -a t^3 / 6 + b t^4 / 24 + c t^5 / 120 = 0
    let onset = (-b / 24.0 + (b * b / 576.0 + a * c / 180.0).sqrt()) / (c / 60.0);
    let rate = (-a / 2.0 + (b / 6.0 + c / 24.0 * onset) * onset) * onset * onset;
    for exponent in [1.0, 1.5, 3.0] {
        let after = 1e-7;
        let forces = [0.0, -a, b, c].map(|derivative| vec![derivative, 0.0]).to_vec();
        let engine = complete(&balls_that_touch(2, exponent, 1e4), forces, onset + after, 1e-12);
        let overlap = engine.x(0) - engine.x(1);
        assert_eq!(engine.work().events, 1, "p = {exponent}");
        assert!((overlap - rate * after).abs() < 1e-3 * rate * after, "p = {exponent}: {overlap:e}");
    }
}

/// Contacts that have stopped to press while forces vary hold no step back, and no step looks far beyond where they
/// open.
#[test]
fn contacts_without_pressure_hold_no_step_back_while_forces_vary() {
    let mut parameters = balls_that_touch(5, 1.5, 2.1e6);
    (parameters.damping_law, parameters.relaxation_time) = (DampingLaw::Viscoelastic, 7.6e-4);
    let forces =
        [[0.0, 0.502, 0.546, 0.0, 0.0666], [0.0, 0.984, 0.525, -0.549, -0.822], [-0.539, 0.922, 0.0, -0.771, 0.106]];
    let span = 0.0103;
    for start in 0..3 {
        let zero = Inputs::zero(5);
        let mut engine = Engine::new(&parameters, &zero, 0.0).unwrap();
        for point in start..start + 16 {
            let derivative = |order: usize| {
                let force = forces[(point + order) % 3].map(|f| f / f64::powi(span, order as i32)).to_vec();
                Inputs { force, ..zero.clone() }
            };
            let held = if point % 4 == 0 { zero.clone() } else { derivative(0) };
            engine.hold(&held, &[derivative(1), derivative(2), derivative(3)]).unwrap();
            engine.advance(span * (point - start + 1) as f64, &mut Vec::new()).unwrap();
            assert_energy(&engine, 1e-13, &point.to_string());
        }
    }
}

/// Gravity parts balls that touch, and a wave reaches them right after that: their contact does not close before.
#[test]
fn touching_balls_part_before_a_wave_reaches_them() {
    for (first, moving, v) in [(0, 0, 0.01466), (1, 0, 0.01466), (1, 1, 0.01466), (0, 3, -0.1001), (1, 3, -0.1001)] {
        let dead_band = 1.7922e-6;
        let mut parameters = Parameters { exponent: 2.0, dead_band, ..Parameters::default_for(5) };
        parameters.x_start = (first..first + 5).map(|i| -(f64::from(i) * dead_band)).collect();
        parameters.v_start[moving] = v;
        complete(&parameters, vec![vec![0.0; 5]], 0.1, 1e-13);
    }
}

/// The same where forces at the ends press.
#[test]
fn touching_balls_part_before_forces_press_them() {
    for exponent in [1.5, 2.0, 2.5] {
        let dead_band = 1.6529975176654166e-8;
        let mut parameters = Parameters { exponent, dead_band, stiffness: 3.3e8, ..Parameters::default_for(4) };
        parameters.x_start = (0..4).map(|i| -(f64::from(i) * dead_band)).collect();
        complete(&parameters, vec![vec![0.06, 0.0, 0.0, -0.06]], 0.008, 1e-13);
    }
}

/// How fast balls at rest are soon is not told by what they hold as yet: next to no energy, and speeds of next to
/// nothing.
#[test]
fn balls_with_tiny_overlaps_are_pressed() {
    for (overlap, v) in [(7e-23, 0.0), (3e-24, 0.0), (7e-23, 3e-27)] {
        let mut parameters = Parameters { mass: 0.37, ..balls_that_touch(4, 2.5, 2.8e4) };
        parameters.x_start = (0..4).map(|i| -(f64::from(i) * overlap)).collect();
        parameters.v_start[2] = v;
        complete(&parameters, vec![vec![0.3, 0.0, 0.0, -0.3]], 0.09, 1e-13);
    }
}

/// Balls that overlap by next to nothing part by less than rounding: no step is planned to end where they do.
#[test]
fn release_is_not_planned_for_balls_at_rest_but_for_rounding() {
    let mut parameters = cradle(
        7,
        "contact.deadBand=0 ball.mass=0.18320617160920666 contact.exponent=2.5 contact.stiffness=1000915.7391515343 \
         pendulum.drag=0.008168440798958728 v_start=-0.025405157448488994,-0.07375915148600602,0,0,0,0,0",
    );
    parameters.x_start = (0..7).map(|i| -(f64::from(i) * 2.4463804472887435e-21)).collect();
    complete(&parameters, vec![vec![0.0; 7]], 1.2, 1e-13);
}
