//! The flight of one ball, with its derivatives by the start and the coefficients.
//!
//! The motion and its responses have closed forms. The effect of a coefficient is an integral of the response to it, by
//! Gauss's rule.

use super::map::{Map, OF_BALL, V, X};
use crate::engine::flight::{Flight, Forcing, degree, forcing_at};
use crate::model::BallModel;
use crate::solver::gauss::{NODES, Stretching};
use crate::solver::oscillator::Oscillator;

/// Longest part, times `omega + 2 gamma`, for which the rule is exact to rounding.
const REACH: f64 = 4.0;

/// Number of parts of a flight for the time `length` (s).
pub(super) fn parts(o: &Oscillator, length: f64) -> f64 {
    (o.pace() * length / REACH).ceil().max(1.0)
}

/// The linearised motion of a ball on this flight, under the external force `push` (N), for the time `length` (s), and
/// its displacement and velocity at the end.
pub(super) fn follow(
    (ball, tuning): (usize, usize),
    (model, o): (&BallModel, &Oscillator),
    (flight, push): (&Flight, &Forcing),
    length: f64,
) -> (Map, (f64, f64)) {
    let basis: [f64; 3] = o.basis(length.into());
    let [_, u1, u2] = basis;
    let mut map = Map::zero(ball, 1, tuning);
    // Position and velocity by those at the start, minus the identity.
    let turn = -o.omega2() * u2;
    for (number, by_start) in [(X, [turn, u1]), (V, [-o.omega2() * u1, turn - 2.0 * o.gamma() * u1])] {
        map.row(number)[0].copy_from_slice(&by_start);
    }
    let table = Stretching::None.table();
    for m in 0..NODES {
        // Nodes and weights are symmetric: the time left to the end is that of the mirrored node.
        let [s, left] = [m, NODES - 1 - m].map(|m| length * table.times[m]);
        let (moved, v) = moved(flight, o, &o.basis(s.into()), s);
        let [u0, u1, _]: [f64; 3] = o.basis(left.into());
        let by_mass = -forcing_at(push, s) / (model.mass * model.mass);
        let effects: [f64; OF_BALL] = [by_mass, -(flight.x + moved), -2.0 * v, 1.0 / model.mass];
        for (number, response) in [(X, u1), (V, u0)] {
            let weight = length * table.of_rate[m] * response;
            let [_, by] = map.row(number);
            by.iter_mut().zip(effects).for_each(|(by, effect)| *by += weight * effect);
            by[OF_BALL] -= weight;
        }
    }
    (map, moved(flight, o, &basis, length))
}

/// Displacement and velocity on a flight at the time `t` (s), from the oscillator's functions there.
fn moved(flight: &Flight, o: &Oscillator, basis: &[f64; 3], t: f64) -> (f64, f64) {
    if degree(&flight.forcing) == 0 {
        (flight.displacement(o, basis), flight.velocity(o, basis))
    } else {
        flight.at(o, t.into())
    }
}
