//! Derivatives of a whole run in both directions: along one direction, or of one number by everything at once.
//!
//! A [`Tape`] holds the parts of a run of elastic contacts, each with its linearised map from the state at its start
//! and the coefficients to the state at its end: flights of single balls ([`flown`]) and neighbours that press on each
//! other ([`segment`]). Run forwards, the maps take a direction along; transposed and run backwards, they give the
//! derivatives of one number by the start state and all coefficients, for the price of a few runs (reverse mode:
//! Griewank and Walther, Evaluating Derivatives, 2008, chapter 3). Both use the same numbers, so that they agree to
//! rounding.
//!
//! Elastic forces are continuous where a contact closes and opens: the shifts of these times count by their second
//! order only. They are taken as the run has had them.

mod coefficients;
mod flown;
mod pair;
mod readout;
mod record;
mod segment;
mod slots;
mod variation;

use self::coefficients::Coefficients;
use self::flown::Flown;
use self::pair::Pair;
use self::segment::Segment;
use self::slots::{Slots, dot, exactly};
use self::variation::Variation;
use crate::model::{Cradle, Differential, Inputs, Parameters};
use crate::solver::double_double::DoubleDouble;
use crate::solver::dual::Dual;
use crate::solver::oscillator::Oscillator;

pub(crate) use record::Recorder;

/// What acts between two changes of the tunable parameters.
#[derive(Clone, Debug)]
struct Tuning {
    parameters: Parameters,
    cradle: Cradle,
    oscillators: Vec<Oscillator>,
}

/// A part of a run.
#[derive(Clone, Debug)]
enum Part {
    Flown(Flown),
    Pair(Box<Pair>),
    Segment(Segment),
}

/// A run in parts.
#[derive(Clone, Debug)]
pub struct Tape {
    tunings: Vec<Tuning>,
    parts: Vec<Part>,
    /// What acts at its end.
    last: usize,
    end: readout::End,
}

/// The derivatives of one number by everything that a run depends on.
#[derive(Clone, Debug)]
pub struct Gradient<'a> {
    tape: &'a Tape,
    start: Slots,
    /// By the coefficients, for each tuning.
    coefficients: Vec<Coefficients<DoubleDouble>>,
}

impl Tape {
    fn balls(&self) -> usize {
        self.end.x.len()
    }

    /// How the coefficients change along a direction, for each tuning.
    fn changes(&self, tangent: &Parameters, inputs: &Inputs) -> Vec<Coefficients> {
        let change = |tuning: &Tuning| {
            let along = Cradle::<Dual>::along(&tuning.parameters, tangent);
            Coefficients::along(&along, inputs)
        };
        self.tunings.iter().map(change).collect()
    }

    /// Derivatives of the outputs at its end along a direction of parameters and inputs, like those of
    /// `WholeRun`; NaN where [`Self::lacks`] them.
    pub fn along(&self, tangent: &Parameters, inputs: &Inputs) -> Differential {
        let changes = self.changes(tangent, inputs);
        let mut slots = Slots::zero(self.balls());
        (slots.x, slots.v) = (exactly(&tangent.x_start), exactly(&tangent.v_start));
        for part in &self.parts {
            match part {
                Part::Flown(flown) => flown.forward(&changes[flown.tuning], &mut slots),
                Part::Pair(pair) => pair.forward(&changes[pair.tuning], &mut slots),
                Part::Segment(segment) => {
                    let cradle = &self.tunings[segment.tuning].cradle;
                    Variation::new(segment, cradle).forward(&changes[segment.tuning], &mut slots);
                }
            }
        }
        let mut outputs = self.end.lacking();
        self.end.read(&self.tunings[self.last].cradle, &slots, &changes[self.last], &mut outputs);
        outputs
    }

    /// The derivatives of the sum of the outputs at its end times these weights.
    pub fn gradient(&self, weights: &Differential) -> Gradient<'_> {
        let mut coefficients = vec![Coefficients::zero(self.balls()); self.tunings.len()];
        let mut slots = Slots::zero(self.balls());
        self.end.weigh(&self.tunings[self.last].cradle, weights, &mut slots, &mut coefficients[self.last]);
        for part in self.parts.iter().rev() {
            match part {
                Part::Flown(flown) => flown.backward(&mut coefficients[flown.tuning], &mut slots),
                Part::Pair(pair) => pair.backward(&mut coefficients[pair.tuning], &mut slots),
                Part::Segment(segment) => {
                    let cradle = &self.tunings[segment.tuning].cradle;
                    Variation::new(segment, cradle).backward(&mut coefficients[segment.tuning], &mut slots);
                }
            }
        }
        Gradient { tape: self, start: slots, coefficients }
    }

    /// The weights in a weighted `sum` of the outputs whose derivatives it has.
    pub fn weights(&self, sum: impl Fn(&Differential) -> f64) -> Differential {
        let mut weights = Differential::zero(self.balls());
        let mut unit = Differential::zero(self.balls());
        let mut of = |field: fn(&mut Differential) -> &mut [f64]| {
            for i in 0..field(&mut unit).len() {
                field(&mut unit)[i] = 1.0;
                field(&mut weights)[i] = sum(&unit);
                field(&mut unit)[i] = 0.0;
            }
        };
        of(|d| &mut d.x);
        of(|d| &mut d.v);
        of(|d| &mut d.impulse);
        of(|d| std::slice::from_mut(&mut d.energy));
        of(|d| std::slice::from_mut(&mut d.momentum));
        of(|d| std::slice::from_mut(&mut d.support_force));
        weights
    }

    /// Zero for each output whose derivatives it has, NaN for the others.
    pub fn lacks(&self) -> Differential {
        self.end.lacking()
    }
}

impl Gradient<'_> {
    /// The derivative along a direction of parameters and inputs.
    pub fn along(&self, tangent: &Parameters, inputs: &Inputs) -> f64 {
        let by_start = dot(&self.start.x, &tangent.x_start) + dot(&self.start.v, &tangent.v_start);
        let changes = self.tape.changes(tangent, inputs);
        let all = self.coefficients.iter().zip(&changes);
        all.fold(by_start, |sum, (by, change)| sum + by.dot(change)).value()
    }
}
