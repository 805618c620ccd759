//! How the motion of two equal pendulums that press on each other by a linear contact changes with its start and with
//! the coefficients.
//!
//! Their centre swings like one of them, their distance like an oscillator of its own: both motions and their responses
//! are closed forms. What the coefficients change is the integral of the response to it, by Gauss's rule in a time
//! `3 c^2 - 2 c^3`, which takes the logarithm of the overlap.

use super::coefficients::{CLEARANCE, Coefficients, OfContact};
use super::flown::{Swing, first_half, moved};
use super::slots::Slots;
use crate::engine::flight::{Flight, Forcing, forcing_at};
use crate::model::{BallModel, ContactLaw, Cradle};
use crate::solver::double_double::DoubleDouble;
use crate::solver::oscillator::Oscillator;

/// Changes at the end: of position and velocity of the centre, of the distance and its rate, and of the impulse.
type Ends<T = f64> = [T; 5];

/// Those of the centre, and the others.
type OfCentre = [f64; 2];
type OfDistance = [f64; 3];

/// Derivatives of the changes at the end by the coefficients.
#[derive(Clone, Debug, Default)]
struct ByCoefficients {
    /// By those of the left ball, then of the right one.
    balls: [Ends; 8],
    contact: [OfDistance; 7],
    /// By the acceleration of the support.
    support: [OfCentre; 1],
}

/// Two balls in contact, on the way together.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    /// The left one.
    first: usize,
    pub tuning: usize,
    shares: [f64; 2],
    of_centre: Swing,
    of_distance: Swing,
    /// What the impulse changes by with the distance and its rate at the start.
    impulse: [f64; 2],
    by: ByCoefficients,
}

/// Their motion.
struct Motion<'a> {
    models: &'a [BallModel],
    law: &'a ContactLaw,
    own: Oscillator,
    contact: Oscillator,
    /// Of the centre of mass, and of the overlap.
    centre: Flight,
    overlap: Flight,
    /// External forces, N.
    pushes: [Forcing; 2],
    length: f64,
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
    contact: OfContact,
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

    /// The motion of two balls from these flights on, under these external forces (N), from the overlap (m) for the
    /// time `length` (s); then their displacements, velocities, and the change of the overlap.
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
        let (at_end, of_distance) = (own.basis(length.into()), contact.basis(length.into()));
        let (centre_moved, centre_v) = moved(&centre, &own, &at_end, length);
        let (closer, rate) = moved(&overlap, &contact, &of_distance, length);
        let ends = [
            (centre_moved + shares[1] * closer, centre_v + shares[1] * rate),
            (centre_moved - shares[0] * closer, centre_v - shares[0] * rate),
        ];
        let law = &cradle.contacts[first];
        let by = Motion { models, law, own, contact, centre, overlap, pushes, length }.by_coefficients(&of_distance);
        // The integral of a distance that has begun with 1 at rest is t - omega^2 U_3: so nothing cancels.
        let integrals = [of_distance[1] + 2.0 * contact.gamma() * of_distance[2], of_distance[2]];
        let pair = Self {
            first,
            tuning,
            shares,
            of_centre: Swing::new(&own, &at_end),
            of_distance: Swing::new(&contact, &of_distance),
            impulse: integrals.map(|integral| law.stiffness * integral),
            by,
        };
        (pair, ends, closer)
    }

    /// Changes of the state at the end from those at the start.
    pub fn forward(&self, change: &Coefficients, slots: &mut Slots) {
        let (i, j, [left, right]) = (self.first, self.first + 1, self.shares);
        let mean = |values: &[DoubleDouble]| values[i] * left + values[j] * right;
        let (r, rate) = (slots.x[i] - slots.x[j], slots.v[i] - slots.v[j]);
        let centre = self.of_centre.forward((mean(&slots.x), mean(&slots.v)));
        let distance = self.of_distance.forward((r, rate));
        let impulse = r * self.impulse[0] + rate * self.impulse[1];
        let mut ends: Ends<DoubleDouble> = [centre.0, centre.1, distance.0, distance.1, impulse];
        let (of_centre, of_distance) = ends.split_at_mut(2);
        add(&self.by.support, [&change.support], of_centre);
        add(&self.by.contact, &change.contacts[i], of_distance);
        add(&self.by.balls, change.balls[i..=j].iter().flatten(), &mut ends);
        let [x, v, r, rate, impulse] = ends;
        (slots.x[i], slots.x[j]) = (x + r * right, x - r * left);
        (slots.v[i], slots.v[j]) = (v + rate * right, v - rate * left);
        slots.impulse[i] += impulse;
    }

    /// The derivatives by the state at the start, and by the coefficients, from those by the state at the end.
    pub fn backward(&self, gradient: &mut Coefficients<DoubleDouble>, slots: &mut Slots) {
        let (i, j, [left, right]) = (self.first, self.first + 1, self.shares);
        let of_centre = |values: &[DoubleDouble]| values[i] + values[j];
        let of_distance = |values: &[DoubleDouble]| values[i] * right - values[j] * left;
        let (centre, impulse) = ((of_centre(&slots.x), of_centre(&slots.v)), slots.impulse[i]);
        let distance = (of_distance(&slots.x), of_distance(&slots.v));
        let ends: Ends<DoubleDouble> = [centre.0, centre.1, distance.0, distance.1, impulse];
        let (of_centre, of_distance) = ends.split_at(2);
        weigh(&self.by.support, [&mut gradient.support], of_centre);
        weigh(&self.by.contact, &mut gradient.contacts[i], of_distance);
        weigh(&self.by.balls, gradient.balls[i..=j].iter_mut().flatten(), &ends);
        let (x, v) = self.of_centre.backward(centre);
        let (r, rate) = self.of_distance.backward(distance);
        let (r, rate) = (r + impulse * self.impulse[0], rate + impulse * self.impulse[1]);
        (slots.x[i], slots.x[j]) = (x * left + r, x * right - r);
        (slots.v[i], slots.v[j]) = (v * left + rate, v * right - rate);
    }
}

