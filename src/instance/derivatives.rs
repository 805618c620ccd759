//! Derivatives of the outputs by time, and along directions of inputs and parameters.

use std::fmt::Display;
use std::sync::Arc;

use super::legality::{Kind, Phase};
use super::lifecycle::{Instance, InstanceState};
use crate::engine::{Differential, History, MAX_OUTPUT_DERIVATIVE, Simulation, Tape, Unfollowed, state_count};
use crate::variables::{Access, Causality, DerivativesOf, Extra, Refusal, Settings, Type, Variable, ensure};

/// In messages: the variables that have derivatives, by time and along a direction.
const OUTPUTS: &str = "real outputs";
const INITIAL_UNKNOWNS: &str = "real outputs, states, their derivatives and calculated parameters";
const EXCHANGED: &str = "real outputs and derivatives of states";
const INPUTS: &str = "inputs and, in Initialization Mode or with derivatives.of = run, real parameters; in model \
                      exchange, after it, continuous states";
/// In messages: why there are no derivatives of the run.
const NO_HISTORY: &str = "derivatives.of = run must be set before an input or a tunable parameter changes; the history \
                          of these changes holds at most 16 million values";

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
struct SettingsDirection {
    settings: Settings,
    states: Vec<f64>,
}

impl SettingsDirection {
    fn none(instance: &Instance) -> Self {
        Self { settings: Settings::zero(instance.balls()), states: vec![0.0; state_count(instance.balls())] }
    }
}

/// A scalar, or an element of an array; none if it belongs to no contact.
type Element = Option<Variable>;

impl Instance {
    /// Time derivatives of the elements of outputs at the current time, one order from 1 on for each variable; 0 for
    /// variables that change only at events and communication points.
    pub fn output_derivatives(&mut self, references: &[u32], orders: &[i32]) -> Result<Vec<f64>, Refusal> {
        let mut known: [Option<Differential>; MAX_OUTPUT_DERIVATIVE] = Default::default();
        let mut found = Vec::new();
        for (reference, order) in references.iter().zip(orders) {
            for element in self.elements_of(&[*reference], false)? {
                let Some(variable) = element else {
                    found.push(0.0);
                    continue;
                };
                check_differentiable(&variable, &[Causality::Output], OUTPUTS)?;
                let order = variable.check_order(*order, MAX_OUTPUT_DERIVATIVE)?;
                let of_order = &mut known[order - 1];
                if of_order.is_none() {
                    *of_order = Some(self.simulation()?.time_derivative(order));
                }
                found.push(self.finite(variable, value(of_order.as_ref(), &variable), None)?);
            }
        }
        Ok(found)
    }

    /// Derivatives of all elements of `unknowns` along the direction in which the elements of the `knowns` change by
    /// `seed`. In Initialization Mode these are derivatives of the start values; later, of the values at the end of the
    /// last step, along inputs held over it or along parameters and inputs of the whole run; in model exchange, of what
    /// follows from states and inputs.
    pub fn directional(&mut self, unknowns: &[u32], knowns: &[u32], seed: &[f64]) -> Result<Vec<f64>, Refusal> {
        let (unknowns, knowns) = (self.elements_of(unknowns, false)?, self.knowns(knowns)?);
        Refusal::unless_count("nSeed", seed.len(), knowns.len())?;
        self.recompute()?;
        let mut along = SettingsDirection::none(self);
        for (known, change) in knowns.iter().zip(seed) {
            self.turn(&mut along, *known, *change)?;
        }
        self.check_unknowns(&unknowns)?;
        self.derivatives_along(&unknowns, &along, true)
    }

    /// The sums of the derivatives of the elements of `unknowns`, times the weights `seed`, by each element of the
    /// `knowns`. Sums over a step or a run are found all at once, others one known after another.
    pub fn adjoint(&mut self, unknowns: &[u32], knowns: &[u32], seed: &[f64]) -> Result<Vec<f64>, Refusal> {
        let (unknowns, knowns) = (self.elements_of(unknowns, false)?, self.knowns(knowns)?);
        Refusal::unless_count("nSeed", seed.len(), unknowns.len())?;
        self.recompute()?;
        let weighted = unknowns.iter().zip(seed).filter_map(|(element, weight)| Some(((*element)?, *weight)));
        let all: Vec<(Variable, f64)> = weighted.collect();
        if let Some((_, weight)) = all.iter().find(|(_, weight)| !weight.is_finite()) {
            return Err(Refusal::argument("seed", weight, "any finite value"));
        }
        let tape = self.tape()?.and_then(Result::ok);
        let lacks = tape.as_ref().map(|tape| tape.lacks());
        self.check_unknowns(&unknowns)?;
        let is_taped = |(unknown, _): &(Variable, f64)| value(lacks.as_ref(), unknown) == 0.0;
        let (taped, others): (Vec<_>, Vec<_>) = all.iter().copied().partition(is_taped);
        let sum = |of: &Differential| taped.iter().map(|(unknown, weight)| weight * value(Some(of), unknown)).sum();
        let gradient = tape.as_ref().map(|tape| tape.gradient(sum));
        let mut along = SettingsDirection::none(self);
        let derivative = |known: &Element| {
            let Some(variable) = known else { return Ok(0.0) };
            self.turn(&mut along, *known, 1.0)?;
            let Settings { parameters, inputs, .. } = &along.settings;
            let found = gradient.as_ref().map(|gradient| gradient.along(parameters, inputs));
            let found = found.filter(|found| found.is_finite());
            // Without a finite sum from the tape, each unknown is followed on its own.
            let followed = if found.is_some() { &others } else { &all };
            let (unknowns, weights): (Vec<Element>, Vec<f64>) =
                followed.iter().map(|(unknown, weight)| (Some(*unknown), *weight)).unzip();
            let of_followed = match unknowns[..] {
                [] => Vec::new(),
                _ => self.derivatives_along(&unknowns, &along, false)?,
            };
            let of_followed = of_followed.iter().zip(&weights).map(|(derivative, weight)| derivative * weight);
            let found = found.unwrap_or(0.0) + of_followed.sum::<f64>();
            self.turn(&mut along, *known, 0.0)?;
            self.finite(format_args!("the sum of the unknowns by {variable}"), found, None)
        };
        knowns.iter().map(derivative).collect()
    }

