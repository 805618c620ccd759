//! The flight of a ball on a line, linearised in closed form.

use super::coefficients::{Coefficients, MASS, STATE, V, X};
use super::part::Part;
use crate::engine::flight::{Flight, Forcing};
use crate::model::{BallModel, Cradle};
use crate::solver::{BASIS, Oscillator};

/// A part of the flight of one ball.
#[derive(Debug)]
pub(super) struct FlightPart {
    pub ball: usize,
    /// State at its start, and acceleration by the external force from then on, m/s2.
    pub start: Flight,
    pub external: Forcing,
    /// Length, s; at most what [`Oscillator::longest`] allows.
    pub length: f64,
}

/// A vector of the phase plane: position (m) and velocity (m/s) of a ball, or derivatives by them.
type PhaseVector = [f64; 2];

impl FlightPart {
    /// The changes of the motion at the end for a unit of position and of velocity at the start, less that unit.
    fn growth(model: &BallModel, [_, u1, u2]: [f64; 3]) -> [PhaseVector; 2] {
        let turn = model.omega2 * u2;
        [[-turn, -model.omega2 * u1], [u1, -turn - 2.0 * model.gamma * u1]]
    }

    /// The changes of the motion at the end by mass, decay rate, square of the frequency, and a constant acceleration.
    fn responses(&self, model: &BallModel, o: &Oscillator, u: &[f64; BASIS]) -> [PhaseVector; 4] {
        let (Flight { x, v, forcing }, z) = (&self.start, o.sensitivities(self.length, u));
        // The formula of the velocity, with `of[k]` in place of `U_k`.
        let sum = |of: &[f64]| {
            let varying = forcing.iter().zip(&of[1..]).skip(1).map(|(forcing, of)| forcing * of);
            v * of[0] + (forcing[0] - model.omega2 * x) * of[1] + varying.sum::<f64>()
        };
        let pushed =
            |k: usize| -self.external.iter().zip(&u[k..]).map(|(external, u)| external * u).sum::<f64>() / model.mass;
        [
            [pushed(2), pushed(1)],
            [-2.0 * sum(&z[1..]), -2.0 * sum(&z)],
            [-(x * u[2] + sum(&z[2..])), -(x * u[1] + sum(&z[1..]))],
            [u[2], u[1]],
        ]
    }
}

fn dot([x, v]: PhaseVector, [by_x, by_v]: PhaseVector) -> f64 {
    by_x * x + by_v * v
}

impl Part for FlightPart {
    fn numbers(&self) -> usize {
        16
    }

    fn forward(&self, cradle: &Cradle, changes: &Coefficients, state: &mut [f64]) {
        let (model, state) = (&cradle.balls[self.ball], &mut state[self.ball * STATE..][..=V]);
        let (o, mut change) = (Oscillator::new(model.omega2, model.gamma), [state[X], state[V]]);
        let mut add = |by: PhaseVector, of: f64| change.iter_mut().zip(by).for_each(|(sum, by)| *sum += by * of);
        if changes.leave(self.ball) {
            let [of_x, of_v] = Self::growth(model, o.basis(self.length.into()));
            add(of_x, state[X]);
            add(of_v, state[V]);
        } else {
            let u: [f64; BASIS] = o.basis(self.length.into());
            let [of_x, of_v] = Self::growth(model, [u[0], u[1], u[2]]);
            let causes = [changes.of_ball(self.ball)[MASS]].into_iter().chain(changes.of_motion(self.ball, model));
            self.responses(model, &o, &u).into_iter().zip(causes).for_each(|(by, of)| add(by, of));
            add(of_x, state[X]);
            add(of_v, state[V]);
        }
        (state[X], state[V]) = (change[X], change[V]);
    }

    fn backward(&self, cradle: &Cradle, by_changes: &mut Coefficients, by_state: &mut [f64]) {
        let (model, by_state) = (&cradle.balls[self.ball], &mut by_state[self.ball * STATE..][..=V]);
        let (o, by) = (Oscillator::new(model.omega2, model.gamma), [by_state[X], by_state[V]]);
        let u: [f64; BASIS] = o.basis(self.length.into());
        let [by_mass, by_motion @ ..] = self.responses(model, &o, &u).map(|response| dot(response, by));
        by_changes.of_ball_mut(self.ball)[MASS] += by_mass;
        by_changes.add_of_motion(self.ball, model, by_motion);
        let [of_x, of_v] = Self::growth(model, [u[0], u[1], u[2]]);
        (by_state[X], by_state[V]) = (by[X] + dot(of_x, by), by[V] + dot(of_v, by));
    }
}