/// Adds what these changes of coefficients make of the changes at the end.
fn add<'a, const N: usize>(by: &[[f64; N]], changes: impl IntoIterator<Item = &'a f64>, ends: &mut [DoubleDouble]) {
    for (by, change) in by.iter().zip(changes) {
        ends.iter_mut().zip(by).for_each(|(end, by)| *end += DoubleDouble::product(*by, *change));
    }
}

/// Adds the derivatives by coefficients, from those by the changes at the end.
fn weigh<'a, const N: usize>(
    by: &[[f64; N]],
    sums: impl IntoIterator<Item = &'a mut DoubleDouble>,
    ends: &[DoubleDouble],
) {
    for (by, sum) in by.iter().zip(sums) {
        ends.iter().zip(by).for_each(|(end, by)| *sum += *end * *by);
    }
}

/// Adds a multiple.
fn add_multiple<const N: usize>(sums: &mut [f64; N], factor: f64, of: &[f64; N]) {
    sums.iter_mut().zip(of).for_each(|(sum, of)| *sum += factor * of);
}

impl Motion<'_> {
    /// Derivatives of the changes at the end by the coefficients; the functions of the oscillator of the distance have
    /// these values then.
    fn by_coefficients(&self, at_end: &[f64; 3]) -> ByCoefficients {
        let (shares, inverse_mass) = (shares(self.models), inverse_mass(self.models));
        let mut by = ByCoefficients::default();
        let mut clearance = [0.0; 3];
        self.each_place(|place| {
            let centre = [place.of_centre[1], place.of_centre[0]].map(|of| place.weight * of);
            let [u0, u1, u2] = place.of_distance;
            let distance = [u1, u0, self.law.stiffness * u2].map(|of| place.weight * of);
            for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
                let mass = self.models[side].mass;
                let sources = [-place.force[side] / (mass * mass), -place.x[side], -2.0 * place.v[side], 1.0 / mass];
                let [x, v] = centre.map(|of| shares[side] * of);
                let [r, rate, impulse] = distance.map(|of| sign * of);
                let of: Ends = [x, v, r, rate, impulse];
                let sums = &mut by.balls[4 * side..];
                sums.iter_mut().zip(sources).for_each(|(sums, source)| add_multiple(sums, source, &of));
            }
            let mut of_force = distance.map(|of| -inverse_mass * of);
            of_force[2] += place.weight;
            by.contact.iter_mut().zip(place.contact).for_each(|(sums, of)| add_multiple(sums, of, &of_force));
            add_multiple(&mut by.support[0], -1.0, &centre);
            add_multiple(&mut clearance, -self.own.omega2(), &distance);
        });
        // It is at the clearance that the overlap begins.
        let [_, u1, u2] = *at_end;
        let (omega2, stiffness) = (self.contact.omega2(), self.law.stiffness);
        let begun = [omega2 * u2, omega2 * u1, -stiffness * (u1 + 2.0 * self.contact.gamma() * u2)];
        by.contact[CLEARANCE] = std::array::from_fn(|end| begun[end] + clearance[end]);
        by
    }

    fn each_place(&self, mut each: impl FnMut(Place)) {
        let shares = shares(self.models);
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
                let (x, r) = (self.centre.x + centre_moved, overlap + self.law.clearance);
                let force = self.law.stiffness * overlap;
                let pushes = [0, 1].map(|side: usize| forcing_at(&self.pushes[side], s));
                each(Place {
                    weight,
                    of_centre: own[1 - side],
                    of_distance: contact[1 - side],
                    x: [x + shares[1] * r, x - shares[0] * r],
                    v: [centre_v + shares[1] * rate, centre_v - shares[0] * rate],
                    force: [pushes[0] - force, pushes[1] + force],
                    contact: law_derivatives(self.law, overlap, rate, force, self.law.stiffness),
                });
            }
        }
    }
}

/// Derivatives of the force of a contact by the coefficients with the overlap held, at this overlap and rate, where the
/// force and its derivative by the overlap are the given ones.
pub(super) fn law_derivatives(law: &ContactLaw, overlap: f64, rate: f64, force: f64, slope: f64) -> OfContact {
    if overlap <= 0.0 {
        return OfContact::default();
    }
    let by_exponent = force * libm::log(overlap / law.overlap_ref);
    let by_reference = (1.0 - law.exponent) * force / law.overlap_ref;
    [force / law.stiffness, by_reference, by_exponent, 0.0, rate, force * rate, slope * rate]
}
