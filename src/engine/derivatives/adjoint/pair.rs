//! How the motion of two equal pendulums that press on each other by a linear contact changes with its start and with
//! the coefficients.
//!
//! Their centre swings like one of them, their distance like an oscillator of its own: both motions and their responses
//! are closed forms. What the coefficients change is the integral of the response to it, by Gauss's rule in a time
//! `3 c^2 - 2 c^3`, which takes the logarithm of the overlap.

use super::flown::{first_half, moved, swing};
use super::map::{CLEARANCE, COEFFICIENTS, IMPULSE, Map, OF_BALL, OF_CONTACT, STATE, V, X};
use crate::engine::flight::{Flight, Forcing, forcing_at};
use crate::model::{BallModel, ContactLaw};
use crate::solver::oscillator::Oscillator;

/// What changes by the end: position and velocity of the centre, the distance and its rate, and the impulse.
type Ends = [f64; 5];

/// Two equal pendulums in a linear contact.
pub(super) struct Pair {
    models: [BallModel; 2],
    law: ContactLaw,
    /// Shares of the two balls in their mass, and the inverse of their reduced mass, 1/kg.
    shares: [f64; 2],
    inverse_mass: f64,
    /// The oscillators of the centre and of the overlap.
    pub oscillators: [Oscillator; 2],
}

impl Pair {
    /// These balls, if their motion is the sum of two oscillations.
    pub fn of(models: &[BallModel], law: &ContactLaw) -> Option<Self> {
        let &[left, right] = models else { return None };
        let equal = left.omega2 == right.omega2 && left.gamma == right.gamma;
        (equal && law.exponent == 1.0 && law.is_elastic()).then(|| {
            let (total, inverse_mass) = (left.mass + right.mass, 1.0 / left.mass + 1.0 / right.mass);
            let stiff = Oscillator::new(left.omega2 + law.stiffness * inverse_mass, left.gamma);
            let oscillators = [Oscillator::new(left.omega2, left.gamma), stiff];
            Self {
                models: [left, right],
                law: *law,
                shares: [left.mass / total, right.mass / total],
                inverse_mass,
                oscillators,
            }
        })
    }

    /// Their motion from these flights on, under these external forces (N), from the overlap (m) for the time `length`
    /// (s); then their displacements and velocities.
    pub fn press(
        &self,
        (first, tuning): (usize, usize),
        [left, right]: &[Flight; 2],
        pushes: &[Forcing; 2],
        overlap: f64,
        length: f64,
    ) -> (Map, [(f64, f64); 2]) {
        let (shares, [own, contact]) = (self.shares, &self.oscillators);
        let mean = |left: f64, right: f64| shares[0] * left + shares[1] * right;
        let centre = Flight {
            x: mean(left.x, right.x),
            v: mean(left.v, right.v),
            forcing: std::array::from_fn(|k| mean(left.forcing[k], right.forcing[k])),
        };
        let mut forcing: Forcing = std::array::from_fn(|k| left.forcing[k] - right.forcing[k]);
        forcing[0] -= own.omega2() * self.law.clearance;
        let overlap = Flight { x: overlap, v: left.v - right.v, forcing };
        let (of_centre, of_distance) = (own.basis(length.into()), contact.basis(length.into()));
        let (centre_moved, centre_v) = moved(&centre, own, &of_centre, length);
        let (closer, rate) = moved(&overlap, contact, &of_distance, length);
        let ends = [
            (centre_moved + shares[1] * closer, centre_v + shares[1] * rate),
            (centre_moved - shares[0] * closer, centre_v - shares[0] * rate),
        ];
        let by_start = self.by_start(&of_centre, &of_distance);
        let (mut by_coefficients, by_support) = self.by_coefficients(&[centre, overlap], pushes, length);
        // It is at the clearance that the overlap begins.
        let by_clearance = &mut by_coefficients[OF_BALL + CLEARANCE];
        by_clearance.iter_mut().zip(self.by_distance(&of_distance)).for_each(|(by, of)| *by -= of[0]);
        let mut map = Map::zero(first, 2, tuning);
        let mut enter = |number: usize, of: &dyn Fn(&Ends) -> f64| {
            let row = map.row(number);
            row.state.iter_mut().zip(&by_start).for_each(|(to, ends)| *to = of(ends));
            row.coefficients.iter_mut().zip(&by_coefficients).for_each(|(to, ends)| *to = of(ends));
            *row.support = of(&by_support);
        };
        for k in [X, V] {
            enter(k, &|ends| ends[k] + shares[1] * ends[2 + k]);
            enter(STATE + k, &|ends| ends[k] - shares[0] * ends[2 + k]);
        }
        enter(IMPULSE, &|ends| ends[4]);
        (map, ends)
    }

