//! How the motion of two equal pendulums that press on each other by a linear contact changes with its start and with the
//! coefficients.
//!
//! Their centre swings like one of them, their distance like an oscillator of its own: both motions and their responses are closed
//! forms. What the coefficients change is the integral of the response to it, by Gauss's rule in a time `3 c^2 - 2 c^3`, which takes the
//! logarithm of the overlap.

use super::coefficients::Coefficients;
use super::flown::{first_half, moved, swung, swung_back};
use super::slots::Slots;
use crate::engine::flight::{Flight, Forcing, forcing_at};
use crate::model::{BallModel, ContactLaw, Cradle};
use crate::solver::oscillator::Oscillator;

/// Two balls in contact, on the way together.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    /// The left one.
    pub first: usize,
    pub tuning: usize,
    /// Of the centre of mass, and of the overlap.
    centre: Flight,
    overlap: Flight,
    /// External forces, N.
    pushes: [Forcing; 2],
    length: f64,
    own: Oscillator,
    contact: Oscillator,
    /// The functions of the two oscillators at the end.
    of_centre: [f64; 3],
    of_distance: [f64; 3],
}

/// A place on the way.
struct Place {
    weight: f64,
    /// Responses at the end to an acceleration here.
    of_centre: [f64; 3],
    of_distance: [f64; 3],
    /// Position, velocity and force (N) of each ball.
    x: [f64; 2],
    v: [f64; 2],
    force: [f64; 2],
    /// Derivatives of the contact force by the coefficients.
    contact: [f64; 7],
}

/// Shares of the two balls in their mass.
fn shares(models: &[BallModel]) -> [f64; 2] {
    let total = models[0].mass + models[1].mass;
    [models[0].mass / total, models[1].mass / total]
}

/// Inverse of their reduced mass, 1/kg.
fn inverse_mass(models: &[BallModel]) -> f64 {
    1.0 / models[0].mass + 1.0 / models[1].mass
}

impl Pair {
    /// The oscillators of the centre and of the overlap, if the motion is the sum of the two.
    pub fn oscillators(models: &[BallModel], law: &ContactLaw) -> Option<[Oscillator; 2]> {
        let equal = models[0].omega2 == models[1].omega2 && models[0].gamma == models[1].gamma;
        let (omega2, gamma) = (models[0].omega2, models[0].gamma);
        (equal && law.exponent == 1.0 && law.is_elastic()).then(|| {
            [Oscillator::new(omega2, gamma), Oscillator::new(omega2 + law.stiffness * inverse_mass(models), gamma)]
        })
    }

    /// The motion of two balls from these flights on, under these external forces (N), from the overlap (m) for the time `length` (s);
    /// then their displacements, velocities, and the change of the overlap.
    pub fn new(
        (first, tuning): (usize, usize),
        cradle: &Cradle,
        [own, contact]: [Oscillator; 2],
        balls: [Flight; 2],
        pushes: [Forcing; 2],
        overlap: f64,
        length: f64,
    ) -> (Self, [(f64, f64); 2], f64) {
        let models = &cradle.balls[first..first + 2];
        let shares = shares(models);
        let mean = |left: f64, right: f64| shares[0] * left + shares[1] * right;
        let [left, right] = &balls;
        let centre = Flight {
            x: mean(left.x, right.x),
            v: mean(left.v, right.v),
            forcing: std::array::from_fn(|k| mean(left.forcing[k], right.forcing[k])),
        };
        let mut forcing: Forcing = std::array::from_fn(|k| left.forcing[k] - right.forcing[k]);
        forcing[0] -= own.omega2() * cradle.contacts[first].clearance;
        let overlap = Flight { x: overlap, v: left.v - right.v, forcing };
        let (of_centre, of_distance) = (own.basis(length.into()), contact.basis(length.into()));
        let (centre_moved, centre_v) = moved(&centre, &own, &of_centre, length);
        let (closer, rate) = moved(&overlap, &contact, &of_distance, length);
        let ends = [
            (centre_moved + shares[1] * closer, centre_v + shares[1] * rate),
            (centre_moved - shares[0] * closer, centre_v - shares[0] * rate),
        ];
        (Self { first, tuning, centre, overlap, pushes, length, own, contact, of_centre, of_distance }, ends, closer)
    }

