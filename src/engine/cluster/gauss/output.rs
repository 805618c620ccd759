//! What is read off a step of Gauss collocation, at any time of it.
//!
//! The forces at the nodes are all that is kept. A pendulum answers them linearly: with `U_k` the functions of the oscillator
//! (`solver::oscillator`) and `w_l(tau)` the weights of the integral from the start to tau,
//!
//! ```text
//! x(tau) = x_free(tau) + sum_l w_l(tau) U_1(tau - t_l) f_l,     x' with U_0, the integral of x with U_2
//! ```
//!
//! At the end of the step these are the sums of the method itself. So is the overlap, as a difference of two such motions.

use std::cell::Ref;

use super::motion::Motion;
use crate::engine::cluster::dense_output::DenseOutput;
use crate::engine::cluster::window::{OverlapSeries, Switch, Window, clipping};
use crate::engine::flight::{Forcing, Rounding, degree, forcing_at};
use crate::next::Next;
use crate::solver::double_double::DoubleDouble;
use crate::solver::gauss::{NODES, Nodes, Rule, weighted};
use crate::solver::multiversion::multiversioned;
use crate::solver::oscillator::{BASIS, Oscillator};
use crate::solver::{root, series};

/// Terms of the power series of the oscillator's functions, and what the first term left out may be.
const TERMS: usize = 14;
const LEFT_OUT: f64 = 1e-18;

/// How far a peak may exceed the largest force at the nodes and at the ends.
const MARGIN: f64 = 1.25;

/// Longest step, over the time scale of the pendulum, that those terms serve.
pub(super) const LONGEST: f64 = 0.25;

/// What the functions of a time need.
#[derive(Clone, Debug, Default)]
pub(super) struct Moment {
    /// The time (s); none before the first.
    tau: Option<f64>,
    /// The oscillator's functions.
    basis: [f64; BASIS],
    /// The weights of the integral from the start, s.
    weights: Nodes,
    /// A contact each, and one of 0 at either end: the integral of its force, and what a unit of mass answers to it: velocity,
    /// displacement, and its integral.
    sums: Vec<[f64; 4]>,
}

/// `U_0`, `U_1` and `U_2` by power series about 0, for negative times as well.
pub(super) struct Responses {
    /// Coefficients of `U_1`, from the first power on.
    terms: [f64; TERMS],
    count: usize,
}

impl Responses {
    /// For times up to `longest` (s).
    pub fn new(o: &Oscillator, longest: f64) -> Self {
        let mut terms = [0.0; TERMS];
        terms[0] = 1.0;
        terms[1] = -o.gamma();
        let reach = (o.omega() + 2.0 * o.gamma()) * longest;
        let (mut count, mut left_out) = (1, 0.5 * reach);
        for k in 2..TERMS {
            if left_out <= LEFT_OUT {
                break;
            }
            // Coefficient k + 1 of a function with U'' = -2 gamma U' - omega^2 U.
            let n = (k + 1) as f64;
            terms[k] = -(2.0 * o.gamma() * (n - 1.0) * terms[k - 1] + o.omega2() * terms[k - 2]) / (n * (n - 1.0));
            left_out *= reach / n;
            count = k + 1;
        }
        Self { terms, count: count.max(2) }
    }

    /// `U_0`, `U_1`, `U_2` at `s`.
    #[inline]
    pub fn at(&self, s: f64) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for (k, term) in self.terms[..self.count].iter().enumerate().rev() {
            let n = (k + 1) as f64;
            sums = [sums[0] * s + n * term, sums[1] * s + term, sums[2] * s + term / (n + 1.0)];
        }
        [sums[0], sums[1] * s, sums[2] * s * s]
    }

    /// These `weights`, and their products with [`Self::at`] `s`.
    #[inline(always)]
    fn weights(&self, weights: &Nodes, s: &Nodes) -> [Nodes; 4] {
        let [mut u0, mut u1, mut u2] = [[0.0; NODES]; 3];
        for (k, term) in self.terms[..self.count].iter().enumerate().rev() {
            let n = (k + 1) as f64;
            let terms = [n * term, *term, term / (n + 1.0)];
            for m in 0..NODES {
                u0[m] = u0[m] * s[m] + terms[0];
                u1[m] = u1[m] * s[m] + terms[1];
                u2[m] = u2[m] * s[m] + terms[2];
            }
        }
        for m in 0..NODES {
            u0[m] *= weights[m];
            u1[m] *= weights[m] * s[m];
            u2[m] *= weights[m] * s[m] * s[m];
        }
        [*weights, u0, u1, u2]
    }
}

