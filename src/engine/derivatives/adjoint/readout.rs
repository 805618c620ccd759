//! The outputs that follow from the end of a tape, and their derivatives.

use super::map::{COEFFICIENTS, IMPULSE, OF_BALL, STATE, V, X, dot, numbers_of_coefficients, numbers_of_state};
use crate::model::{Cradle, Differential};
use crate::solver::double_double::DoubleDouble;

/// The derivatives of one output by the state at the end and by the coefficients.
#[derive(Clone, Debug)]
struct Row {
    state: Vec<f64>,
    coefficients: Vec<f64>,
}

/// The derivatives of the outputs that are sums over all balls.
#[derive(Clone, Debug)]
pub(super) struct End {
    energy: Row,
    momentum: Row,
    support_force: Row,
}

/// Zero for the outputs that are read here, NaN for the others.
pub(super) fn lacking(balls: usize) -> Differential {
    let (ball, contact) = (vec![f64::NAN; balls], vec![f64::NAN; balls.saturating_sub(1)]);
    Differential {
        force: contact.clone(),
        force_mean: contact.clone(),
        force_peak: contact.clone(),
        overlap: contact.clone(),
        overlap_rate: contact,
        a: ball,
        next_onset: f64::NAN,
        support_force_mean: f64::NAN,
        period: f64::NAN,
        dissipated_energy: f64::NAN,
        dissipation: f64::NAN,
        external_work: f64::NAN,
        external_power: f64::NAN,
        ..Differential::zero(balls)
    }
}

impl End {
    /// At positions (m), velocities (m/s) and the overlaps (m) of the contacts that are closed.
    pub fn new(cradle: &Cradle, x: &[f64], v: &[f64], overlaps: &[Option<f64>]) -> Self {
        let balls = cradle.balls.len();
        let zero =
            Row { state: vec![0.0; numbers_of_state(balls)], coefficients: vec![0.0; numbers_of_coefficients(balls)] };
        // Sums of m (v^2 + omega2 x^2) / 2 + F d / (p + 1), of m v, and of m (omega2 x + 2 gamma v).
        let (mut energy, mut momentum, mut support_force) = (zero.clone(), zero.clone(), zero);
        for (i, ball) in cradle.balls.iter().enumerate() {
            let (x, v, mass) = (x[i], v[i], ball.mass);
            let enter = |row: &mut Row, of_x: f64, of_v: f64, of_ball: [f64; OF_BALL]| {
                (row.state[STATE * i + X], row.state[STATE * i + V]) = (of_x, of_v);
                row.coefficients[COEFFICIENTS * i..][..OF_BALL].copy_from_slice(&of_ball);
            };
            let of_ball = [0.5 * (v * v + ball.omega2 * x * x), 0.5 * mass * x * x, 0.0, 0.0];
            enter(&mut energy, mass * ball.omega2 * x, mass * v, of_ball);
            enter(&mut momentum, 0.0, mass, [v, 0.0, 0.0, 0.0]);
            let of_ball = [ball.omega2 * x + 2.0 * ball.gamma * v, mass * x, 2.0 * mass * v, 0.0];
            enter(&mut support_force, mass * ball.omega2, 2.0 * mass * ball.gamma, of_ball);
        }
        for (j, law) in cradle.contacts.iter().enumerate() {
            let Some(overlap) = overlaps[j].filter(|overlap| *overlap > 0.0) else { continue };
            let (force, stored) = (law.elastic_force(overlap), law.elastic_energy(overlap));
            energy.state[STATE * j + X] += force;
            energy.state[STATE * (j + 1) + X] -= force;
            let by_reference = (1.0 - law.exponent) * stored / law.overlap_ref;
            let by_exponent = stored * (libm::log(overlap / law.overlap_ref) - 1.0 / (law.exponent + 1.0));
            let by_law = [stored / law.stiffness, by_reference, by_exponent, -force];
            energy.coefficients[COEFFICIENTS * j + OF_BALL..][..by_law.len()].copy_from_slice(&by_law);
        }
        Self { energy, momentum, support_force }
    }

    /// Derivatives of the outputs from the changes of the state and of the coefficients.
    pub fn read(&self, state: &[DoubleDouble], changes: &[f64]) -> Differential {
        let balls = state.len().div_ceil(STATE);
        let value = |row: &Row| {
            let of_coefficients = row.coefficients.iter().zip(changes);
            let sum = dot(state, &row.state);
            of_coefficients.fold(sum, |sum, (by, change)| sum + DoubleDouble::product(*by, *change)).value()
        };
        let of_balls = |number: usize| state.iter().skip(number).step_by(STATE).map(|change| change.value()).collect();
        Differential {
            x: of_balls(X),
            v: of_balls(V),
            impulse: of_balls(IMPULSE),
            energy: value(&self.energy),
            momentum: value(&self.momentum),
            support_force: value(&self.support_force),
            ..lacking(balls)
        }
    }

    /// The derivatives of their sum with these weights, by the state and the coefficients.
    pub fn weigh(&self, weights: &Differential, state: &mut [DoubleDouble], coefficients: &mut [DoubleDouble]) {
        for (number, weights) in [(X, &weights.x), (V, &weights.v), (IMPULSE, &weights.impulse)] {
            state.iter_mut().skip(number).step_by(STATE).zip(weights).for_each(|(to, weight)| *to += *weight);
        }
        let sums = [
            (&self.energy, weights.energy),
            (&self.momentum, weights.momentum),
            (&self.support_force, weights.support_force),
        ];
        for (row, weight) in sums {
            let numbers = state.iter_mut().zip(&row.state).chain(coefficients.iter_mut().zip(&row.coefficients));
            numbers.for_each(|(sum, by)| *sum += DoubleDouble::product(weight, *by));
        }
    }
}