    /// Changes of the state at the end from those at the start.
    pub fn forward(&self, cradle: &Cradle, change: &Coefficients, slots: &mut Slots) {
        let (i, j) = (self.first, self.first + 1);
        let (models, law) = (&cradle.balls[i..=j], &cradle.contacts[i]);
        let shares = shares(models);
        let mean = |values: &[f64]| shares[0] * values[0] + shares[1] * values[1];
        let (x, v) = (mean(&slots.x[i..=j]), mean(&slots.v[i..=j]));
        let clearance = change.contacts[i].clearance;
        let (r, rate) = ((slots.x[i] - slots.x[j]) - clearance, slots.v[i] - slots.v[j]);
        let mut centre = swung(&self.own, &self.of_centre, x, v);
        let mut distance = swung(&self.contact, &self.of_distance, r, rate);
        let mut integral = self.integral_of_distance() * r + self.of_distance[2] * rate;
        let mut force_integral = 0.0;
        let (by, contact) = (&change.balls[i..=j], change.contacts[i].array());
        self.each_place(models, law, |place| {
            let force: f64 = place.contact.iter().zip(contact).map(|(of, by)| of * by).sum();
            let source = |side: usize| {
                let (by, mass) = (&by[side], models[side].mass);
                by.force / mass
                    - place.force[side] * by.mass / (mass * mass)
                    - by.omega2 * place.x[side]
                    - 2.0 * by.gamma * place.v[side]
            };
            let sources = [source(0), source(1)];
            let common = place.weight * (mean(&sources) - change.support);
            let source = sources[0] - sources[1] - self.own.omega2() * clearance;
            let apart = place.weight * (source - force * inverse_mass(models));
            centre[0] += place.of_centre[1] * common;
            centre[1] += place.of_centre[0] * common;
            distance[0] += place.of_distance[1] * apart;
            distance[1] += place.of_distance[0] * apart;
            integral += place.of_distance[2] * apart;
            force_integral += place.weight * force;
        });
        distance[0] += clearance;
        for (k, slots) in [&mut slots.x, &mut slots.v].into_iter().enumerate() {
            (slots[i], slots[j]) = (centre[k] + shares[1] * distance[k], centre[k] - shares[0] * distance[k]);
        }
        slots.impulse[i] += law.stiffness * integral + force_integral;
    }