    /// What the ends change by with the distance and its rate at the start.
    fn by_distance(&self, basis: &[f64; 3]) -> [[f64; 2]; 5] {
        let (contact, [_, u1, u2]) = (&self.oscillators[1], *basis);
        let [distance, rate] = swing(contact, basis);
        // The integral of a distance that has begun with 1 at rest is t - omega^2 U_3: so nothing cancels.
        let impulse = [u1 + 2.0 * contact.gamma() * u2, u2].map(|integral| self.law.stiffness * integral);
        [[0.0; 2], [0.0; 2], distance, rate, impulse]
    }

    /// What the ends change by with the states of the two balls at the start.
    fn by_start(&self, of_centre: &[f64; 3], of_distance: &[f64; 3]) -> [Ends; 2 * STATE - 1] {
        let (centre, distance) = (swing(&self.oscillators[0], of_centre), self.by_distance(of_distance));
        let mut by = [Ends::default(); 2 * STATE - 1];
        for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
            for k in [X, V] {
                let ends = &mut by[STATE * side + k];
                *ends = distance.map(|of| sign * of[k]);
                (ends[0], ends[1]) = (self.shares[side] * centre[0][k], self.shares[side] * centre[1][k]);
            }
        }
        by
    }

    /// What the ends change by with the coefficients and with the acceleration of the support, the overlap at the start
    /// held, along these motions of the centre and of the overlap.
    fn by_coefficients(
        &self,
        [centre, overlap]: &[Flight; 2],
        pushes: &[Forcing; 2],
        length: f64,
    ) -> ([Ends; COEFFICIENTS + OF_BALL], Ends) {
        let ([own, contact], law) = (&self.oscillators, &self.law);
        let mut by = [Ends::default(); COEFFICIENTS + OF_BALL];
        let mut by_support = Ends::default();
        let add = |sums: &mut Ends, source: f64, of: &Ends| {
            sums.iter_mut().zip(of).for_each(|(sum, of)| *sum += source * of);
        };
        for (c, weight) in first_half() {
            // The time is symmetric: what is left till the end is the time of the other node of the pair.
            let early = length * (c * c * (3.0 - 2.0 * c));
            let times = [early, length - early];
            let weight = 6.0 * weight * length * (c * (1.0 - c));
            let of_centre: [[f64; 3]; 2] = times.map(|s| own.basis(s.into()));
            let of_distance: [[f64; 3]; 2] = times.map(|s| contact.basis(s.into()));
            for (place, s) in times.into_iter().enumerate() {
                let (centre_moved, centre_v) = moved(centre, own, &of_centre[place], s);
                let (closer, rate) = moved(overlap, contact, &of_distance[place], s);
                let overlap = overlap.x + closer;
                let (centre, distance) = (centre.x + centre_moved, overlap + law.clearance);
                let force = law.stiffness * overlap;
                // Responses at the end to an acceleration here.
                let [x, v] = [1, 0].map(|k| weight * of_centre[1 - place][k]);
                let [r, faster] = [1, 0].map(|k| weight * of_distance[1 - place][k]);
                let impulse = weight * law.stiffness * of_distance[1 - place][2];
                for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
                    let (mass, share, other) = (self.models[side].mass, self.shares[side], self.shares[1 - side]);
                    let total = forcing_at(&pushes[side], s) - sign * force;
                    let of_x = -(centre + sign * other * distance);
                    let of_v = -2.0 * (centre_v + sign * other * rate);
                    let ends = [share * x, share * v, sign * r, sign * faster, sign * impulse];
                    for (k, source) in [-total / (mass * mass), of_x, of_v, 1.0 / mass].into_iter().enumerate() {
                        add(&mut by[COEFFICIENTS * side + k], source, &ends);
                    }
                }
                let [of_r, of_rate, of_impulse] = [r, faster, impulse].map(|of| -self.inverse_mass * of);
                let ends = [0.0, 0.0, of_r, of_rate, of_impulse + weight];
                let sources = law_derivatives(law, overlap, rate, force, law.stiffness);
                by[OF_BALL..].iter_mut().zip(sources).for_each(|(sums, source)| add(sums, source, &ends));
                add(&mut by[OF_BALL + CLEARANCE], -own.omega2(), &[0.0, 0.0, r, faster, impulse]);
                add(&mut by_support, -1.0, &[x, v, 0.0, 0.0, 0.0]);
            }
        }
        (by, by_support)
    }
}

/// Derivatives of the force of a contact by the coefficients with the overlap held, at this overlap and rate, where the
/// force and its derivative by the overlap are the given ones.
pub(super) fn law_derivatives(law: &ContactLaw, overlap: f64, rate: f64, force: f64, slope: f64) -> [f64; OF_CONTACT] {
    if overlap <= 0.0 {
        return [0.0; OF_CONTACT];
    }
    let by_exponent = force * libm::log(overlap / law.overlap_ref);
    let by_reference = (1.0 - law.exponent) * force / law.overlap_ref;
    [force / law.stiffness, by_reference, by_exponent, 0.0, rate, force * rate, slope * rate]
}
