//! What a host has set: the values of parameters and inputs, what is allowed for them, and setting them by variable.

use std::fmt::Display;

use serde::{Deserialize, Serialize};

use super::error::VariableError;
use super::table::TABLE;
use super::table::row::{ANY, Access, Causality, Type, Variability};
use super::text::Number;
use super::variable::{Variable, variables};
use crate::model::{Inputs, MAX_INPUT_DERIVATIVE, Parameters};

/// Everything a host can set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Parameters of the cradle.
    pub parameters: Parameters,
    /// Inputs as last set.
    pub inputs: Inputs,
}

impl Settings {
    /// The defaults for `balls` balls.
    pub fn default_for(balls: usize) -> Self {
        Self { parameters: Parameters::default_for(balls), inputs: Inputs::zero(balls) }
    }

    /// Number of balls n.
    pub fn balls(&self) -> usize {
        self.parameters.balls()
    }

    /// No direction at all: every real setting is zero.
    pub fn zero(balls: usize) -> Self {
        let mut zero = Self::default_for(balls);
        for variable in variables(balls) {
            variable.set_real(&mut zero, 0.0);
        }
        zero
    }

    /// Whether they are settings of `balls` balls and every value is one that may be set.
    pub fn are_sound(&self, balls: usize) -> bool {
        let fits = TABLE.iter().all(|row| match row.access {
            Access::Parameter { get, .. } => get(&self.parameters).len() == row.shape.len(balls),
            Access::Input { get, .. } => get(&self.inputs).len() == row.shape.len(balls),
            _ => true,
        });
        let allowed = |variable: Variable| variable.real(self).is_none_or(|value| variable.check_real(value).is_ok());
        fits && variables(balls).filter(|variable| variable.row.settable()).all(allowed)
    }
}

impl Variable {
    /// Whether a host may set it as a value of type `asked`; `between_steps` when initialization is over.
    pub fn check_settable(&self, asked: Type, between_steps: bool) -> Result<(), VariableError> {
        let actual = match self.row.access.data_type() {
            Type::Enumeration => Type::Integer,
            other => other,
        };
        if asked != actual {
            return Err(self.wrong_type(asked));
        }
        if !self.row.settable() {
            return Err(VariableError::NotSettable { variable: self.to_string(), causality: self.row.causality });
        }
        if between_steps && self.row.causality != Causality::Input && self.row.variability != Variability::Tunable {
            return Err(VariableError::Fixed { variable: self.to_string() });
        }
        Ok(())
    }

    /// Whether `value` is finite and in range.
    pub fn check_real(&self, value: f64) -> Result<(), VariableError> {
        if self.row.range.contains(value) {
            return Ok(());
        }
        let quantified = |value: &dyn Display| self.row.quantified(value);
        Err(VariableError::not_allowed(self, quantified(&Number(value)), quantified(&self.row.range)))
    }

    /// Whether it is an input, and its derivative by time of this order (1/s^order times its unit) may be `value`.
    pub fn check_input_derivative(&self, order: i32, value: f64) -> Result<(), VariableError> {
        if !matches!(self.row.access, Access::Input { .. }) {
            return Err(VariableError::NotInput { variable: self.to_string(), causality: self.row.causality });
        }
        if !usize::try_from(order).is_ok_and(|order| (1..=MAX_INPUT_DERIVATIVE).contains(&order)) {
            return Err(self.no_such_order(order, MAX_INPUT_DERIVATIVE));
        }
        if !value.is_finite() {
            return Err(VariableError::not_allowed(format_args!("derivative {order} of {self}"), Number(value), ANY));
        }
        Ok(())
    }

    /// The error for a derivative of an `order` that is not one of 1 to `most`.
    pub(crate) fn no_such_order(&self, order: i32, most: usize) -> VariableError {
        let what = format_args!("order of the derivative of {self}");
        VariableError::not_allowed(what, order, format_args!("1 to {most}"))
    }

    /// Whether `value` is the integer of an item.
    pub fn check_item(&self, value: impl Into<i64>) -> Result<(), VariableError> {
        let value: i64 = value.into();
        let item = i32::try_from(value).ok();
        match self.row.access {
            Access::Enumeration(enumeration) if item.and_then(|item| enumeration.item(item)).is_none() => {
                Err(VariableError::not_allowed(self, value, enumeration))
            }
            _ => Ok(()),
        }
    }