    /// The derivatives by the state at the start, and by the coefficients, from those by the state at the end.
    pub fn backward(&self, cradle: &Cradle, gradient: &mut Coefficients, slots: &mut Slots) {
        let (i, j) = (self.first, self.first + 1);
        let (models, law) = (&cradle.balls[i..=j], &cradle.contacts[i]);
        let shares = shares(models);
        let of_centre = |values: &[f64]| values[0] + values[1];
        let of_distance = |values: &[f64]| shares[1] * values[0] - shares[0] * values[1];
        let (x, v) = (of_centre(&slots.x[i..=j]), of_centre(&slots.v[i..=j]));
        let (r, rate) = (of_distance(&slots.x[i..=j]), of_distance(&slots.v[i..=j]));
        let impulse = slots.impulse[i];
        let of_integral = law.stiffness * impulse;
        let (balls, mut contact) = (&mut gradient.balls, [0.0; 7]);
        let (mut totals, mut total_apart) = ([0.0; 2], 0.0);
        self.each_place(models, law, |place| {
            let common = place.weight * (place.of_centre[1] * x + place.of_centre[0] * v);
            let [u0, u1, u2] = place.of_distance;
            let apart = place.weight * (u1 * r + u0 * rate + u2 * of_integral);
            for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
                let source = shares[side] * common + sign * apart;
                let (by, mass) = (&mut balls[i + side], models[side].mass);
                totals[side] += source;
                by.mass -= source * place.force[side] / (mass * mass);
                by.omega2 -= source * place.x[side];
                by.gamma -= 2.0 * source * place.v[side];
            }
            gradient.support -= common;
            total_apart += apart;
            let force = place.weight * impulse - apart * inverse_mass(models);
            contact.iter_mut().zip(place.contact).for_each(|(sum, of)| *sum += force * of);
        });
        for side in 0..2 {
            balls[i + side].force += totals[side] / models[side].mass;
        }
        gradient.contacts[i].add_array(&contact);
        let centre = swung_back(&self.own, &self.of_centre, x, v);
        let mut distance = swung_back(&self.contact, &self.of_distance, r, rate);
        distance[0] += self.integral_of_distance() * of_integral;
        distance[1] += self.of_distance[2] * of_integral;
        gradient.contacts[i].clearance += r - distance[0] - self.own.omega2() * total_apart;
        for (k, slots) in [&mut slots.x, &mut slots.v].into_iter().enumerate() {
            (slots[i], slots[j]) = (shares[0] * centre[k] + distance[k], shares[1] * centre[k] - distance[k]);
        }
    }

    /// Integral of the distance that has begun with 1 at rest, `t - omega^2 U_3`, without cancellation.
    fn integral_of_distance(&self) -> f64 {
        self.of_distance[1] + 2.0 * self.contact.gamma() * self.of_distance[2]
    }

    fn each_place(&self, models: &[BallModel], law: &ContactLaw, mut each: impl FnMut(Place)) {
        let shares = shares(models);
        for (c, weight) in first_half() {
            // The time is symmetric: what is left till the end is the time of the other node of the pair.
            let early = self.length * (c * c * (3.0 - 2.0 * c));
            let times = [early, self.length - early];
            let weight = 6.0 * weight * self.length * (c * (1.0 - c));
            let own: [[f64; 3]; 2] = times.map(|s| self.own.basis(s.into()));
            let contact: [[f64; 3]; 2] = times.map(|s| self.contact.basis(s.into()));
            for (side, s) in times.into_iter().enumerate() {
                let (centre_moved, centre_v) = moved(&self.centre, &self.own, &own[side], s);
                let (closer, rate) = moved(&self.overlap, &self.contact, &contact[side], s);
                let overlap = self.overlap.x + closer;
                let (x, r) = (self.centre.x + centre_moved, overlap + law.clearance);
                let force = law.stiffness * overlap;
                let pushes = [0, 1].map(|side: usize| forcing_at(&self.pushes[side], s));
                each(Place {
                    weight,
                    of_centre: own[1 - side],
                    of_distance: contact[1 - side],
                    x: [x + shares[1] * r, x - shares[0] * r],
                    v: [centre_v + shares[1] * rate, centre_v - shares[0] * rate],
                    force: [pushes[0] - force, pushes[1] + force],
                    contact: law_derivatives(law, overlap, rate, force, law.stiffness),
                });
            }
        }
    }
}

/// Derivatives of the force of a contact by the coefficients with the overlap held, in the order of
/// [`OfContact::array`](super::coefficients::OfContact::array), at this overlap and rate, where the force and its derivative by the
/// overlap are the given ones.
pub(super) fn law_derivatives(law: &ContactLaw, overlap: f64, rate: f64, force: f64, slope: f64) -> [f64; 7] {
    if overlap <= 0.0 {
        return [0.0; 7];
    }
    let by_exponent = force * libm::log(overlap / law.overlap_ref);
    let by_reference = (1.0 - law.exponent) * force / law.overlap_ref;
    [force / law.stiffness, by_reference, by_exponent, 0.0, rate, force * rate, slope * rate]
}
