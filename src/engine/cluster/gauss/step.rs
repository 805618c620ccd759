//! One step of explicit Gauss collocation, from its plan to its outcome. Picard's iteration moves its end to a
//! switching.

use super::motion::{GaussStep, Tolerance};
use crate::engine::cluster::window::Switch;
use crate::model::Mode;
use crate::solver::{Stretching, Table, weighted};

/// Iterations before a step may end, and most iterations.
const LEAST_ITERATIONS: usize = 2;
const MOST_ITERATIONS: usize = 60;

/// A step whose error is this many times the allowed one is given up at once; a larger error is tolerated while
/// overlaps still change.
const TOO_LONG: f64 = 1.5;
const STILL_CHANGING: f64 = 1e5;

/// The iteration has converged if it changes overlaps by less than `CONVERGED` of their size. It also has if, at the
/// present rate, the next change would be less, or `SENSITIVITY` p^2 times the one after it: velocities at the end are
/// more sensitive, the more so the larger the exponent p. Changes below `STAGNATION` that no longer fall are rounding.
/// Guarded by `rattling_balls_cost_little_and_keep_their_energy`.
const CONVERGED: f64 = 8e-16;
const SENSITIVITY: f64 = 7.0;
const STAGNATION: f64 = 2e-15;

/// Rates, if forces depend on them, have converged if their next change, or the one after it with the same factor, is
/// less than this part of the scale of velocities. Under strong damping they converge long after the overlaps. Guarded
/// by `clipped_contacts_overlapping_deeply_at_the_start`.
const CONVERGED_RATE: f64 = 4e-15;

/// Switchings are looked for once the iteration changes overlaps by no more than this part of the overlap of the
/// contact that presses least.
const SWITCHINGS_VISIBLE: f64 = 0.1;

/// The directions of balls on arcs are computed again once the iteration changes overlaps by less than new directions
/// would. That change is expected to be the last one by new directions, multiplied by the first one; before the first,
/// both count as `FIRST_TURN`. These are parts of the largest overlap. Directions stand if the next change would be at
/// most `STANDS`, a part of the largest overlap, displacement or acceleration.
const FIRST_TURN: f64 = 1e-2;
const STANDS: f64 = 1e-15;

/// Factor on the error where the state at the end has fewer digits than the coefficients promise: if a step is left
/// where a force changes its sign, or if the branch point of a second contact follows soon after the end. Guarded by
/// `rattling_balls_cost_little_and_keep_their_energy`.
const FEWER_DIGITS: f64 = 100.0;

/// Largest factor by which the iteration may lengthen the step.
const MOST_LENGTHENED: f64 = 4.0;

#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    pub stretching: Stretching,
    /// Length of the step, s; a first guess if it ends at a switching.
    pub length: f64,
    /// The contact whose switching is to end the step.
    pub switching: Option<usize>,
}

/// How often the directions of balls on arcs have been computed, and the effect.
#[derive(Clone, Copy, Default)]
struct Turns {
    count: u32,
    /// Changes of overlaps by the first and by the last computation, over the largest overlap; the latter once known.
    first: f64,
    last: Option<f64>,
    /// Changes of displacements between the last two computations, of balls that press and of all, and the largest so
    /// far.
    changes: [f64; 2],
    largest: f64,
    /// Length of the step at the last computation, s.
    length: f64,
}

impl Turns {
    /// Expected change of overlaps by the next computation; 0, so that none is due, until that by the last one is
    /// known.
    fn next(&self) -> f64 {
        if self.count == 0 { FIRST_TURN * FIRST_TURN } else { self.last.map_or(0.0, |last| self.first * last) }
    }

    /// Notes the change of overlaps in an iteration; right after new directions it is their effect.
    fn note(&mut self, change: f64) {
        if self.count > 0 && self.last.is_none() {
            self.last = Some(change);
            if self.count == 1 {
                self.first = change;
            }
        }
    }
}

/// How fast the changes of overlaps from iteration to iteration fall.
struct Convergence {
    /// The last change, and its ratio to the one before; `None` if both are 0.
    change: f64,
    rate: Option<f64>,
    /// `SENSITIVITY` p^2.
    sensitivity: f64,
}

impl Convergence {
    /// Before the first iteration, for contacts with the exponent p.
    fn new(p: f64) -> Self {
        Self { change: f64::INFINITY, rate: Some(0.0), sensitivity: SENSITIVITY * p * p }
    }

    /// Whether overlaps have converged with this change; and its expected ratio to the next one or, with the
    /// sensitivity, to the one after it.
    #[inline]
    fn judge(&self, change: f64) -> (bool, f64) {
        // Right after the end has moved far, the change falls faster than it will later.
        let rates = [rate_of(change, self.change), self.rate.map(|rate| 0.5 * rate)];
        let rate = rates.into_iter().flatten().reduce(f64::max);
        let ahead = rate.map_or(1.0, |rate| rate.min(1.0) * (self.sensitivity * rate).min(1.0));
        let has_converged = change <= CONVERGED
            || rate.is_some_and(|rate| {
                (rate < 0.5 && change * ahead <= CONVERGED) || (change <= STAGNATION && rate > 0.5)
            });
        (has_converged, ahead)
    }

