//! Reading and setting variables by value reference.

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

    /// Reads an integer or an enumeration; counts that do not fit are `i32::MAX`.
    pub fn integer(&mut self, reference: u32) -> Result<i32, Refusal> {
        let variable = self.variable(reference)?;
        match variable.row.access {
            Access::Count(get) => Ok(i32::try_from(get(self.results()?, variable.index)).unwrap_or(i32::MAX)),
            _ => variable.item(&self.run.settings).ok_or_else(|| variable.wrong_type(Type::Integer)),
        }
    }

    pub fn boolean(&mut self, reference: u32) -> Result<bool, Refusal> {
        let variable = self.variable(reference)?;
        match variable.row.access {
            Access::Flag(get) => Ok(get(self.results()?, variable.index)),
            _ => Err(variable.wrong_type(Type::Boolean)),
        }
    }

    /// Sets real variables: all, or none if any is refused.
    ///
    /// A value takes effect with the next step, in Initialization Mode and model exchange at once. Setting the same
    /// value again is no change.
    pub fn set_reals(&mut self, references: &[u32], values: &[f64]) -> Result<(), Refusal> {
        let checked = self.checked(references, values, Type::Real, |variable, value| variable.check_real(value))?;
        self.set(checked, Variable::set_real);
        Ok(())
    }

    /// Sets time derivatives of inputs, of `orders` from 1 on, for the next step: all, or none if any is refused. After
    /// that step the inputs keep the value they reached.
    pub fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Result<(), Refusal> {
        let given = || references.iter().zip(orders).zip(values);
        for ((reference, order), value) in given() {
            self.variable(*reference)?.check_input_derivative(*order, *value)?;
        }
        let run = &mut self.run;
        let balls = run.settings.balls();
        let mut derivatives = std::mem::take(&mut run.input_derivatives);
        for ((reference, order), value) in given() {
            let order = usize::try_from(*order).unwrap_or_default();
            if derivatives.len() < order {
                derivatives.resize(order, Inputs::zero(balls));
            }
            if let (Some(variable), Some(inputs)) = (Variable::at(*reference, balls), derivatives.get_mut(order - 1)) {
                variable.set_input(inputs, *value);
            }
        }
        while derivatives.pop_if(|derivative| *derivative == Inputs::zero(balls)).is_some() {}
        run.inputs_changed |= !derivatives.is_empty();
        run.input_derivatives = derivatives;
        Ok(())
    }

    /// Sets enumerations: all, or none if any is refused.
    pub fn set_integers(&mut self, references: &[u32], values: &[i32]) -> Result<(), Refusal> {
        let check = |variable: &Variable, item: i32| variable.check_item(item.into());
        let checked = self.checked(references, values, Type::Integer, check)?;
        self.set(checked, Variable::set_item);
        Ok(())
    }

    /// The variables behind `references` with the values for them, if all of these can be set as values of type `asked`
    /// and pass the `check`.
    fn checked<T: Copy>(
        &self,
        references: &[u32],
        values: &[T],
        asked: Type,
        check: impl Fn(&Variable, T) -> Result<(), Refusal>,
    ) -> Result<Vec<(Variable, T)>, Refusal> {
        let each = |(reference, value): (&u32, &T)| {
            let variable = self.variable(*reference)?;
            self.check_settable(variable, asked)?;
            check(&variable, *value)?;
            Ok((variable, *value))
        };
        references.iter().zip(values).map(each).collect()
    }

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

    /// Error for a type without settable variables.
    pub fn refuse_to_set(&self, references: &[u32], asked: Type) -> Result<(), Refusal> {
        references.iter().try_for_each(|reference| self.check_settable(self.variable(*reference)?, asked))
    }

    /// Error for reading a string; there are none.
    pub fn refuse_string(&self, reference: u32) -> Refusal {
        self.variable(reference).map_or_else(|refusal| refusal, |variable| variable.wrong_type(Type::String))
    }

    #[inline]
    pub(super) fn variable(&self, reference: u32) -> Result<Variable, Refusal> {
        let balls = self.balls();
        Variable::at(reference, balls).ok_or_else(|| unknown_reference(reference, balls))
    }

    /// Whether a variable can be set now as a value of type `asked`.
    pub(super) fn check_settable(&self, variable: Variable, asked: Type) -> Result<(), Refusal> {
        let phase = self.run.phase;
        variable.check_settable(asked, phase > Phase::InitializationMode)?;
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
