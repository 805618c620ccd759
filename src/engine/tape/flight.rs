//! The flight of a ball on a line, linearised in closed form.

use super::coefficients::{Coefficients, STATE, V, X};
use super::nodes::BallNodes;
use super::part::Part;
use crate::engine::flight::{Flight, Forcing, forcing_at};
use crate::model::{BallModel, Cradle};
use crate::solver::{NODES, Nodes, Oscillator, Stretching, weighted};

/// A part of the flight of one ball.
#[derive(Debug)]
pub(super) struct FlightPart {
    pub ball: usize,
    /// Its start, and the external force (N) and the acceleration of the support (m/s2) from then on.
    pub start: Flight,
    pub inputs: [Forcing; 2],
    /// In s; at most [`Self::REACH`] over the pace of the pendulum.
    pub length: f64,
}

impl FlightPart {
    /// Longest part, times `omega + 2 gamma`, on which the nodes resolve the motion to rounding.
    pub const REACH: f64 = 4.0;

    fn oscillator(model: &BallModel) -> Oscillator {
        Oscillator::new(model.omega2, model.gamma)
    }

    /// The motion at the nodes.
    fn nodes(&self, model: &BallModel) -> BallNodes {
        let (o, times) = (Self::oscillator(model), &Stretching::None.table().times);
        let moved: [(f64, f64); NODES] = times.map(|c| self.start.at(&o, (self.length * c).into()));
        let inputs = self.inputs.map(|input| [times.map(|c| forcing_at(&input, self.length * c)), [0.0; NODES]]);
        BallNodes::new(model, [moved.map(|(x, _)| self.start.x + x), moved.map(|(_, v)| v)], &[0.0; NODES], inputs)
    }

    /// The change of the position and of the velocity at the end by an acceleration at the nodes, with their weights.
    fn responses(&self, model: &BallModel) -> [Nodes; 2] {
        let (o, table) = (Self::oscillator(model), Stretching::None.table());
        // Nodes are symmetric: the time left to the end is that of the mirrored node.
        let left: [[f64; 3]; NODES] =
            std::array::from_fn(|m| o.basis((self.length * table.times[NODES - 1 - m]).into()));
        [1, 0].map(|k| std::array::from_fn(|m| self.length * table.of_rate[m] * left[m][k]))
    }

    /// The changes of position and velocity in the flight by those at its start: those of the position first.
    fn growth(&self, model: &BallModel) -> [[f64; 2]; 2] {
        let o = Self::oscillator(model);
        let [_, u1, u2]: [f64; 3] = o.basis(self.length.into());
        let turn = o.omega2() * u2;
        [[-turn, u1], [-o.omega2() * u1, -turn - 2.0 * o.gamma() * u1]]
    }
}

impl Part for FlightPart {
    fn numbers(&self) -> usize {
        16
    }

    fn forward(&self, cradle: &Cradle, changes: &Coefficients, state: &mut [f64]) {
        let (model, state) = (&cradle.balls[self.ball], &mut state[self.ball * STATE..][..=V]);
        let growth = self.growth(model).map(|by| by[0] * state[X] + by[1] * state[V]);
        if !changes.leave(self.ball) {
            let accelerations = self.nodes(model).accelerations(model, self.ball, changes);
            let responses = self.responses(model);
            for (sum, response) in state.iter_mut().zip(&responses) {
                *sum += weighted(response, &accelerations);
            }
        }
        (state[X], state[V]) = (state[X] + growth[0], state[V] + growth[1]);
    }

    fn backward(&self, cradle: &Cradle, by_changes: &mut Coefficients, by_state: &mut [f64]) {
        let (model, by_state) = (&cradle.balls[self.ball], &mut by_state[self.ball * STATE..][..=V]);
        let ([of_x, of_v], [by_x, by_v]) = (self.responses(model), [by_state[X], by_state[V]]);
        let by: Nodes = std::array::from_fn(|m| by_x * of_x[m] + by_v * of_v[m]);
        self.nodes(model).add_derivatives(model, self.ball, &by, by_changes);
        let [of_x, of_v] = self.growth(model);
        (by_state[X], by_state[V]) =
            (by_x + (of_x[0] * by_x + of_v[0] * by_v), by_v + (of_x[1] * by_x + of_v[1] * by_v));
    }
}