impl Moment {
    /// With room for so many forces.
    pub fn with_capacity(forces: usize) -> Self {
        Self { sums: Vec::with_capacity(forces), ..Self::default() }
    }

    /// The motion is another one.
    pub fn forget(&mut self) {
        self.tau = None;
    }

    #[inline(always)]
    fn sum_portable(&mut self, responses: &Responses, ago: &Nodes, forces: &[Nodes]) {
        let weights = responses.weights(&self.weights, ago);
        self.sums.resize(forces.len(), [0.0; 4]);
        for (sums, forces) in self.sums.iter_mut().zip(forces) {
            for (sum, weights) in sums.iter_mut().zip(&weights) {
                *sum = weighted(weights, forces);
            }
        }
    }
}

multiversioned! {
impl Moment {
    /// The sums for these `forces` at nodes that are so long ago (s).
    fn sum(&mut self, responses: &Responses, ago: &Nodes, forces: &[Nodes]) = sum_portable;
}
}

impl Motion {
    /// What is known at `tau` (s).
    fn moment(&self, tau: f64) -> Ref<'_, Moment> {
        if self.moment.borrow().tau != Some(tau) {
            self.compute_moment(&mut self.moment.borrow_mut(), tau);
        }
        self.moment.borrow()
    }

    fn compute_moment(&self, moment: &mut Moment, tau: f64) {
        let (o, table) = (&self.oscillator, self.stretching.table());
        moment.tau = Some(tau);
        moment.basis = if self.varies {
            o.basis(DoubleDouble::from(tau))
        } else {
            let mut basis = [0.0; BASIS];
            basis[..4].copy_from_slice(&o.basis::<4>(DoubleDouble::from(tau)));
            basis
        };
        moment.weights = self.weights(tau);
        let ago = table.times.map(|time| tau - self.length * time);
        moment.sum(&Responses::new(o, self.length), &ago, &self.forces);
    }

    /// The weights of the integral from the start to `tau` (s).
    fn weights(&self, tau: f64) -> Nodes {
        let table = self.stretching.table();
        if tau == self.length {
            return table.of_rate.map(|weight| self.length * weight);
        }
        let mut weights = Rule::get().integrals(self.stretching.inverse(tau / self.length));
        weights.iter_mut().zip(table.paces).for_each(|(weight, pace)| *weight *= self.length * pace);
        weights
    }

    /// Of ball `i`, 1/kg. A window has a contact at every ball, on the right of all but the last one.
    fn inverse_mass(&self, i: usize) -> f64 {
        match self.tracks.get(i) {
            Some(track) => track.inverse_masses[0],
            None => self.tracks[i - 1].inverse_masses[1],
        }
    }

    /// How the forces of the contacts have changed velocity, displacement and its integral of ball `i`.
    fn answer(&self, moment: &Moment, i: usize) -> [f64; 3] {
        let inverse_mass = self.inverse_mass(i);
        std::array::from_fn(|k| (moment.sums[i][k + 1] - moment.sums[i + 1][k + 1]) * inverse_mass)
    }

    /// What the forces of the contacts add to the velocity of ball `i` at the nodes, m/s.
    fn pushed_velocities(&self, i: usize) -> Nodes {
        let (o, table) = (&self.oscillator, self.stretching.table());
        let inverse_mass = self.inverse_mass(i);
        let responses = Responses::new(o, self.length);
        let times = table.times.map(|part| self.length * part);
        // The motion that starts with what the pushes so far would have had to be at the start.
        let back = times.map(|time| responses.at(-time));
        let push = |m: usize| (self.forces[i][m] - self.forces[i + 1][m]) * inverse_mass;
        let [velocities, displacements] =
            [0, 1].map(|k| table.integrate(&std::array::from_fn(|m| push(m) * back[m][k])));
        std::array::from_fn(|m| {
            let [velocity, displacement, _] = responses.at(times[m]);
            self.length * (velocity * velocities[m] - o.omega2() * displacement * displacements[m])
        })
    }

    /// The force of contact `j` by its law, N, and the rate of its overlap, m/s, at the start, at the end or within the step.
    fn force(&self, j: usize, tau: f64) -> (f64, f64) {
        let track = &self.tracks[j];
        let (overlap, change) = match tau {
            0.0 => (track.overlap, 0.0),
            tau if tau == self.length => self.overlap(j, tau),
            _ => self.overlap_within(j, tau),
        };
        // Where the overlap is 0, a dashpot acts all the same.
        let rate = track.rate + change;
        let [force] = track.law.unclipped_forces(&[overlap], &[rate]);
        (force, rate)
    }

    /// Overlap of contact `j` and the change of its rate, of it alone.
    fn overlap_within(&self, j: usize, tau: f64) -> (f64, f64) {
        let (track, table, o) = (&self.tracks[j], self.stretching.table(), &self.oscillator);
        let [a, b] = track.inverse_masses;
        let (weights, responses) = (self.weights(tau), Responses::new(o, self.length));
        let [left, own, right] = [0, 1, 2].map(|beside| &self.forces[j + beside]);
        let mut sums = [0.0; 2];
        for l in 0..NODES {
            let pushed = weights[l] * ((left[l] - own[l]) * a - (own[l] - right[l]) * b);
            let [velocity, displacement, _] = responses.at(tau - self.length * table.times[l]);
            sums = [sums[0] + displacement * pushed, sums[1] + velocity * pushed];
        }
        let basis: [f64; BASIS] = o.basis(DoubleDouble::from(tau));
        (
            track.overlap + (track.free.displacement(o, &basis) + sums[0]),
            track.free.change_of_velocity(o, &basis) + sums[1],
        )
    }

    /// The switching of contact `j`, if it is this one.
    fn ends_with(&self, j: usize, switch: Switch) -> Next {
        if self.end == Some((j, switch)) { Next::At(self.until) } else { Next::Never }
    }
}

