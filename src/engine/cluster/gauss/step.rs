//! One step of explicit Gauss collocation: Picard's iteration, with the switching that ends the step as a part of it.
//!
//! The unknowns are the overlaps at the nodes, which only the closed contacts need while the iteration goes on. In the step the
//! overlap of a contact ends at `d + r h + S h^2`, with S the weighted sum of its accelerations: where that is 0 the contact opens or
//! closes, and the iteration moves the end of the step there. The sign of a force is such a parabola, too.

use super::motion::{Motion, Track};
use crate::engine::cluster::window::{Switch, clipping};
use crate::engine::flight::Rounding;
use crate::model::{Mode, SignOfForce};
use crate::solver::gauss::{NODES, Nodes, Stretching, Table, combine, weighted};

/// Iterations before the error is looked at for the first time, and at most.
const FIRST_ERROR: usize = 5;
const MOST: usize = 60;

/// The error at that first time over the one allowed that is not worth going on for.
const HOPELESS: f64 = 100.0;

/// The iteration has converged where it changes overlaps by less than this part of their size, the next change at the present rate
/// included; rounding keeps it from getting there if it still changes them by less than the other one.
const CONVERGED: f64 = 1e-17;
const NOISE: f64 = 2e-15;

/// Switchings are looked for as soon as the iteration changes overlaps by no more than this part of their size.
const ROUGH: f64 = 1e-2;

/// How far the overlaps at the nodes are known, over speed and length.
const UNKNOWN: f64 = 1e-15;

/// What the error counts for, as a factor, where a contact is clipped at the end: the branch point is so near behind it that the
/// coefficients fall slowly, and the end of the step is less exact than they tell.
const BEFORE_CLIP: f64 = 1e4;

/// How far the end of the step may move within the iteration, as a factor.
const FARTHEST: f64 = 4.0;

/// What a step is to be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    pub stretching: Stretching,
    /// Its length, s; to begin with if it ends at a switching.
    pub length: f64,
    pub ends_at_switching: bool,
}

/// What the errors of a step are measured by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tolerance {
    /// Scale of the velocities, m/s.
    pub speed: f64,
    /// The two highest Legendre coefficients over that.
    pub tail: f64,
    /// What the velocities may be off by, m/s.
    pub local_error: f64,
    /// The longest step, s.
    pub longest: f64,
    pub rounding: Rounding,
}

/// What came of an attempt.
#[derive(Clone, Copy, Debug)]
pub(super) enum Outcome {
    /// The step stands, with this error in units of the one allowed.
    Stands(f64),
    /// This contact switches at the start.
    AtOnce(usize, Switch),
    /// A contact switches before the end, after about this time (s).
    Within(Switch, f64),
    /// No contact switches where one was to end the step.
    NoSwitching,
    /// The error is this many times too large.
    TooLong(f64),
    /// The iteration does not converge, or a switching may have been passed over.
    Failed,
}

/// How a contact stands at the end of a step.
struct End {
    overlap: f64,
    rate: f64,
    /// S.
    curvature: f64,
}

impl Motion {
    /// Computes the step of this `plan`, and what ends it.
    pub(super) fn attempt(&mut self, plan: &Plan, tolerance: &Tolerance, evaluations: &mut u64) -> Outcome {
        let table = plan.stretching.table();
        (self.stretching, self.length, self.end) = (plan.stretching, plan.length, None);
        let closed = self.tracks.iter().filter(|track| track.mode == Mode::Pressing).count() as u64;
        self.begin(table);
        let (mut last_change, mut looked) = (f64::INFINITY, false);
        for count in 0..MOST {
            *evaluations += closed;
            self.push();
            let settled = last_change < ROUGH;
            let look = settled && !looked;
            looked |= settled;
            if plan.ends_at_switching || look {
                match self.first_switching(table, tolerance) {
                    Some((j, switch, 0.0)) if settled => return Outcome::AtOnce(j, switch),
                    Some((.., 0.0)) => {}
                    Some((j, switch, time)) if plan.ends_at_switching => {
                        if time.is_nan() || time > (FARTHEST * plan.length).min(tolerance.longest) {
                            return Outcome::Failed;
                        }
                        (self.length, self.end) = (time, Some((j, switch)));
                    }
                    Some((_, switch, time)) if time < self.length * (1.0 - 1e-12) => {
                        return Outcome::Within(switch, time);
                    }
                    None if plan.ends_at_switching => return Outcome::NoSwitching,
                    Some(_) | None => {}
                }
            }
            let change = self.update(table);
            if count == FIRST_ERROR {
                let error = self.error(table, tolerance);
                if error > HOPELESS {
                    return Outcome::TooLong(error);
                }
            }
            if count >= FIRST_ERROR {
                let rate = change / last_change;
                if change <= CONVERGED || (rate < 0.5 && change * rate <= CONVERGED) || (change <= NOISE && rate > 0.5)
                {
                    return self.conclude(plan, table, tolerance);
                }
                if rate > 0.9 && count > 4 * FIRST_ERROR {
                    return Outcome::Failed;
                }
            }
            last_change = change;
        }
        Outcome::Failed
    }

