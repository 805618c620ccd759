//! Dense output of a step of Gauss collocation.
//!
//! The motion follows from the accelerations at the nodes: with `w_l(tau)` the weights of the integral from the start
//! to tau,
//!
//! ```text
//! v(tau) = v + sum_l w_l(tau) a_l,     x(tau) = x + v tau + sum_l w_l(tau) (tau - t_l) a_l
//! ```
//!
//! At the end of the step these are the sums of the method itself. Integrals are sums of values at the nodes of the
//! step; up to a time early in it, at nodes of their own, without the rounding of later values.

use std::cell::{OnceCell, Ref};

use super::motion::{GaussStep, MotionAtTime, Samples};
use crate::engine::cluster::window::{DenseOutput, Switch, Window};
use crate::engine::flight::{Flight, Forcing, Rounding, degree, forcing_at};
use crate::engine::{Forecast, Peak};
use crate::model::{Mode, Pair};
use crate::solver::{NODES, Nodes, RULE, root, series, weighted};

/// Largest peak over the largest force at the nodes and at the ends.
const MARGIN: f64 = 1.25;

/// Largest time from the peak of the polynomial through these forces to the peak by the law, over that between the
/// nodes beside it.
const NEWTON_RANGE: f64 = 1e-3;

/// Up to this part of the stretched step, integrals have nodes of their own.
const EARLY: f64 = 0.5;

