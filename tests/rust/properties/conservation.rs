//! Energy and momentum, of every cradle at every time.

use newtons_cradle::engine::{Chain, Engine, Results};
use newtons_cradle::model::{ContactModel, Inputs, PendulumModel};
use proptest::collection::vec;
use proptest::prelude::*;

use super::config;
use super::cradles::{ANY, ARCS, Case, Family, cradles, ended_early, rigid};
use super::grids::within;
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
    let at_start = engine.total_energy();
    for point in 0..=POINTS {
        if point > 0 {
            engine.advance(case.time * point as f64 / POINTS as f64, &mut Vec::new()).map_err(ended_early)?;
        }
        scale = energy_scale(&engine, n).max(scale);
        let (residual, now) = (engine.energy_residual(), engine.time());
        prop_assert!(residual.abs() <= 1e-12 * scale, "residual {:e} of the energy at {now}", residual / scale);
        let dissipated = engine.dissipated_energy();
        let balance = engine.total_energy() - at_start + dissipated - engine.external_work();
        prop_assert!((residual - balance).abs() <= 1e-13 * scale, "residual {residual:e}, not {balance:e} at {now}");
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

/// On arcs: places, energies, overlaps and accelerations follow from the angles and the rates, and momentum goes into
/// the support, sideways and upwards.
fn equations_on_arcs_hold(case: &Case, engine: &Engine) -> Result<(), TestCaseError> {
    let (p, n, now) = (&case.p, case.p.balls(), engine.time());
    let close = |what: &str, value: f64, expected: f64, allowed: f64| {
        prop_assert!((value - expected).abs() <= allowed, "{what} at {now}: {value}, not {expected} to {allowed:e}");
        Ok(())
    };
    // What contacts do to the balls, sideways and upwards; the strings to the support; the largest force.
    let (mut pushes, mut support, mut energy, mut largest) = (vec![[0.0; 2]; n], [0.0; 2], 0.0, 0.0f64);
    for i in 0..n - 1 {
        let radii = p.radius_of(i) + p.radius_of(i + 1);
        let rest = radii + p.gap[i];
        let apart = [rest + engine.x(i + 1) - engine.x(i), engine.y(i + 1) - engine.y(i)];
        let distance = apart[0].hypot(apart[1]);
        close("overlap", engine.overlap(i), radii - p.dead_band - distance, 1e-14 * (1.0 + rest))?;
        for k in 0..2 {
            pushes[i][k] -= engine.force(i) * apart[k] / distance;
            pushes[i + 1][k] += engine.force(i) * apart[k] / distance;
        }
        (energy, largest) = (energy + engine.contact_energy(i), largest.max(engine.force(i).abs()));
    }
    for (i, [sideways, upwards]) in pushes.into_iter().enumerate() {
        let (mass, length, angle) = (p.mass * p.mass_ratio[i], p.length * p.length_ratio[i], engine.angle(i));
        let ((sin, cos), height) = (angle.sin_cos(), 2.0 * length * (0.5 * angle).sin().powi(2));
        let (speed, weight) = (engine.v(i) / cos, mass * p.gravity);
        let outside = case.inputs.force[i] - mass * case.inputs.support_acceleration;
        close("x", engine.x(i), length * sin, 1e-14 * length)?;
        close("y", engine.y(i), height, 1e-14 * length)?;
        close("E_kinetic", engine.kinetic_energy(i), 0.5 * mass * speed * speed, 1e-14 * mass * speed * speed)?;
        close("E_gravity", engine.gravity_energy(i), weight * height, 1e-14 * weight * length)?;
        energy += engine.kinetic_energy(i) + engine.gravity_energy(i);
        let along = (sideways + outside) * cos + (upwards - weight) * sin - p.drag * speed;
        let inward = mass * speed * speed / length;
        largest = largest.max(outside.abs()).max(weight).max(inward).max(p.drag * speed.abs());
        let own = [along * cos - inward * sin, along * sin + inward * cos];
        close("a", mass * engine.a(i), own[0], 1e-12 * largest)?;
        support = [support[0] + outside - own[0], support[1] - weight - own[1]];
    }
    close("F_support", engine.support_force(), support[0], 1e-12 * largest)?;
    close("F_support_vertical", engine.support_force_vertical(), support[1], 1e-12 * largest)?;
    close("E_total", engine.total_energy(), energy, 1e-14 * energy)
}

proptest! {
    #![proptest_config(config(100))]

    /// In flight and within contacts.
    #[test]
    fn arcs_motion_obeys_the_equations(case in cradles(ARCS), mut shares in vec(0.0..1.0, 5)) {
        shares.extend(within(&case.run()?.1, &shares, case.time));
        shares.sort_by(f64::total_cmp);
        let mut engine = case.start()?;
        for share in shares {
            engine.advance(share * case.time, &mut Vec::new()).map_err(ended_early)?;
            equations_on_arcs_hold(&case, &engine)?;
        }
    }
}

proptest! {
    #![proptest_config(config(800))]

    #[test]
    fn conservation_of_energy_momentum_and_impulses(case in cradles(ANY)) {
        all_is_accounted_for(&case)?;
    }

    #[test]
    fn conservation_of_energy_momentum_and_impulses_on_arcs(case in cradles(ARCS)) {
        all_is_accounted_for(&case)?;
    }

    #[test]
    fn conservation_of_energy_momentum_and_impulses_of_rigid_balls(case in rigid()) {
        all_is_accounted_for(&case)?;
    }

    /// With inputs that change between the steps and within them.
    #[test]
    fn conservation_of_rigid_energy_under_changing_inputs(
        case in rigid(),
        changes in vec((0..6usize, -3.0..3.0, -10.0..10.0, any::<bool>()), 2..12),
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
    fn conservation_of_energy_in_pressed_runs(mut case in cradles(Family { pressed: true, ..ANY })) {
        case.time = case.time.min(1.0);
        all_is_accounted_for(&case)?;
    }
}