    /// Where the iteration starts: overlaps under the accelerations of the start.
    fn begin(&mut self, table: &Table) {
        let length = self.length;
        for (j, track) in self.tracks.iter().enumerate() {
            let force = |track: &Track| match track.mode {
                Mode::Pressing => track.law.unclipped_force(track.overlap, track.rate),
                Mode::Open | Mode::Clipped => 0.0,
            };
            let beside = |j: Option<usize>| j.and_then(|j| self.tracks.get(j)).map_or(0.0, force);
            let forces = [beside(j.checked_sub(1)), force(track), beside(Some(j + 1))];
            let half = 0.5 * track.acceleration(forces, &self.oscillator, track.overlap, track.rate, 0.0);
            self.overlaps[j] = table.times.map(|t| track.overlap + (track.rate + half * (length * t)) * (length * t));
            self.rates[j] = table.times.map(|t| track.rate + 2.0 * half * (length * t));
        }
    }

    /// Forces and accelerations of the closed contacts.
    fn push(&mut self) {
        for (j, track) in self.tracks.iter().enumerate() {
            if track.mode == Mode::Pressing {
                self.forces[j + 1] = track.law.unclipped_forces(&self.overlaps[j], &self.rates[j]);
            }
        }
        for j in 0..self.tracks.len() {
            if self.tracks[j].mode == Mode::Pressing {
                self.accelerate(j);
            }
        }
    }

    /// Relative accelerations of the balls of contact `j` at the nodes.
    fn accelerate(&mut self, j: usize) {
        let track = &self.tracks[j];
        let [left, own, right] = [&self.forces[j], &self.forces[j + 1], &self.forces[j + 2]];
        let (a, b, omega2) = (track.inverse_masses[0], track.inverse_masses[1], self.oscillator.omega2());
        let overlaps = &self.overlaps[j];
        let mut sums = [0.0; NODES];
        for m in 0..NODES {
            sums[m] = (left[m] - own[m]) * a - (own[m] - right[m]) * b + (track.pull - omega2 * overlaps[m]);
        }
        if self.oscillator.gamma() > 0.0 {
            let damped = 2.0 * self.oscillator.gamma();
            sums.iter_mut().zip(&self.rates[j]).for_each(|(sum, rate)| *sum -= damped * rate);
        }
        if self.varies {
            let times = self.stretching.table().times;
            sums.iter_mut().zip(times).for_each(|(sum, t)| *sum += track.varying(self.length * t));
        }
        self.accelerations[j] = sums;
    }

    /// Overlaps and rates of the closed contacts from their accelerations; returns the largest change of an overlap over the largest
    /// overlap.
    fn update(&mut self, table: &Table) -> f64 {
        let (mut change, mut size) = (0.0_f64, f64::MIN_POSITIVE);
        for j in 0..self.tracks.len() {
            if self.tracks[j].mode == Mode::Pressing {
                let [changed, largest] = self.move_contact(j, table);
                (change, size) = (change.max(changed), size.max(largest));
            }
        }
        change / size
    }

