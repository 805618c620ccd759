//! Derivatives of the outputs: by time, and along directions of inputs and parameters.

use std::fmt::Display;
use std::sync::Arc;

use super::legality::{Kind, Phase};
use super::lifecycle::Instance;
use crate::engine::{Differential, History, MAX_OUTPUT_DERIVATIVE, NotFollowed, Tape, state_count};
use crate::model::Parameters;
use crate::variables::{Causality, DerivativesOf, Refusal, Settings, Type, Variable};

/// What has derivatives by time, and along a direction.
const OUTPUTS: &str = "real outputs";
const INITIAL_UNKNOWNS: &str = "real outputs, states, their derivatives and calculated parameters";
const EXCHANGED: &str = "real outputs and derivatives of states";
/// Along what.
const INPUTS: &str = "inputs and, in Initialization Mode or with derivatives.of = run, real parameters; in model exchange, \
                      after it, continuous states";
/// What derivatives of the run cannot do without.
const NO_HISTORY: &str = "derivatives.of = run must be set before an input or a tunable parameter changes, or the host has \
                          changed them too often (16 million values)";

/// Which derivatives the host has asked for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Derived {
    Start,
    /// The last step, or the point at its end.
    Step,
    Run,
    /// The equations, in model exchange.
    Exchanged,
}

/// A direction in the space of parameters, inputs and states.
struct Direction {
    settings: Settings,
    states: Vec<f64>,
}

impl Direction {
    fn none(instance: &Instance) -> Self {
        Self { settings: Settings::zero(instance.balls()), states: vec![0.0; state_count(instance.balls())] }
    }
}

/// What the run has been given, if all of it was kept.
fn complete(history: &History) -> Result<&History, Refusal> {
    if history.is_complete() { Ok(history) } else { Err(Refusal::no_value(NO_HISTORY)) }
}

impl Instance {
    /// Derivatives of outputs by time at the current time, each of its order, from 1 on. What changes only at events
    /// and communication points has derivative 0.
    pub fn output_derivatives(&mut self, references: &[u32], orders: &[i32]) -> Result<Vec<f64>, Refusal> {
        let mut known: [Option<Differential>; MAX_OUTPUT_DERIVATIVE] = Default::default();
        let mut derivative = |(reference, order): (&u32, &i32)| {
            let variable = self.differentiable(*reference, &[Causality::Output], OUTPUTS)?;
            let wanted = usize::try_from(*order).unwrap_or_default();
            let Some(slot) = wanted.checked_sub(1).and_then(|place| known.get_mut(place)) else {
                return Err(variable.no_such_order(*order, MAX_OUTPUT_DERIVATIVE));
            };
            if slot.is_none() {
                *slot = Some(self.simulation()?.time_derivative(wanted));
            }
            self.derivative(variable, slot.as_ref())
        };
        references.iter().zip(orders).map(&mut derivative).collect()
    }

    /// Derivatives of `unknowns` along the direction in which the `knowns` change by `direction`: in Initialization
    /// Mode those of the start values, later those of the end of the last step along inputs that were held over it or
    /// along parameters and inputs of the whole run, or in model exchange those of what follows from states and inputs.
    pub fn directional_derivatives(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        direction: &[f64],
    ) -> Result<Vec<f64>, Refusal> {
        let mut along = Direction::none(self);
        for (known, change) in knowns.iter().zip(direction) {
            self.turn(&mut along, *known, *change)?;
        }
        let unknowns = self.unknowns(unknowns)?;
        if self.derives(Derived::Exchanged) {
            let differential = self.exchange()?.along(&along.states, &along.settings.inputs);
            return unknowns.into_iter().map(|unknown| self.derivative(unknown, Some(&differential))).collect();
        }
        let Settings { parameters: tangent, inputs, .. } = &along.settings;
        if self.derives(Derived::Run) {
            let taken = self.tape()?.map(|tape| tape.along(tangent, inputs));
            return self.of_tape_or_run(&unknowns, taken.as_ref(), &along.settings);
        }
        let parameters = self.run.effective_parameters();
        let at_point = self.run.settings.derivatives_of == DerivativesOf::Point;
        let initial = self.derives(Derived::Start);
        let simulation = self.simulation()?;
        let differential = match initial {
            false if at_point => Ok(simulation.sensitivity_at_point(inputs)),
            true => simulation.sensitivity_of_start(&parameters, tangent, inputs),
            false => simulation.sensitivity_of_step(inputs),
        };
        let differential = differential.ok();
        unknowns.into_iter().map(|unknown| self.derivative(unknown, differential.as_ref())).collect()
    }

