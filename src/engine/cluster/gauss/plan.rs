//! Planning: the first attempt from the forecasts, the next one from the outcome of an attempt.

use super::motion::{Motion, Tolerance};
use super::step::{Outcome, Plan};
use crate::engine::cluster::step_control::Problem;
use crate::engine::cluster::window::Switch;
use crate::solver::gauss::Stretching;

/// Allowed size of the two highest Legendre coefficients over the scale of the velocities, times the exponent of the
/// contacts, at the default tolerance. The end of a step has twice as many digits: its error is 1e-16, within the step
/// 3e-14. Guarded by `balls_that_rattle_keep_their_energy_at_all_times`.
const TAIL: f64 = 1.5e-10;
const EPSILON: f64 = 1e-17;

/// First step over the time in which the fastest contact stops its balls: from an onset on, from another switching on,
/// and for a whole exponent, over the exponent.
const FIRST: f64 = 0.5;
const FIRST_LATER: f64 = 0.8;
const FIRST_SMOOTH: f64 = 1.6;

/// Largest number of steps ahead at which a switching becomes the end of the step.
const NEAR: f64 = 0.7;

/// The next step over the last one: the part of what the error allows, the least and largest factor, and the factors
/// after a step that did not reach a release and after a failed one.
const SAFETY: f64 = 0.93;
const CHANGE: [f64; 2] = [0.3, 4.0];
const SHORTER: f64 = 0.65;
const FAILED: f64 = 0.5;
const LEAST: f64 = 0.05;

/// What to do after an attempt.
#[derive(Clone, Copy, Debug)]
pub(super) enum Decision {
    /// The step is accepted; length of the next one, s.
    Take(f64),
    /// The step has no length: this contact switches at its start.
    End(usize, Switch),
    Try(Plan),
    /// The step is left to another method.
    GiveUp,
}

#[derive(Debug)]
pub(super) struct Planner {
    /// The stretching of a step that ends at no release.
    stretching: Stretching,
    /// Longest such step, by the attempts so far, s.
    length: f64,
    pub tolerance: Tolerance,
}

impl Planner {
    /// The first plan. See [`Motion::follow`] for the arguments.
    pub fn new(motion: &Motion, problem: &Problem, before: f64) -> (Self, Plan) {
        let &Problem { window, control, ref rounding, speed, local_error } = problem;
        let longest = motion.longest().min(control.longest).min(motion.reach_of_branch_points(rounding));
        let tolerance = Tolerance {
            speed,
            tail: motion.smoothness() * TAIL / window.laws[0].exponent * (control.epsilon / EPSILON).sqrt().max(1.0),
            local_error,
            longest,
            rounding: *rounding,
        };
        let (power, stretching) = (motion.stretching_power(), motion.onset_stretching(rounding, speed));
        let first = match power {
            None => FIRST_SMOOTH / window.laws[0].exponent,
            Some(_) if stretching == Stretching::None => FIRST_LATER,
            Some(_) => FIRST,
        };
        let length = if before > 0.0 { before } else { first * motion.fastest(window, speed) };
        let mut planner = Self { stretching, length, tolerance };
        let near =
            |ahead: Option<(usize, f64)>| ahead.filter(|(_, time)| (f64::MIN_POSITIVE..NEAR * length).contains(time));
        let release = motion.release_ahead(rounding);
        // A step that begins at a branch point does not end at one.
        let plan = if stretching == Stretching::None
            && let Some((j, time)) = near(release)
        {
            to_release(motion, j, time)
        } else if let Some((j, time)) = near(motion.switching_ahead(rounding)) {
            planner.to_switching(j, time)
        } else if let Some((_, time)) = release
            && power.is_some()
        {
            planner.ahead(SHORTER * time)
        } else {
            planner.ahead(length)
        };
        (planner, Plan { length: plan.length.min(longest), ..plan })
    }

    /// A step of this length (s) or the longest allowed, to no switching.
    fn ahead(&mut self, length: f64) -> Plan {
        self.length = self.length.min(length);
        Plan { stretching: self.stretching, length: self.length, switching: None }
    }

    /// A step to the switching of contact `j`, where that has no branch point, in about this time (s).
    fn to_switching(&self, j: usize, length: f64) -> Plan {
        Plan { stretching: self.stretching, length, switching: Some(j) }
    }

    pub fn decide(&mut self, motion: &Motion, plan: &Plan, outcome: Outcome) -> Decision {
        // An iteration that diverges may have moved the end anywhere.
        let (least, longest) = (LEAST * plan.length, self.tolerance.longest);
        let (reached, tried) = (motion.length, motion.length.clamp(least, plan.length));
        let plan = match (outcome, plan.switching) {
            (Outcome::Stands(error), _) => {
                return Decision::Take((reached * change_for(error)).min(longest));
            }
            // The mean slope over a step does not show which way a force, or an overlap at rest, goes from 0; a series
            // does.
            (Outcome::AtOnce(_, Switch::Clip), _) => return Decision::GiveUp,
            (Outcome::AtOnce(j, Switch::Release), _) if motion.tracks[j].is_resting(&self.tolerance.rounding) => {
                return Decision::GiveUp;
            }
            (Outcome::AtOnce(j, switch), _) => return Decision::End(j, switch),
            // It switches before the end found for it; the same step would give the same result.
            (Outcome::Within(j, _, time), Some(planned)) if j == planned => self.ahead(SHORTER * time.max(least)),
            (Outcome::Within(j, Switch::Release, time), _) if motion.presses(j) => {
                match plan.stretching {
                    Stretching::None | Stretching::AtEnd(_) => to_release(motion, j, time.max(least)),
                    // It closes and opens in one step.
                    Stretching::AtStart(_) => self.ahead(FAILED * time.max(least)),
                }
            }
            (Outcome::Within(j, _, time), _) => self.to_switching(j, time.max(least)),
            // It nearly opens; the same step would give the same result.
            (Outcome::NoSwitching, _) => self.ahead(SHORTER * self.length.min(reached.max(least))),
            (Outcome::TooLong(_) | Outcome::Failed, Some(_)) => self.ahead(SHORTER * tried),
            (Outcome::TooLong(error), None) => self.ahead(tried * change_for(error).min(SHORTER)),
            (Outcome::Failed, None) => self.ahead(FAILED * tried),
        };
        Decision::Try(Plan { length: plan.length.min(longest), ..plan })
    }
}

/// The step that ends where contact `j` opens, in about this `time` (s).
fn to_release(motion: &Motion, j: usize, time: f64) -> Plan {
    let stretching = motion.stretching_power().map_or(Stretching::None, Stretching::AtEnd);
    Plan { stretching, length: time, switching: Some(j) }
}

/// The next step over the last one, from its error over the allowed one.
fn change_for(error: f64) -> f64 {
    // The sixteenth root, which is nearly that of the order.
    let root = error.sqrt().sqrt().sqrt().sqrt();
    (SAFETY / root).clamp(CHANGE[0], CHANGE[1])
}

/// Prints an attempt, its outcome and the decision, in a build with `--features trace`.
#[expect(clippy::print_stderr, reason = "that is what the feature is for")]
pub(super) fn trace(plan: &Plan, outcome: &Outcome, decision: &Decision) {
    if cfg!(feature = "trace") {
        eprintln!("{plan:?} -> {outcome:?} -> {decision:?}");
    }
}
