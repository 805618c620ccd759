//! How the motion of a ball that touches nothing changes with its start and with the coefficients.
//!
//! The change obeys the same equation, with what the changes of the coefficients do on the way as a force: it is that
//! of the start, and the integral of the response to that force, by Gauss's rule.

use super::map::{Map, OF_BALL};
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

/// What position and velocity of an oscillator grow by with those at the start, in the time at which its functions have
/// these values.
pub(super) fn swing(o: &Oscillator, [_, u1, u2]: &[f64; 3]) -> [[f64; 2]; 2] {
    let turn = o.omega2() * u2;
    [[-turn, *u1], [-o.omega2() * u1, -turn - 2.0 * o.gamma() * u1]]
}

/// This flight with this external force (N) for the time `length` (s), and its end: displacement and velocity.
pub(super) fn flown(
    (ball, tuning): (usize, usize),
    model: &BallModel,
    o: &Oscillator,
    (flight, push): (&Flight, &Forcing),
    length: f64,
) -> (Map, (f64, f64)) {
    let basis = o.basis(length.into());
    let constant = degree(&flight.forcing) == 0 && degree(push) == 0;
    let short = constant && o.pace() * length <= SHORT;
    let (two, sixteen) = (short.then_some((EARLY, 0.5)), first_half().filter(|_| !short));
    let (mut by, mut total) = ([[0.0; 2]; OF_BALL], [0.0; 2]);
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
    let mut map = Map::zero(ball, 1, tuning);
    for (k, by_start) in swing(o, &basis).iter().enumerate() {
        let row = map.row(k);
        row.state.copy_from_slice(by_start);
        row.coefficients.iter_mut().zip(by).for_each(|(to, by)| *to = by[k]);
        *row.support = -total[k];
    }
    (map, moved(flight, o, &basis, length))
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
