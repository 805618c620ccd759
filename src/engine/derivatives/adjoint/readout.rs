//! The outputs at the end of a tape, and their derivatives.

use super::map::{COEFFICIENTS, Map, OF_BALL, STATE, V, X};
use crate::model::Cradle;

/// The derivatives of energy, momentum and force on the support at positions (m), velocities (m/s) and the overlaps (m)
/// of the contacts that are closed.
pub(super) fn sums(cradle: &Cradle, tuning: usize, x: &[f64], v: &[f64], overlaps: &[Option<f64>]) -> Map {
    let mut map = Map::of_rows(3, 0, cradle.balls.len(), tuning);
    for (i, ball) in cradle.balls.iter().enumerate() {
        let (x, v, mass) = (x[i], v[i], ball.mass);
        // m (v^2 + omega2 x^2) / 2, m v, and m (omega2 x + 2 gamma v), by x, v and the coefficients.
        let of_energy = [0.5 * (v * v + ball.omega2 * x * x), 0.5 * mass * x * x, 0.0];
        let of_force = [ball.omega2 * x + 2.0 * ball.gamma * v, mass * x, 2.0 * mass * v];
        for (number, by_x, by_v, by_ball) in [
            (0, mass * ball.omega2 * x, mass * v, of_energy),
            (1, 0.0, mass, [v, 0.0, 0.0]),
            (2, mass * ball.omega2, 2.0 * mass * ball.gamma, of_force),
        ] {
            let [state, coefficients] = map.row(number);
            (state[STATE * i + X], state[STATE * i + V]) = (by_x, by_v);
            coefficients[COEFFICIENTS * i..][..by_ball.len()].copy_from_slice(&by_ball);
        }
    }
    let [state, coefficients] = map.row(0);
    for (j, law) in cradle.contacts.iter().enumerate() {
        let Some(overlap) = overlaps[j].filter(|overlap| *overlap > 0.0) else { continue };
        // F d / (p + 1).
        let (force, stored) = (law.elastic_force(overlap), law.elastic_energy(overlap));
        state[STATE * j + X] += force;
        state[STATE * (j + 1) + X] -= force;
        let by_reference = (1.0 - law.exponent) * stored / law.overlap_ref;
        let by_exponent = stored * (libm::log(overlap / law.overlap_ref) - 1.0 / (law.exponent + 1.0));
        let by_law = [stored / law.stiffness, by_reference, by_exponent, -force];
        coefficients[COEFFICIENTS * j + OF_BALL..][..by_law.len()].copy_from_slice(&by_law);
    }
    map
}
