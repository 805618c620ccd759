//! Picard's iteration on one step: forces from overlaps, accelerations from forces, overlaps from accelerations.
//!
//! Only the closed contacts need their overlaps while it goes on. All loops run over the nodes of one contact, without branches, so
//! that compilers turn them into instructions for several numbers.

use super::motion::{Motion, Track};
use crate::model::Mode;
use crate::solver::gauss::{NODES, Nodes, Table};

/// The last nodes, and some from all over the step.
const LAST: [usize; 4] = [NODES - 4, NODES - 3, NODES - 2, NODES - 1];
const SOME: [usize; 4] = [0, NODES / 3, 2 * NODES / 3, NODES - 1];

impl Motion {
    /// Where the iteration starts: overlaps by the first derivatives at the start of the step.
    pub(super) fn begin(&mut self, table: &Table) {
        let times = table.times.map(|t| self.length * t);
        let length = self.length;
        for (j, Track { overlap, rate, acceleration, jerk, .. }) in self.tracks.iter().enumerate() {
            let (half, sixth) = (acceleration / 2.0, jerk / 6.0);
            // Viscoelastic forces have no derivative at an onset; right after it that is large, but not for long.
            let farthest = overlap.abs() + (rate.abs() + half.abs() * length) * length;
            let sixth = if sixth.abs() * length * length * length <= farthest { sixth } else { 0.0 };
            self.overlaps[j] = times.map(|t| overlap + (rate + (half + sixth * t) * t) * t);
            if self.needs_rates {
                self.rates[j] = times.map(|t| rate + (acceleration + 3.0 * sixth * t) * t);
            }
        }
    }

    /// Forces and accelerations of the closed contacts.
    pub(super) fn push(&mut self) {
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
    #[inline]
    pub(super) fn accelerate(&mut self, j: usize) {
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

    /// Overlaps and rates of the closed contacts from their accelerations; returns the largest change of an overlap over the largest
    /// overlap, and the largest change of a rate at the last node, m/s. Iterations change most towards the end of the step: its last
    /// nodes tell by how much, and some nodes how large overlaps are.
    pub(super) fn update(&mut self, table: &Table) -> [f64; 2] {
        let (mut change, mut size, mut of_rate) = (0.0, f64::MIN_POSITIVE, 0.0);
        for j in 0..self.tracks.len() {
            if self.tracks[j].mode == Mode::Pressing {
                let (before, rate) = (LAST.map(|m| self.overlaps[j][m]), self.rates[j][NODES - 1]);
                self.move_contact(j, table);
                for (m, before) in LAST.into_iter().zip(before) {
                    change = larger(change, (self.overlaps[j][m] - before).abs());
                }
                size = SOME.into_iter().fold(size, |size, m| larger(size, self.overlaps[j][m]));
                of_rate = larger(of_rate, (self.rates[j][NODES - 1] - rate).abs());
            }
        }
        [change / size, of_rate]
    }

    /// Overlaps and, where they matter, rates of contact `j` from its accelerations.
    pub(super) fn move_contact(&mut self, j: usize, table: &Table) {
        let (length, square) = (self.length, self.length * self.length);
        let Track { overlap, rate, .. } = self.tracks[j];
        if self.needs_rates {
            self.rates[j] = table.integrate(&self.accelerations[j]).map(|sum| rate + length * sum);
        }
        let (sums, closing) = (table.integrate_twice(&self.accelerations[j]), rate * length);
        self.overlaps[j] = std::array::from_fn(|m| overlap + (closing * table.times[m] + square * sums[m]));
    }
}

/// What the `forces` of three neighbouring contacts, a constant pull and the pendulums accelerate an overlap by.
#[inline]
fn accelerations(track: &Track, omega2: f64, forces: [&Nodes; 3], overlaps: &Nodes, sums: &mut Nodes) {
    let ([a, b], pull, [left, own, right]) = (track.inverse_masses, track.pull, forces);
    for m in 0..NODES {
        sums[m] = (left[m] - own[m]) * a - (own[m] - right[m]) * b + (pull - omega2 * overlaps[m]);
    }
}

/// The larger one, the first if the other is not a number.
#[inline]
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}
