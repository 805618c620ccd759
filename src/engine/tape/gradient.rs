//! The parts of a run, for derivatives of its outputs along a direction, or of one number by everything at once.

use std::sync::Arc;

use super::coefficients::Coefficients;
use super::end::{Direction, End, change_of_start, cradle_along};
use super::part::Part;
use crate::model::{Cradle, Differential, Inputs, Parameters};
use crate::solver::Dual;

/// What acts between two changes of the tunable parameters.
#[derive(Clone, Debug)]
pub(super) struct Tuning {
    pub parameters: Parameters,
    pub cradle: Cradle,
}

impl Tuning {
    pub fn new(parameters: &Parameters) -> Self {
        Self { parameters: parameters.clone(), cradle: Cradle::new(parameters) }
    }
}

/// A part, and the index of its tuning.
pub(super) type TapedPart = (usize, Arc<dyn Part>);

/// A run in parts, from its start or from the start of its last step.
#[derive(Clone, Debug)]
pub struct Tape {
    pub(super) tunings: Vec<Tuning>,
    pub(super) parts: Vec<TapedPart>,
    pub(super) end: End,
}

/// The derivatives of a sum of outputs by the start and the coefficients of a run.
pub struct Gradient<'a> {
    tape: &'a Tape,
    /// Weights of the outputs in the sum.
    weights: Differential,
    by_start: Vec<f64>,
    /// By the coefficients of each tuning.
    by_coefficients: Vec<Coefficients>,
}

impl Tape {
    fn balls(&self) -> usize {
        self.tunings[0].cradle.balls.len()
    }

    /// The changes along a direction: of the start, and of the coefficients for each tuning; and the cradle at the end.
    fn changes(&self, direction: Direction) -> (Vec<f64>, Vec<Coefficients>, Cradle<Dual>) {
        let first = &self.tunings[0].parameters;
        let mut cradle = cradle_along(first, direction);
        let start = change_of_start(first, direction, &cradle);
        let mut changes = vec![Coefficients::along(&cradle, direction.1)];
        for tuning in &self.tunings[1..] {
            cradle = cradle_along(&tuning.parameters, direction);
            changes.push(Coefficients::along(&cradle, direction.1));
        }
        (start, changes, cradle)
    }

    /// Derivatives of the outputs at the end along a direction of parameters and inputs; the next onset is left out.
    pub fn along(&self, tangent: &Parameters, inputs: &Inputs) -> Differential {
        let (mut state, changes, last) = self.changes((Some(tangent), inputs));
        for (tuning, part) in &self.parts {
            part.forward(&self.tunings[*tuning].cradle, &changes[*tuning], &mut state);
        }
        self.end.outputs(last, inputs, &state)
    }

    /// Zero for each output whose derivatives the tape has, NaN for the others.
    pub fn lacks(&self) -> Differential {
        Differential { next_onset: f64::NAN, ..Differential::all(self.balls(), 0.0) }
    }

    /// The derivatives of a weighted `sum` of the outputs, without the next onset.
    pub fn gradient(&self, sum: impl Fn(&Differential) -> f64) -> Gradient<'_> {
        let balls = self.balls();
        let weights = Differential::weights(balls, sum);
        let mut by_coefficients = vec![Coefficients::zero(balls); self.tunings.len()];
        let mut by_state = self.end.backward(&self.tunings[self.tunings.len() - 1].cradle, &weights);
        for (tuning, part) in self.parts.iter().rev() {
            part.backward(&self.tunings[*tuning].cradle, &mut by_coefficients[*tuning], &mut by_state);
        }
        Gradient { tape: self, weights, by_start: by_state, by_coefficients }
    }
}

impl Gradient<'_> {
    /// The derivative along a direction of parameters and inputs.
    pub fn along(&self, tangent: &Parameters, inputs: &Inputs) -> f64 {
        let (start, changes, last) = self.tape.changes((Some(tangent), inputs));
        let by_end = self.tape.end.outputs(last, inputs, &vec![0.0; self.by_start.len()]).dot(&self.weights);
        let by_start = self.by_start.iter().zip(&start).filter(|(_, change)| **change != 0.0);
        let by_start: f64 = by_start.map(|(by, change)| by * change).sum();
        let by_coefficients = self.by_coefficients.iter().zip(&changes).map(|(by, changes)| by.dot(changes));
        by_end + by_start + by_coefficients.sum::<f64>()
    }
}
