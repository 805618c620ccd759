//! `contact.model = rigid`: impacts without duration, and balls that stay in contact.

use newtons_cradle::engine::{Engine, NEVER, Pulse};
use newtons_cradle::model::{ContactModel, Inputs, Parameters};

/// `n` rigid balls without dead band at rest in touch.
fn rigid(n: usize, restitution: f64) -> Parameters {
    let mut p = Parameters::default_for(n);
    (p.contact_model, p.restitution, p.dead_band) = (ContactModel::Rigid, restitution, 0.0);
    p.x_start = vec![0.0; n];
    p
}

fn started(p: &Parameters) -> Engine {
    Engine::new(p, &Inputs::zero(p.balls()), 0.0).unwrap()
}

fn velocities(engine: &Engine, n: usize) -> Vec<f64> {
    (0..n).map(|i| engine.v(i)).collect()
}

fn energy_holds(engine: &Engine) {
    let scale = engine.total_energy() + engine.dissipated_energy() + engine.external_work().abs();
    assert!(engine.energy_residual().abs() <= 1e-13 * scale, "{:e}", engine.energy_residual() / scale);
}

/// As many balls leave as were lifted, click after click.
#[test]
fn one_to_four_lifted_balls_of_five() {
    for lifted in 1..=4 {
        let mut p = rigid(5, 1.0);
        p.x_start[..lifted].fill(-0.1);
        let mut engine = started(&p);
        let quarter = 0.5 * std::f64::consts::PI / (p.gravity / p.length).sqrt();
        let mut pulses = Vec::new();
        for click in 0..100 {
            // Half way between two clicks.
            engine.advance((2.0 * f64::from(click) + 2.0) * quarter, &mut pulses).unwrap();
            let right = click % 2 == 0;
            for i in 0..5 {
                let swings = if right { i >= 5 - lifted } else { i < lifted };
                let expected = if !swings { 0.0 } else if right { 0.1 } else { -0.1 };
                assert!((engine.x(i) - expected).abs() < 1e-13, "{lifted} {click} {i}: {}", engine.x(i));
            }
            assert_eq!(pulses.len(), (click as usize + 1) * lifted * (5 - lifted));
        }
        assert!(engine.dissipated_energy() < 1e-30);
        energy_holds(&engine);
    }
}
