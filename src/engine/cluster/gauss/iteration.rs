//! Picard's iteration on one step: forces from overlaps, accelerations from forces, overlaps from accelerations.
//!
//! Only the closed contacts need their overlaps while it goes on. Where the end of the step moves, the overlaps move with the nodes: left
//! where they are, they would follow the end, and the end them, by a third of each change. All loops run over the nodes of one contact,
//! without branches, so that compilers turn them into instructions for several numbers.

use super::motion::{Motion, Track};
use crate::model::Mode;
use crate::solver::gauss::{NODES, Nodes, Table};
use crate::solver::multiversion::multiversioned;

/// The last nodes, and some from all over the step.
const LAST: [usize; 4] = [NODES - 4, NODES - 3, NODES - 2, NODES - 1];
const SOME: [usize; 4] = [0, NODES / 3, 2 * NODES / 3, NODES - 1];

/// Where the end of the step moves by more than this part of its length, the nodes move there with the rates of this iteration; else
/// with those of an earlier one or those it starts from, as good as they need be.
const FAR: f64 = 1e-3;

multiversioned! {
impl Motion {
    /// Where the iteration starts: overlaps and rates by the first derivatives at the start of the step.
    pub(super) fn begin(&mut self, table: &Table) = begin_portable;
    /// Forces and accelerations of the closed contacts.
    pub(super) fn push(&mut self) = push_portable;
    /// Relative accelerations of the balls of contact `j` at the nodes.
    pub(super) fn accelerate(&mut self, j: usize) = accelerate_portable;
    /// Overlaps and, where they matter, rates of contact `j` from its accelerations, at the nodes of a step that ends `later` (s).
    pub(super) fn move_contact(&mut self, j: usize, table: &Table, later: f64) = move_contact_portable;
}
}

impl Motion {
    #[inline(always)]
    fn begin_portable(&mut self, table: &Table) {
        let length = self.length;
        for (j, Track { overlap, rate, acceleration, jerk, .. }) in self.tracks.iter().enumerate() {
            let (half, sixth) = (acceleration / 2.0, jerk / 6.0);
            // Viscoelastic forces have no derivative at an onset; right after it that is large, but not for long.
            let farthest = overlap.abs() + (rate.abs() + half.abs() * length) * length;
            let sixth = if sixth.abs() * length * length * length <= farthest { sixth } else { 0.0 };
            for (value, part) in self.overlaps[j].iter_mut().zip(&table.times) {
                let t = length * part;
                *value = overlap + (rate + (half + sixth * t) * t) * t;
            }
            for (value, part) in self.rates[j].iter_mut().zip(&table.times) {
                let t = length * part;
                *value = rate + (acceleration + 3.0 * sixth * t) * t;
            }
        }
    }

    #[inline(always)]
    fn push_portable(&mut self) {
        for (j, track) in self.tracks.iter().enumerate() {
            if track.mode == Mode::Pressing {
                self.forces[j + 1] = track.law.unclipped_forces(&self.overlaps[j], &self.rates[j]);
            }
        }
        for j in 0..self.tracks.len() {
            if self.tracks[j].mode == Mode::Pressing {
                self.accelerate_portable(j);
            }
        }
    }

    #[inline(always)]
    fn accelerate_portable(&mut self, j: usize) {
        let track = &self.tracks[j];
        let [left, own, right] = [&self.forces[j], &self.forces[j + 1], &self.forces[j + 2]];
        let sums = &mut self.accelerations[j];
        accelerations(track, self.oscillator.omega2(), [left, own, right], &self.overlaps[j], sums);
        if self.oscillator.gamma() > 0.0 {
            let damped = 2.0 * self.oscillator.gamma();
            sums.iter_mut().zip(&self.rates[j]).for_each(|(sum, rate)| *sum -= damped * rate);
        }
        if self.varies {
            let times = self.stretching.table().times;
            sums.iter_mut().zip(times).for_each(|(sum, t)| *sum += track.varying(self.length * t));
        }
    }

    /// Overlaps and rates of the closed contacts from their accelerations, and the end of the step `later` (s) than it is; returns the
    /// largest change of an overlap over the largest overlap, and the largest change of a rate at the last node, m/s. Iterations change
    /// most towards the end of the step: its last nodes tell by how much, and some nodes how large overlaps are.
    pub(super) fn update(&mut self, table: &Table, later: f64) -> [f64; 2] {
        let (mut change, mut size, mut of_rate) = (0.0, f64::MIN_POSITIVE, 0.0);
        for j in 0..self.tracks.len() {
            if self.tracks[j].mode == Mode::Pressing {
                let (before, rate) = (LAST.map(|m| self.overlaps[j][m]), self.rates[j][NODES - 1]);
                self.move_contact(j, table, later);
                let after = &self.overlaps[j];
                for (m, before) in LAST.into_iter().zip(before) {
                    change = larger(change, (after[m] - before).abs());
                }
                size = SOME.into_iter().fold(size, |size, m| larger(size, after[m]));
                if self.needs_rates {
                    of_rate = larger(of_rate, (self.rates[j][NODES - 1] - rate).abs());
                }
            }
        }
        self.length += later;
        [change / size, of_rate]
    }

