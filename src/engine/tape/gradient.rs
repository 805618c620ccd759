//! The parts of a run, for derivatives of its outputs along a direction, or of one number by everything at once.

use std::sync::Arc;

use super::coefficients::{Coefficients, numbers_of_state};
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

/// A part, and the number of its tuning.
pub(super) type TapedPart = (usize, Arc<dyn Part>);

/// A run in parts, from its start or from that of its last step.
#[derive(Clone, Debug)]
pub struct Tape {
    pub(super) tunings: Vec<Tuning>,
    pub(super) parts: Vec<TapedPart>,
    pub(super) end: End,
}

/// The derivatives of a sum of outputs by the start and the coefficients of a run.
pub struct Gradient<'a> {
    tape: &'a Tape,
    sum: Box<dyn Fn(&Differential) -> f64 + 'a>,
    by_start: Vec<f64>,
    /// For each tuning.
    by_coefficients: Vec<Coefficients>,
}

impl Tape {
    fn balls(&self) -> usize {
        self.tunings[0].cradle.balls.len()
    }

    /// Changes of the coefficients along a direction, for each tuning, and the cradle at the end.
    fn changes(&self, direction: Direction) -> (Vec<Coefficients>, Cradle<Dual>) {
        let mut last = Cradle::default();
        let mut change = |tuning: &Tuning| {
            last = cradle_along(&tuning.parameters, direction);
            Coefficients::along(&last, direction.1)
        };
        let changes = self.tunings.iter().map(&mut change).collect();
        (changes, last)
    }

    /// Derivatives of the outputs at its end along a direction of parameters and inputs; not of the next onset.
    pub fn along(&self, tangent: &Parameters, inputs: &Inputs) -> Differential {
        let (changes, last) = self.changes((Some(tangent), inputs));
        let mut state = change_of_start(&self.tunings[0].parameters, (Some(tangent), inputs));
        for (tuning, part) in &self.parts {
            part.forward(&self.tunings[*tuning].cradle, &changes[*tuning], &mut state);
        }
        self.end.outputs(last, inputs, &state)
    }

    /// Zero for each output whose derivatives it has, NaN for the others.
    pub fn lacks(&self) -> Differential {
        Differential { next_onset: f64::NAN, ..Differential::all(self.balls(), 0.0) }
    }

    /// The derivatives of a weighted `sum` of the outputs, without the next onset.
    pub fn gradient<'a>(&'a self, sum: impl Fn(&Differential) -> f64 + 'a) -> Gradient<'a> {
        let balls = self.balls();
        let mut by_coefficients = vec![Coefficients::zero(balls); self.tunings.len()];
        let mut by_state = vec![0.0; numbers_of_state(balls)];
        if let Some(Tuning { cradle, .. }) = self.tunings.last() {
            // Numbers of the state one by one.
            let (along, inputs) = (cradle.map(Dual::from), Inputs::zero(balls));
            let mut unit = by_state.clone();
            let mut derivative = |number: usize| {
                unit[number] = 1.0;
                let found = sum(&self.end.outputs(along.clone(), &inputs, &unit));
                unit[number] = 0.0;
                found
            };
            for (number, by) in by_state.iter_mut().enumerate() {
                *by = derivative(number);
            }
        }
        for (tuning, part) in self.parts.iter().rev() {
            part.backward(&self.tunings[*tuning].cradle, &mut by_coefficients[*tuning], &mut by_state);
        }
        Gradient { tape: self, sum: Box::new(sum), by_start: by_state, by_coefficients }
    }
}

impl Gradient<'_> {
    /// The derivative along a direction of parameters and inputs.
    pub fn along(&self, tangent: &Parameters, inputs: &Inputs) -> f64 {
        let (changes, last) = self.tape.changes((Some(tangent), inputs));
        let by_end = (self.sum)(&self.tape.end.outputs(last, inputs, &vec![0.0; self.by_start.len()]));
        let start = change_of_start(&self.tape.tunings[0].parameters, (Some(tangent), inputs));
        let by_start = self.by_start.iter().zip(&start).filter(|(_, change)| **change != 0.0);
        let by_start: f64 = by_start.map(|(by, change)| by * change).sum();
        let by_coefficients = self.by_coefficients.iter().zip(&changes).map(|(by, changes)| by.dot(changes));
        by_end + by_start + by_coefficients.sum::<f64>()
    }
}
