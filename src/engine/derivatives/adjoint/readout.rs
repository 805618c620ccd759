//! The outputs that follow from the end of a tape, and their derivatives.

use super::coefficients::Coefficients;
use super::slots::{Slots, dot, exactly, rounded};
use crate::model::{Cradle, Differential};
use crate::solver::double_double::DoubleDouble;

/// State of the chain at the end of a run.
#[derive(Clone, Debug, Default)]
pub(super) struct End {
    pub x: Vec<f64>,
    pub v: Vec<f64>,
    /// Overlaps of the contacts that are closed.
    pub overlaps: Vec<Option<f64>>,
}

/// The derivatives of one output by positions, velocities and the coefficients.
struct Row {
    x: Vec<f64>,
    v: Vec<f64>,
    coefficients: Coefficients,
}

impl End {
    /// Zero for the outputs that are read here, NaN for the others.
    pub fn lacking(&self) -> Differential {
        let balls = self.x.len();
        let (ball, contact) = (vec![f64::NAN; balls], vec![f64::NAN; balls.saturating_sub(1)]);
        let known = Differential::zero(balls);
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
            ..known
        }
    }

    /// Their derivatives from the changes of the state and of the coefficients.
    pub fn read(&self, cradle: &Cradle, state: &Slots, change: &Coefficients, outputs: &mut Differential) {
        let value = |row: Row| (dot(&state.x, &row.x) + dot(&state.v, &row.v) + row.coefficients.dot(change)).value();
        outputs.energy = value(self.energy(cradle));
        outputs.momentum = value(self.momentum(cradle));
        outputs.support_force = value(self.support_force(cradle));
        outputs.x = rounded(&state.x);
        outputs.v = rounded(&state.v);
        outputs.impulse = rounded(&state.impulse);
    }

    /// The derivatives of their sum with these weights, by the state and the coefficients.
    pub fn weigh(
        &self,
        cradle: &Cradle,
        weights: &Differential,
        state: &mut Slots,
        gradient: &mut Coefficients<DoubleDouble>,
    ) {
        state.x = exactly(&weights.x);
        state.v = exactly(&weights.v);
        state.impulse = exactly(&weights.impulse);
        let mut add = |row: Row, weight: f64| {
            let sum = |to: &mut [DoubleDouble], from: &[f64]| {
                to.iter_mut().zip(from).for_each(|(to, from)| *to += DoubleDouble::product(weight, *from));
            };
            sum(&mut state.x, &row.x);
            sum(&mut state.v, &row.v);
            gradient.add(weight, &row.coefficients);
        };
        add(self.energy(cradle), weights.energy);
        add(self.momentum(cradle), weights.momentum);
        add(self.support_force(cradle), weights.support_force);
    }

    /// `sum m (v^2 + omega2 x^2) / 2 + sum F d / (p + 1)`.
    fn energy(&self, cradle: &Cradle) -> Row {
        let mut row = self.row();
        for (i, ball) in cradle.balls.iter().enumerate() {
            let (x, v, by) = (self.x[i], self.v[i], &mut row.coefficients.balls[i]);
            (row.x[i], row.v[i]) = (ball.mass * ball.omega2 * x, ball.mass * v);
            *by = [0.5 * (v * v + ball.omega2 * x * x), 0.5 * ball.mass * x * x, 0.0, 0.0];
        }
        for (j, law) in cradle.contacts.iter().enumerate() {
            let Some(overlap) = self.overlaps[j].filter(|overlap| *overlap > 0.0) else { continue };
            let (force, energy) = (law.elastic_force(overlap), law.elastic_energy(overlap));
            row.x[j] += force;
            row.x[j + 1] -= force;
            let by_reference = (1.0 - law.exponent) * energy / law.overlap_ref;
            let by_exponent = energy * (libm::log(overlap / law.overlap_ref) - 1.0 / (law.exponent + 1.0));
            row.coefficients.contacts[j] = [energy / law.stiffness, by_reference, by_exponent, -force, 0.0, 0.0, 0.0];
        }
        row
    }

    /// `sum m v`.
    fn momentum(&self, cradle: &Cradle) -> Row {
        let mut row = self.row();
        for (i, ball) in cradle.balls.iter().enumerate() {
            (row.v[i], row.coefficients.balls[i]) = (ball.mass, [self.v[i], 0.0, 0.0, 0.0]);
        }
        row
    }

    /// `sum m (omega2 x + 2 gamma v)`.
    fn support_force(&self, cradle: &Cradle) -> Row {
        let mut row = self.row();
        for (i, ball) in cradle.balls.iter().enumerate() {
            let (x, v, by) = (self.x[i], self.v[i], &mut row.coefficients.balls[i]);
            (row.x[i], row.v[i]) = (ball.mass * ball.omega2, 2.0 * ball.mass * ball.gamma);
            *by = [ball.omega2 * x + 2.0 * ball.gamma * v, ball.mass * x, 2.0 * ball.mass * v, 0.0];
        }
        row
    }

    fn row(&self) -> Row {
        let zero = vec![0.0; self.x.len()];
        Row { x: zero.clone(), v: zero, coefficients: Coefficients::zero(self.x.len()) }
    }
}