    /// The sums of the derivatives of `unknowns`, times the weights `seed`, by each of the `knowns`. Those over a run
    /// that has a tape are found all at once, others one known after the other.
    pub fn adjoint_derivatives(&mut self, unknowns: &[u32], seed: &[f64], knowns: &[u32]) -> Result<Vec<f64>, Refusal> {
        if let Some(weight) = seed.iter().find(|weight| !weight.is_finite()) {
            return Err(Refusal::argument("seed", weight, "any finite value"));
        }
        let tape = if self.derives(Derived::Run) { self.tape()? } else { None };
        let lacks = tape.as_ref().map(|tape| tape.lacks());
        let unknowns = self.unknowns(unknowns)?;
        let value = |of: &Differential, unknown: &Variable| {
            unknown.row.derivative.map_or(f64::NAN, |get| get(of, unknown.index))
        };
        let is_taped = |unknown: &Variable| lacks.as_ref().is_some_and(|lacks| value(lacks, unknown) == 0.0);
        let weighted = unknowns.iter().copied().zip(seed.iter().copied());
        let (taped, others): (Vec<_>, Vec<_>) = weighted.clone().partition(|(unknown, _)| is_taped(unknown));
        let sum = |of: &Differential| taped.iter().map(|(unknown, weight)| weight * value(of, unknown)).sum();
        let gradient = tape.as_ref().map(|tape| tape.gradient(&tape.weights(sum)));
        let all: Vec<(Variable, f64)> = weighted.collect();
        let mut along = Direction::none(self);
        let mut sensitivity = Vec::with_capacity(knowns.len());
        for known in knowns {
            self.turn(&mut along, *known, 1.0)?;
            let Settings { parameters, inputs, .. } = &along.settings;
            let found = gradient.as_ref().map(|gradient| gradient.along(parameters, inputs));
            let found = found.filter(|found| found.is_finite());
            // Without a finite sum from the tape each unknown is followed by itself.
            let (followed, weights): (Vec<Variable>, Vec<f64>) =
                if found.is_some() { &others } else { &all }.iter().copied().unzip();
            let references: Vec<u32> = followed.iter().map(Variable::reference).collect();
            let derivatives = match (followed.is_empty(), self.derives(Derived::Run)) {
                (true, _) => Vec::new(),
                (false, true) => self.of_tape_or_run(&followed, None, &along.settings)?,
                (false, false) => self.directional_derivatives(&references, &[*known], &[1.0])?,
            };
            let of_followed = derivatives.iter().zip(&weights).map(|(derivative, weight)| derivative * weight);
            let found = found.unwrap_or(0.0) + of_followed.sum::<f64>();
            if !found.is_finite() && self.run.phase != Phase::Error {
                return Err(no_derivative(format_args!("the sum of the unknowns by {}", self.variable(*known)?)));
            }
            self.turn(&mut along, *known, 0.0)?;
            sensitivity.push(found);
        }
        Ok(sensitivity)
    }

    /// Whether directional and adjoint derivatives are now of this kind.
    fn derives(&self, kind: Derived) -> bool {
        let now = match (self.run.phase, self.run.purpose.kind) {
            (Phase::InitializationMode, _) => Derived::Start,
            (_, Kind::ModelExchange) => Derived::Exchanged,
            _ if self.run.derives_over_run() => Derived::Run,
            _ => Derived::Step,
        };
        now == kind
    }

    /// Has a direction change a known by `change`, if that can be one.
    fn turn(&self, along: &mut Direction, known: u32, change: f64) -> Result<(), Refusal> {
        let variable = self.variable(known)?;
        let state = variable.state_place(self.balls()).filter(|_| self.derives(Derived::Exchanged));
        let input = variable.row.causality == Causality::Input;
        let parameter = variable.row.settable() && variable.row.access.data_type() == Type::Real;
        let by_parameters = self.derives(Derived::Start) || self.derives(Derived::Run);
        if !(input || by_parameters && parameter || state.is_some()) {
            return Err(not_differentiable(format_args!("a direction along {variable}"), INPUTS));
        }
        if !change.is_finite() {
            return Err(Refusal::number("dvKnown", change, variable.row.unit(), "any finite value"));
        }
        match state {
            Some(place) => along.states[place] = change,
            None => _ = variable.set_real(&mut along.settings, change),
        }
        Ok(())
    }

