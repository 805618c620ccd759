//! The plan of an attempt: the first from forecasts of switchings and branch points, the next from the last outcome.

use super::motion::{GaussStep, StepContact, Tolerance};
use super::step::{Attempt, Plan};
use super::switching::fall;
use crate::engine::cluster::step_control::Problem;
use crate::engine::cluster::window::{Switch, Window};
use crate::engine::flight::{Flight, Rounding};
use crate::model::{BallModel, Mode};
use crate::solver::{NODES, Power, Stretching, Table};

/// Allowed size of the two highest Legendre coefficients over the scale of the velocities, times the exponent of the
/// contacts, at the default tolerance. The end of a step has twice as many digits: its error is 1e-16, within the step
/// 3e-14. Guarded by `rattling_balls_keep_their_energy_at_all_times`.
const TAIL: f64 = 1.5e-10;
const EPSILON: f64 = 1e-17;

/// First step over the time in which the fastest contact stops its balls; for a whole exponent, this is over the
/// exponent.
const FIRST_STEP: f64 = 0.5;
const FIRST_SMOOTH_STEP: f64 = 1.6;

/// Number of steps ahead up to which a switching becomes the end of the step.
const STEPS_AHEAD: f64 = 0.7;

/// Ratio of the next step to the last one: the part that is taken of what the error allows, the least and the largest
/// ratio, and the ratio after a step that failed or did not reach a release.
const SAFETY: f64 = 0.93;
const LENGTH_RATIOS: [f64; 2] = [0.3, 4.0];
const SHORTER_RATIO: f64 = 0.65;

/// Contacts that have just closed need no stretched step if their rate is below this part of the speed of the others;
/// contacts about to open are ignored if their overlap is below this part of the largest one.
const NEGLIGIBLE_CONTACT: f64 = 1e-6;

/// Weight of the rate at the release in the mean rate until then: from rest to the release it is half an impact's
/// duration.
const LAST_IN_MEAN: f64 = 0.68;

/// Longest step over the time scale of the pendulums, because their error is not checked.
const SWING_OF_A_STEP: f64 = 0.25;

/// Largest angle (rad) by which balls on arcs turn in a step.
const SMALL_ANGLE: f64 = 1e-3;

/// A step feels the branch point of a contact that has just closed or is about to open if it is longer than this many
/// times the time to it. Guarded by `onset_of_contacts_closed_at_the_start` and
/// `rattling_balls_cost_little_and_keep_their_energy`.
const BEYOND: f64 = 8.0;

/// What follows an attempt.
#[derive(Clone, Copy, Debug)]
pub(super) enum Decision {
    /// Another attempt, by this plan.
    Retry(Plan),
    /// The step is done: the length of it, 0 if a contact switches at its start, and of the next one, s.
    Done { length: f64, next: f64 },
    /// The motion is left to another method.
    LeaveToOther,
}

pub(super) struct Planner<'a> {
    /// The stretching of steps that do not end at a release.
    stretching: Stretching,
    /// Longest such step that the attempts so far allow, s.
    length: f64,
    pub tolerance: Tolerance<'a>,
    /// Length of the step before, s.
    before: f64,
}

impl<'a> Planner<'a> {
    /// The first plan. See [`GaussStep::follow`] for the arguments.
    pub fn new(motion: &GaussStep, problem: &'a Problem<'a>, before: f64) -> (Self, Plan) {
        let &Problem { window, control, ref rounding, speed, .. } = problem;
        // The stretching of a step serves only a branch point at its start, not one shortly before it.
        let since = |contact: &StepContact| to_branch_point(contact, contact.overlap, contact.rate, rounding);
        let since = motion.contacts.iter().filter_map(since).fold(f64::INFINITY, f64::min);
        let longest = (BEYOND * since).min(motion.longest()).min(control.longest);
        let smoothness = motion.branch_point.map_or(1.0, |branch_point| branch_point.smoothness);
        let tolerance = Tolerance {
            problem,
            tail: smoothness * TAIL / window.laws[0].exponent * (control.epsilon / EPSILON).sqrt().max(1.0),
            longest,
        };
        let (branches, stretching) = (motion.branch_point.is_some(), motion.onset_stretching(rounding, speed));
        let first = if branches { FIRST_STEP } else { FIRST_SMOOTH_STEP / window.laws[0].exponent };
        let length = if before > 0.0 { before } else { first * motion.fastest(window, speed) };
        let mut planner = Self { stretching, length, tolerance, before };
        let near = |ahead: Option<(usize, f64)>| {
            ahead.filter(|(_, time)| (f64::MIN_POSITIVE..STEPS_AHEAD * length).contains(time))
        };
        let release = motion.release_ahead(rounding);
        // A step that begins at a branch point does not end at one. Fourth powers make steps too short to reach one;
        // forces that need fourth powers clip before the balls part.
        let plan = if stretching == Stretching::None
            && let Some((j, time)) = near(release)
            && motion.branch_point.is_none_or(|branch_point| branch_point.power != Power::Fourth)
        {
            to_release(motion, j, time)
        } else if let Some((j, time)) = near(motion.switching_ahead(rounding)) {
            planner.to_switching(j, time)
        } else if let Some((_, time)) = release
            && branches
        {
            planner.ahead(SHORTER_RATIO * time)
        } else {
            planner.ahead(length)
        };
        (planner, Plan { length: plan.length.min(longest), ..plan })
    }

