//! How the motion of a ball that touches nothing changes with its start and with the coefficients.
//!
//! The change obeys the same equation, with what the changes of the coefficients do on the way as a force: it is that
//! of the start, and the integral of the response to that force, by Gauss's rule.

use super::coefficients::Coefficients;
use super::slots::Slots;
use crate::engine::flight::{Flight, Forcing, degree, forcing_at};
use crate::model::BallModel;
use crate::solver::double_double::DoubleDouble;
use crate::solver::gauss::{NODES, Stretching};
use crate::solver::oscillator::Oscillator;

/// Longest flight that is taken at once, times `omega + 2 gamma`: within that the rule is exact to rounding.
pub(super) const REACH: f64 = 4.0;

/// Up to this, two nodes are enough where inputs are constant: what they leave out grows with the fourth power.
const SHORT: f64 = 1e-3;

/// Earlier place of the two-point rule on [0, 1], whose weights are 1/2.
const EARLY: f64 = 0.211_324_865_405_187_13;

/// Position and velocity, or their derivatives.
type State = (DoubleDouble, DoubleDouble);

/// What an oscillator makes of changes of its state in some time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Swing {
    u0: f64,
    u1: f64,
    /// `omega2 U_1` and `omega2 U_2`.
    pull: f64,
    turn: f64,
}

impl Swing {
    /// From the functions of the oscillator at the end.
    pub fn new(o: &Oscillator, [u0, u1, u2]: &[f64; 3]) -> Self {
        Self { u0: *u0, u1: *u1, pull: o.omega2() * u1, turn: o.omega2() * u2 }
    }

    /// The state after it.
    pub fn forward(&self, (x, v): State) -> State {
        (x - x * self.turn + v * self.u1, v * self.u0 - x * self.pull)
    }

    /// The derivatives by the state before it, from those by the state after it.
    pub fn backward(&self, (x, v): State) -> State {
        (x - x * self.turn - v * self.pull, x * self.u1 + v * self.u0)
    }
}

/// A flight of one ball.
#[derive(Clone, Debug)]
pub(super) struct Flown {
    pub ball: usize,
    pub tuning: usize,
    swing: Swing,
    /// Derivatives of the position and the velocity at the end by the coefficients of the ball, and by the acceleration
    /// of the support.
    by: [[f64; 2]; 5],
}

impl Flown {
    /// This flight with this external force (N) for the time `length` (s), and its end: displacement and velocity.
    pub fn new(
        (ball, tuning): (usize, usize),
        model: &BallModel,
        o: &Oscillator,
        (flight, push): (&Flight, &Forcing),
        length: f64,
    ) -> (Self, (f64, f64)) {
        let basis = o.basis(length.into());
        let end = moved(flight, o, &basis, length);
        let constant = degree(&flight.forcing) == 0 && degree(push) == 0;
        let short = constant && (o.omega() + 2.0 * o.gamma()) * length <= SHORT;
        let (two, sixteen) = (short.then_some((EARLY, 0.5)), first_half().filter(|_| !short));
        let mut by = [[0.0; 2]; 5];
        let mut total = [0.0; 2];
        // The rule is symmetric: what is left till the end is the time of the other node of the pair.
        for (place, weight) in two.into_iter().chain(sixteen) {
            let early = length * place;
            let times = [early, length - early];
            let bases: [[f64; 3]; 2] = times.map(|s| o.basis(s.into()));
            for (side, s) in times.into_iter().enumerate() {
                let (displacement, v) = moved(flight, o, &bases[side], s);
                let sources = [forcing_at(push, s) / (model.mass * model.mass), flight.x + displacement, 2.0 * v];
                for k in 0..2 {
                    let response = length * weight * bases[1 - side][1 - k];
                    total[k] += response;
                    by.iter_mut().zip(sources).for_each(|(by, source)| by[k] -= response * source);
                }
            }
        }
        by[3] = total.map(|total| total / model.mass);
        by[4] = total.map(|total| -total);
        let swing = Swing::new(o, &basis);
        (Self { ball, tuning, swing, by }, end)
    }

    /// Changes of the state at the end from those at the start.
    pub fn forward(&self, change: &Coefficients, slots: &mut Slots) {
        let i = self.ball;
        let (mut x, mut v) = self.swing.forward((slots.x[i], slots.v[i]));
        for ([of_x, of_v], change) in self.by.iter().zip(change.balls[i].iter().chain([&change.support])) {
            x += DoubleDouble::product(*of_x, *change);
            v += DoubleDouble::product(*of_v, *change);
        }
        (slots.x[i], slots.v[i]) = (x, v);
    }

    /// The derivatives by the state at the start, and by the coefficients, from those by the state at the end.
    pub fn backward(&self, gradient: &mut Coefficients<DoubleDouble>, slots: &mut Slots) {
        let i = self.ball;
        let (x, v) = (slots.x[i], slots.v[i]);
        let sums = gradient.balls[i].iter_mut().chain([&mut gradient.support]);
        for ([of_x, of_v], sum) in self.by.iter().zip(sums) {
            *sum += x * *of_x + v * *of_v;
        }
        (slots.x[i], slots.v[i]) = self.swing.backward((x, v));
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
