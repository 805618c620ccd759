//! The outputs that follow from the end of a tape, and their derivatives.

use super::coefficients::Coefficients;
use super::slots::Slots;
use crate::model::{Cradle, Differential};

/// State of the chain at the end of a run.
#[derive(Clone, Debug, Default)]
pub(super) struct End {
    pub x: Vec<f64>,
    pub v: Vec<f64>,
    /// Overlaps of the contacts that are closed.
    pub overlaps: Vec<Option<f64>>,
}

/// The derivatives of one output by the state and the coefficients.
struct Row {
    state: Slots,
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
        let value = |row: Row| row.state.dot(state) + row.coefficients.dot(change);
        outputs.energy = value(self.energy(cradle));
        outputs.momentum = value(self.momentum(cradle));
        outputs.support_force = value(self.support_force(cradle));
        outputs.x.clone_from(&state.x);
        outputs.v.clone_from(&state.v);
        outputs.impulse.clone_from(&state.impulse);
    }

    /// The derivatives of their sum with these weights, by the state and the coefficients.
    pub fn weigh(&self, cradle: &Cradle, weights: &Differential, state: &mut Slots, gradient: &mut Coefficients) {
        state.x.clone_from(&weights.x);
        state.v.clone_from(&weights.v);
        state.impulse.clone_from(&weights.impulse);
        let mut add = |row: Row, weight: f64| {
            let sum =
                |to: &mut [f64], from: &[f64]| to.iter_mut().zip(from).for_each(|(to, from)| *to += weight * from);
            sum(&mut state.x, &row.state.x);
            sum(&mut state.v, &row.state.v);
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
            (row.state.x[i], row.state.v[i]) = (ball.mass * ball.omega2 * x, ball.mass * v);
            (by.mass, by.omega2) = (0.5 * (v * v + ball.omega2 * x * x), 0.5 * ball.mass * x * x);
        }
        for (j, law) in cradle.contacts.iter().enumerate() {
            let Some(overlap) = self.overlaps[j].filter(|overlap| *overlap > 0.0) else { continue };
            let (force, energy) = (law.elastic_force(overlap), law.elastic_energy(overlap));
            row.state.x[j] += force;
            row.state.x[j + 1] -= force;
            let by = &mut row.coefficients.contacts[j];
            by.clearance = -force;
            by.stiffness = energy / law.stiffness;
            by.overlap_ref = (1.0 - law.exponent) * energy / law.overlap_ref;
            by.exponent = energy * (libm::log(overlap / law.overlap_ref) - 1.0 / (law.exponent + 1.0));
        }
        row
    }

    /// `sum m v`.
    fn momentum(&self, cradle: &Cradle) -> Row {
        let mut row = self.row();
        for (i, ball) in cradle.balls.iter().enumerate() {
            (row.state.v[i], row.coefficients.balls[i].mass) = (ball.mass, self.v[i]);
        }
        row
    }

    /// `sum m (omega2 x + 2 gamma v)`.
    fn support_force(&self, cradle: &Cradle) -> Row {
        let mut row = self.row();
        for (i, ball) in cradle.balls.iter().enumerate() {
            let (x, v, by) = (self.x[i], self.v[i], &mut row.coefficients.balls[i]);
            (row.state.x[i], row.state.v[i]) = (ball.mass * ball.omega2, 2.0 * ball.mass * ball.gamma);
            by.mass = ball.omega2 * x + 2.0 * ball.gamma * v;
            (by.omega2, by.gamma) = (ball.mass * x, 2.0 * ball.mass * v);
        }
        row
    }

    fn row(&self) -> Row {
        Row { state: Slots::zero(self.x.len()), coefficients: Coefficients::zero(self.x.len()) }
    }
}
