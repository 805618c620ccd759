//! What is read off a step of Gauss collocation, at any time of it.
//!
//! The forces at the nodes are all that is kept. A pendulum answers them linearly: with `U_k` the functions of the
//! oscillator (`solver::oscillator`) and `w_l(tau)` the weights of the integral from the start to tau,
//!
//! ```text
//! x(tau) = x_free(tau) + sum_l w_l(tau) U_1(tau - t_l) f_l,     x' with U_0, the integral of x with U_2
//! ```
//!
//! At the end of the step these are the sums of the method itself. So is the overlap, as a difference of two such
//! motions.
//!
//! Integrals up to a time early in the step are sums at nodes on the way there: by the nodes of the step, they would be
//! known to the rounding of what comes later.

use std::cell::Ref;

use super::motion::{Moment, Motion, Part, Track};
use crate::engine::cluster::dense_output::DenseOutput;
use crate::engine::cluster::window::{OverlapSeries, Switch, Window, clipping};
use crate::engine::flight::{Forcing, Rounding, degree, forcing_at};
use crate::model::Mode;
use crate::next::Next;
use crate::solver::double_double::DoubleDouble;
use crate::solver::gauss::{NODES, Nodes, Rule, weighted};
use crate::solver::oscillator::{BASIS, Oscillator};
use crate::solver::{root, series};

/// Terms of the power series of the oscillator's functions, and what the first term left out may be.
const TERMS: usize = 14;
const LEFT_OUT: f64 = 1e-18;

/// How far a peak may exceed the largest force at the nodes and at the ends.
const MARGIN: f64 = 1.25;

/// Up to this part of the step, as it is stretched, integrals have nodes of their own: where steps end early, those of
/// the step serve.
const EARLY: f64 = 0.5;

/// Longest step, over the time scale of the pendulum, that those terms serve.
pub(super) const LONGEST: f64 = 0.25;

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
        let reach = o.pace() * longest;
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
    fn weights(&self, weights: &Nodes, s: &Nodes) -> [Nodes; 3] {
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
        [u0, u1, u2]
    }
}

impl Motion {
    /// The motion is another one.
    pub(super) fn forget(&mut self) {
        (self.moment.get_mut().tau, self.part.get_mut().tau) = (None, None);
    }