    /// The variables behind value references, if there are derivatives of them now.
    fn unknowns(&self, unknowns: &[u32]) -> Result<Vec<Variable>, Refusal> {
        let (causalities, allowed): (&[Causality], _) = if self.derives(Derived::Start) {
            (&[Causality::Output, Causality::Local, Causality::CalculatedParameter], INITIAL_UNKNOWNS)
        } else if self.derives(Derived::Exchanged) {
            (&[Causality::Output, Causality::Local], EXCHANGED)
        } else {
            (&[Causality::Output], OUTPUTS)
        };
        unknowns.iter().map(|unknown| self.differentiable(*unknown, causalities, allowed)).collect()
    }

    /// Derivatives over the run as `taken` from its tape or, where that has none, by following the run.
    fn of_tape_or_run(
        &self,
        unknowns: &[Variable],
        taken: Option<&Differential>,
        along: &Settings,
    ) -> Result<Vec<f64>, Refusal> {
        let from_tape = |unknown: &Variable| {
            let derivative = unknown.row.derivative.zip(taken).map(|(get, taken)| get(taken, unknown.index));
            derivative.filter(|derivative| derivative.is_finite())
        };
        let known: Vec<Option<f64>> = unknowns.iter().map(from_tape).collect();
        let mut followed = None;
        if known.iter().any(Option::is_none) {
            let parameters = self.run.effective_parameters();
            followed = self.sensitivity_of_run(&parameters, along)?.ok();
        }
        let either = |(unknown, known): (&Variable, Option<f64>)| {
            known.map_or_else(|| self.derivative(*unknown, followed.as_ref()), Ok)
        };
        unknowns.iter().zip(known).map(either).collect()
    }

    /// The tape of the run, if it has one.
    fn tape(&self) -> Result<Option<Arc<Tape>>, Refusal> {
        let parameters = self.run.effective_parameters();
        let start = self.run.start_time();
        let simulation = self.run.simulation.as_ref().ok_or_else(|| Refusal::new("nothing is calculated yet"))?;
        let history = complete(&self.run.history)?;
        Ok(history.tape(|history| simulation.tape(&parameters, start, history)))
    }

    /// Derivatives of the outputs along a direction of parameters and inputs over the whole run, if it can be followed.
    fn sensitivity_of_run(
        &self,
        parameters: &Parameters,
        along: &Settings,
    ) -> Result<Result<Differential, NotFollowed>, Refusal> {
        let start = self.run.start_time();
        let history = complete(&self.run.history)?;
        let simulation = self.run.simulation.as_ref().ok_or_else(|| Refusal::new("nothing is calculated yet"))?;
        Ok(simulation.sensitivity_of_run(parameters, start, history, &along.parameters, &along.inputs))
    }

    /// The real variable behind a value reference, if it has derivatives and one of these causalities.
    fn differentiable(
        &self,
        reference: u32,
        causalities: &[Causality],
        allowed: &'static str,
    ) -> Result<Variable, Refusal> {
        let variable = self.variable(reference)?;
        if variable.row.access.data_type() != Type::Real {
            return Err(variable.wrong_type(Type::Real));
        }
        if variable.row.derivative.is_none() || !causalities.contains(&variable.row.causality) {
            return Err(not_differentiable(variable, allowed));
        }
        Ok(variable)
    }

    /// The derivative of `variable`, if there is one and it is finite; after a failed step it may be anything, like the
    /// values.
    fn derivative(&self, variable: Variable, differential: Option<&Differential>) -> Result<f64, Refusal> {
        let derivative = variable.row.derivative.zip(differential);
        let derivative = derivative.map_or(f64::NAN, |(get, differential)| get(differential, variable.index));
        if derivative.is_finite() || self.run.phase == Phase::Error {
            Ok(derivative)
        } else {
            Err(no_derivative(variable))
        }
    }
}

#[cold]
pub(super) fn no_derivative(what: impl Display) -> Refusal {
    Refusal::no_value(format_args!(
        "{what} has no derivative here: it is not finite, or the step has too many switchings, or contacts too stiff \
         for its length"
    ))
}

#[cold]
fn not_differentiable(what: impl Display, allowed: &str) -> Refusal {
    Refusal::new(format_args!("{what} has no such derivative; allowed: {allowed}"))
}
