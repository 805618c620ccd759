//! Reading and setting variables by value reference.

use crate::instance::legality::{Kind, Phase};
use crate::instance::lifecycle::Instance;
use crate::instance::refusal::Refusal;
use crate::model::{Inputs, Tunables};
use crate::variables::{Access, Causality, Settings, Type, Variability, Variable, VariableError};

impl Instance {
    /// Reads a real variable.
    #[inline]
    pub fn real(&mut self, reference: u32) -> Result<f64, Refusal> {
        let variable = self.variable(reference)?;
        match variable.row.access {
            Access::Real(get) => {
                let value = get(self.results()?, variable.index);
                // In the error state values may be anything.
                if value.is_nan() && self.run.phase != Phase::Error {
                    return Err(Refusal::NotANumber { variable: variable.to_string(), time: self.time() });
                }
                Ok(value)
            }
            _ => variable.real(&self.run.settings).ok_or_else(|| variable.wrong_type(Type::Real).into()),
        }
    }

    /// Reads an integer or an enumeration; counts that do not fit are `i32::MAX`.
    pub fn integer(&mut self, reference: u32) -> Result<i32, Refusal> {
        let variable = self.variable(reference)?;
        match variable.row.access {
            Access::Count(get) => Ok(i32::try_from(get(self.results()?, variable.index)).unwrap_or(i32::MAX)),
            _ => variable.item(&self.run.settings).ok_or_else(|| variable.wrong_type(Type::Integer).into()),
        }
    }

    /// Reads a boolean.
    pub fn boolean(&mut self, reference: u32) -> Result<bool, Refusal> {
        let variable = self.variable(reference)?;
        match variable.row.access {
            Access::Flag(get) => Ok(get(self.results()?, variable.index)),
            _ => Err(variable.wrong_type(Type::Boolean).into()),
        }
    }

    /// Sets real variables: all of them, or none if any of it is refused.
    ///
    /// A value takes effect with the next step (in Initialization Mode and in model exchange: at once). Setting what is
    /// set already is no change.
    pub fn set_reals(&mut self, references: &[u32], values: &[f64]) -> Result<(), Refusal> {
        self.set(references, values, Type::Real, Variable::check_real, Variable::set_real)
    }

    /// Gives derivatives of inputs by time, `orders` from the first on, for the next step: all of them, or none if any
    /// of it is refused. After that step the inputs stay at the value they reached.
    pub fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Result<(), Refusal> {
        for ((reference, order), value) in references.iter().zip(orders).zip(values) {
            self.variable(*reference)?.check_input_derivative(*order, *value)?;
        }
        let run = &mut self.run;
        let balls = run.settings.balls();
        let mut derivatives = std::mem::take(&mut run.input_derivatives);
        for ((reference, order), value) in references.iter().zip(orders).zip(values) {
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

    /// Sets enumerations: all of them, or none if any of it is refused.
    pub fn set_integers<T: Copy + Into<i64>>(&mut self, references: &[u32], values: &[T]) -> Result<(), Refusal> {
        let check = |variable: &Variable, item: T| variable.check_item(item.into());
        let set = |variable: &Variable, settings: &mut Settings, item: T| {
            i32::try_from(item.into()).is_ok_and(|item| variable.set_item(settings, item))
        };
        self.set(references, values, Type::Integer, check, set)
    }

    /// Sets variables of type `asked` to values that pass the `check`: all of them, or none.
    fn set<T: Copy>(
        &mut self,
        references: &[u32],
        values: &[T],
        asked: Type,
        check: impl Fn(&Variable, T) -> Result<(), VariableError>,
        set: impl Fn(&Variable, &mut Settings, T) -> bool,
    ) -> Result<(), Refusal> {
        for (reference, value) in references.iter().zip(values) {
            check(&self.settable(*reference, asked)?, *value)?;
        }
        let before = self.run.settings.parameters.tunables();
        let mut any = false;
        for (reference, value) in references.iter().zip(values) {
            let variable = self.variable(*reference)?;
            if set(&variable, &mut self.run.settings, *value) {
                self.changed(variable, before);
                any = true;
            }
        }
        if any
            && self.run.phase > Phase::InitializationMode
            && let Some(exchange) = &mut self.run.exchange
        {
            let Settings { parameters, inputs } = &self.run.settings;
            exchange.set(parameters, inputs);
        }
        Ok(())
    }

    /// Says why variables cannot be set as values of type `asked`, of which the interface has none that are settable.
    pub fn refuse_to_set(&mut self, references: &[u32], asked: Type) -> Result<(), Refusal> {
        references.iter().try_for_each(|reference| self.settable(*reference, asked).map(|_| ()))
    }

    /// Says why a variable cannot be read as a string: there are none.
    pub fn refuse_string(&self, reference: u32) -> Refusal {
        self.variable(reference).map_or_else(|refusal| refusal, |variable| variable.wrong_type(Type::String).into())
    }

    #[inline]
    pub(super) fn variable(&self, reference: u32) -> Result<Variable, Refusal> {
        let balls = self.balls();
        Variable::at(reference, balls).ok_or_else(|| VariableError::UnknownReference { reference, balls }.into())
    }

    pub(in crate::instance) fn settable(&self, reference: u32, asked: Type) -> Result<Variable, Refusal> {
        let variable = self.variable(reference)?;
        let phase = self.run.phase;
        variable.check_settable(asked, phase > Phase::InitializationMode)?;
        if phase == Phase::ContinuousTimeMode && variable.row.causality != Causality::Input {
            return Err(VariableError::NotContinuous { variable: variable.to_string() }.into());
        }
        Ok(variable)
    }

    /// Remembers that the simulation does not know of a setting yet; `before` are the tunable parameters before the
    /// call.
    fn changed(&mut self, variable: Variable, before: Tunables) {
        if self.run.phase <= Phase::InitializationMode {
            (self.run.simulation, self.run.exchange) = (None, None);
        } else if self.run.kind == Kind::ModelExchange {
            // It is told at once.
        } else if variable.row.variability == Variability::Tunable {
            self.run.tuned_from.get_or_insert(before);
        } else {
            self.run.inputs_changed = true;
        }
    }
}
