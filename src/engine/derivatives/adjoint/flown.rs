//! How the motion of a ball that touches nothing changes with its start and with the coefficients.
//!
//! The change obeys the same equation, with what the changes of the coefficients do on the way as a force: it is that of the start,
//! and the integral of the response to that force, by Gauss's rule.

use super::coefficients::Coefficients;
use super::slots::Slots;
use crate::engine::flight::{Flight, Forcing, degree, forcing_at};
use crate::model::BallModel;
use crate::solver::gauss::{NODES, Stretching};
use crate::solver::oscillator::Oscillator;

/// Longest flight that is taken at once, times `omega + 2 gamma`: within that the rule is exact to rounding.
pub(super) const REACH: f64 = 4.0;

/// Up to this, two nodes are enough where inputs are constant: what they leave out grows with the fourth power.
const SHORT: f64 = 1e-3;

/// Earlier place of the two-point rule on [0, 1], whose weights are 1/2.
const EARLY: f64 = 0.211_324_865_405_187_13;

/// A flight of one ball.
#[derive(Clone, Debug)]
pub(super) struct Flown {
    pub ball: usize,
    pub tuning: usize,
    /// At its start.
    pub flight: Flight,
    /// External force from its start on, N, with its derivatives.
    pub push: Forcing,
    /// Its length, s.
    pub length: f64,
    /// The functions of the oscillator at its end.
    pub basis: [f64; 3],
}

/// A place on the way: the weight of the force there in the position and the velocity at the end, and the motion.
struct Place {
    of_x: f64,
    of_v: f64,
    x: f64,
    v: f64,
    push: f64,
}

impl Flown {
    /// Changes of the state at the end from those at the start.
    pub fn forward(&self, model: &BallModel, o: &Oscillator, change: &Coefficients, slots: &mut Slots) {
        let i = self.ball;
        let [mut at_x, mut at_v] = swung(o, &self.basis, slots.x[i], slots.v[i]);
        let by = &change.balls[i];
        self.each_place(o, |place| {
            let source = by.force / model.mass
                - place.push * by.mass / (model.mass * model.mass)
                - change.support
                - by.omega2 * place.x
                - 2.0 * by.gamma * place.v;
            at_x += place.of_x * source;
            at_v += place.of_v * source;
        });
        (slots.x[i], slots.v[i]) = (at_x, at_v);
    }

    /// The derivatives by the state at the start, and by the coefficients, from those by the state at the end.
    pub fn backward(&self, model: &BallModel, o: &Oscillator, gradient: &mut Coefficients, slots: &mut Slots) {
        let i = self.ball;
        let (x, v) = (slots.x[i], slots.v[i]);
        let by = &mut gradient.balls[i];
        let mut total = 0.0;
        self.each_place(o, |place| {
            let source = place.of_x * x + place.of_v * v;
            total += source;
            by.mass -= source * place.push / (model.mass * model.mass);
            by.omega2 -= source * place.x;
            by.gamma -= 2.0 * source * place.v;
        });
        by.force += total / model.mass;
        gradient.support -= total;
        [slots.x[i], slots.v[i]] = swung_back(o, &self.basis, x, v);
    }

    fn each_place(&self, o: &Oscillator, each: impl FnMut(Place)) {
        let constant = degree(&self.flight.forcing) == 0 && degree(&self.push) == 0;
        if constant && (o.omega() + 2.0 * o.gamma()) * self.length <= SHORT {
            self.each_of([(EARLY, 0.5)], o, each);
        } else {
            self.each_of(first_half(), o, each);
        }
    }

    fn each_of(&self, rule: impl IntoIterator<Item = (f64, f64)>, o: &Oscillator, mut each: impl FnMut(Place)) {
        // The rule is symmetric: what is left till the end is the time of the other node of the pair.
        for (place, weight) in rule {
            let early = self.length * place;
            let times = [early, self.length - early];
            let weight = self.length * weight;
            let bases: [[f64; 3]; 2] = times.map(|s| o.basis(s.into()));
            for (side, s) in times.into_iter().enumerate() {
                let (here, rest) = (&bases[side], &bases[1 - side]);
                let (displacement, v) = moved(&self.flight, o, here, s);
                each(Place {
                    of_x: weight * rest[1],
                    of_v: weight * rest[0],
                    x: self.flight.x + displacement,
                    v,
                    push: forcing_at(&self.push, s),
                });
            }
        }
    }
}

/// Gauss's rule with 16 nodes on [0, 1], which is symmetric: its nodes below 1/2, with their weights.
pub(super) fn first_half() -> impl Iterator<Item = (f64, f64)> {
    let table = Stretching::None.table();
    table.times.iter().copied().zip(table.of_rate).take(NODES / 2)
}

/// Displacement and velocity on a flight at the time `t` (s), where the functions of the oscillator have these values.
pub(super) fn moved(flight: &Flight, o: &Oscillator, basis: &[f64; 3], t: f64) -> (f64, f64) {
    if degree(&flight.forcing) == 0 {
        (flight.displacement(o, basis), flight.velocity(o, basis))
    } else {
        flight.at(o, t.into())
    }
}

/// The state after a swing, and the derivatives by the state before it from those by the state after it.
pub(super) fn swung(o: &Oscillator, [u0, u1, u2]: &[f64; 3], x: f64, v: f64) -> [f64; 2] {
    [x - o.omega2() * u2 * x + u1 * v, u0 * v - o.omega2() * u1 * x]
}

pub(super) fn swung_back(o: &Oscillator, [u0, u1, u2]: &[f64; 3], x: f64, v: f64) -> [f64; 2] {
    [x - o.omega2() * (u2 * x + u1 * v), u1 * x + u0 * v]
}