    fn note(&mut self, change: f64) {
        (self.change, self.rate) = (change, rate_of(change, self.change));
    }
}

/// The outcome of an attempt.
#[derive(Clone, Copy, Debug)]
pub(super) enum Attempt {
    /// The step is accepted, with this error over the allowed one.
    Stands(f64),
    /// This contact switches at the start.
    AtOnce(usize, Switch),
    /// This contact switches before the end, after about this time (s).
    Within(usize, Switch, f64),
    /// No contact switches, although the plan ends the step at a switching.
    NoSwitching,
    /// The error is this many times the allowed one.
    TooLong(f64),
    /// The iteration does not converge, or a switching may have been passed over.
    Failed,
}

impl GaussStep {
    /// Attempts the step of this `plan`, and finds what ends it.
    pub(super) fn attempt(&mut self, plan: &Plan, tolerance: &Tolerance, evaluations: &mut u64) -> Attempt {
        let table = plan.stretching.table();
        (self.stretching, self.length, self.end) = (plan.stretching, plan.length, None);
        let closed = self.contacts.iter().filter(|contact| contact.mode == Mode::Pressing).count() as u64;
        self.begin(table);
        let (mut has_looked, mut is_measured) = (false, false);
        let mut convergence = Convergence::new(self.contacts[0].law.exponent); // contacts have one
        let mut turns = self.on_arcs().then(Turns::default);
        for count in 0..MOST_ITERATIONS {
            *evaluations = evaluations.saturating_add(closed);
            self.evaluate_forces();
            if let Some(turns) = turns.as_mut().filter(|turns| convergence.change < turns.next()) {
                self.turn_on(turns);
                self.evaluate_forces();
            }
            if !has_looked && convergence.change < SWITCHINGS_VISIBLE * self.evenness().min(1.0) {
                has_looked = true;
                if let Some(outcome) = self.look_for_switching(plan, table, tolerance) {
                    return outcome;
                }
            }
            let later = match self.find_end(plan, has_looked, table, tolerance) {
                Ok(later) => later,
                Err(outcome) => return outcome,
            };
            let [change, of_rate] = self.update(table, later);
            turns.iter_mut().for_each(|turns| turns.note(change));
            if count >= LEAST_ITERATIONS {
                if !is_measured {
                    let still = change * STILL_CHANGING;
                    let error = self.error(table, tolerance);
                    if error > TOO_LONG + still {
                        return Attempt::TooLong(error);
                    }
                    is_measured = still < TOO_LONG;
                }
                let (has_converged, ahead) = convergence.judge(change);
                // The end must have converged, too: contacts in equilibrium do not change, however far it still moves.
                let ended = |(j, _)| later.abs() * self.rate_at_end(j, table).abs() <= self.overlap_error(tolerance);
                if has_converged
                    && self.end.is_none_or(ended)
                    && of_rate * ahead <= CONVERGED_RATE * tolerance.problem.speed
                    && turns.as_mut().is_none_or(|turns| self.settle_directions(turns))
                {
                    return self.conclude(table, tolerance);
                }
            }
            convergence.note(change);
        }
        Attempt::Failed
    }

    /// Looks for the first switching, and ends the step there if the `plan` allows that. Returns the outcome if it ends
    /// the attempt.
    fn look_for_switching(&mut self, plan: &Plan, table: &Table, tolerance: &Tolerance) -> Option<Attempt> {
        (0..self.contacts.len()).for_each(|j| self.accelerate_unless_pressing(j, table));
        match self.first_switching(table, tolerance)? {
            (j, switch, 0.0) => return Some(Attempt::AtOnce(j, switch)),
            (j, ..) if plan.switching == Some(j) => {}
            (j, switch, time) if time < self.length * (1.0 - 1e-12) => {
                if !self.may_end(plan, j, switch) {
                    return Some(Attempt::Within(j, switch, time));
                }
                self.end = Some((j, switch));
            }
            _ => {}
        }
        None
    }

    /// How much later the step has to end (s) where it ends at a switching, by the present accelerations; 0 if it does
    /// not, or if that is not yet to be seen. An error if the attempt has failed: surely so without a switching only
    /// after the attempt `has_looked` for one.
    fn find_end(
        &mut self,
        plan: &Plan,
        has_looked: bool,
        table: &Table,
        tolerance: &Tolerance,
    ) -> Result<f64, Attempt> {
        let Some(j) = self.end.map_or(plan.switching, |(j, _)| Some(j)) else { return Ok(0.0) };
        self.accelerate_unless_pressing(j, table);
        let from_start = || self.switching(j, table, tolerance).map(|(_, time)| time);
        match self.switching_near_end(j, table).or_else(from_start) {
            Some(time) if time > 0.0 && time <= (MOST_LENGTHENED * plan.length).min(tolerance.longest) => {
                self.end = Some((j, self.contacts[j].switch()));
                Ok(time - self.length)
            }
            Some(_) => Err(Attempt::Failed),
            None if has_looked || self.end.is_some() => Err(Attempt::NoSwitching),
            None => Ok(0.0),
        }
    }