impl DenseOutput for Motion {
    fn moved(&self, i: usize, tau: f64) -> (f64, f64) {
        let (moment, flight, o) = (self.moment(tau), &self.flights[i], &self.oscillator);
        let [velocity, displacement, _] = self.answer(&moment, i);
        (flight.displacement(o, &moment.basis) + displacement, flight.change_of_velocity(o, &moment.basis) + velocity)
    }

    fn displacement_integral(&self, i: usize, tau: f64) -> f64 {
        let moment = self.moment(tau);
        self.flights[i].displacement_integral(&self.oscillator, &moment.basis) + self.answer(&moment, i)[2]
    }

    fn squared_velocity_integral(&self, i: usize, tau: f64) -> f64 {
        let (pushed, times) = (self.pushed_velocities(i), self.stretching.table().times);
        let free = |m: usize| self.flights[i].at(&self.oscillator, DoubleDouble::from(self.length * times[m])).1;
        weighted(&self.weights(tau), &std::array::from_fn(|m| (free(m) + pushed[m]).powi(2)))
    }

    fn work(&self, i: usize, forcing: &Forcing, tau: f64) -> f64 {
        if degree(forcing) == 0 {
            return if forcing[0] == 0.0 { 0.0 } else { forcing[0] * self.moved(i, tau).0 };
        }
        // The forcing may vary much beyond the time where the step is left.
        let free = self.flights[i].work(forcing, &self.oscillator, tau, &self.moment(tau).basis);
        let (pushed, times) = (self.pushed_velocities(i), self.stretching.table().times);
        let power = std::array::from_fn(|m| pushed[m] * forcing_at(forcing, self.length * times[m]));
        free + weighted(&self.weights(tau), &power)
    }

    fn overlap(&self, j: usize, tau: f64) -> (f64, f64) {
        let (moment, track, o) = (self.moment(tau), &self.tracks[j], &self.oscillator);
        let [a, b] = track.inverse_masses;
        let answer = |k: usize| {
            let [left, own, right] = [0, 1, 2].map(|beside| moment.sums[j + beside][k]);
            (left - own) * a - (own - right) * b
        };
        (
            track.overlap + (track.free.displacement(o, &moment.basis) + answer(2)),
            track.free.change_of_velocity(o, &moment.basis) + answer(1),
        )
    }

    fn overlap_series(&self, _: usize, _: f64) -> Option<OverlapSeries> {
        None
    }

