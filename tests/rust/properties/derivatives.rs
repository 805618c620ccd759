//! Derivatives of runs of random cradles: along directions, backwards, and by differences.

use newtons_cradle::engine::{Differential, History, Simulation, Tape, Unfollowed, Unrecorded};
use newtons_cradle::model::Inputs;
use newtons_cradle::variables::Settings;
use proptest::prelude::*;
use proptest::test_runner::Config;

use super::config;
use super::cradles::{ANY, ARCS, Case, Family, cradles, ended_early, rigid};
use crate::differences::by_differences;

/// What a direction changes: the name, and the number in the settings; over the whole run, or over the last step only.
type Known = (&'static str, fn(&mut Settings) -> &mut f64, Over);

#[derive(Clone, Copy, PartialEq)]
enum Over {
    Run,
    Step,
}

const KNOWNS: [Known; 18] = [
    ("v_start[1]", |s| &mut s.parameters.v_start[0], Over::Run),
    ("x_start[2]", |s| &mut s.parameters.x_start[1], Over::Run),
    ("ball.massRatio[2]", |s| &mut s.parameters.mass_ratio[1], Over::Run),
    ("ball.radiusRatio[2]", |s| &mut s.parameters.radius_ratio[1], Over::Run),
    ("ball.youngModulusRatio[1]", |s| &mut s.parameters.young_modulus_ratio[0], Over::Run),
    ("contact.stiffness", |s| &mut s.parameters.stiffness, Over::Run),
    ("pendulum.length", |s| &mut s.parameters.length, Over::Run),
    ("contact.deadBand", |s| &mut s.parameters.dead_band, Over::Run),
    ("pendulum.drag", |s| &mut s.parameters.drag, Over::Run),
    ("contact.damping", |s| &mut s.parameters.damping, Over::Run),
    ("contact.huntCrossley", |s| &mut s.parameters.hunt_crossley, Over::Run),
    ("contact.relaxationTime", |s| &mut s.parameters.relaxation_time, Over::Run),
    ("contact.restitution", |s| &mut s.parameters.restitution, Over::Run),
    ("contact.lossRatio[1]", |s| &mut s.parameters.loss_ratio[0], Over::Run),
    ("force[1]", |s| &mut s.inputs.force[0], Over::Run),
    ("supportAcceleration", |s| &mut s.inputs.support_acceleration, Over::Run),
    ("force[2]", |s| &mut s.inputs.force[1], Over::Step),
    ("supportAcceleration", |s| &mut s.inputs.support_acceleration, Over::Step),
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

/// The run of a case in two steps, the second one a tenth of it and with inputs of its own.
fn run(case: &Case, settings: &Settings, inputs_of_step: &Inputs) -> Result<Simulation, TestCaseError> {
    let mut simulation = Simulation::new(&settings.parameters, &settings.inputs, 0.0).map_err(ended_early)?;
    simulation.advance(0.9 * case.time, &mut Unrecorded).map_err(ended_early)?;
    simulation.hold(inputs_of_step, &[]).map_err(ended_early)?;
    simulation.advance(case.time, &mut Unrecorded).map_err(ended_early)?;
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
    let (name, number, over) = KNOWNS[which];
    let settings = {
        let (parameters, inputs) = (case.p.clone(), case.inputs.clone());
        Settings { parameters, inputs, ..Settings::default_for(case.p.balls()) }
    };
    let simulation = run(case, &settings, &settings.inputs)?;
    if pulses(&simulation).iter().map(|(pulses, _)| pulses).sum::<u64>() > MANY {
        return Err(TestCaseError::reject("many pulses"));
    }
    let tape = match over {
        Over::Run => simulation.tape(&History::default()),
        Over::Step => simulation.tape_of_step(&History::default()),
    };
    let tape = match tape {
        Ok(tape) => tape,
        // What is said to have none.
        Err(Unfollowed::TooLong | Unfollowed::RigidBody | Unfollowed::JointImpact | Unfollowed::Grazing) => {
            return Err(TestCaseError::reject("no tape"));
        }
        Err(why) => return Err(TestCaseError::fail(why.to_string())),
    };
    let mut along = Settings::zero(case.p.balls());
    *number(&mut along) = 1.0;
    let (value, now) = (*number(&mut settings.clone()), values(&simulation));
    if name == "contact.restitution" && value == 0.0 {
        return Err(TestCaseError::reject("a power of 0"));
    }
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
            let mut other = settings.clone();
            *number(&mut other) += change;
            let before = if over == Over::Run { &other } else { &settings };
            let changed =
                run(case, before, &other.inputs).ok().filter(|changed| pulses(changed) == pulses(&simulation));
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
    fn derivatives_of_random_runs_on_lines(case in cradles(Family { powers: true, ..ANY }), which in 0..KNOWNS.len()) {
        derivatives_agree(&case, which)?;
    }

    #[test]
    fn derivatives_of_random_runs_of_pressed_contacts(
        case in cradles(Family { pressed: true, powers: true, ..ANY }),
        which in 0..KNOWNS.len(),
    ) {
        derivatives_agree(&case, which)?;
    }

    #[test]
    fn derivatives_of_random_runs_on_arcs(case in cradles(ARCS), which in 0..KNOWNS.len()) {
        derivatives_agree(&case, which)?;
    }

    #[test]
    fn derivatives_of_random_runs_of_rigid_contacts(case in rigid(), which in 0..KNOWNS.len()) {
        derivatives_agree(&case, which)?;
    }
}