    #[inline(always)]
    fn move_contact_portable(&mut self, j: usize, table: &Table, later: f64) {
        let (length, square) = (self.length, self.length * self.length);
        let Track { overlap, rate, .. } = self.tracks[j];
        let (accelerations, closing) = (&self.accelerations[j], rate * length);
        let twice = if self.needs_rates || later.abs() > FAR * length {
            let [once, twice] = table.integrate_both(accelerations);
            self.rates[j] = once.map(|sum| rate + length * sum);
            twice
        } else {
            table.integrate_twice(accelerations)
        };
        let mut overlaps: Nodes = std::array::from_fn(|m| overlap + (closing * table.times[m] + square * twice[m]));
        if later != 0.0 {
            let mut rates = self.rates[j];
            for m in 0..NODES {
                let after = later * table.times[m];
                overlaps[m] += (rates[m] + 0.5 * accelerations[m] * after) * after;
                rates[m] += accelerations[m] * after;
            }
            self.rates[j] = rates;
        }
        self.overlaps[j] = overlaps;
    }
}

/// What the `forces` of three neighbouring contacts, a constant pull and the pendulums accelerate an overlap by.
#[inline(always)]
fn accelerations(track: &Track, omega2: f64, forces: [&Nodes; 3], overlaps: &Nodes, sums: &mut Nodes) {
    let ([a, b], pull, [left, own, right]) = (track.inverse_masses, track.pull, forces);
    for m in 0..NODES {
        sums[m] = (left[m] - own[m]) * a - (own[m] - right[m]) * b + (pull - omega2 * overlaps[m]);
    }
}

/// The larger one, the first if the other is not a number.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::flight::Flight;
    use crate::model::{ContactLaw, Damping};
    use crate::solver::gauss::{Power, Stretching};
    use crate::solver::oscillator::Oscillator;

    /// A chain of five balls on three closed contacts and an open one, within a step.
    fn motion(exponent: f64, damping: Damping, stretching: Stretching) -> Motion {
        let mut motion =
            Motion { oscillator: Oscillator::new(9.0, 0.1), needs_rates: true, stretching, ..Motion::default() };
        motion.length = 3e-5;
        for j in 0..4 {
            let law = ContactLaw { stiffness: 3e9, overlap_ref: 1.0, exponent, clearance: 0.0, damping };
            let (overlap, rate) = (1e-6 * (j as f64 + 0.3), 0.1 - 0.07 * j as f64);
            let mode = if j == 2 { Mode::Open } else { Mode::Pressing };
            let free = Flight { x: overlap, v: rate, forcing: [0.1, 0.0, 0.0, 0.0] };
            let (inverse_masses, pull) = ([4.0, 5.0 + j as f64], 0.1);
            let (acceleration, jerk) = (-300.0 * overlap / 1e-6, 1e7);
            motion.tracks.push(Track { law, mode, overlap, rate, inverse_masses, free, pull, acceleration, jerk });
        }
        let zeros = [0.0; NODES];
        (motion.overlaps, motion.rates) = (vec![zeros; 4], vec![zeros; 4]);
        (motion.accelerations, motion.forces) = (vec![zeros; 4], vec![zeros; 6]);
        motion
    }

    #[test]
    fn all_processors_give_the_same_bits() {
        let dampings = [
            Damping::None,
            Damping::KelvinVoigt { c: 30.0, pull: true },
            Damping::HuntCrossley { alpha: 0.3 },
            Damping::Viscoelastic { relaxation: 4e-7 },
        ];
        let stretchings = [Stretching::None, Stretching::AtStart(Power::Square), Stretching::AtEnd(Power::Cube)];
        for (damping, exponent) in dampings.into_iter().flat_map(|d| [1.5, 1.7, 2.0, 3.3].map(|p| (d, p))) {
            for stretching in stretchings {
                let table = stretching.table();
                let mut at_hand = motion(exponent, damping, stretching);
                let mut portable = at_hand.clone();
                at_hand.begin(table);
                portable.begin_portable(table);
                for later in [0.0, 1e-7, 0.0, -1e-9, 0.0] {
                    at_hand.push();
                    portable.push_portable();
                    for j in [0, 1, 3] {
                        at_hand.move_contact(j, table, later);
                        portable.move_contact_portable(j, table, later);
                    }
                }
                at_hand.accelerate(2);
                portable.accelerate_portable(2);
                at_hand.move_contact(2, table, 0.0);
                portable.move_contact_portable(2, table, 0.0);
                for (a, b) in [
                    (&at_hand.overlaps, &portable.overlaps),
                    (&at_hand.rates, &portable.rates),
                    (&at_hand.accelerations, &portable.accelerations),
                    (&at_hand.forces, &portable.forces),
                ] {
                    let bits = |values: &[Nodes]| values.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>();
                    assert!(a.iter().flatten().all(|value| value.is_finite()), "{a:?}");
                    assert_eq!(bits(a), bits(b), "{damping:?}, {exponent}, {stretching:?}");
                }
            }
        }
    }
}
