//! Derivatives of runs of random cradles: along directions, backwards, and by differences.

use newtons_cradle::engine::{Differential, History, Simulation, Tape, Unfollowed, Unrecorded};
use newtons_cradle::model::Parameters;
use newtons_cradle::variables::Settings;
use proptest::prelude::*;
use proptest::test_runner::Config;

use super::config;
use super::cradles::{ANY, ARCS, Case, Family, cradles, ended_early, rigid};
use crate::differences::by_differences;

/// What a direction changes: the name, and the number in the parameters.
type Known = (&'static str, fn(&mut Parameters) -> &mut f64);

const KNOWNS: [Known; 11] = [
    ("v_start[1]", |p| &mut p.v_start[0]),
    ("x_start[2]", |p| &mut p.x_start[1]),
    ("ball.massRatio[2]", |p| &mut p.mass_ratio[1]),
    ("ball.radiusRatio[2]", |p| &mut p.radius_ratio[1]),
    ("ball.youngModulusRatio[1]", |p| &mut p.young_modulus_ratio[0]),
    ("contact.stiffness", |p| &mut p.stiffness),
    ("pendulum.length", |p| &mut p.length),
    ("contact.deadBand", |p| &mut p.dead_band),
    ("pendulum.drag", |p| &mut p.drag),
    ("contact.damping", |p| &mut p.damping),
    ("contact.restitution", |p| &mut p.restitution),
];

/// Largest difference of both directions over the largest derivative, and over the largest output, in proportion to
/// what changes. Most differ by less than 1e-13; balls that come to rest bounce by bounce magnify rounding.
const BOTH_WAYS: f64 = 1e-6;
const ROUNDING: f64 = 1e-15;

/// Pulses beyond which many impacts have magnified the rounding, and derivatives over the size of the outputs.
const MANY: u64 = 30;
const LARGE: f64 = 1e9;

/// Allowed difference to finite differences, over the largest derivative of the outputs, and over the largest output,
/// in proportion to what changes.
const DIFFERENCES: f64 = 1e-4;
const SMALL: f64 = 1e-9;

fn outputs(of: &Differential) -> Vec<f64> {
    [&of.x[..], &of.v, &of.impulse, &of.force_mean, &of.force_peak, &[of.momentum, of.support_force_mean]].concat()
}

/// The run of a case in two steps, the second one a tenth of it.
fn run(case: &Case, p: &Parameters) -> Result<Simulation, TestCaseError> {
    let mut simulation = Simulation::new(p, &case.inputs, 0.0).map_err(ended_early)?;
    for end in [0.9 * case.time, case.time] {
        simulation.advance(end, &mut Unrecorded).map_err(ended_early)?;
    }
    Ok(simulation)
}

/// The same values of a run as those of [`outputs`].
fn values(run: &Simulation) -> Vec<f64> {
    let (n, contacts) = (run.cradle().balls.len(), run.cradle().contacts.len());
    let balls = (0..n).map(|i| run.x(i)).chain((0..n).map(|i| run.v(i)));
    let of_contacts = (0..contacts).map(|j| run.impulse(j)).chain((0..contacts).map(|j| run.force_mean(j)));
    let peaks = (0..contacts).map(|j| run.force_peak(j));
    balls.chain(of_contacts).chain(peaks).chain([run.momentum(), run.support_force_mean()]).collect()
}

/// How often each contact has closed and opened.
fn pulses(run: &Simulation) -> Vec<(u64, bool)> {
    (0..run.cradle().contacts.len()).map(|j| (run.pulses(j), run.in_contact(j))).collect()
}

/// Forwards and backwards, the sum of the outputs with weights from -1 to 1 changes by the same.
fn both_ways(tape: &Tape, along: &Settings, name: &str, rounding: f64) -> Result<Vec<f64>, TestCaseError> {
    let forwards = outputs(&tape.along(&along.parameters, &along.inputs));
    let weight = |k: usize| (k as f64 * 0.618_033_988_749_895).fract() * 2.0 - 1.0;
    let sum = |of: &Differential| outputs(of).iter().enumerate().map(|(k, of)| weight(k) * of).sum::<f64>();
    let backwards = tape.gradient(sum).along(&along.parameters, &along.inputs);
    let expected: f64 = forwards.iter().enumerate().map(|(k, of)| weight(k) * of).sum();
    let largest = forwards.iter().fold(0.0, |most: f64, of| most.max(of.abs()));
    let off = (backwards - expected).abs();
    let allowed = BOTH_WAYS * largest + rounding;
    prop_assert!(off <= allowed, "{name}: {backwards} backwards, {expected} forwards, largest {largest}");
    Ok(forwards)
}

fn derivatives_agree(case: &Case, which: usize) -> Result<(), TestCaseError> {
    let simulation = run(case, &case.p)?;
    if pulses(&simulation).iter().map(|(pulses, _)| pulses).sum::<u64>() > MANY {
        return Err(TestCaseError::reject("many pulses"));
    }
    let tape = match simulation.tape(&History::default()) {
        Ok(tape) => tape,
        // What is said to have none.
        Err(Unfollowed::TooLong | Unfollowed::RigidBody | Unfollowed::JointImpact | Unfollowed::Grazing) => {
            return Err(TestCaseError::reject("no tape"));
        }
        Err(why) => return Err(TestCaseError::fail(why.to_string())),
    };
    let (name, number) = KNOWNS[which];
    let mut along = Settings::zero(case.p.balls());
    *number(&mut along.parameters) = 1.0;
    let (value, now) = (*number(&mut case.p.clone()), values(&simulation));
    let size = now.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let rounding = if value == 0.0 { 0.0 } else { ROUNDING * size / value.abs() };
    let forwards = outputs(&tape.along(&along.parameters, &along.inputs));
    let scale = forwards.iter().fold(0.0, |most: f64, of| most.max(of.abs()));
    if scale > LARGE * size {
        return Err(TestCaseError::reject("rounding decides"));
    }
    let found = both_ways(&tape, &along, name, rounding)?;
    // Small against what the run depends on so much.
    let h = (1e-4 * value.abs()).min(1e-5 * size / scale);
    if !(h > 1e-9 * value.abs() && h > 0.0) || value - 3.0 * h < 0.0 && name.starts_with("contact.") {
        return Err(TestCaseError::reject("too sensitive for differences"));
    }
    let differences = |h: f64| {
        let mut same = true;
        let found = by_differences(h, false, |change| {
            let mut p = case.p.clone();
            *number(&mut p) += change;
            let changed = run(case, &p).ok().filter(|changed| pulses(changed) == pulses(&simulation));
            same &= changed.is_some();
            changed.map_or_else(|| now.clone(), |changed| values(&changed))
        });
        same.then_some(found.0)
    };
    let (Some(coarse), Some(fine)) = (differences(h), differences(0.5 * h)) else {
        return Err(TestCaseError::reject("other pulses"));
    };
    for (k, (found, (coarse, fine))) in found.iter().zip(coarse.iter().zip(&fine)).enumerate() {
        let noise = (coarse - fine).abs();
        if noise <= 1e-3 * scale {
            let off = (found - fine).abs();
            let small = if value == 0.0 { 0.0 } else { SMALL * size / value.abs() };
            prop_assert!(
                off <= DIFFERENCES * scale + small + 20.0 * noise,
                "{name}, output {k}: {found}, by differences {fine}, largest {scale}"
            );
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(Config { max_global_rejects: 10_000, ..config(60) })]

    #[test]
    fn on_lines(case in cradles(Family { powers: true, ..ANY }), which in 0..KNOWNS.len()) {
        derivatives_agree(&case, which)?;
    }

    #[test]
    fn of_pressed_contacts(case in cradles(Family { pressed: true, powers: true, ..ANY }), which in 0..KNOWNS.len()) {
        derivatives_agree(&case, which)?;
    }

    #[test]
    fn on_arcs(case in cradles(ARCS), which in 0..KNOWNS.len()) {
        derivatives_agree(&case, which)?;
    }

    #[test]
    fn of_rigid_contacts(case in rigid(), which in 0..KNOWNS.len()) {
        derivatives_agree(&case, which)?;
    }
}