impl GaussStep {
    fn moment(&self, tau: f64) -> Ref<'_, MotionAtTime> {
        if self.moment.borrow().tau != Some(tau) {
            self.compute_moment(&mut self.moment.borrow_mut(), tau);
        }
        self.moment.borrow()
    }

    fn compute_moment(&self, moment: &mut MotionAtTime, tau: f64) {
        (moment.tau, moment.weights, moment.early) = (Some(tau), self.weights(tau), OnceCell::new());
        let weights = &moment.weights;
        moment.relative.clear();
        moment.relative.extend(self.contacts.iter().zip(&self.accelerations).map(|(contact, a)| match contact.mode {
            Mode::Pressing => moved_by(weights, contact.rate, a, tau),
            Mode::Open | Mode::Clipped => [0.0; 3],
        }));
        moment.balls.clear();
        if self.needs_balls() {
            let balls = self.flights.iter().zip(&self.ball_accelerations);
            moment.balls.extend(balls.map(|(flight, a)| moved_by(weights, flight.v, a, tau)));
        } else {
            self.move_about_centres(&mut moment.balls, &moment.relative, tau);
        }
        moment.contacts.clear();
        for (j, contact) in self.contacts.iter().enumerate() {
            moment.contacts.push(if contact.mode == Mode::Pressing {
                [contact.overlap + moment.relative[j][0], moment.relative[j][1]]
            } else if self.on_arcs() {
                let pair = Pair { balls: [&self.arcs.models[j], &self.arcs.models[j + 1]], law: &contact.law };
                let states = [j, j + 1].map(|i| (self.flights[i].x, self.flights[i].v));
                let moves = [j, j + 1].map(|i| moment.balls[i]);
                let then = [0, 1].map(|k| (states[k].0 + moves[k][0], states[k].1 + moves[k][1]));
                let change = pair.change_of_overlap(states.map(|(place, _)| place), moves.map(|[way, ..]| way));
                [contact.overlap + change, pair.overlap_rate(then) - pair.overlap_rate(states)]
            } else {
                let [left, right] = [&moment.balls[j], &moment.balls[j + 1]];
                [contact.overlap + (left[0] - right[0]), left[1] - right[1]]
            });
        }
    }

    /// Motion of equal pendulums without drag up to `tau` (s): the centre of mass of balls that press on each other
    /// flies, and the changes of the overlaps give the places about it.
    fn move_about_centres(&self, balls: &mut Vec<[f64; 3]>, relative: &[[f64; 3]], tau: f64) {
        let (o, mut first) = (&self.oscillators[0], 0);
        let [_, u1, u2, u3]: [f64; 4] = o.basis(tau.into());
        for last in 0..self.flights.len() {
            if self.presses(last) {
                continue;
            }
            let mass = |i: usize| 1.0 / self.inverse_mass(i);
            let (mut all, mut sums) = (0.0, [0.0; 3]);
            for i in first..last + 1 {
                let Flight { x, v, forcing } = self.flights[i];
                all += mass(i);
                sums.iter_mut().zip([x, v, forcing[0]]).for_each(|(sum, value)| *sum += mass(i) * value);
            }
            let [x, v, forcing] = sums.map(|sum| sum / all);
            let free = forcing - o.omega2() * x;
            let mut place = [v * u1 + free * u2, free * u1 - v * o.omega2() * u2, v * u2 + free * u3];
            let (begin, mut right) = (balls.len(), all);
            balls.push(place);
            for (j, change) in (first..).zip(&relative[first..last]) {
                right -= mass(j);
                // The balls so far move by the mass share of those beyond.
                let share = right / all;
                balls[begin..].iter_mut().for_each(|ball| (0..3).for_each(|k| ball[k] += share * change[k]));
                (0..3).for_each(|k| place[k] -= (1.0 - share) * change[k]);
                balls.push(place);
            }
            first = last + 1;
        }
    }

    /// Weights of the integral from the start to `tau` (s), s, of the double integral, s2, and of the triple integral,
    /// s3.
    fn weights(&self, tau: f64) -> [Nodes; 3] {
        let (table, length) = (self.stretching.table(), self.length);
        let (mut once, paces) = if tau == length {
            (table.of_rate, &[1.0; NODES])
        } else if let Some(node) = table.times.iter().position(|time| length * time == tau) {
            (table.up_to_node[node], &[1.0; NODES])
        } else {
            (RULE.integrals(self.stretching.inverse(tau / length)), &table.paces)
        };
        let (mut twice, mut thrice) = ([0.0; NODES], [0.0; NODES]);
        for m in 0..NODES {
            let ago = tau - length * table.times[m];
            once[m] *= length * paces[m];
            twice[m] = once[m] * ago;
            thrice[m] = 0.5 * twice[m] * ago;
        }
        [once, twice, thrice]
    }

    /// Inverse mass of ball `i`, 1/kg, from the contact on its right or, for the last one, on its left.
    pub(super) fn inverse_mass(&self, i: usize) -> f64 {
        match self.contacts.get(i) {
            Some(contact) => contact.inverse_masses[0],
            None => self.contacts[i - 1].inverse_masses[1],
        }
    }

    fn early(&self, tau: f64) -> Ref<'_, Option<(Samples, Nodes)>> {
        let compute = || {
            if self.length == 0.0 {
                return None;
            }
            let end = self.stretching.inverse(tau / self.length);
            (end <= EARLY).then(|| {
                let [times, weights] = self.stretching.nodes_up_to(end).map(|nodes| nodes.map(|t| self.length * t));
                (self.samples(times), weights)
            })
        };
        Ref::map(self.moment(tau), |moment| moment.early.get_or_init(compute))
    }

    fn samples(&self, times: Nodes) -> Samples {
        let mut samples = Samples { times, ..self.at_nodes.clone() };
        let mut moment = MotionAtTime::default();
        for (m, tau) in times.into_iter().enumerate() {
            self.compute_moment(&mut moment, tau);
            for (i, [displacement, change, _]) in moment.balls.iter().enumerate() {
                (samples.balls[i][0][m], samples.balls[i][1][m]) = (*displacement, self.flights[i].v + change);
            }
            for (j, [overlap, change]) in moment.contacts.iter().enumerate() {
                (samples.overlaps[j][m], samples.rates[j][m]) = (*overlap, self.contacts[j].rate + change);
            }
        }
        for (j, contact) in self.contacts.iter().enumerate().filter(|(_, contact)| contact.mode == Mode::Pressing) {
            samples.forces[j + 1] = contact.law.unclipped_forces(&samples.overlaps[j], &samples.rates[j]);
        }
        samples
    }

    /// The integral up to `tau` (s) of `values` at the nodes.
    fn integral(&self, tau: f64, values: impl Fn(&Samples) -> Nodes) -> f64 {
        match &*self.early(tau) {
            Some((samples, weights)) => weighted(weights, &values(samples)),
            None => weighted(&self.moment(tau).weights[0], &values(&self.at_nodes)),
        }
    }

    /// The overlap of contact `j`, m, its rate, m/s, and the force by its law, N, at any time of the step.
    fn contact_at(&self, j: usize, tau: f64) -> [f64; 3] {
        let contact = &self.contacts[j];
        let [overlap, change] = match tau {
            0.0 => [contact.overlap, 0.0],
            tau if tau == self.length => self.moment(tau).contacts[j],
            _ => {
                let [change, of_rate, _] = moved_by(&self.weights(tau), contact.rate, &self.accelerations[j], tau);
                [contact.overlap + change, of_rate]
            }
        };
        // A dashpot acts even at overlap 0.
        let rate = contact.rate + change;
        let [force] = contact.law.unclipped_forces(&[overlap], &[rate]);
        [overlap, rate, force]
    }

    /// How much later than `tau` (s) the force of contact `j` is largest, s, by one step of Newton's method for the
    /// rate of the force by the law, from the state at `tau`. `falls` has the coefficients of a polynomial in powers of
    /// `2 c - 1` that is roughly minus that rate.
    fn way_to_top(&self, j: usize, tau: f64, [overlap, rate, _]: [f64; 3], falls: &Nodes) -> f64 {
        let c = self.stretching.inverse(tau / self.length);
        let (x, pace) = (2.0 * c - 1.0, 0.5 * self.length * self.stretching.at_rounded(c).1);
        let [_, slope, _] = series::value_and_derivatives(falls, x);
        let (by_overlap, by_rate) = self.contacts[j].law.force_slopes(overlap, rate);
        let bent = match by_rate {
            0.0 => 0.0,
            _ => by_rate * series::value(&RULE.powers.map(|row| weighted(&row, &self.accelerations[j])), x),
        };
        (by_overlap * rate + bent) * pace * pace / slope
    }

    /// When, between these times (s), the polynomial in powers of `2 c - 1` with these coefficients rises through 0, s.
    pub(super) fn rising_zero(&self, coefficients: &Nodes, start: f64, end: f64) -> Option<f64> {
        let x = |time: f64| 2.0 * self.stretching.inverse(time / self.length) - 1.0;
        let at = |x: f64| series::value_and_derivatives(coefficients, x);
        let [low, high] = [x(start), x(end)].map(|x| (x, at(x)[0]));
        let c = || 0.5 + 0.5 * root::rising_zero(at, low, high);
        (low.1 < 0.0 && high.1 >= 0.0).then(|| (self.length * self.stretching.at_rounded(c()).0).clamp(start, end))
    }
}