    /// The same for contact `j`: largest change, and largest overlap.
    fn move_contact(&mut self, j: usize, table: &Table) -> [f64; 2] {
        let (length, square) = (self.length, self.length * self.length);
        let Track { overlap, rate, .. } = self.tracks[j];
        let sums = combine(&table.positions, &self.accelerations[j]);
        let (mut change, mut size) = ([0.0_f64; 2], [0.0_f64; 2]);
        for (m, known) in self.overlaps[j].iter_mut().enumerate() {
            let new = overlap + (rate * (length * table.times[m]) + square * sums[m]);
            let (changed, lane) = ((new - *known).abs(), m % 2);
            change[lane] = if changed > change[lane] { changed } else { change[lane] };
            size[lane] = if new > size[lane] { new } else { size[lane] };
            *known = new;
        }
        if self.needs_rates {
            self.rates[j] = combine(&table.rates, &self.accelerations[j]).map(|sum| rate + length * sum);
        }
        [change[0].max(change[1]), size[0].max(size[1])]
    }

    /// The two highest Legendre coefficients of the accelerations of closed contacts, in units of what is allowed.
    fn error(&self, table: &Table, tolerance: &Tolerance) -> f64 {
        let mut largest = 0.0_f64;
        for (track, accelerations) in self.tracks.iter().zip(&self.accelerations) {
            if track.mode == Mode::Pressing {
                for tail in &table.tail {
                    largest = largest.max(weighted(tail, accelerations).abs());
                }
                if !accelerations[NODES - 1].is_finite() {
                    return f64::INFINITY;
                }
            }
        }
        largest * self.length / (tolerance.speed * tolerance.tail)
    }

    /// How far overlaps are known, m.
    fn noise(&self, tolerance: &Tolerance) -> f64 {
        tolerance.rounding.position.max(UNKNOWN * tolerance.speed * self.length)
    }

    /// How contact `j` stands at the end of the step.
    fn end_of(&self, j: usize, table: &Table) -> End {
        let (track, accelerations) = (&self.tracks[j], &self.accelerations[j]);
        let curvature = weighted(&table.of_position, accelerations);
        End {
            overlap: track.overlap + (track.rate + curvature * self.length) * self.length,
            rate: track.rate + self.length * weighted(&table.of_rate, accelerations),
            curvature,
        }
    }

    /// The earliest switching, as far as the iteration has got: contact, what it is, and the time (s).
    fn first_switching(&mut self, table: &Table, tolerance: &Tolerance) -> Option<(usize, Switch, f64)> {
        let mut first: Option<(usize, Switch, f64)> = None;
        for j in 0..self.tracks.len() {
            if self.tracks[j].mode != Mode::Pressing {
                self.accelerate(j);
                self.move_contact(j, table);
            }
            if let Some((switch, time)) = self.switching(j, table, tolerance)
                && first.is_none_or(|(.., before)| time < before)
            {
                first = Some((j, switch, time));
            }
        }
        first
    }

