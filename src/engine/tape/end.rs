//! The outputs at the end of a run, and their derivatives along a direction that changes the state there.

use std::ops::Range;

use super::coefficients::{BEFORE, IMPULSE, PEAK, STATE, V, X, numbers_of_state};
use crate::engine::HeldInputs;
use crate::engine::chain_state::ChainState;
use crate::engine::cluster::WindowContact;
use crate::engine::equations::State;
use crate::engine::flight::Flight;
use crate::model::{Cradle, Differential, Inputs, Mode, Parameters};
use crate::solver::{Dual, Scalar};

/// A chain in `state`, which changes by `changes`, under the inputs `held`, which change by `inputs`.
pub(crate) fn along_direction(
    cradle: Cradle<Dual>,
    state: &ChainState,
    changes: &[f64],
    held: &HeldInputs,
    inputs: &Inputs,
) -> State<Dual> {
    let forcing = |i: usize| {
        let input = |of: &dyn Fn(&Inputs) -> f64| Dual::with_tangent(of(&held.orders[0]), of(inputs));
        input(&|inputs| inputs.force[i]) / cradle.balls[i].mass - input(&|inputs| inputs.support_acceleration)
    };
    let forcings: Vec<Dual> = (0..cradle.balls.len()).map(forcing).collect();
    let number = |number: usize, value: fn(&Flight) -> f64| {
        let pairs = state.flights.iter().zip(changes.chunks(STATE));
        pairs.map(|(flight, changes)| Dual::with_tangent(value(flight), changes[number])).collect::<Vec<_>>()
    };
    let (x, v) = (number(X, |flight| flight.x), number(V, |flight| flight.v));
    let overlap = |(j, contact): (usize, &WindowContact)| {
        Dual::with_tangent(contact.overlap, cradle.pair(j).overlap([x[j], x[j + 1]]).tangent())
    };
    let overlaps = state.contacts.iter().enumerate().map(overlap).collect();
    State::at(cradle, state.contacts.iter().map(|contact| contact.mode).collect(), [x, v, overlaps], forcings)
}

/// The end of a run or of a step.
#[derive(Clone, Debug)]
pub(crate) struct End {
    pub state: ChainState,
    pub inputs: HeldInputs,
    /// Length of the last step, s, 0 at the start, and integral of the acceleration of the support over that step, m/s.
    pub length: f64,
    pub support_speed: f64,
}

impl End {
    /// Derivatives of the outputs along a direction: of the coefficients of `cradle`, of the inputs, and of the state.
    pub fn outputs(&self, cradle: Cradle<Dual>, inputs: &Inputs, changes: &[f64]) -> Differential {
        let at = along_direction(cradle, &self.state, changes, &self.inputs, inputs);
        let mut outputs = Differential::along(&&at);
        outputs.next_onset = f64::NAN;
        let contacts = 0..at.cradle.contacts.len();
        let of_contacts = |value: &dyn Fn(&[f64]) -> f64| -> Vec<f64> {
            changes.chunks(STATE).take(contacts.len()).map(value).collect()
        };
        if self.length == 0.0 {
            if at.cradle.rigid {
                // Rigid contacts transmit nothing before the first step.
                outputs.force.fill(0.0);
            }
            outputs.force_mean.clone_from(&outputs.force);
            outputs.force_peak.clone_from(&outputs.force);
            return Differential { support_force_mean: outputs.support_force, ..outputs };
        }
        let mass: Dual = at.cradle.balls.iter().map(|ball| ball.mass).sum();
        let given = self.length * (inputs.force.iter().sum::<f64>() - inputs.support_acceleration * mass.value());
        let before = changes.last().copied().unwrap_or_default();
        let on_support = given - self.support_speed * mass.tangent() - (outputs.momentum - before);
        Differential {
            impulse: of_contacts(&|of| of[IMPULSE]),
            force_mean: of_contacts(&|of| (of[IMPULSE] - of[BEFORE]) / self.length),
            force_peak: of_contacts(&|of| of[PEAK]),
            support_force_mean: on_support / self.length,
            ..outputs
        }
    }
}