/// Displacement, change of velocity, and integral of the displacement, from a velocity, accelerations and
/// [weights](GaussStep::weights).
fn moved_by([once, twice, thrice]: &[Nodes; 3], v: f64, accelerations: &Nodes, tau: f64) -> [f64; 3] {
    let [velocity, displacement, integral] = [once, twice, thrice].map(|weights| weighted(weights, accelerations));
    [v * tau + displacement, velocity, 0.5 * v * tau * tau + integral]
}

impl DenseOutput for GaussStep {
    fn moved(&self, i: usize, tau: f64) -> (f64, f64) {
        let [displacement, change, _] = self.moment(tau).balls[i];
        (displacement, change)
    }

    fn displacement_integral(&self, i: usize, tau: f64) -> f64 {
        if self.early(tau).is_none() {
            return self.moment(tau).balls[i][2];
        }
        self.integral(tau, |at| at.balls[i][0])
    }

    fn squared_velocity_integral(&self, i: usize, tau: f64) -> f64 {
        self.integral(tau, |at| at.balls[i][1].map(|v| v * v))
    }

    fn work(&self, i: usize, forcing: &Forcing, tau: f64) -> f64 {
        if degree(forcing) == 0 && self.early(tau).is_none() {
            return forcing[0] * self.moved(i, tau).0;
        }
        self.integral(tau, |at| std::array::from_fn(|m| forcing_at(forcing, at.times[m]) * at.balls[i][1][m]))
    }

