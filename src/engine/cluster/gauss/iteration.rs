//! Picard's iteration on one step: forces from overlaps, accelerations from forces, overlaps from accelerations.
//!
//! Only closed contacts need their overlaps during the iteration. Loops over nodes have no branches, so compilers
//! vectorise them.

use super::motion::{GaussStep, Samples, StepContact};
use crate::engine::flight::forcing_at;
use crate::model::Mode;
use crate::solver::{NODES, Table};

/// The last nodes, and a few spread over the step.
const LAST: [usize; 4] = [NODES - 4, NODES - 3, NODES - 2, NODES - 1];
const SOME: [usize; 4] = [0, NODES / 3, 2 * NODES / 3, NODES - 1];

/// If the end of the step moves by more than this part of its length, the nodes move with the rates of this iteration;
/// otherwise earlier rates are good enough.
const MOVED_END: f64 = 1e-3;

/// Negligible part of the motion by the pendulums, over the motion by the forces.
const LEFT_OUT: f64 = 1e-17;

impl GaussStep {
    /// Starts the iteration with the Taylor polynomials of overlaps and rates about the start of the step. Open
    /// contacts, which exert no force, keep the values at the start.
    pub(super) fn begin(&mut self, table: &Table) {
        let length = self.length;
        let cube = length * length * length;
        for (j, StepContact { mode, overlap, rate, accelerations, .. }) in self.contacts.iter().enumerate() {
            if *mode == Mode::Open {
                (self.at_nodes.overlaps[j], self.at_nodes.rates[j]) = ([*overlap; NODES], [*rate; NODES]);
                continue;
            }
            let [acceleration, jerk, snap, crackle] = accelerations;
            let half = acceleration / 2.0;
            let mut reach = overlap.abs() + (rate.abs() + half.abs() * length) * length;
            // At an onset fractional powers have no such derivatives, and shortly after it large ones: the polynomial
            // ends before the first term that is larger than those before it together.
            let mut unless_large = |term: f64, power: f64| {
                let size = term.abs() * power;
                reach = if size <= reach { reach + size } else { 0.0 };
                if reach > 0.0 { term } else { 0.0 }
            };
            let third = unless_large(jerk / 6.0, cube);
            let fourth = unless_large(snap / 24.0, cube * length);
            let fifth = unless_large(crackle / 120.0, cube * length * length);
            for (value, part) in self.at_nodes.overlaps[j].iter_mut().zip(&table.times) {
                let t = length * part;
                *value = overlap + (rate + (half + (third + (fourth + fifth * t) * t) * t) * t) * t;
            }
            for (value, part) in self.at_nodes.rates[j].iter_mut().zip(&table.times) {
                let t = length * part;
                *value = rate + (acceleration + (3.0 * third + (4.0 * fourth + 5.0 * fifth * t) * t) * t) * t;
            }
        }
    }

    /// Forces and accelerations of the closed contacts.
    pub(super) fn evaluate_forces(&mut self) {
        for (j, contact) in self.contacts.iter().enumerate() {
            if contact.mode == Mode::Pressing {
                self.at_nodes.forces[j + 1] =
                    contact.law.unclipped_forces(&self.at_nodes.overlaps[j], &self.at_nodes.rates[j]);
            }
        }
        if self.unlike {
            self.move_balls();
        }
        for j in 0..self.contacts.len() {
            if self.presses(j) {
                self.accelerate(j);
            }
        }
    }

    /// Computes the directions of paths and contacts at the nodes from the present forces. Returns the largest changes
    /// of displacements since the last call, of balls that press and of all balls, over the least length or distance of
    /// pivots.
    pub(super) fn update_directions(&mut self) -> [f64; 2] {
        let (table, length) = (self.stretching.table(), self.length);
        let times = table.times.map(|part| length * part);
        let (mut changes, mut nearest) = ([0.0_f64; 2], f64::INFINITY);
        for i in 0..self.flights.len() {
            let presses = self.presses(i) || i > 0 && self.presses(i - 1);
            let flight = &self.flights[i];
            let [once, twice] = table.integrate_both(&self.arcs.accelerations(i, &self.at_nodes.forces));
            let (mut way, mut u) = ([0.0; NODES], [0.0; NODES]);
            for m in 0..NODES {
                way[m] = length * (flight.v * table.times[m] + length * twice[m]);
                u[m] = flight.v + length * once[m];
            }
            let change = (way[NODES - 1] - self.arcs.turned[i]).abs();
            changes = [if presses { larger(changes[0], change) } else { changes[0] }, larger(changes[1], change)];
            self.arcs.turned[i] = way[NODES - 1];
            self.at_nodes.balls[i] = [way, u];
            let arcs = &mut self.arcs;
            arcs.balls[i].follow(&arcs.models[i], flight, &self.at_nodes.balls[i], &times);
            nearest = self
                .contacts
                .get(i)
                .map_or(nearest, |contact| contact.law.pivots.min(nearest))
                .min(arcs.models[i].length);
        }
        self.arcs.update_directions();
        changes.map(|change| change / nearest)
    }