    /// What is known at `tau` (s).
    fn moment(&self, tau: f64) -> Ref<'_, Moment> {
        if self.moment.borrow().tau != Some(tau) {
            self.compute_moment(&mut self.moment.borrow_mut(), tau);
        }
        self.moment.borrow()
    }

    fn compute_moment(&self, moment: &mut Moment, tau: f64) {
        moment.tau = Some(tau);
        moment.weights = self.weights(tau);
        let ago = self.ago(tau);
        let (mut basis, mut responses, mut left) = ([0.0; BASIS], [[0.0; NODES]; 3], [0.0; 3]);
        let sums = |responses: &[Nodes; 3], i: usize| responses.each_ref().map(|r| weighted(r, &self.forces[i]));
        moment.balls.clear();
        for (i, (o, flight)) in self.oscillators.iter().zip(&self.flights).enumerate() {
            if i == 0 || *o != self.oscillators[i - 1] {
                basis = self.basis(o, tau);
                responses = Responses::new(o, self.length).weights(&moment.weights, &ago);
                left = sums(&responses, i);
            }
            let (right, inverse_mass) = (sums(&responses, i + 1), self.inverse_mass(i));
            let pushed: [f64; 3] = std::array::from_fn(|k| (left[k] - right[k]) * inverse_mass);
            moment.balls.push([
                flight.displacement(o, &basis) + pushed[1],
                flight.change_of_velocity(o, &basis) + pushed[0],
                flight.displacement_integral(o, &basis) + pushed[2],
            ]);
            left = right;
        }
        moment.contacts.clear();
        for (j, track) in self.tracks.iter().enumerate() {
            let (overlap, change) = if track.mode == Mode::Pressing {
                self.overlap_by(&moment.weights, &ago, j, tau)
            } else {
                let [left, right] = [&moment.balls[j], &moment.balls[j + 1]];
                (track.overlap + (left[0] - right[0]), left[1] - right[1])
            };
            moment.contacts.push([overlap, change]);
        }
    }

    /// The functions of the oscillator `o`, as many as inputs call for.
    fn basis(&self, o: &Oscillator, tau: f64) -> [f64; BASIS] {
        if self.varies {
            return o.basis(DoubleDouble::from(tau));
        }
        let mut basis = [0.0; BASIS];
        basis[..4].copy_from_slice(&o.basis::<4>(DoubleDouble::from(tau)));
        basis
    }

    /// Overlap of the pressing contact `j` (m) and the change of its rate (m/s), by its accelerations with these
    /// `weights` (s) so long `ago` (s).
    fn overlap_by(&self, weights: &Nodes, ago: &Nodes, j: usize, tau: f64) -> (f64, f64) {
        let (track, accelerations) = (&self.tracks[j], &self.accelerations[j]);
        let moved = weighted(&std::array::from_fn(|m| weights[m] * ago[m]), accelerations);
        (track.overlap + (track.rate * tau + moved), weighted(weights, accelerations))
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
    pub(super) fn inverse_mass(&self, i: usize) -> f64 {
        match self.tracks.get(i) {
            Some(track) => track.inverse_masses[0],
            None => self.tracks[i - 1].inverse_masses[1],
        }
    }

    /// The step up to `tau` (s).
    fn part(&self, tau: f64) -> Ref<'_, Part> {
        if self.part.borrow().tau != Some(tau) {
            let scaled = |nodes: Nodes| nodes.map(|value| self.length * value);
            let (table, end) = (self.stretching.table(), self.stretching.inverse(tau / self.length));
            let part = if end > EARLY {
                let [times, paces] = [table.times, table.paces].map(scaled);
                Part { tau: Some(tau), times, paces, weights: self.weights(tau), contacts: None }
            } else {
                let [times, paces, weights] = self.stretching.nodes_up_to(end).map(scaled);
                Part { tau: Some(tau), times, paces, weights, contacts: Some(self.contacts_at(&times)) }
            };
            *self.part.borrow_mut() = part;
        }
        self.part.borrow()
    }

    /// Overlaps (m), rates (m/s) and forces (N) of the contacts at these times (s); 0 for those that do not press.
    fn contacts_at(&self, times: &Nodes) -> Vec<[Nodes; 3]> {
        let within = times.map(|time| (time, self.weights(time), self.ago(time)));
        let values = |(j, track): (usize, &Track)| {
            let (mut overlaps, mut rates) = ([0.0; NODES], [0.0; NODES]);
            if track.mode != Mode::Pressing {
                return [[0.0; NODES]; 3];
            }
            for (m, (time, weights, ago)) in within.iter().enumerate() {
                let (overlap, change) = self.overlap_by(weights, ago, j, *time);
                (overlaps[m], rates[m]) = (overlap, track.rate + change);
            }
            [overlaps, rates, track.law.unclipped_forces(&overlaps, &rates)]
        };
        self.tracks.iter().enumerate().map(values).collect()
    }

    /// Forces at the nodes of this part of the step of the contacts beside ball `i`, N; 0 where there is none.
    fn forces_on<'a>(&'a self, i: usize, part: &'a Part) -> [&'a Nodes; 2] {
        const NONE: Nodes = [0.0; NODES];
        match &part.contacts {
            None => [&self.forces[i], &self.forces[i + 1]],
            Some(contacts) => {
                let force = |j: usize| contacts.get(j).map_or(&NONE, |[.., forces]| forces);
                [i.checked_sub(1).map_or(&NONE, force), force(i)]
            }
        }
    }

    /// What the forces of the contacts add up to `tau` (s) to the velocity (m/s) and the position (m) of ball `i`, and
    /// to the integral of its position (m.s).
    fn pushed_up_to(&self, i: usize, tau: f64) -> [f64; 3] {
        let part = self.part(tau);
        let [left, right] = self.forces_on(i, &part);
        let responses = Responses::new(&self.oscillators[i], self.length);
        let weights = responses.weights(&part.weights, &part.times.map(|time| tau - time));
        weights.map(|weights| (weighted(&weights, left) - weighted(&weights, right)) * self.inverse_mass(i))
    }

    /// How long before `tau` (s) the nodes are, s.
    fn ago(&self, tau: f64) -> Nodes {
        self.stretching.table().times.map(|time| tau - self.length * time)
    }

    /// What the forces of the contacts add to the velocity of ball `i` at the nodes of this part of the step, m/s.
    fn pushed_velocities(&self, i: usize, part: &Part) -> Nodes {
        let (o, inverse_mass) = (&self.oscillators[i], self.inverse_mass(i));
        let [left, right] = self.forces_on(i, part);
        let responses = Responses::new(o, self.length);
        // The motion that starts with what the pushes so far would have had to be at the start.
        let back = part.times.map(|time| responses.at(-time));
        let push = |m: usize| part.paces[m] * (left[m] - right[m]) * inverse_mass;
        let [velocities, displacements] =
            [0, 1].map(|k| Rule::get().integrate(&std::array::from_fn(|m| push(m) * back[m][k])));
        std::array::from_fn(|m| {
            let [velocity, displacement, _] = responses.at(part.times[m]);
            velocity * velocities[m] - o.omega2() * displacement * displacements[m]
        })
    }

    /// The force of contact `j` by its law, N, and the rate of its overlap, m/s, at the start, at the end or within the
    /// step.
    fn force(&self, j: usize, tau: f64) -> (f64, f64) {
        let track = &self.tracks[j];
        let (overlap, change) = match tau {
            0.0 => (track.overlap, 0.0),
            tau if tau == self.length => self.overlap(j, tau),
            _ => self.overlap_by(&self.weights(tau), &self.ago(tau), j, tau),
        };
        // Where the overlap is 0, a dashpot acts all the same.
        let rate = track.rate + change;
        let [force] = track.law.unclipped_forces(&[overlap], &[rate]);
        (force, rate)
    }

    /// The switching of contact `j`, if it is this one.
    fn ends_with(&self, j: usize, switch: Switch) -> Next {
        if self.end == Some((j, switch)) { Next::At(self.until) } else { Next::Never }
    }
}

