//! Energy and momentum, of every cradle at every time.

use newtons_cradle::engine::{Chain, Engine, Results};
use newtons_cradle::model::{ContactModel, Inputs, PendulumModel};
use proptest::prelude::*;

use super::config;
use super::cradles::{ANY, ARCS, Case, Family, cradles, ended_early, rigid};
use crate::runs::{energy, state};

/// Communication points in a run of a property.
const POINTS: usize = 20;

/// The largest energies in a run so far, J, as the scale of errors.
pub fn energy_scale(engine: &Engine, n: usize) -> f64 {
    let contacts: f64 = (0..n - 1).map(|i| engine.contact_energy(i)).sum();
    energy(engine) + contacts
}

/// Energy is balanced, and losses never fall. In each step the momentum changes by the external forces and that of the
/// support; for each ball of a free chain without drag, by the impulses of its contacts and the inputs.
fn all_is_accounted_for(case: &Case) -> Result<(), TestCaseError> {
    let n = case.p.balls();
    let masses: Vec<f64> = case.p.mass_ratio.iter().map(|ratio| ratio * case.p.mass).collect();
    let pushed = case.inputs.force.iter().sum::<f64>() - case.inputs.support_acceleration * case.mass();
    let (mut total, mut lost) = (f64::INFINITY, 0.0);
    let (mut before, mut momenta, mut time, mut largest) = (f64::NAN, 0.0f64, 0.0, 0.0f64);
    let (mut engine, mut scale) = (case.start()?, 0.0);
    for point in 0..=POINTS {
        if point > 0 {
            engine.advance(case.time * point as f64 / POINTS as f64, &mut Vec::new()).map_err(ended_early)?;
        }
        scale = energy_scale(&engine, n).max(scale);
        let (residual, now) = (engine.energy_residual(), engine.time());
        prop_assert!(residual.abs() <= 1e-12 * scale, "residual {:e} of the energy at {now}", residual / scale);
        let dissipated = engine.dissipated_energy();
        // Each of many bounces rounds.
        let rounding = if case.p.contact_model == ContactModel::Rigid { 1e-13 } else { 1e-14 };
        prop_assert!(dissipated >= lost - rounding * scale, "{:e} came back at {now}", lost - dissipated);
        let gained = engine.total_energy() - total;
        prop_assert!(case.driven() || gained <= 1e-12 * scale, "energy was gained at {now}");
        (total, lost) = (engine.total_energy(), dissipated);

        let (_, v) = state(&engine, n);
        let step = now - time;
        let from_support = engine.support_force_mean() * step;
        momenta = momenta.max(masses.iter().zip(&v).map(|(m, v)| m * v.abs()).sum::<f64>());
        momenta = momenta.max(from_support.abs()).max(pushed.abs() * step).max(engine.support_force().abs() * step);
        if !before.is_nan() {
            let off = engine.momentum() - before - pushed * step + from_support;
            prop_assert!(off.abs() <= 1e-12 * momenta, "momentum off by {:e} at {now}", off / momenta);
        }
        (before, time) = (engine.momentum(), now);

        let free = case.p.gravity == 0.0 && case.p.drag == 0.0 && case.p.pendulum == PendulumModel::Linear;
        for i in (0..n).filter(|_| free) {
            let from_left = if i > 0 { engine.impulse(i - 1) } else { 0.0 };
            let from_right = if i + 1 < n { engine.impulse(i) } else { 0.0 };
            let push = (case.inputs.force[i] - masses[i] * case.inputs.support_acceleration) * now;
            let momentum = masses[i] * case.p.v_start[i] + push + from_left - from_right;
            largest = largest.max(from_left.abs() + from_right.abs() + push.abs() + masses[i] * v[i].abs());
            let off = (masses[i] * v[i] - momentum).abs();
            prop_assert!(off <= 1e-12 * largest, "ball {i}: off by {:e}", off / largest);
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(800))]

    #[test]
    fn energy_momentum_and_impulses(case in cradles(ANY)) {
        all_is_accounted_for(&case)?;
    }

    #[test]
    fn energy_momentum_and_impulses_on_arcs(case in cradles(ARCS)) {
        all_is_accounted_for(&case)?;
    }

    #[test]
    fn energy_momentum_and_impulses_of_rigid_balls(case in rigid()) {
        all_is_accounted_for(&case)?;
    }

    /// With inputs that change between the steps and within them.
    #[test]
    fn energy_of_rigid_runs_under_changing_inputs(
        case in rigid(),
        changes in proptest::collection::vec((0..6usize, -3.0..3.0, -10.0..10.0, any::<bool>()), 2..12),
    ) {
        let mut engine = case.start()?;
        let mut scale = energy_scale(&engine, case.p.balls());
        let mut held = case.inputs.clone();
        for (k, (ball, force, rate, ramps)) in (1..).zip(&changes) {
            let mut derivative = Inputs::zero(case.p.balls());
            let ball = ball % case.p.balls();
            held.force[ball] = force * case.p.mass;
            derivative.force[ball] = rate * case.p.mass;
            let derivatives = if *ramps { vec![derivative] } else { Vec::new() };
            engine.hold(&held, &derivatives).map_err(ended_early)?;
            engine.advance(case.time * f64::from(k) / changes.len() as f64, &mut Vec::new()).map_err(ended_early)?;
            scale = scale.max(energy_scale(&engine, case.p.balls()));
            let off = engine.energy_residual().abs() / scale;
            prop_assert!(off <= 1e-12, "residual {off:e} at {}", engine.time());
            for i in 0..case.p.balls() - 1 {
                prop_assert!(engine.overlap(i) <= 0.0 && engine.force(i) >= 0.0);
            }
        }
    }
}

proptest! {
    #![proptest_config(config(60))]

    #[test]
    fn energy_of_pressed_runs(mut case in cradles(Family { pressed: true, ..ANY })) {
        case.time = case.time.min(1.0);
        all_is_accounted_for(&case)?;
    }
}