    /// Plans a step that ends at no switching, of this length (s) or the longest one allowed.
    fn ahead(&mut self, length: f64) -> Plan {
        self.length = self.length.min(length);
        Plan { stretching: self.stretching, length: self.length, switching: None }
    }

    /// Plans a step that ends, in about this time (s), where contact `j` switches without a branch point.
    fn to_switching(&self, j: usize, length: f64) -> Plan {
        Plan { stretching: self.stretching, length, switching: Some(j) }
    }

    /// Decides what to do after an attempt.
    pub fn decide(&mut self, motion: &mut GaussStep, plan: &Plan, outcome: Attempt) -> Decision {
        // An iteration that diverges may have moved the end anywhere.
        let (least, longest) = (LENGTH_RATIOS[0] * plan.length, self.tolerance.longest);
        let (reached, tried) = (motion.length, motion.length.clamp(least, plan.length));
        let plan = match (outcome, plan.switching) {
            (Attempt::Stands(error), _) => {
                return Decision::Done { length: motion.until, next: (reached * change_for(error)).min(longest) };
            }
            // A series shows which way a force or an overlap goes from 0; the mean slope over a step does not.
            (Attempt::AtOnce(_, Switch::Clip), _) => return Decision::LeaveToOther,
            (Attempt::AtOnce(j, Switch::Release), _)
                if motion.contacts[j].is_resting(&self.tolerance.problem.rounding) =>
            {
                return Decision::LeaveToOther;
            }
            (Attempt::AtOnce(j, switch), _) => {
                (motion.length, motion.until, motion.end) = (0.0, 0.0, Some((j, switch)));
                motion.at_nodes.forces.iter_mut().for_each(|forces| *forces = [0.0; NODES]);
                return Decision::Done { length: 0.0, next: self.before };
            }
            // It switches before its planned end; the same step would give the same result.
            (Attempt::Within(j, _, time), Some(planned)) if j == planned => self.ahead(SHORTER_RATIO * time.max(least)),
            (Attempt::Within(j, Switch::Release, time), _) if motion.presses(j) => {
                match plan.stretching {
                    Stretching::None | Stretching::AtEnd(_) => to_release(motion, j, time.max(least)),
                    // It closes and opens in one step.
                    Stretching::AtStart(_) => self.ahead(SHORTER_RATIO * time.max(least)),
                }
            }
            (Attempt::Within(j, _, time), _) => self.to_switching(j, time.max(least)),
            // It nearly opens; the same step would give the same result.
            (Attempt::NoSwitching, _) => self.ahead(SHORTER_RATIO * self.length.min(reached.max(least))),
            (Attempt::TooLong(error), None) => self.ahead(tried * shorter_for(error, plan.stretching)),
            (Attempt::TooLong(_) | Attempt::Failed, _) => self.ahead(SHORTER_RATIO * tried),
        };
        Decision::Retry(Plan { length: plan.length.min(longest), ..plan })
    }
}

impl GaussStep {
    /// The stretching for contacts that have just closed at a rate that matters at this `speed` (m/s).
    fn onset_stretching(&self, rounding: &Rounding, speed: f64) -> Stretching {
        let fresh = |contact: &StepContact| {
            contact.mode == Mode::Pressing
                && contact.overlap <= rounding.position
                && contact.rate >= NEGLIGIBLE_CONTACT * speed
        };
        let branch_point = self.branch_point.filter(|_| self.contacts.iter().any(fresh));
        branch_point.map_or(Stretching::None, |branch_point| Stretching::AtStart(branch_point.power))
    }

    /// The time in which the fastest contact stops balls of this `speed` (m/s), s.
    fn fastest(&self, window: &Window, speed: f64) -> f64 {
        // Contacts have one exponent and one reference overlap.
        let squared_time = |j: &usize| window.reduced_mass(*j) / self.contacts[*j].law.stiffness;
        let pressing = (0..self.contacts.len()).filter(|j| self.presses(*j));
        let fastest = pressing.min_by(|a, b| squared_time(a).total_cmp(&squared_time(b)));
        fastest.map_or(f64::INFINITY, |j| self.contacts[j].law.largest_overlap(window.reduced_mass(j), speed) / speed)
    }

    /// The longest step on which the pendulums hardly act, s.
    fn longest(&self) -> f64 {
        let pace = self.pace();
        let longest = if pace > 0.0 { SWING_OF_A_STEP / pace } else { f64::INFINITY };
        let moving = self.arcs.models.iter().zip(&self.flights).filter(|(_, flight)| flight.v != 0.0);
        let turn = |(ball, flight): (&BallModel, &Flight)| SMALL_ANGLE * ball.length / flight.v.abs();
        moving.map(turn).fold(longest, f64::min)
    }

