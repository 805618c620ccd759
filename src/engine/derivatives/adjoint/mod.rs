//! Derivatives of a whole run of elastic contacts: along one direction, or of one number by everything at once. See
//! "Derivatives" in docs/theory.md.
//!
//! A [`Tape`] is the chain of the linear maps ([`Map`]) of the parts of a run, each from the state at its start and the
//! coefficients to the state at its end: flights of single balls and equal pendulums in a linear contact
//! (`oscillation`), and other neighbours that press on each other (`group`).

mod group;
mod map;
mod oscillation;
mod record;

use std::sync::Arc;

use self::map::{IMPULSE, Map, STATE, V, X, changes, dot, numbers_of_coefficients, numbers_of_state};
use crate::model::{Cradle, Differential, Inputs, Parameters};
use crate::solver::{DoubleDouble, Dual};

pub(crate) use record::Recorder;

/// What acts between two changes of the tunable parameters.
#[derive(Clone, Debug)]
struct Tuning {
    parameters: Parameters,
    cradle: Cradle,
}

/// A run in parts.
#[derive(Clone, Debug)]
pub struct Tape {
    tunings: Vec<Arc<Tuning>>,
    parts: Vec<Map>,
    /// Energy, momentum and force on the support at its end.
    sums: Map,
}

/// The derivatives of one number by the start and the coefficients of a run.
#[derive(Clone, Debug)]
pub struct Gradient<'a> {
    tape: &'a Tape,
    by_start: Vec<DoubleDouble>,
    /// For each tuning.
    by_coefficients: Vec<Vec<DoubleDouble>>,
}

/// A change of the state at the start.
fn change_of_start(tangent: &Parameters) -> Vec<f64> {
    let mut change = vec![0.0; numbers_of_state(tangent.balls())];
    for (i, (x, v)) in tangent.x_start.iter().zip(&tangent.v_start).enumerate() {
        (change[STATE * i + X], change[STATE * i + V]) = (*x, *v);
    }
    change
}

impl Tape {
    fn balls(&self) -> usize {
        self.tunings[self.sums.tuning].cradle.balls.len()
    }

    /// Changes of the coefficients along a direction, for each tuning.
    fn changes(&self, tangent: &Parameters, inputs: &Inputs) -> Vec<Vec<f64>> {
        let change = |tuning: &Arc<Tuning>| changes(&Cradle::<Dual>::along(&tuning.parameters, tangent), inputs);
        self.tunings.iter().map(change).collect()
    }

    /// Derivatives of the outputs at its end along a direction of parameters and inputs; NaN for what it lacks.
    pub fn along(&self, tangent: &Parameters, inputs: &Inputs) -> Differential {
        let changes = self.changes(tangent, inputs);
        let mut state: Vec<DoubleDouble> = change_of_start(tangent).into_iter().map(DoubleDouble::from).collect();
        self.parts.iter().for_each(|part| part.forward(&changes[part.tuning], &mut state));
        let sums = self.sums.apply(&changes[self.sums.tuning], &state);
        let of_balls = |number: usize| state.iter().skip(number).step_by(STATE).map(|change| change.value()).collect();
        Differential {
            x: of_balls(X),
            v: of_balls(V),
            impulse: of_balls(IMPULSE),
            total_energy: sums[0].value(),
            momentum: sums[1].value(),
            support_force: sums[2].value(),
            ..self.lacks()
        }
    }

    /// The derivatives of a weighted `sum` of the outputs whose derivatives it has.
    pub fn gradient(&self, sum: impl Fn(&Differential) -> f64) -> Gradient<'_> {
        let zero = |numbers: usize| vec![DoubleDouble::ZERO; numbers];
        let mut by_coefficients = vec![zero(numbers_of_coefficients(self.balls())); self.tunings.len()];
        let mut by_state = zero(numbers_of_state(self.balls()));
        let mut unit = Differential::all(self.balls(), 0.0);
        let mut weight = |output: &dyn Fn(&mut Differential) -> &mut f64| {
            *output(&mut unit) = 1.0;
            let weight = sum(&unit);
            *output(&mut unit) = 0.0;
            DoubleDouble::from(weight)
        };
        for (i, by_ball) in by_state.chunks_mut(STATE).enumerate() {
            (by_ball[X], by_ball[V]) = (weight(&|of| &mut of.x[i]), weight(&|of| &mut of.v[i]));
            if let Some(by_impulse) = by_ball.get_mut(IMPULSE) {
                *by_impulse = weight(&|of| &mut of.impulse[i]);
            }
        }
        let sums =
            [weight(&|of| &mut of.total_energy), weight(&|of| &mut of.momentum), weight(&|of| &mut of.support_force)];
        self.sums.apply_transposed(&sums, &mut by_coefficients[self.sums.tuning], &mut by_state);
        for part in self.parts.iter().rev() {
            part.backward(&mut by_coefficients[part.tuning], &mut by_state);
        }
        Gradient { tape: self, by_start: by_state, by_coefficients }
    }

    /// Zero for each output whose derivatives it has, NaN for the others.
    pub fn lacks(&self) -> Differential {
        let [has, lacks] = [0.0, f64::NAN].map(|value| Differential::all(self.balls(), value));
        let Differential { x, v, impulse, total_energy, momentum, support_force, .. } = has;
        Differential { x, v, impulse, total_energy, momentum, support_force, ..lacks }
    }
}

impl Gradient<'_> {
    /// The derivative along a direction of parameters and inputs.
    pub fn along(&self, tangent: &Parameters, inputs: &Inputs) -> f64 {
        let by_start = dot(&self.by_start, &change_of_start(tangent));
        let all = self.by_coefficients.iter().zip(self.tape.changes(tangent, inputs));
        all.fold(by_start, |sum, (by, changes)| sum + dot(by, &changes)).value()
    }
}
