//! One ball is a pendulum: `x'' + 2 gamma x' + omega^2 x = f`, with closed forms for everything.

use newtons_cradle::engine::{Chain, Engine, Results};
use newtons_cradle::model::{Inputs, Parameters};
use proptest::prelude::*;

use super::config;
use super::cradles::decades;
use crate::runs::{cradle, run};

/// Displacement from the equilibrium and velocity after `t`, from `(x, v)`, by the textbook's formulas.
fn swing(omega2: f64, gamma: f64, (x, v): (f64, f64), t: f64) -> (f64, f64) {
    let discriminant = omega2 - gamma * gamma;
    let decay = (-gamma * t).exp();
    let (c, s) = if discriminant >= 0.0 {
        let w = discriminant.sqrt();
        ((w * t).cos(), if w > 0.0 { (w * t).sin() / w } else { t })
    } else {
        let w = (-discriminant).sqrt();
        ((w * t).cosh(), (w * t).sinh() / w)
    };
    (decay * (x * (c + gamma * s) + v * s), decay * (v * (c - gamma * s) - omega2 * x * s))
}

fn single(gravity: f64, mass: f64, drag: f64, (x, v): (f64, f64)) -> Parameters {
    cradle(1, &format!("gravity={gravity} ball.mass={mass} pendulum.drag={drag} x_start={x} v_start={v}"))
}

proptest! {
    #![proptest_config(config(500))]

    /// Under a force and an acceleration of the support that change at some time. The decay rates stay where the
    /// formulas above do not cancel.
    #[test]
    fn pendulum_follows_its_closed_form(
        (gravity, mass, decay) in (0.1..30.0, decades(-2.0, 2.0), prop_oneof![Just(0.0), decades(-4.0, 0.7)]),
        start in (-1.0..1.0, -1.0..1.0),
        ((force, support), (later_force, later_support)) in ((-1.0..1.0, -1.0..1.0), (-1.0..1.0, -1.0..1.0)),
        (change, end) in (0.01..5.0, 0.01..5.0),
    ) {
        let drag = decay * mass;
        let p = single(gravity, mass, drag, start);
        let inputs = |force: f64, support_acceleration: f64| {
            let mut inputs = Inputs::zero(1);
            (inputs.force[0], inputs.support_acceleration) = (force * mass, support_acceleration);
            inputs
        };
        let mut engine = Engine::new(&p, &inputs(force, support), 0.0).unwrap();
        let (omega2, gamma) = (gravity / p.length, 0.5 * decay);
        let mut expected = start;
        let mut time = 0.0;
        for (acceleration, duration) in [(force - support, change), (later_force - later_support, end)] {
            let rest = acceleration / omega2;
            let (x, v) = swing(omega2, gamma, (expected.0 - rest, expected.1), duration);
            expected = (x + rest, v);
            time += duration;
            engine.advance(time, &mut Vec::new()).unwrap();
            engine.hold(&inputs(later_force, later_support), &[]).unwrap();
        }
        let scale = 1.0 + 4.0 / omega2;
        let (dx, dv) = ((engine.x(0) - expected.0).abs(), (engine.v(0) - expected.1).abs());
        prop_assert!(dx < 2e-14 * scale * (1.0 + time * omega2.sqrt()), "x off by {dx:e}");
        prop_assert!(dv < 2e-14 * scale * (1.0 + time * omega2.sqrt()) * (1.0 + omega2.sqrt()), "v off by {dv:e}");
        let energy = mass * (1.0 + 4.0 / omega2) * (1.0 + omega2) * (1.0 + 4.0 / omega2);
        prop_assert!(engine.energy_residual().abs() < 1e-14 * energy, "residual {:e}", engine.energy_residual());
        prop_assert!(engine.dissipated_energy() >= 0.0);
    }

    /// Without drag it is back after any number of periods.
    #[test]
    fn pendulum_period_does_not_drift(gravity in 0.1..30.0, start in (-1.0..1.0, -1.0..1.0), periods in 1u32..100_000) {
        let p = single(gravity, 1.0, 0.0, start);
        let omega = (gravity / p.length).sqrt();
        let end = f64::from(periods) * (std::f64::consts::TAU / omega);
        let engine = run(&p, end);
        // The end itself and the frequency are rounded.
        let phase = 4.0 * f64::EPSILON * omega * end + 1e-15;
        prop_assert!((engine.x(0) - start.0).abs() < phase * (1.0 + 1.0 / omega));
        prop_assert!((engine.v(0) - start.1).abs() < phase * (1.0 + omega));
    }
}
