//! Reading real variables, and setting variables, as hosts of either version do.

use super::legality::{Kind, Phase};
use super::lifecycle::Instance;
use crate::model::{Inputs, Tunables};
use crate::variables::{Access, Causality, Number, Refusal, Settings, TABLE, Type, Variability, Variable};

impl Instance {
    #[inline]
    pub fn real(&mut self, reference: u32) -> Result<f64, Refusal> {
        self.real_of(self.variable(reference)?)
    }

    #[inline]
    pub(super) fn real_of(&mut self, variable: Variable) -> Result<f64, Refusal> {
        match variable.row.access {
            Access::Real(get) => {
                let value = get(self.results()?, variable.index);
                // In the error state values may be anything.
                if value.is_nan() && self.run.phase != Phase::Error {
                    return Err(no_number(variable, self.time()));
                }
                Ok(value)
            }
            _ => variable.real(&self.run.settings).ok_or_else(|| variable.wrong_type(Type::Real)),
        }
    }

    /// Sets time derivatives of inputs, of `orders` from 1 on, for the next step: all, or none if any is refused. After
    /// that step the inputs keep the value they reached.
    pub fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Result<(), Refusal> {
        let each = |((reference, order), value): ((&u32, &i32), &f64)| {
            let variable = self.variable(*reference)?;
            Ok((variable, variable.check_input_derivative(*order, *value)?, *value))
        };
        let checked = references.iter().zip(orders).zip(values).map(each).collect::<Result<Vec<_>, Refusal>>()?;
        let run = &mut self.run;
        let balls = run.settings.balls();
        let mut derivatives = std::mem::take(&mut run.input_derivatives);
        for (variable, order, value) in checked {
            derivatives.resize_with(order.max(derivatives.len()), || Inputs::zero(balls));
            variable.set_input(&mut derivatives[order - 1], value);
        }
        while derivatives.pop_if(|derivative| *derivative == Inputs::zero(balls)).is_some() {}
        run.inputs_changed |= !derivatives.is_empty();
        run.input_derivatives = derivatives;
        Ok(())
    }

    /// Sets variables to checked values. They take effect with the next step, in Initialization Mode and model exchange
    /// at once. Setting the same value again is no change.
    pub(super) fn set<T>(&mut self, values: Vec<(Variable, T)>, set: impl Fn(&Variable, &mut Settings, T) -> bool) {
        let before = self.run.settings.parameters.tunables();
        let mut any = false;
        for (variable, value) in values {
            // The engine knows neither slopes nor `derivatives.of`, which only FMI 3.0 has: they are read when they are
            // used.
            if set(&variable, &mut self.run.settings, value) && variable.position < TABLE.len() {
                self.changed(variable, before);
                any = true;
            }
        }
        if any
            && self.run.phase > Phase::InitializationMode
            && let Some(exchange) = &mut self.run.exchange
        {
            let Settings { parameters, inputs, .. } = &self.run.settings;
            exchange.set(parameters, inputs);
        }
    }

    #[inline]
    pub(super) fn variable(&self, reference: u32) -> Result<Variable, Refusal> {
        let balls = self.balls();
        Variable::at(reference, balls).ok_or_else(|| unknown_reference(reference, balls))
    }

    /// Whether a variable can be set now.
    pub(super) fn check_settable(&self, variable: Variable) -> Result<(), Refusal> {
        let phase = self.run.phase;
        variable.check_settable(phase > Phase::InitializationMode)?;
        if phase == Phase::ContinuousTimeMode && variable.row.causality != Causality::Input {
            let text = "cannot be set in Continuous-Time Mode: only inputs can; tunable parameters in Event Mode";
            return Err(Refusal::new(format_args!("{variable} {text}")));
        }
        Ok(())
    }

    /// Marks a setting to be passed to the simulation; `before` are the tunable parameters before the call.
    fn changed(&mut self, variable: Variable, before: Tunables) {
        if self.run.phase <= Phase::InitializationMode {
            (self.run.simulation, self.run.exchange) = (None, None);
        } else if self.run.purpose.kind == Kind::ModelExchange {
            // There it acts at once.
        } else if variable.row.variability == Variability::Tunable {
            self.run.tuned_from.get_or_insert(before);
        } else {
            self.run.inputs_changed = true;
        }
    }
}

#[cold]
pub(super) fn unknown_reference(reference: u32, balls: usize) -> Refusal {
    Refusal::unknown(format_args!("value reference {reference}"), balls)
}

#[cold]
fn no_number(variable: Variable, time: f64) -> Refusal {
    let why = "what it is calculated from is beyond the range of doubles";
    Refusal::no_value(format_args!("{variable} has no value at t = {} s: {why}", Number(time)))
}
