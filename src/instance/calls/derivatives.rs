//! Derivatives of the outputs: by time, and along directions of inputs and parameters.

use crate::engine::{Differential, MAX_OUTPUT_DERIVATIVE, NotFollowed};
use crate::instance::hybrid::Hybrid;
use crate::instance::legality::{Kind, Phase};
use crate::instance::lifecycle::Instance;
use crate::instance::refusal::Refusal;
use crate::model::Parameters;
use crate::variables::{Causality, Settings, Type, Variable, VariableError};

/// What has derivatives by time, and along a direction.
const OUTPUTS: &str = "real outputs";
const INITIAL_UNKNOWNS: &str = "real outputs, states, their derivatives and calculated parameters";
const EXCHANGED: &str = "real outputs and derivatives of states";
/// Along what.
const INPUTS: &str = "inputs and, in Initialization Mode or with derivatives.of = run, real parameters; in model exchange, after it, continuous states";
/// What derivatives of the run cannot do without.
const NO_HISTORY: &str = "derivatives.of = run must be set before an input or a tunable parameter changes, or the host has changed \
                          them too often (16 million values)";

impl Instance {
    /// Derivatives of outputs by time at the current time, each of its order, from 1 on. What changes only at events and
    /// communication points has derivative 0.
    pub fn output_derivatives(&mut self, references: &[u32], orders: &[i32]) -> Result<Vec<f64>, Refusal> {
        let mut known: [Option<Differential>; MAX_OUTPUT_DERIVATIVE] = Default::default();
        let mut derivative = |(reference, order): (&u32, &i32)| {
            let variable = self.differentiable(*reference, &[Causality::Output], OUTPUTS)?;
            let wanted = usize::try_from(*order).unwrap_or_default();
            let Some(slot) = wanted.checked_sub(1).and_then(|place| known.get_mut(place)) else {
                return Err(variable.no_such_order(*order, MAX_OUTPUT_DERIVATIVE).into());
            };
            if slot.is_none() {
                *slot = Some(self.simulation()?.time_derivative(wanted));
            }
            self.derivative(variable, slot.as_ref())
        };
        references.iter().zip(orders).map(&mut derivative).collect()
    }

    /// Derivatives of `unknowns` along the direction in which the `knowns` change by `direction`: in Initialization Mode those of
    /// the start values, later those of the end of the last step along inputs that were held over it or along parameters and inputs of
    /// the whole run, or in model exchange those of what follows from states and inputs.
    pub fn directional_derivatives(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        direction: &[f64],
    ) -> Result<Vec<f64>, Refusal> {
        let initializing = self.run.phase == Phase::InitializationMode;
        let exchanging = self.run.kind == Kind::ModelExchange && !initializing;
        let of_run = !initializing && !exchanging && self.run.hybrid.as_ref().is_some_and(Hybrid::derives_over_run);
        let mut along = Settings::zero(self.balls());
        let mut states = vec![0.0; self.states()];
        for (known, change) in knowns.iter().zip(direction) {
            let variable = self.variable(*known)?;
            let state = variable.state_place(self.balls()).filter(|_| exchanging);
            let input = variable.row.causality == Causality::Input;
            let parameter = variable.row.settable() && variable.row.access.data_type() == Type::Real;
            if !(input || (initializing || of_run) && parameter || state.is_some()) {
                return Err(VariableError::NotDifferentiable {
                    variable: format!("a direction along {variable}"),
                    allowed: INPUTS,
                }
                .into());
            }
            if !change.is_finite() {
                return Err(Refusal::number("dvKnown", *change, variable.row.unit(), "any finite value"));
            }
            match state {
                Some(place) => states[place] = *change,
                None => _ = variable.set_real(&mut along, *change),
            }
        }
        let (causalities, allowed): (&[Causality], _) = match (initializing, exchanging) {
            (true, _) => (&[Causality::Output, Causality::Local, Causality::CalculatedParameter], INITIAL_UNKNOWNS),
            (_, true) => (&[Causality::Output, Causality::Local], EXCHANGED),
            _ => (&[Causality::Output], OUTPUTS),
        };
        let unknowns: Vec<Variable> = unknowns
            .iter()
            .map(|unknown| self.differentiable(*unknown, causalities, allowed))
            .collect::<Result<_, _>>()?;
        if exchanging {
            let differential = self.exchange()?.along(&states, &along.inputs);
            return unknowns.into_iter().map(|unknown| self.derivative(unknown, Some(&differential))).collect();
        }
        let parameters = self.run.effective_parameters();
        let at_point = self.run.hybrid.as_ref().is_some_and(Hybrid::derives_at_point);
        let simulation = self.simulation()?;
        let differential = match initializing {
            false if of_run => self.sensitivity_of_run(&parameters, &along)?,
            false if at_point => Ok(simulation.sensitivity_at_point(&along.inputs)),
            true => simulation.sensitivity_of_start(&parameters, &along.parameters, &along.inputs),
            false => simulation.sensitivity_of_step(&along.inputs),
        };
        let differential = differential.ok();
        unknowns.into_iter().map(|unknown| self.derivative(unknown, differential.as_ref())).collect()
    }

    /// Derivatives of the outputs along a direction of parameters and inputs over the whole run, if it can be followed.
    fn sensitivity_of_run(
        &mut self,
        parameters: &Parameters,
        along: &Settings,
    ) -> Result<Result<Differential, NotFollowed>, Refusal> {
        let start = self.run.experiment.unwrap_or_default().start;
        let history = self.run.hybrid.as_ref().map(|hybrid| &hybrid.history).filter(|history| history.is_complete());
        let history = history.ok_or(Refusal::Unsupported(NO_HISTORY))?;
        let simulation = self.run.simulation.as_ref().ok_or(Refusal::Missing("nothing is calculated yet"))?;
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
            return Err(variable.wrong_type(Type::Real).into());
        }
        if variable.row.derivative.is_none() || !causalities.contains(&variable.row.causality) {
            return Err(VariableError::NotDifferentiable { variable: variable.to_string(), allowed }.into());
        }
        Ok(variable)
    }

    /// The derivative of `variable`, if there is one and it is finite; after a failed step it may be anything, like the values.
    fn derivative(&self, variable: Variable, differential: Option<&Differential>) -> Result<f64, Refusal> {
        let derivative = variable.row.derivative.zip(differential);
        let derivative = derivative.map_or(f64::NAN, |(get, differential)| get(differential, variable.index));
        if derivative.is_finite() || self.run.phase == Phase::Error {
            Ok(derivative)
        } else {
            Err(Refusal::Derivative(variable.to_string()))
        }
    }
}