impl DenseOutput for Motion {
    fn moved(&self, i: usize, tau: f64) -> (f64, f64) {
        let [displacement, change, _] = self.moment(tau).balls[i];
        (displacement, change)
    }

    fn displacement_integral(&self, i: usize, tau: f64) -> f64 {
        if self.part(tau).contacts.is_none() {
            return self.moment(tau).balls[i][2];
        }
        let (o, [_, _, pushed]) = (&self.oscillators[i], self.pushed_up_to(i, tau));
        self.flights[i].displacement_integral(o, &self.basis(o, tau)) + pushed
    }

    fn squared_velocity_integral(&self, i: usize, tau: f64) -> f64 {
        let part = self.part(tau);
        let pushed = self.pushed_velocities(i, &part);
        let free = |m: usize| self.flights[i].at(&self.oscillators[i], DoubleDouble::from(part.times[m])).1;
        weighted(&part.weights, &std::array::from_fn(|m| (free(m) + pushed[m]).powi(2)))
    }

    fn work(&self, i: usize, forcing: &Forcing, tau: f64) -> f64 {
        let o = &self.oscillators[i];
        if degree(forcing) == 0 && self.part(tau).contacts.is_none() {
            return forcing[0] * self.moved(i, tau).0;
        }
        if degree(forcing) == 0 {
            let [_, pushed, _] = self.pushed_up_to(i, tau);
            return forcing[0] * (self.flights[i].displacement(o, &self.basis(o, tau)) + pushed);
        }
        let free = self.flights[i].work(forcing, o, tau, &o.basis::<BASIS>(DoubleDouble::from(tau)));
        let part = self.part(tau);
        let pushed = self.pushed_velocities(i, &part);
        let power = std::array::from_fn(|m| pushed[m] * forcing_at(forcing, part.times[m]));
        free + weighted(&part.weights, &power)
    }

    fn overlap(&self, j: usize, tau: f64) -> (f64, f64) {
        let [overlap, change] = self.moment(tau).contacts[j];
        (overlap, change)
    }

    fn overlap_series(&self, _: usize, _: f64) -> Option<OverlapSeries> {
        None
    }

    fn impulse(&self, j: usize, tau: f64) -> f64 {
        let part = self.part(tau);
        weighted(&part.weights, self.forces_on(j, &part)[1])
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
        let part = self.part(tau);
        let [overlaps, rates] = match &part.contacts {
            Some(contacts) => [&contacts[j][0], &contacts[j][1]],
            None => [&self.overlaps[j], &self.rates[j]],
        };
        let forces = self.tracks[j].law.damping_forces(overlaps, rates);
        weighted(&part.weights, &std::array::from_fn(|m| forces[m] * rates[m]))
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
