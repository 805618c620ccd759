//! Switchings on a step: those at its end, where `d(h)` of "Gauss collocation" in docs/theory.md is 0, and whether it
//! has missed any. A change of a force's sign is found afterwards; the step is valid up to there.
//!
//! The search for the first crossing of a known function (`solver::root`) does not apply: the end of the step moves
//! with the switching while the motion is still being computed.

use super::motion::{GaussStep, StepContact, Tolerance};
use crate::engine::cluster::window::{Switch, sign_after_clip};
use crate::model::Mode;
use crate::solver::{NODES, Nodes, RULE, Table, root::first_root_of_parabola, weighted};

/// Error of the overlaps at the nodes, over speed and length.
const OVERLAP_ERROR: f64 = 1e-15;

/// Where a quantity at the nodes exceeds a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Excess {
    Never,
    /// At this node, [`NODES`] being the end.
    At(usize),
    /// It may, between the nodes on either side of this one.
    Near(usize),
}

impl GaussStep {
    /// Error of the overlaps, m.
    pub(super) fn overlap_error(&self, tolerance: &Tolerance) -> f64 {
        tolerance.problem.rounding.position.max(OVERLAP_ERROR * tolerance.problem.speed * self.length)
    }

    /// The factor S of `h^2` in the overlap of contact `j` at the end of the step, m/s2.
    pub(super) fn curvature(&self, j: usize, table: &Table) -> f64 {
        weighted(&table.of_position, &self.accelerations[j])
    }

    /// Overlap of contact `j` at the end of the step, m.
    pub(super) fn overlap_at_end(&self, j: usize, curvature: f64) -> f64 {
        self.contacts[j].overlap + (self.contacts[j].rate + curvature * self.length) * self.length
    }

    /// Rate of the overlap of contact `j` at the end of the step, m/s.
    pub(super) fn rate_at_end(&self, j: usize, table: &Table) -> f64 {
        self.contacts[j].rate + self.length * weighted(&table.of_rate, &self.accelerations[j])
    }

    /// Smallest overlap of a pressing contact over the largest: 0 if none overlaps yet, infinite if none presses.
    pub(super) fn evenness(&self) -> f64 {
        let pressing =
            self.contacts.iter().zip(&self.at_nodes.overlaps).filter(|(contact, _)| contact.mode == Mode::Pressing);
        let largest = pressing.map(|(_, overlaps)| range(overlaps)[1]);
        let [least, most] = largest.fold([f64::INFINITY, 0.0], |[least, most], d| [d.min(least), d.max(most)]);
        if most > 0.0 { least / most } else { least.max(0.0) }
    }

    /// The earliest onset or release by the present accelerations: contact, switching, and time (s).
    pub(super) fn first_switching(&self, table: &Table, tolerance: &Tolerance) -> Option<(usize, Switch, f64)> {
        let mut first: Option<(usize, Switch, f64)> = None;
        for j in 0..self.contacts.len() {
            // The parabola for a release may still vanish, if the contact comes to rest.
            let stays_closed = self.presses(j)
                && range(&self.at_nodes.overlaps[j])[0] > 0.0
                && self.overlap_at_end(j, self.curvature(j, table)) > 0.0;
            if !stays_closed
                && let Some((switch, time)) = self.switching(j, table, tolerance)
                && first.is_none_or(|(.., before)| time < before)
            {
                first = Some((j, switch, time));
            }
        }
        first
    }

    /// Computes, if contact `j` does not press, its accelerations by its neighbours and, if it ends the step, its
    /// overlaps.
    pub(super) fn accelerate_unless_pressing(&mut self, j: usize, table: &Table) {
        if !self.presses(j) {
            self.accelerate(j);
            // Through the pendulums an overlap acts on itself: a little, but the end of the step needs all digits.
            if self.end.is_some_and(|(ending, _)| ending == j) {
                self.move_contact(j, table, 0.0);
            }
        }
    }

    /// The onset or release of contact `j`, within the step or after it.
    pub(super) fn switching(&self, j: usize, table: &Table, tolerance: &Tolerance) -> Option<(Switch, f64)> {
        let (contact, curvature) = (&self.contacts[j], self.curvature(j, table));
        if contact.mode == Mode::Open {
            if contact.is_resting(&tolerance.problem.rounding) {
                return self.onset_from_rest(j, table, tolerance).map(|time| (Switch::Onset, time));
            }
            if contact.overlap >= 0.0 && contact.rate > 0.0 {
                return Some((Switch::Onset, 0.0));
            }
            return fall(-contact.overlap.min(0.0), -contact.rate, -curvature).map(|time| (Switch::Onset, time));
        }
        let time = if contact.overlap > tolerance.problem.rounding.no_overlap() {
            self.fall_at_nodes(j, table).or_else(|| fall(contact.overlap, contact.rate, curvature))
        } else {
            // It has just closed. A rate within rounding does not show whether its balls part.
            let known = tolerance.problem.rounding.velocity;
            let parts = curvature < 0.0 || contact.rate < -known;
            parts.then(|| if contact.rate > known { -contact.rate / curvature } else { 0.0 })
        };
        time.map(|time| (contact.switch(), time))
    }