    /// Derivatives of `unknowns` along a direction. Those over a run come from its tape, if `taped` and the tape has
    /// them; otherwise the run is followed.
    fn derivatives_along(
        &mut self,
        unknowns: &[Element],
        along: &SettingsDirection,
        taped: bool,
    ) -> Result<Vec<f64>, Refusal> {
        let Settings { parameters: tangent, inputs, .. } = &along.settings;
        let derived = self.derived();
        let tape = if derived == Derived::Run { self.tape()? } else { None };
        // A run can be followed along a direction for longer than a tape can be kept, and at its start, where there is
        // no tape. Where a tape fails for another reason, following fails, too.
        let mut why = tape.as_ref().and_then(|tape| tape.as_ref().err().copied());
        let follows = why.is_none_or(|why| matches!(why, Unfollowed::TooLong | Unfollowed::NoHistory));
        let mut found_or = |found: Result<Differential, Unfollowed>| found.map_err(|refused| why = Some(refused)).ok();
        let at_point = self.run.settings.derivatives_of == DerivativesOf::Point;
        // The motion is followed beyond now only if an unknown needs it.
        let of_next_onset = Differential { next_onset: 1.0, ..Differential::all(self.balls(), 0.0) };
        let asks = |unknown: &Variable| value(Some(&of_next_onset), unknown) != 0.0;
        let next_onset = unknowns.iter().flatten().any(asks);
        let found = match derived {
            Derived::Exchanged => Some(self.exchange()?.along(&along.states, inputs)),
            Derived::Start => Some(self.simulation()?.sensitivity_at_start((tangent, inputs), next_onset)),
            Derived::Step if at_point => {
                Some(self.simulation()?.last_step().with_next_onset(next_onset).at_end_along_inputs(inputs))
            }
            Derived::Step => {
                let InstanceState { history, simulation, .. } = &self.run;
                let run = simulation.as_ref();
                run.and_then(|run| found_or(run.sensitivity_of_step(history, inputs, next_onset)))
            }
            Derived::Run => tape.filter(|_| taped).and_then(Result::ok).map(|tape| tape.along(tangent, inputs)),
        };
        let all_of = |found: Option<&Differential>| -> Vec<f64> {
            unknowns.iter().map(|unknown| unknown.map_or(0.0, |variable| value(found, &variable))).collect()
        };
        let mut values = all_of(found.as_ref());
        if derived == Derived::Run && follows && values.iter().any(|value| !value.is_finite()) {
            let (simulation, history) = self.so_far()?;
            let followed = found_or(simulation.sensitivity_of_run(history, (tangent, inputs), next_onset));
            for (derivative, followed) in values.iter_mut().zip(all_of(followed.as_ref())) {
                *derivative = if derivative.is_finite() { *derivative } else { followed };
            }
        }
        let finite = |(unknown, derivative): (&Element, f64)| match unknown {
            Some(variable) => self.finite(*variable, derivative, why),
            None => Ok(derivative),
        };
        unknowns.iter().zip(values).map(finite).collect()
    }

    fn derived(&self) -> Derived {
        match (self.run.phase, self.run.purpose.kind) {
            (Phase::InitializationMode, _) => Derived::Start,
            (_, Kind::ModelExchange) => Derived::Exchanged,
            _ if self.run.derives_over_run() => Derived::Run,
            _ => Derived::Step,
        }
    }