    /// Relative accelerations of the balls of contact `j` at the nodes, by the forces of three neighbouring contacts, a
    /// constant acceleration and the pendulums.
    pub(super) fn accelerate(&mut self, j: usize) {
        let (contact, Samples { overlaps, rates, forces, balls, .. }) = (&self.contacts[j], &self.at_nodes);
        if self.on_arcs() {
            let ([left, own, right], mut sums) = (&self.arcs.factors[j], self.arcs.directions[j].free);
            for m in 0..NODES {
                sums[m] += left[m] * forces[j][m] + own[m] * forces[j + 1][m] + right[m] * forces[j + 2][m];
            }
            self.accelerations[j] = sums;
            return;
        }
        let ([a, b], [omega2, drag], [left, own, right]) =
            (contact.inverse_masses, contact.mean, [&forces[j], &forces[j + 1], &forces[j + 2]]);
        let mut sums = [0.0; NODES];
        for m in 0..NODES {
            let pushed = (left[m] - own[m]) * a - (own[m] - right[m]) * b;
            sums[m] = pushed + (contact.free_at_touch - omega2 * overlaps[j][m]);
        }
        if drag > 0.0 {
            (0..NODES).for_each(|m| sums[m] -= drag * rates[j][m]);
        }
        if self.unlike {
            let ([of_place, of_velocity], [left, right]) = (contact.unlike, [&balls[j], &balls[j + 1]]);
            for m in 0..NODES {
                let [place, velocity] = [0, 1].map(|k| 0.5 * (left[k][m] + right[k][m]));
                sums[m] -= of_place * place + of_velocity * velocity;
            }
        }
        if self.varies {
            let times = &self.stretching.table().times;
            (0..NODES).for_each(|m| sums[m] += contact.varying(self.length * times[m]));
        }
        self.accelerations[j] = sums;
    }

    /// Motion of the balls at the nodes. The first ball of a group moves by its accelerations, iterated for its
    /// pendulum; the others follow from the overlaps.
    pub(super) fn move_balls(&mut self) {
        if self.on_arcs() {
            for i in 0..self.flights.len() {
                self.ball_accelerations[i] = self.arcs.accelerations(i, &self.at_nodes.forces);
            }
            return;
        }
        let (table, length, reach) = (self.stretching.table(), self.length, self.pace() * self.length);
        let gain = if self.drags { 2.0 * reach } else { reach * reach };
        // Errors of displacements act only through the pendulums, unless velocities are needed.
        let needs_velocities = self.drags || self.varies;
        let enough = if needs_velocities { LEFT_OUT } else { LEFT_OUT / gain };
        for i in 0..self.flights.len() {
            let flight = &self.flights[i];
            let (mut displacements, mut velocities) = ([0.0; NODES], [0.0; NODES]);
            if i > 0 && self.presses(i - 1) {
                let (contact, Samples { overlaps, rates, balls, .. }) = (&self.contacts[i - 1], &self.at_nodes);
                for m in 0..NODES {
                    displacements[m] = balls[i - 1][0][m] - (overlaps[i - 1][m] - contact.overlap);
                }
                if needs_velocities {
                    (0..NODES).for_each(|m| velocities[m] = balls[i - 1][1][m] - rates[i - 1][m]);
                }
                self.at_nodes.balls[i] = [displacements, velocities];
            } else {
                let (v, free) = (flight.v, flight.forcing[0] - self.oscillators[i].omega2() * flight.x);
                for m in 0..NODES {
                    let t = length * table.times[m];
                    (displacements[m], velocities[m]) = ((v + 0.5 * free * t) * t, v + free * t);
                }
                let (mut left_out, mut round) = (if self.presses(i) || self.varies { 1.0 } else { gain }, 1.0);
                self.at_nodes.balls[i] = [displacements, velocities];
                while left_out > enough {
                    self.accelerate_ball(i);
                    let accelerations = &self.ball_accelerations[i];
                    let twice = if needs_velocities {
                        let [once, twice] = table.integrate_both(accelerations);
                        (0..NODES).for_each(|m| velocities[m] = v + length * once[m]);
                        twice
                    } else {
                        table.integrate_twice(accelerations)
                    };
                    for m in 0..NODES {
                        displacements[m] = length * (v * table.times[m] + length * twice[m]);
                    }
                    self.at_nodes.balls[i] = [displacements, velocities];
                    (left_out, round) = (left_out * gain / round, round + 1.0);
                }
            }
            self.accelerate_ball(i);
        }
    }