    fn impulse(&self, j: usize, tau: f64) -> f64 {
        self.moment(tau).sums[j + 1][0]
    }

    /// Looked for between the nodes as the polynomial through the forces there; its value is that of the law.
    fn peak(&self, j: usize, from: f64, to: f64, known: f64) -> f64 {
        let (forces, table) = (&self.forces[j + 1], self.stretching.table());
        let time = |m: usize| self.length * table.times[m];
        let nodes_before = |tau: f64| (0..NODES).take_while(|m| time(*m) < tau).count();
        let is_whole = from == 0.0 && to == self.length;
        let (first, end) = if is_whole { (0, NODES) } else { (nodes_before(from), nodes_before(to)) };
        let node = (first..end).reduce(|a, b| if forces[b] >= forces[a] { b } else { a });
        let mut largest = node.map_or(0.0, |m| forces[m]);
        let is_cut = from > 0.0 || to < self.until;
        if node.is_some() && !is_cut && largest * MARGIN <= known {
            return known;
        }
        // An end of the step counts where the force rises towards it, one within the step in any case.
        let few = end < first + 2;
        let mut at_end = false;
        if few || from > 0.0 || forces[first] >= forces[first + 1] {
            let (force, rate) = self.force(j, from);
            at_end = is_whole && node == Some(first) && rate <= 0.0;
            largest = largest.max(force);
        }
        if few || to < self.until || forces[end - 1] >= forces[end - 2] {
            let (force, rate) = self.force(j, to);
            at_end |= is_whole && node == Some(end - 1) && rate >= 0.0;
            largest = largest.max(force);
        }
        // An elastic force grows with the overlap.
        if largest * MARGIN <= known || (at_end && self.tracks[j].law.is_elastic()) {
            return largest.max(known);
        }
        let start = node.filter(|m| *m > first).map_or(from, |m| time(m - 1));
        let end = node.filter(|m| m + 1 < end).map_or(to, |m| time(m + 1));
        let x = |tau: f64| 2.0 * self.stretching.inverse(tau / self.length) - 1.0;
        let coefficients = Rule::get().powers.map(|row| weighted(&row, forces));
        let falls: Nodes = std::array::from_fn(|k| -((k + 1) as f64) * coefficients.get(k + 1).unwrap_or(&0.0));
        let fall = |x: f64| series::value_and_derivatives(&falls, x);
        let (low, high) = (x(start), x(end));
        let (at_low, at_high) = (fall(low)[0], fall(high)[0]);
        if at_low < 0.0 && at_high >= 0.0 {
            let c = 0.5 + 0.5 * root::rising_zero(fall, (low, at_low), (high, at_high));
            let place = (self.length * self.stretching.part(c)).clamp(from, to);
            return largest.max(self.force(j, place).0).max(known);
        }
        largest.max(known)
    }

    fn contact_loss(&self, j: usize, tau: f64) -> f64 {
        let elastic = self.tracks[j].law.elastic_forces(&self.overlaps[j]);
        let power = std::array::from_fn(|m| (self.forces[j + 1][m] - elastic[m]) * self.rates[j][m]);
        weighted(&self.moment(tau).weights, &power)
    }

    fn onset(&self, j: usize, _: &Window, _: f64, _: &Rounding) -> Next {
        self.ends_with(j, Switch::Onset)
    }

    fn release(&self, j: usize, _: f64, _: &Rounding) -> Next {
        self.ends_with(j, Switch::Release)
    }

    fn clip(&self, j: usize, _: &Window, _: f64, _: &Rounding) -> Next {
        self.ends_with(j, clipping(self.tracks[j].mode).1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_processors_give_the_same_sums() {
        let nodes = |seed: f64| std::array::from_fn(|m| libm::sin(seed + m as f64));
        let forces: Vec<Nodes> = (0..5).map(|j| nodes(f64::from(j))).collect();
        let (responses, ago) = (Responses::new(&Oscillator::new(9.0, 0.1), 1.0), nodes(0.3));
        let mut at_hand = Moment { weights: nodes(0.7), ..Moment::default() };
        let mut portable = at_hand.clone();
        at_hand.sum(&responses, &ago, &forces);
        portable.sum_portable(&responses, &ago, &forces);
        let bits = |moment: &Moment| moment.sums.iter().flatten().map(|sum| sum.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&at_hand), bits(&portable));
    }
}