    /// Sets the component of a direction along a known to `change`, if it can be a known.
    fn turn(&self, along: &mut SettingsDirection, known: Element, change: f64) -> Result<(), Refusal> {
        let Some(variable) = known else { return Ok(()) };
        let state = variable.state_place(self.balls(), true).filter(|_| self.derived() == Derived::Exchanged);
        let input = variable.row.causality == Causality::Input;
        let parameter = variable.row.settable() && variable.row.access.data_type() == Type::Real;
        let by_parameters = matches!(self.derived(), Derived::Start | Derived::Run);
        let known = input || by_parameters && parameter || state.is_some();
        ensure(known, || not_differentiable(format_args!("a direction along {variable}"), INPUTS))?;
        let unit = variable.row.unit();
        ensure(change.is_finite(), || Refusal::number("dvKnown", change, unit, "any finite value"))?;
        match state {
            Some(place) => along.states[place] = change,
            None => _ = variable.set(&mut along.settings, change),
        }
        Ok(())
    }

    /// Checks that these have derivatives now.
    fn check_unknowns(&self, unknowns: &[Element]) -> Result<(), Refusal> {
        let (causalities, allowed): (&[Causality], _) = match self.derived() {
            Derived::Start => {
                (&[Causality::Output, Causality::Local, Causality::CalculatedParameter], INITIAL_UNKNOWNS)
            }
            Derived::Exchanged => (&[Causality::Output, Causality::Local], EXCHANGED),
            Derived::Step | Derived::Run => (&[Causality::Output], OUTPUTS),
        };
        unknowns.iter().flatten().try_for_each(|unknown| check_differentiable(unknown, causalities, allowed))
    }

    /// The run so far, and its complete history of inputs.
    fn so_far(&self) -> Result<(&Simulation, &History), Refusal> {
        let InstanceState { history, simulation, .. } = &self.run;
        ensure(history.is_complete(), || Refusal::no_value(NO_HISTORY))?;
        let simulation = simulation.as_ref().ok_or_else(|| Refusal::new("nothing is calculated yet"))?;
        Ok((simulation, history))
    }

    /// The tape of the step or the run over which derivatives are taken, if they are.
    fn tape(&self) -> Result<Option<Result<Arc<Tape>, Unfollowed>>, Refusal> {
        let InstanceState { history, simulation, settings, .. } = &self.run;
        Ok(match (self.derived(), simulation) {
            (Derived::Run, _) => {
                let (simulation, history) = self.so_far()?;
                Some(history.tape(true, |history| simulation.tape(history)))
            }
            (Derived::Step, Some(run)) if settings.derivatives_of != DerivativesOf::Point => {
                Some(history.tape(false, |history| run.tape_of_step(history)))
            }
            _ => None,
        })
    }

    /// Passes the derivative of `variable` if it is finite; after a failed step, in any case.
    fn finite(&self, variable: impl Display, derivative: f64, why: Option<Unfollowed>) -> Result<f64, Refusal> {
        ensure(derivative.is_finite() || self.run.phase == Phase::Error, || no_derivative(variable, why))?;
        Ok(derivative)
    }

    /// The elements of the real variables behind `references`. Slopes `without_effect` count as elements of no contact.
    fn elements_of(&self, references: &[u32], without_effect: bool) -> Result<Vec<Element>, Refusal> {
        let balls = self.balls();
        let mut elements = Vec::new();
        for reference in references {
            let variable = self.variable(*reference, Type::Real)?;
            let known = match variable.row.access {
                Access::Instance(_, extra) => matches!(extra, Extra::Joined(..)),
                _ => without_effect || variable.row.causality != Causality::Input || variable.row.rate_of().is_none(),
            };
            ensure(known, || no_derivative(variable, None))?;
            elements.extend((0..variable.len(balls)).map(|index| variable.element(index).of_fmi2(balls)));
        }
        Ok(elements)
    }

    fn knowns(&self, references: &[u32]) -> Result<Vec<Element>, Refusal> {
        let of_step = self.run.purpose.kind == Kind::CoSimulation
            && self.run.phase > Phase::InitializationMode
            && self.run.settings.derivatives_of != DerivativesOf::Point;
        self.elements_of(references, !of_step)
    }
}

/// Checks that a real variable has derivatives and one of these causalities.
fn check_differentiable(variable: &Variable, causalities: &[Causality], allowed: &str) -> Result<(), Refusal> {
    let known = variable.row.derivative.is_some() && causalities.contains(&variable.row.causality);
    ensure(known, || not_differentiable(variable, allowed))
}

/// The derivative of `variable`; NaN if there is none.
fn value(of: Option<&Differential>, variable: &Variable) -> f64 {
    variable.row.derivative.zip(of).map_or(f64::NAN, |(get, of)| get(of, variable.index))
}

/// Refusal of a derivative, for the reason `why` or because it is not finite.
fn no_derivative(what: impl Display, why: Option<Unfollowed>) -> Refusal {
    match why {
        Some(why) => Refusal::no_value(format_args!("{what} has no derivative here: {why}")),
        None => Refusal::no_value(format_args!("{what} has no derivative here: it is not finite")),
    }
}

fn not_differentiable(what: impl Display, allowed: &str) -> Refusal {
    Refusal::new(format_args!("{what} has no such derivative; allowed: {allowed}"))
}