    /// The switching of contact `j`, within the step or after it.
    fn switching(&self, j: usize, table: &Table, tolerance: &Tolerance) -> Option<(Switch, f64)> {
        let (track, end) = (&self.tracks[j], self.end_of(j, table));
        if track.mode == Mode::Open {
            if track.is_resting(&tolerance.rounding) {
                return self.is_felt(track, &end, tolerance).then_some((Switch::Onset, 0.0));
            }
            if track.overlap >= 0.0 && track.rate > 0.0 {
                return Some((Switch::Onset, 0.0));
            }
            return rise(track.overlap.min(0.0), track.rate, end.curvature).map(|time| (Switch::Onset, time));
        }
        let release = self.falling(track.overlap, tolerance.rounding.no_overlap(), track.rate, end.curvature);
        let switch = clipping(track.mode);
        let clip = track.sign().and_then(|sign| {
            let (value, by_rate) =
                (sign.at(track.overlap, track.rate), sign.by_rate * (end.rate - track.rate) / self.length);
            let (slope, curvature) = (sign.by_overlap * track.rate + by_rate, sign.by_overlap * end.curvature);
            let along = -switch.0;
            self.falling(along * value, self.noise_of_sign(&sign, tolerance), along * slope, along * curvature)
        });
        let clip = clip.map(|time| (switch.1, time));
        clip.into_iter().chain(release.map(|time| (Switch::Release, time))).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// When `d + r h + s h^2` falls through 0, s; it may only just have risen if it does not exceed `noise`.
    fn falling(&self, d: f64, noise: f64, r: f64, s: f64) -> Option<f64> {
        if d > noise {
            return fall(d, r, s);
        }
        (s < 0.0 || r * self.length < -noise).then(|| if r > 0.0 { -r / s } else { 0.0 })
    }

    /// How far the sign of a force is known.
    fn noise_of_sign(&self, sign: &SignOfForce, tolerance: &Tolerance) -> f64 {
        let of_rate = tolerance.rounding.velocity.max(UNKNOWN * tolerance.speed);
        sign.by_overlap * self.noise(tolerance) + sign.by_rate * of_rate
    }

    /// Whether a ball at rest beside the one of an open contact would be pressed, or moved by more than may be left out.
    fn is_felt(&self, track: &Track, end: &End, tolerance: &Tolerance) -> bool {
        let speed_up =
            track.law.elastic_force(end.overlap) * self.length * (track.inverse_masses[0] + track.inverse_masses[1]);
        end.overlap > self.noise(tolerance) || speed_up > tolerance.local_error
    }

    /// After the iteration: the forces of the last overlaps, and whether the step stands.
    fn conclude(&mut self, plan: &Plan, table: &Table, tolerance: &Tolerance) -> Outcome {
        self.push();
        let clips = matches!(self.end, Some((_, Switch::Clip)));
        let error = self.error(table, tolerance) * if clips { BEFORE_CLIP } else { 1.0 };
        if error > 1.0 {
            return Outcome::TooLong(error);
        }
        for j in 0..self.tracks.len() {
            if self.tracks[j].mode != Mode::Pressing {
                self.accelerate(j);
                self.move_contact(j, table);
            }
        }
        if !plan.ends_at_switching {
            match self.first_switching(table, tolerance) {
                Some((j, switch, 0.0)) => return Outcome::AtOnce(j, switch),
                Some((_, switch, time)) if time < self.length * (1.0 - 1e-13) => return Outcome::Within(switch, time),
                Some(_) | None => {}
            }
        }
        for j in 0..self.tracks.len() {
            let track = &self.tracks[j];
            let resting = track.mode == Mode::Open && track.is_resting(&tolerance.rounding);
            if !resting && self.may_have_switched(j, table, tolerance) {
                return Outcome::Failed;
            }
        }
        Outcome::Stands(error)
    }

    /// Whether the overlap of contact `j`, or its force by the law, has or may have the sign of another mode within the step.
    fn may_have_switched(&self, j: usize, table: &Table, tolerance: &Tolerance) -> bool {
        let (track, end) = (&self.tracks[j], self.end_of(j, table));
        let side = if track.mode == Mode::Open { 1.0 } else { -1.0 };
        let overlaps = &self.overlaps[j];
        may_exceed(side, [track.overlap, end.overlap], overlaps, self.noise(tolerance))
            || track.sign().is_some_and(|sign| {
                let within = std::array::from_fn(|m| sign.at(overlaps[m], self.rates[j][m]));
                let ends = [sign.at(track.overlap, track.rate), sign.at(end.overlap, end.rate)];
                may_exceed(clipping(track.mode).0, ends, &within, self.noise_of_sign(&sign, tolerance))
            })
    }
}

/// Whether something, on this `side` of 0, exceeds `noise` at the nodes, or may between them. The `ends` are its values before and
/// after them.
fn may_exceed(side: f64, ends: [f64; 2], within: &Nodes, noise: f64) -> bool {
    let at = |m: usize| side * within.get(m).unwrap_or(&ends[1]);
    let mut before = side * ends[0];
    for m in 0..NODES {
        let (here, after) = (at(m), at(m + 1));
        // An extremum lies no farther beyond the nodes about it than these differ.
        let beyond = if here >= before && here > after { here - before.min(after) } else { 0.0 };
        if here > noise || (beyond > noise && here + 0.5 * beyond > noise) {
            return true;
        }
        before = here;
    }
    false
}

/// When `d + r h + s h^2` falls through 0, from d > 0.
fn fall(d: f64, r: f64, s: f64) -> Option<f64> {
    let discriminant = r * r - 4.0 * s * d;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    // Of the two forms the one that does not cancel.
    if r > 0.0 {
        return (s < 0.0).then(|| (-r - root) / (2.0 * s));
    }
    let denominator = root - r;
    (denominator > 0.0).then(|| 2.0 * d / denominator)
}

/// When it rises through 0, from d <= 0.
fn rise(d: f64, r: f64, s: f64) -> Option<f64> {
    if d == 0.0 {
        return (r < 0.0 && s > 0.0).then(|| -r / s);
    }
    fall(-d, -r, -s)
}
