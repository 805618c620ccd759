//! Picard's iteration on one step: forces from overlaps, accelerations from forces, overlaps from accelerations.
//!
//! Only the closed contacts need their overlaps while it goes on. Where the end of the step moves, the overlaps move
//! with the nodes: left where they are, they would follow the end, and the end them, by a third of each change. All
//! loops run over the nodes of one contact, without branches, so that compilers turn them into instructions for several
//! numbers.

use super::motion::{Motion, Track};
use crate::engine::flight::forcing_at;
use crate::model::Mode;
use crate::solver::gauss::{NODES, Nodes, Table};

/// The last nodes, and some from all over the step.
const LAST: [usize; 4] = [NODES - 4, NODES - 3, NODES - 2, NODES - 1];
const SOME: [usize; 4] = [0, NODES / 3, 2 * NODES / 3, NODES - 1];

/// Where the end of the step moves by more than this part of its length, the nodes move there with the rates of this
/// iteration; else with those of an earlier one or those it starts from, as good as they need be.
const FAR: f64 = 1e-3;

impl Motion {
    /// Where the iteration starts: overlaps and rates by the first derivatives at the start of the step.
    pub(super) fn begin(&mut self, table: &Table) {
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
        for ([positions, velocities], flight) in self.states.iter_mut().zip(&self.flights) {
            *positions = table.times.map(|part| flight.x + flight.v * (length * part));
            *velocities = [flight.v; NODES];
        }
    }

    /// Forces and accelerations of the closed contacts.
    pub(super) fn push(&mut self) {
        for (j, track) in self.tracks.iter().enumerate() {
            if track.mode == Mode::Pressing {
                self.forces[j + 1] = track.law.unclipped_forces(&self.overlaps[j], &self.rates[j]);
            }
        }
        for i in 0..self.states.len() {
            self.move_ball(i);
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
        accelerations(track, [left, own, right], &self.overlaps[j], sums);
        if track.mean[1] > 0.0 {
            sums.iter_mut().zip(&self.rates[j]).for_each(|(sum, rate)| *sum -= track.mean[1] * rate);
        }
        if track.unlike != [0.0; 2] {
            let ([of_position, of_velocity], [left, right]) = (track.unlike, [&self.states[j], &self.states[j + 1]]);
            for (m, sum) in sums.iter_mut().enumerate() {
                let [position, velocity] = [0, 1].map(|k| 0.5 * (left[k][m] + right[k][m]));
                *sum -= of_position * position + of_velocity * velocity;
            }
        }
        if self.varies {
            let times = self.stretching.table().times;
            sums.iter_mut().zip(times).for_each(|(sum, t)| *sum += track.varying(self.length * t));
        }
    }

    /// Position and velocity of ball `i` at the nodes, from what accelerates it there.
    fn move_ball(&mut self, i: usize) {
        let (table, length, flight) = (self.stretching.table(), self.length, &self.flights[i]);
        let (inverse_mass, o, [positions, velocities]) =
            (self.inverse_mass(i), &self.oscillators[i], &mut self.states[i]);
        let accelerations = std::array::from_fn(|m| {
            (self.forces[i][m] - self.forces[i + 1][m]) * inverse_mass
                + (forcing_at(&flight.forcing, length * table.times[m])
                    - o.omega2() * positions[m]
                    - 2.0 * o.gamma() * velocities[m])
        });
        let [once, twice] = table.integrate_both(&accelerations);
        *velocities = once.map(|sum| flight.v + length * sum);
        *positions = std::array::from_fn(|m| flight.x + length * (flight.v * table.times[m] + length * twice[m]));
    }

    /// Overlaps and rates of the closed contacts from their accelerations, and the end of the step `later` (s) than it
    /// is; returns the largest change of an overlap over the largest overlap, and the largest change of a rate at the
    /// last node, m/s. Iterations change most towards the end of the step: its last nodes tell by how much, and some
    /// nodes how large overlaps are.
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

    /// Overlaps and, where they matter, rates of contact `j` from its accelerations, at the nodes of a step that ends
    /// `later` (s).
    pub(super) fn move_contact(&mut self, j: usize, table: &Table, later: f64) {
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
fn accelerations(track: &Track, forces: [&Nodes; 3], overlaps: &Nodes, sums: &mut Nodes) {
    let ([a, b], pull, omega2, [left, own, right]) = (track.inverse_masses, track.pull, track.mean[0], forces);
    for m in 0..NODES {
        sums[m] = (left[m] - own[m]) * a - (own[m] - right[m]) * b + (pull - omega2 * overlaps[m]);
    }
}

/// The larger one, the first if the other is not a number.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}