    /// When the overlap of contact `j` vanishes between two nodes (s), if it does.
    fn fall_at_nodes(&self, j: usize, table: &Table) -> Option<f64> {
        let overlaps = &self.at_nodes.overlaps[j];
        let after = overlaps.iter().position(|overlap| *overlap <= 0.0).filter(|m| *m > 0)?;
        let [from, to] = [after - 1, after].map(|m| self.time_of(m, table));
        let before = overlaps[after - 1];
        Some(from + (to - from) * before / (before - overlaps[after]))
    }

    /// When the overlap of contact `j` vanishes (s), by its value, rate and acceleration at the current end of the
    /// step, where the parabola from its start is less exact. `None` if that is not near.
    pub(super) fn switching_near_end(&self, j: usize, table: &Table) -> Option<f64> {
        let (overlap, rate) = (self.overlap_at_end(j, self.curvature(j, table)), self.rate_at_end(j, table));
        let half = 0.5 * self.accelerations[j][NODES - 1];
        let side = if self.contacts[j].mode == Mode::Open { -1.0 } else { 1.0 };
        // From where it has yet to vanish, or back from where it has vanished.
        let later = match side * overlap {
            before if before > 0.0 => fall(before, side * rate, side * half)?,
            after => -fall(-after, side * rate, -side * half)?,
        };
        let time = self.length + later;
        (0.5 * self.length..2.0 * self.length).contains(&time).then_some(time)
    }

    /// When the open contact `j`, at rest, closes on this step (s): at once, unless its balls are first accelerated
    /// apart, possibly by a force that grows from 0. Closed at once, it would then be opened again by series.
    fn onset_from_rest(&self, j: usize, table: &Table, tolerance: &Tolerance) -> Option<f64> {
        let contact = &self.contacts[j];
        let matters = self.matters(contact, self.overlap_at_end(j, self.curvature(j, table)), tolerance);
        let first_change = match contact.accelerations {
            [0.0, jerk, ..] => jerk + contact.forcing[1],
            [acceleration, ..] => acceleration,
        };
        if first_change >= 0.0 {
            return matters.then_some(0.0);
        }
        self.switching_near_end(j, table).or(matters.then_some(0.5 * self.length))
    }

    /// Whether this `overlap` at an open contact would press or move a ball at rest noticeably.
    fn matters(&self, contact: &StepContact, overlap: f64, tolerance: &Tolerance) -> bool {
        let speed_up =
            contact.law.elastic_force(overlap) * self.length * (contact.inverse_masses[0] + contact.inverse_masses[1]);
        overlap > self.overlap_error(tolerance) || speed_up > tolerance.problem.local_error
    }

    /// The first change of the sign of a force that may be clipped, against the mode of its contact: which one and when
    /// (s), if any; an error if one may change its sign between two nodes.
    pub(super) fn first_clipping(&self, table: &Table, tolerance: &Tolerance) -> Result<Option<(usize, f64)>, ()> {
        let (mut first, mut unclear) = (None, f64::INFINITY);
        let rate_error = tolerance.problem.rounding.velocity.max(OVERLAP_ERROR * tolerance.problem.speed);
        for (j, contact) in self.contacts.iter().enumerate() {
            let Some(sign) = contact.sign() else { continue };
            let side = sign_after_clip(contact.mode);
            let overlap_at_end = self.overlap_at_end(j, self.curvature(j, table));
            let rate_at_end = self.rate_at_end(j, table);
            let within = std::array::from_fn(|m| sign.at(self.at_nodes.overlaps[j][m], self.at_nodes.rates[j][m]));
            let ends = [sign.at(contact.overlap, contact.rate), sign.at(overlap_at_end, rate_at_end)];
            let threshold = sign.error_bound(overlap_at_end.max(0.0), self.overlap_error(tolerance), rate_error);
            match first_excess(side, ends, &within, threshold) {
                Excess::Never if side * ends[1] <= threshold => {}
                Excess::Near(m) => unclear = unclear.min(self.time_of(m, table)),
                excess => {
                    let m = if let Excess::At(m) = excess { m } else { NODES };
                    let time = self.time_of_change(-side, ends, &within, m, table);
                    if first.is_none_or(|(_, before)| time < before) {
                        first = Some((j, time));
                    }
                }
            }
        }
        let is_known = first.map_or(f64::INFINITY, |(_, time)| time) <= unclear;
        is_known.then_some(first).ok_or(())
    }