    fn overlap(&self, j: usize, tau: f64) -> (f64, f64) {
        self.moment(tau).contacts[j].into()
    }

    fn impulse(&self, j: usize, tau: f64) -> f64 {
        self.integral(tau, |at| at.forces[j + 1])
    }

    /// The time is that of the peak of the polynomial through the forces at the nodes, improved by a step of Newton's
    /// method; the force is that of the law.
    fn peak(&self, j: usize, from: f64, to: f64, known: f64) -> Option<Peak> {
        let (forces, table) = (&self.at_nodes.forces[j + 1], self.stretching.table());
        let time = |m: usize| self.length * table.times[m];
        let nodes_before = |tau: f64| (0..NODES).take_while(|m| time(*m) < tau).count();
        let is_whole = from == 0.0 && to == self.length;
        let (first, end) = if is_whole { (0, NODES) } else { (nodes_before(from), nodes_before(to)) };
        let node = (first..end).reduce(|a, b| if forces[b] >= forces[a] { b } else { a });
        let mut peak = node.map_or(Peak { force: 0.0, time: from }, |m| Peak { force: forces[m], time: time(m) });
        let is_cut = from > 0.0 || to < self.until;
        if node.is_some() && !is_cut && peak.force * MARGIN <= known {
            return None;
        }
        // An end of the step counts if the force rises towards it, a cut within the step always.
        let few = end < first + 2;
        let mut at_end = false;
        if few || from > 0.0 || forces[first] >= forces[first + 1] {
            let [_, rate, force] = self.contact_at(j, from);
            at_end = is_whole && node == Some(first) && rate <= 0.0;
            peak.raise(force, from);
        }
        if few || to < self.until || forces[end - 1] >= forces[end - 2] {
            let [_, rate, force] = self.contact_at(j, to);
            at_end |= is_whole && node == Some(end - 1) && rate >= 0.0;
            peak.raise(force, to);
        }
        // An elastic force grows with the overlap: its peak at an end is certain.
        if peak.force * MARGIN <= known || (at_end && self.contacts[j].law.is_elastic()) {
            return Some(peak);
        }
        let start = node.filter(|m| *m > first).map_or(from, |m| time(m - 1));
        let end = node.filter(|m| m + 1 < end).map_or(to, |m| time(m + 1));
        let coefficients = RULE.powers.map(|row| weighted(&row, forces));
        let falls = std::array::from_fn(|k| -((k + 1) as f64) * coefficients.get(k + 1).unwrap_or(&0.0));
        if let Some(place) = self.rising_zero(&falls, start, end).map(|place| place.clamp(from, to)) {
            let state @ [.., force] = self.contact_at(j, place);
            let way = self.way_to_top(j, place, state, &falls);
            let near = way.abs() < NEWTON_RANGE * (end - start);
            peak.raise_to_maximum(force, if near { (place + way).clamp(from, to) } else { place }, [start, end]);
        }
        Some(peak)
    }

    fn contact_loss(&self, j: usize, tau: f64) -> f64 {
        self.integral(tau, |at| {
            let forces = self.contacts[j].law.damping_forces(&at.overlaps[j], &at.rates[j]);
            std::array::from_fn(|m| forces[m] * at.rates[j][m])
        })
    }

    fn first(&self, switch: Switch, j: usize, _: &Window, _: f64, _: &Rounding) -> Forecast {
        if self.end == Some((j, switch)) { Forecast::At(self.until) } else { Forecast::Never }
    }
}