    /// Whether a step with its time stretched to a release ends shortly before the branch point of another contact.
    pub(super) fn ends_before_branch_point(&self, table: &Table, rounding: &Rounding) -> bool {
        let follows = |(j, contact): (usize, &StepContact)| {
            let (overlap, rate) = (self.overlap_at_end(j, self.curvature(j, table)), self.rate_at_end(j, table));
            let time = to_branch_point(contact, overlap, -rate, rounding);
            self.end.is_none_or(|(own, _)| own != j) && time.is_some_and(|time| self.length > BEYOND * time)
        };
        matches!(self.stretching, Stretching::AtEnd(_)) && self.contacts.iter().enumerate().any(follows)
    }

    /// The closed contact that opens or clips first, and when, s. Contacts that hardly press are ignored.
    fn release_ahead(&self, rounding: &Rounding) -> Option<(usize, f64)> {
        let largest = self.contacts.iter().map(|contact| contact.overlap).fold(0.0, f64::max);
        let negligible = rounding.no_overlap().max(NEGLIGIBLE_CONTACT * largest);
        let opens = |contact: &StepContact| {
            contact.mode == Mode::Pressing && contact.rate < 0.0 && contact.overlap > negligible
        };
        self.first_at_zero(|contact| {
            if !opens(contact) {
                return None;
            }
            let inverse_mass = contact.inverse_masses[0] + contact.inverse_masses[1];
            let own = inverse_mass * contact.law.unclipped_force(contact.overlap, contact.rate).max(0.0);
            // Its force drives the balls apart and vanishes on the way: the rate follows from its remaining energy.
            let last =
                (contact.rate * contact.rate + 2.0 * own * contact.overlap / (contact.law.exponent + 1.0)).sqrt();
            let rate = (1.0 - LAST_IN_MEAN) * contact.rate - LAST_IN_MEAN * last;
            Some((rate, (contact.accelerations[0] + own).max(0.0)))
        })
    }

    /// The first clipped contact to open, or open one to close, and when, s. Without a force it has no branch point.
    /// Balls side by side are left out, because rounding decides there.
    fn switching_ahead(&self, rounding: &Rounding) -> Option<(usize, f64)> {
        self.first_at_zero(|contact| {
            let switches = match contact.mode {
                Mode::Open => contact.overlap < 0.0 && contact.rate > 0.0 && !contact.is_resting(rounding),
                Mode::Clipped => contact.rate < 0.0,
                Mode::Pressing => false,
            };
            switches.then_some((contact.rate, contact.accelerations[0]))
        })
    }

    /// The contact whose overlap vanishes first, and when (s), by rates (m/s) and accelerations (m/s2) from `motion`.
    fn first_at_zero(&self, motion: impl Fn(&StepContact) -> Option<(f64, f64)>) -> Option<(usize, f64)> {
        let at_zero = |(j, contact): (usize, &StepContact)| {
            let side = if contact.overlap > 0.0 { 1.0 } else { -1.0 };
            let (rate, acceleration) = motion(contact)?;
            fall(side * contact.overlap, side * rate, 0.5 * side * acceleration).map(|time| (j, time))
        };
        self.contacts.iter().enumerate().filter_map(at_zero).min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// Time (s) to the branch point of a contact from this overlap (m) at this rate (m/s), in either direction; `None` if
/// there is none, or if the overlap is at it within `rounding`.
fn to_branch_point(contact: &StepContact, overlap: f64, rate: f64, rounding: &Rounding) -> Option<f64> {
    let is_near = contact.mode == Mode::Pressing && overlap > rounding.position && rate > 0.0;
    (is_near && !contact.law.is_smooth()).then_some(overlap / rate)
}

/// Plans the step that ends where contact `j` opens, in about this `time` (s).
fn to_release(motion: &GaussStep, j: usize, time: f64) -> Plan {
    let branch_point = motion.branch_point;
    let stretching = branch_point.map_or(Stretching::None, |branch_point| Stretching::AtEnd(branch_point.power));
    Plan { stretching, length: time, switching: Some(j) }
}

/// Length of the next attempt over that of one that was too long, from its error over the allowed one. Where time is
/// stretched, the error falls with a lower power of the length.
fn shorter_for(error: f64, stretching: Stretching) -> f64 {
    let change = change_for(error);
    (1..stretching.order()).fold(change, |shorter, _| shorter * change).clamp(LENGTH_RATIOS[0], SHORTER_RATIO)
}

/// Length of the next step over that of the last one, from its error over the allowed one.
fn change_for(error: f64) -> f64 {
    if error == 0.0 {
        return LENGTH_RATIOS[1];
    }
    // The sixteenth root is nearly the root that belongs to the order.
    let root = error.sqrt().sqrt().sqrt().sqrt();
    (SAFETY / root).clamp(LENGTH_RATIOS[0], LENGTH_RATIOS[1])
}