    /// When a quantity leaves this `side` of 0 before node `m` or, with [`NODES`], before the end of the step, s. Ten
    /// digits suffice, because a force about to be clipped vanishes.
    fn time_of_change(&self, side: f64, ends: [f64; 2], within: &Nodes, m: usize, table: &Table) -> f64 {
        let before = m.checked_sub(1);
        let (start, end) = (before.map_or(0.0, |m| self.time_of(m, table)), self.time_of(m, table));
        let at_start = side * before.map_or(ends[0], |m| within[m]);
        if at_start <= 0.0 {
            return start;
        }
        let falls = RULE.powers.map(|row| -side * weighted(&row, within));
        self.rising_zero(&falls, start, end).unwrap_or_else(|| {
            // Beyond the outermost nodes the polynomial may have the wrong sign.
            let at_end = side * within.get(m).unwrap_or(&ends[1]);
            start + (end - start) * at_start / (at_start - at_end.min(0.0))
        })
    }

    /// Whether the overlap of a contact has or may have the sign of another mode before the time `until` (s).
    pub(super) fn may_have_passed_over(&self, until: f64, table: &Table, tolerance: &Tolerance) -> bool {
        let threshold = self.overlap_error(tolerance);
        (0..self.contacts.len()).any(|j| {
            let contact = &self.contacts[j];
            if contact.mode == Mode::Open && !self.may_close(j) {
                return false;
            }
            let side = if contact.mode == Mode::Open { 1.0 } else { -1.0 };
            let ends = [contact.overlap, self.overlap_at_end(j, self.curvature(j, table))];
            match first_excess(side, ends, &self.at_nodes.overlaps[j], threshold) {
                Excess::Never => false,
                Excess::At(m) | Excess::Near(m) => m == 0 || self.time_of(m - 1, table) < until,
            }
        })
    }

    /// Whether contact `j`, if open, may close by its rate and twice the largest acceleration at the nodes.
    pub(super) fn may_close(&self, j: usize) -> bool {
        let contact = &self.contacts[j];
        let [least, most] = range(&self.accelerations[j]);
        let farthest = (contact.rate.max(0.0) + most.max(-least) * self.length) * self.length;
        // With NaN it may close.
        let stays_open = contact.overlap <= -2.0 * farthest;
        !stays_open
    }

    /// Time of a node or the end, s.
    fn time_of(&self, m: usize, table: &Table) -> f64 {
        table.times.get(m).map_or(self.length, |t| self.length * t)
    }
}

/// Where `side` times a quantity exceeds `threshold` at the nodes, or may between them. The `ends` are its values
/// before and after the nodes.
fn first_excess(side: f64, ends: [f64; 2], within: &Nodes, threshold: f64) -> Excess {
    let at = |m: usize| side * within.get(m).unwrap_or(&ends[1]);
    // Usually all values stay away from 0 by more than half of their range.
    let [least, most] = range(within).map(|value| side * value);
    let [inner, outer] = [least.max(most).max(side * ends[1]), least.min(most).min(side * ends[0]).min(side * ends[1])];
    if inner + 0.5 * (inner - outer) <= threshold {
        return Excess::Never;
    }
    let mut before = side * ends[0];
    for m in 0..NODES {
        let (here, after) = (at(m), at(m + 1));
        if here > threshold {
            return Excess::At(m);
        }
        // An extremum lies no farther beyond the nodes about it than these differ.
        let beyond = if here >= before && here > after { here - before.min(after) } else { 0.0 };
        if beyond > threshold && here + 0.5 * beyond > threshold {
            return Excess::Near(m);
        }
        before = here;
    }
    Excess::Never
}

#[inline]
fn range(values: &Nodes) -> [f64; 2] {
    const LANES: usize = 4;
    let (mut least, mut most) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
    for values in values.as_chunks::<LANES>().0 {
        for lane in 0..LANES {
            least[lane] = if values[lane] < least[lane] { values[lane] } else { least[lane] };
            most[lane] = if values[lane] > most[lane] { values[lane] } else { most[lane] };
        }
    }
    [least.into_iter().fold(f64::INFINITY, f64::min), most.into_iter().fold(f64::NEG_INFINITY, f64::max)]
}

/// Time at which `d + r h + s h^2` falls through 0, from d >= 0.
pub(super) fn fall(d: f64, r: f64, s: f64) -> Option<f64> {
    Some(first_root_of_parabola(-d, -r, -2.0 * s)).filter(|time| *time != f64::INFINITY)
}
