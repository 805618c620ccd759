//! Reading, checking and changing settings by variable.

use super::refusal::Refusal;
use super::settings::Settings;
use super::table::range::ANY;
use super::table::row::{Access, Causality, Shape, Type, Variability};
use super::text::Number;
use super::variable::{Variable, variables};
use crate::model::{Inputs, MAX_INPUT_DERIVATIVE};

impl Settings {
    /// The zero direction: every real setting is zero.
    pub fn zero(balls: usize) -> Self {
        let mut zero = Self::default_for(balls);
        for variable in variables(balls) {
            variable.set(&mut zero, 0.0); // No item of an enumeration is 0.
        }
        zero
    }

    /// Whether they are settings of `balls` balls with allowed values only.
    pub fn are_sound(&self, balls: usize) -> bool {
        let fits = |array: &Variable| match array.row.access {
            Access::Setting { get, .. } => get(self).len() == array.row.shape.len(balls),
            _ => true,
        };
        let allowed = |variable: Variable| variable.value(self).is_none_or(|value| variable.check(value).is_ok());
        let mut settable = Variable::arrays().filter(|array| array.row.settable());
        settable.all(|array| fits(&array) && array.scalars(balls).all(allowed))
    }
}

impl Variable {
    /// Checks that a host may set it; `between_steps` after initialization.
    pub fn check_settable(&self, between_steps: bool) -> Result<(), Refusal> {
        if !self.row.settable() {
            return Err(self.row.not_settable(self));
        }
        if between_steps && self.row.causality != Causality::Input && self.row.variability != Variability::Tunable {
            let text = "cannot be set after initialization: only inputs and tunable parameters can";
            return Err(Refusal::new(format_args!("{self} {text}")));
        }
        Ok(())
    }

    /// Whether `value` is finite and in range, of an enumeration whether it is the integer of an item.
    pub fn check(&self, value: f64) -> Result<(), Refusal> {
        let row = self.row;
        match row.access {
            Access::Enumeration(enumeration) if enumeration.item(value).is_some() => Ok(()),
            Access::Enumeration(enumeration) => Err(Refusal::value(self, value, enumeration)),
            _ if row.range.contains(value) => Ok(()),
            _ if row.access.data_type() == Type::Integer => Err(Refusal::value(self, value, row.range)),
            _ => Err(Refusal::value(self, row.quantified(Number(value)), row.quantified(row.range))),
        }
    }

    /// Checks that it is an input whose time derivative of this order (1/s^order times its unit) may be `value`.
    /// Returns the order.
    pub fn check_input_derivative(&self, order: i32, value: f64) -> Result<usize, Refusal> {
        if self.row.causality != Causality::Input {
            return Err(Refusal::new(format_args!(
                "no derivative of {self} can be set: only those of inputs can, and its causality is {:?}",
                self.row.causality
            )));
        }
        let known = usize::try_from(order).ok().filter(|order| (1..=MAX_INPUT_DERIVATIVE).contains(order));
        let known = known.ok_or_else(|| self.no_such_order(order, MAX_INPUT_DERIVATIVE))?;
        if !value.is_finite() {
            return Err(Refusal::value(format_args!("derivative {order} of {self}"), Number(value), ANY));
        }
        Ok(known)
    }

    /// The error for an `order` outside 1 to `most`.
    pub(crate) fn no_such_order(&self, order: i32, most: usize) -> Refusal {
        Refusal::value(format_args!("order of the derivative of {self}"), order, format_args!("1 to {most}"))
    }

    /// The error for a getter or setter of the wrong type.
    pub fn wrong_type(&self, asked: Type) -> Refusal {
        let actual = self.row.access.data_type();
        Refusal::new(format_args!("{self} is of type {actual:?}, not {asked:?}"))
    }

    /// The value of a parameter, input or slope, of an enumeration the integer of its item; otherwise none.
    #[inline]
    pub fn value(&self, settings: &Settings) -> Option<f64> {
        match self.row.access {
            Access::Setting { get, .. } => get(settings).get(self.index).copied(),
            Access::Calculated(get) => Some(get(&settings.parameters)),
            Access::Enumeration(enumeration) => Some((enumeration.get)(settings).into()),
            _ => None,
        }
    }

    /// The value of a setting without its unit, an item by its name; otherwise none.
    pub fn text(&self, settings: &Settings) -> Option<String> {
        let value = self.value(settings)?;
        match self.row.access {
            Access::Enumeration(of) => of.item(value).map(|item| item.name.to_owned()),
            _ => Some(Number(value).to_string()),
        }
    }

    /// Sets a parameter, input or slope to a checked value. Returns whether it changed.
    pub fn set(&self, settings: &mut Settings, value: f64) -> bool {
        match self.row.access {
            Access::Setting { set, .. } => {
                set(settings).get_mut(self.index).is_some_and(|slot| std::mem::replace(slot, value) != value)
            }
            Access::Enumeration(enumeration) => {
                let before = (enumeration.get)(settings);
                (enumeration.set)(settings, value as i32);
                before != (enumeration.get)(settings)
            }
            _ => false,
        }
    }

    /// Sets the derivative of an input, of the order that `inputs` holds, to a checked value.
    pub fn set_input(&self, inputs: &mut Inputs, value: f64) {
        match self.row.shape {
            Shape::Scalar => inputs.support_acceleration = value,
            _ => inputs.force[self.index] = value,
        }
    }
}
