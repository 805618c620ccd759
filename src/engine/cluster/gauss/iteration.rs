//! Picard's iteration on one step: forces from overlaps, accelerations from forces, overlaps from accelerations.
//!
//! Only the closed contacts need their overlaps while it goes on. All loops run over the nodes of one contact, without branches, so
//! that compilers turn them into instructions for several numbers.

use super::motion::{Motion, Track};
use crate::model::Mode;
use crate::solver::gauss::{NODES, Nodes, Table};

impl Motion {
    /// Where the iteration starts: overlaps under the accelerations of the start.
    pub(super) fn begin(&mut self, table: &Table) {
        let length = self.length;
        for (j, track) in self.tracks.iter().enumerate() {
            let half = 0.5 * track.acceleration;
            self.overlaps[j] = table.times.map(|t| track.overlap + (track.rate + half * (length * t)) * (length * t));
            self.rates[j] = table.times.map(|t| track.rate + 2.0 * half * (length * t));
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
    /// overlap, and the largest change of a rate at the last node, m/s.
    pub(super) fn update(&mut self, table: &Table) -> [f64; 2] {
        let (mut change, mut size, mut of_rate) = (0.0_f64, f64::MIN_POSITIVE, 0.0_f64);
        for j in 0..self.tracks.len() {
            if self.tracks[j].mode == Mode::Pressing {
                let rate = self.rates[j][NODES - 1];
                let (changes, overlaps) = (self.move_contact(j, table), self.overlaps[j]);
                (change, size) = (change.max(largest(changes)), size.max(largest(overlaps)));
                of_rate = of_rate.max((self.rates[j][NODES - 1] - rate).abs());
            }
        }
        [change / size, of_rate]
    }

    /// Overlaps and, where they matter, rates of contact `j` from its accelerations; returns how much the overlaps change.
    pub(super) fn move_contact(&mut self, j: usize, table: &Table) -> Nodes {
        let (length, square) = (self.length, self.length * self.length);
        let Track { overlap, rate, .. } = self.tracks[j];
        if self.needs_rates {
            self.rates[j] = table.integrate(&self.accelerations[j]).map(|sum| rate + length * sum);
        }
        let sums = table.integrate_twice(&self.accelerations[j]);
        let (overlaps, closing) = (&mut self.overlaps[j], rate * length);
        std::array::from_fn(|m| {
            let new = overlap + (closing * table.times[m] + square * sums[m]);
            (new - std::mem::replace(&mut overlaps[m], new)).abs()
        })
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

/// The largest value, in four lanes side by side.
#[inline]
fn largest(values: Nodes) -> f64 {
    let mut most = [0.0; 4];
    for values in values.as_chunks::<4>().0 {
        for (most, value) in most.iter_mut().zip(values) {
            *most = if value > most { *value } else { *most };
        }
    }
    most.into_iter().fold(0.0, f64::max)
}