    /// Whether directions stand, if need be after they have been computed once more. Otherwise the new ones take effect
    /// in another iteration.
    fn settle_directions(&mut self, turns: &mut Turns) -> bool {
        if !self.stands(turns) {
            self.turn_on(turns);
        }
        self.stands(turns)
    }

    /// Computes the directions again: of all contacts, as those of an open one tell when it closes.
    fn turn_on(&mut self, turns: &mut Turns) {
        let changes = self.update_directions();
        let (count, largest, length) = (turns.count + 1, turns.largest.max(changes[1]), self.length);
        *turns = Turns { count, last: None, changes, largest, length, ..*turns };
    }

    /// Whether directions, and forces of gravity and drag, stand: whether their remaining changes, including those by
    /// the movement of the end of the step since, and their part in the accelerations are small enough.
    fn stands(&self, turns: &Turns) -> bool {
        let Turns { count, last, changes, largest, length, .. } = *turns;
        let (reach, drags) = (self.pace() * self.length, self.arcs.models.iter().any(|ball| ball.gamma > 0.0));
        let gain = if drags { 2.0 * reach } else { reach * reach };
        let moved = largest * (self.length / length - 1.0).abs();
        let [pressed, any] = changes.map(|change| change * gain + moved);
        let remains = if last.is_some() { turns.next() } else { changes[0] };
        count > 0 && remains.max(pressed) <= STANDS && any * gain <= STANDS * largest
    }

    /// Whether a step of this `plan` may end at another switching, of contact `j`: if it has no branch point, and time
    /// is not stretched for another release.
    fn may_end(&self, plan: &Plan, j: usize, switch: Switch) -> bool {
        let has_branch_point = switch == Switch::Release && self.presses(j);
        let is_smooth = !has_branch_point || self.branch_point.is_none();
        is_smooth && !matches!(plan.stretching, Stretching::AtEnd(_))
    }

    /// The two highest Legendre coefficients of the accelerations of closed contacts, over the allowed ones.
    fn error(&self, table: &Table, tolerance: &Tolerance) -> f64 {
        let mut largest = 0.0_f64;
        for (contact, accelerations) in self.contacts.iter().zip(&self.accelerations) {
            if contact.mode == Mode::Pressing {
                for tail in &table.tail {
                    let size = weighted(tail, accelerations).abs();
                    if !size.is_finite() {
                        return f64::INFINITY;
                    }
                    largest = largest.max(size);
                }
            }
        }
        largest * self.length / (tolerance.problem.speed * tolerance.tail)
    }

    /// After the iteration: computes the forces from the last overlaps, and decides whether the step is accepted.
    fn conclude(&mut self, table: &Table, tolerance: &Tolerance) -> Attempt {
        self.evaluate_forces();
        let mut error = self.error(table, tolerance);
        if self.ends_before_branch_point(table, &tolerance.problem.rounding) {
            error *= FEWER_DIGITS;
        }
        if error > 1.0 {
            return Attempt::TooLong(error);
        }
        for j in 0..self.contacts.len() {
            if self.presses(j) {
                continue;
            }
            self.accelerate(j);
            if self.may_close(j) {
                self.move_contact(j, table, 0.0);
                self.accelerate(j);
                self.move_contact(j, table, 0.0);
            }
        }
        if let Some((j, switch, time)) = self.first_switching(table, tolerance) {
            // To within the accuracy of the overlaps.
            let ends = || {
                let overlap = self.overlap_at_end(j, self.curvature(j, table));
                self.end == Some((j, switch)) && overlap.abs() <= self.overlap_error(tolerance)
            };
            if time == 0.0 {
                return Attempt::AtOnce(j, switch);
            }
            if time < self.length * (1.0 - 1e-13) && !ends() {
                return Attempt::Within(j, switch, time);
            }
        }
        self.until = self.length;
        let Ok(clipped) = self.first_clipping(table, tolerance) else { return Attempt::Failed };
        if let Some((j, time)) = clipped {
            if time == 0.0 {
                return Attempt::AtOnce(j, Switch::Clip);
            }
            (self.until, self.end) = (time, Some((j, Switch::Clip)));
            error *= FEWER_DIGITS;
        }
        if error > 1.0 {
            return Attempt::TooLong(error);
        }
        if self.may_have_passed_over(self.until, table, tolerance) {
            return Attempt::Failed;
        }
        self.at_nodes.times = table.times.map(|part| self.length * part);
        if self.needs_balls() {
            self.move_balls();
        }
        Attempt::Stands(error)
    }
}

/// A change over the one before it; `None` if both are 0.
fn rate_of(change: f64, before: f64) -> Option<f64> {
    match before {
        0.0 if change == 0.0 => None,
        0.0 => Some(f64::INFINITY),
        _ => Some(change / before),
    }
}
