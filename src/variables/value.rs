//! Values behind the table: what may be set, and setting it.

use serde::{Deserialize, Serialize};
use std::fmt::Write;

use super::row::{ANY, Access, Causality, Type};
use super::text::Number;
use super::{TABLE, Variable, variables};
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

/// A value that is not accepted, and what would be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refused {
    /// No variable has this value reference.
    UnknownReference { reference: u32, balls: usize },
    /// No variable has this name.
    UnknownName { name: String, balls: usize },
    /// The variable has another type.
    WrongType { variable: String, actual: Type, asked: Type },
    /// The variable cannot be set at all.
    NotSettable { variable: String, causality: Causality },
    /// Derivatives can only be given for inputs.
    NotInput { variable: String, causality: Causality },
    /// The variable has no derivative of the kind asked for.
    NotDifferentiable { variable: String, allowed: &'static str },
    /// The variable cannot be set any more.
    Fixed { variable: String },
    /// The value is outside of what is allowed.
    NotAllowed { variable: String, value: String, allowed: String },
}

impl std::fmt::Display for Refused {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::UnknownReference { reference, balls } => {
                write!(f, "no variable has the value reference {reference} in this FMU of {balls} ball(s)")
            }
            Self::UnknownName { name, balls } => {
                write!(f, "no variable has the name \"{name}\" in this FMU of {balls} ball(s)")
            }
            Self::WrongType { variable, actual, asked } => {
                write!(f, "{variable} is of type {actual:?}, not {asked:?}")
            }
            Self::NotSettable { variable, causality } => {
                write!(
                    f,
                    "{variable} cannot be set: only parameters and inputs can, and it is of causality {causality:?}"
                )
            }
            Self::NotInput { variable, causality } => {
                write!(
                    f,
                    "{variable} can have no derivative set: only inputs can, and it is of causality {causality:?}"
                )
            }
            Self::NotDifferentiable { variable, allowed } => {
                write!(f, "{variable} has no such derivative; allowed: {allowed}")
            }
            Self::Fixed { variable } => {
                write!(f, "{variable} cannot be set after initialization: only inputs and tunable parameters can")
            }
            Self::NotAllowed { variable, value, allowed } => {
                write!(f, "{variable} = {value} is refused; allowed: {allowed}")
            }
        }
    }
}

impl std::error::Error for Refused {}

impl Variable {
    /// Whether a host may set it as a value of type `asked`; `between_steps` when initialization is over.
    pub fn check_settable(&self, asked: Type, between_steps: bool) -> Result<(), Refused> {
        if !self.is_of(asked) {
            return Err(self.wrong_type(asked));
        }
        if !self.row.settable() {
            return Err(Refused::NotSettable { variable: self.to_string(), causality: self.row.causality });
        }
        if between_steps && !self.row.settable_between_steps() {
            return Err(Refused::Fixed { variable: self.to_string() });
        }
        Ok(())
    }

    /// Whether `value` is finite and in range.
    pub fn check_real(&self, value: f64) -> Result<(), Refused> {
        if self.row.range.contains(value) {
            return Ok(());
        }
        Err(Refused::NotAllowed {
            variable: self.to_string(),
            value: self.row.quantified(Number(value)),
            allowed: self.row.quantified(self.row.range),
        })
    }

    /// Whether it is an input, and its derivative by time of this order (1/s^order times its unit) may be `value`.
    pub fn check_input_derivative(&self, order: i32, value: f64) -> Result<(), Refused> {
        if !matches!(self.row.access, Access::Input { .. }) {
            return Err(Refused::NotInput { variable: self.to_string(), causality: self.row.causality });
        }
        let refused = |variable, value, allowed| Err(Refused::NotAllowed { variable, value, allowed });
        if !usize::try_from(order).is_ok_and(|order| (1..=MAX_INPUT_DERIVATIVE).contains(&order)) {
            return refused(
                format!("order of the derivative of {self}"),
                order.to_string(),
                format!("1 to {MAX_INPUT_DERIVATIVE}"),
            );
        }
        if !value.is_finite() {
            return refused(format!("derivative {order} of {self}"), Number(value).to_string(), ANY.to_string());
        }
        Ok(())
    }

    /// Whether `value` is the integer of an item.
    pub fn check_item(&self, value: i32) -> Result<(), Refused> {
        match self.row.access {
            Access::Choice(choice) if choice.item(value).is_none() => Err(Refused::NotAllowed {
                variable: self.to_string(),
                value: value.to_string(),
                allowed: choice.to_string(),
            }),
            _ => Ok(()),
        }
    }

    /// The error for a getter or setter of the wrong type.
    pub fn wrong_type(&self, asked: Type) -> Refused {
        Refused::WrongType { variable: self.to_string(), actual: self.row.access.data_type(), asked }
    }

    fn is_of(&self, asked: Type) -> bool {
        match self.row.access.data_type() {
            Type::Enumeration => asked == Type::Integer,
            actual => actual == asked,
        }
    }

    /// A real parameter, input or derived parameter; nothing for anything else.
    #[inline]
    pub fn real(&self, settings: &Settings) -> Option<f64> {
        match self.row.access {
            Access::Parameter { get, .. } => get(&settings.parameters).get(self.index).copied(),
            Access::Input { get, .. } => get(&settings.inputs).get(self.index).copied(),
            Access::Derived(get) => Some(get(&settings.parameters)),
            _ => None,
        }
    }

    /// The integer of a choice; nothing for anything else.
    pub fn item(&self, settings: &Settings) -> Option<i32> {
        match self.row.access {
            Access::Choice(choice) => Some((choice.get)(&settings.parameters)),
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
        let Access::Choice(choice) = self.row.access else { return false };
        let before = (choice.get)(&settings.parameters);
        (choice.set)(&mut settings.parameters, value);
        before != (choice.get)(&settings.parameters)
    }

    /// Writes the description with the index filled in, and what the attributes of the description cannot say.
    pub fn describe(&self, out: &mut impl Write) -> std::fmt::Result {
        let mut pieces = self.row.description.split('{');
        out.write_str(pieces.next().unwrap_or_default())?;
        for piece in pieces {
            match (piece.strip_prefix("i}"), piece.strip_prefix("j}")) {
                (Some(rest), _) => write!(out, "{}{rest}", self.index + 1)?,
                (_, Some(rest)) => write!(out, "{}{rest}", self.index + 2)?,
                _ => write!(out, "{{{piece}")?,
            }
        }
        if self.row.range.above_min && self.row.settable() { out.write_str("; 0 itself is refused") } else { Ok(()) }
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
                continue; // Choices are tested with their items.
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
        let exponent = Variable::named("contact.exponent", 5).unwrap();
        assert_eq!(
            exponent.check_real(0.5).unwrap_err().to_string(),
            "contact.exponent = 0.5 is refused; allowed: 1 to 10"
        );
    }
}