    /// Acceleration of ball `i` at the nodes, from its motion so far.
    fn accelerate_ball(&mut self, i: usize) {
        let (flight, o, inverse_mass) = (&self.flights[i], &self.oscillators[i], self.inverse_mass(i));
        let Samples { forces, balls, .. } = &self.at_nodes;
        let ([left, right], [displacements, velocities]) = ([&forces[i], &forces[i + 1]], &balls[i]);
        let (mut sums, omega2, free) = ([0.0; NODES], o.omega2(), flight.forcing[0] - o.omega2() * flight.x);
        for m in 0..NODES {
            sums[m] = (left[m] - right[m]) * inverse_mass + (free - omega2 * displacements[m]);
        }
        if o.gamma() > 0.0 {
            sums.iter_mut().zip(velocities).for_each(|(sum, v)| *sum -= 2.0 * o.gamma() * v);
        }
        if self.varies {
            let times = self.stretching.table().times.map(|part| self.length * part);
            sums.iter_mut().zip(times).for_each(|(sum, t)| *sum += forcing_at(&flight.forcing, t) - flight.forcing[0]);
        }
        self.ball_accelerations[i] = sums;
    }

    /// Overlaps and rates of the closed contacts from their accelerations, with the end of the step moved `later` (s).
    /// Returns the largest change of an overlap over the largest overlap, and the largest change of a rate at the last
    /// node, m/s. As iterations change most towards the end of the step, the last nodes suffice for the changes, and
    /// some nodes for the size of the overlaps.
    pub(super) fn update(&mut self, table: &Table, later: f64) -> [f64; 2] {
        let (mut change, mut size, mut of_rate) = (0.0, f64::MIN_POSITIVE, 0.0);
        for j in 0..self.contacts.len() {
            if self.presses(j) {
                let (before, rate) = (LAST.map(|m| self.at_nodes.overlaps[j][m]), self.at_nodes.rates[j][NODES - 1]);
                self.move_contact(j, table, later);
                let after = &self.at_nodes.overlaps[j];
                for (m, before) in LAST.into_iter().zip(before) {
                    change = larger(change, (after[m] - before).abs());
                }
                size = SOME.into_iter().fold(size, |size, m| larger(size, after[m]));
                if self.needs_rates {
                    of_rate = larger(of_rate, (self.at_nodes.rates[j][NODES - 1] - rate).abs());
                }
            }
        }
        self.length += later;
        [change / size, of_rate]
    }

    /// Overlaps and, where they matter, rates of contact `j` from its accelerations, if the step ends `later` (s).
    pub(super) fn move_contact(&mut self, j: usize, table: &Table, later: f64) {
        let (length, square) = (self.length, self.length * self.length);
        let StepContact { overlap, rate, .. } = self.contacts[j];
        let (accelerations, closing) = (&self.accelerations[j], rate * length);
        // In local arrays, which cannot alias their inputs.
        let (mut overlaps, mut rates) = ([0.0; NODES], [0.0; NODES]);
        let integrates = self.needs_rates || later.abs() > MOVED_END * length;
        let twice = if integrates {
            let [once, twice] = table.integrate_both(accelerations);
            for m in 0..NODES {
                rates[m] = rate + length * once[m];
            }
            twice
        } else {
            table.integrate_twice(accelerations)
        };
        for m in 0..NODES {
            overlaps[m] = overlap + (closing * table.times[m] + square * twice[m]);
        }
        if later != 0.0 {
            let now = if integrates { &rates } else { &self.at_nodes.rates[j] };
            for m in 0..NODES {
                let after = later * table.times[m];
                overlaps[m] += (now[m] + 0.5 * accelerations[m] * after) * after;
            }
            for m in 0..NODES {
                rates[m] += accelerations[m] * (later * table.times[m]);
            }
        }
        self.at_nodes.overlaps[j] = overlaps;
        if integrates {
            self.at_nodes.rates[j] = rates;
        }
    }
}

/// The larger one; the first if the other is NaN.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}