    /// The error for a getter or setter of the wrong type.
    pub fn wrong_type(&self, asked: Type) -> VariableError {
        VariableError::WrongType { variable: self.to_string(), actual: self.row.access.data_type(), asked }
    }

    /// A real parameter, input or calculated parameter; nothing for anything else.
    #[inline]
    pub fn real(&self, settings: &Settings) -> Option<f64> {
        match self.row.access {
            Access::Parameter { get, .. } => get(&settings.parameters).get(self.index).copied(),
            Access::Input { get, .. } => get(&settings.inputs).get(self.index).copied(),
            Access::Calculated(get) => Some(get(&settings.parameters)),
            _ => None,
        }
    }

    /// The integer of an enumeration; nothing for anything else.
    pub fn item(&self, settings: &Settings) -> Option<i32> {
        match self.row.access {
            Access::Enumeration(enumeration) => Some((enumeration.get)(&settings.parameters)),
            _ => None,
        }
    }

    /// Sets a real parameter or input to a value that was checked. Says whether that changed anything.
    pub fn set_real(&self, settings: &mut Settings, value: f64) -> bool {
        let slot = match self.row.access {
            Access::Parameter { set, .. } => set(&mut settings.parameters).get_mut(self.index),
            Access::Input { set, .. } => set(&mut settings.inputs).get_mut(self.index),
            _ => None,
        };
        slot.is_some_and(|slot| std::mem::replace(slot, value) != value)
    }

    /// Sets an input, or its derivative of the order that `inputs` holds, to a value that was checked.
    pub fn set_input(&self, inputs: &mut Inputs, value: f64) {
        if let Access::Input { set, .. } = self.row.access
            && let Some(slot) = set(inputs).get_mut(self.index)
        {
            *slot = value;
        }
    }

    /// Selects an item that was checked. Says whether that changed anything.
    pub fn set_item(&self, settings: &mut Settings, value: i32) -> bool {
        let Access::Enumeration(enumeration) = self.row.access else { return false };
        let before = (enumeration.get)(&settings.parameters);
        (enumeration.set)(&mut settings.parameters, value);
        before != (enumeration.get)(&settings.parameters)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_default_is_allowed() {
        for balls in [1, 2, 5, 100] {
            let settings = Settings::default_for(balls);
            for variable in variables(balls).filter(|variable| variable.row.settable()) {
                if let Some(value) = variable.real(&settings) {
                    variable.check_real(value).unwrap();
                } else {
                    variable.check_item(variable.item(&settings).unwrap()).unwrap();
                }
            }
        }
    }

    #[test]
    fn every_settable_variable_can_be_set_and_read_back_alone() {
        for variable in variables(3).filter(|variable| variable.row.settable()) {
            let mut settings = Settings::default_for(3);
            if variable.row.access.data_type() != Type::Real {
                continue; // Enumerations are tested with their items.
            }
            // The upper limit where there is one, but not the default.
            let max = variable.row.range.max.filter(|max| variable.real(&settings) != Some(*max));
            let value = max.unwrap_or(0.123);
            assert!(variable.set_real(&mut settings, value), "{variable}");
            assert!(!variable.set_real(&mut settings, value), "{variable}");
            assert_eq!(variable.real(&settings), Some(value));
            let changed =
                variables(3).filter(|v| v.row.settable() && v.real(&settings) != v.real(&Settings::default_for(3)));
            assert_eq!(changed.count(), 1, "{variable}");
        }
    }

    #[test]
    fn limits_are_refused_by_name() {
        let mass = Variable::named("ball.mass", 5).unwrap();
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY, -f64::INFINITY] {
            let text = mass.check_real(value).unwrap_err().to_string();
            assert!(text.starts_with("ball.mass = ") && text.contains("allowed: finite and > 0 kg"), "{text}");
        }
        let text = Variable::named("contact.exponent", 5).unwrap().check_real(0.5).unwrap_err().to_string();
        assert_eq!(text, "contact.exponent = 0.5 is refused; allowed: 1 to 10");
    }
}