impl End {
    /// The derivatives of a sum of the outputs with these weights, by the numbers of the state.
    pub fn backward(&self, cradle: &Cradle, weights: &Differential) -> Vec<f64> {
        let mut by_state = vec![0.0; numbers_of_state(cradle.balls.len())];
        for i in 0..cradle.balls.len() {
            let affected = self.affected(cradle, i);
            let (part, along, weights) =
                (self.of_balls(&affected), of_balls(cradle, &affected), weights.of_balls(affected.clone()));
            let (inputs, mut unit) = (Inputs::zero(affected.len()), vec![0.0; numbers_of_state(affected.len())]);
            for number in [X, V] {
                let place = (i - affected.start) * STATE + number;
                unit[place] = 1.0;
                by_state[i * STATE + number] = part.outputs(along.clone(), &inputs, &unit).dot(&weights);
                unit[place] = 0.0;
            }
        }
        if self.length > 0.0 {
            for (j, by) in by_state.chunks_mut(STATE).take(cradle.contacts.len()).enumerate() {
                let by_mean = weights.force_mean[j] / self.length;
                (by[IMPULSE], by[BEFORE], by[PEAK]) = (weights.impulse[j] + by_mean, -by_mean, weights.force_peak[j]);
            }
            if let Some(before) = by_state.last_mut() {
                *before = weights.support_force_mean / self.length;
            }
        }
        by_state
    }

    /// The balls whose outputs change with ball `i`: its neighbours and, if contacts are rigid, all in one body with
    /// these.
    fn affected(&self, cradle: &Cradle, i: usize) -> Range<usize> {
        let (mut first, mut end) = (i.saturating_sub(1), (i + 2).min(cradle.balls.len()));
        let joined = |j: usize| cradle.rigid && self.state.contacts[j].mode != Mode::Open;
        while first > 0 && joined(first - 1) {
            first -= 1;
        }
        while end < cradle.balls.len() && joined(end - 1) {
            end += 1;
        }
        first..end
    }

    /// The end for a chain of only these balls.
    fn of_balls(&self, balls: &Range<usize>) -> Self {
        let state = ChainState {
            flights: self.state.flights[balls.clone()].to_vec(),
            contacts: self.state.contacts[balls.start..balls.end - 1].to_vec(),
        };
        let inputs = |inputs: &Inputs| Inputs { force: inputs.force[balls.clone()].to_vec(), ..*inputs };
        let orders = self.inputs.orders.iter().map(inputs).collect();
        Self { state, inputs: HeldInputs { orders, ..self.inputs }, ..*self }
    }
}

fn of_balls(cradle: &Cradle, balls: &Range<usize>) -> Cradle<Dual> {
    Cradle {
        balls: cradle.balls[balls.clone()].iter().map(|ball| ball.map(Dual::from)).collect(),
        contacts: cradle.contacts[balls.start..balls.end - 1].iter().map(|law| law.map(Dual::from)).collect(),
        rigid: cradle.rigid,
    }
}

/// A direction of the parameters, if they change, and of the inputs.
pub(crate) type Direction<'a> = (Option<&'a Parameters>, &'a Inputs);

/// The coefficients by these parameters, along a direction.
pub(crate) fn cradle_along(parameters: &Parameters, (tangent, _): Direction) -> Cradle<Dual> {
    tangent.map_or_else(|| Cradle::new(parameters).map(Dual::from), |tangent| Cradle::along(parameters, tangent))
}

/// The change of the start state along a direction; `along` has the coefficients.
pub(crate) fn change_of_start(parameters: &Parameters, direction: Direction, along: &Cradle<Dual>) -> Vec<f64> {
    let mut change = vec![0.0; numbers_of_state(parameters.balls())];
    let Some(tangent) = direction.0 else { return change };
    for (i, (ball, change)) in along.balls.iter().zip(change.chunks_mut(STATE)).enumerate() {
        let number = |field: fn(&Parameters) -> &[f64]| Dual::with_tangent(field(parameters)[i], field(tangent)[i]);
        let (x, v) = ball.along_path(number(|p| &p.x_start), number(|p| &p.v_start));
        (change[X], change[V]) = (x.tangent(), v.tangent());
    }
    change
}
