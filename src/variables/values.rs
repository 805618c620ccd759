//! Reading, checking and changing settings by variable.

use std::fmt::Display;

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
            variable.set_real(&mut zero, 0.0);
        }
        zero
    }

    /// Whether they are settings of `balls` balls with allowed values only.
    pub fn are_sound(&self, balls: usize) -> bool {
        let fits = |array: &Variable| match array.row.access {
            Access::Setting { get, .. } => get(self).len() == array.row.shape.len(balls),
            _ => true,
        };
        let allowed = |variable: Variable| variable.real(self).is_none_or(|value| variable.check_real(value).is_ok());
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

    /// Whether `value` is finite and in range.
    pub fn check_real(&self, value: f64) -> Result<(), Refusal> {
        if self.row.range.contains(value) {
            return Ok(());
        }
        let quantified = |value: &dyn Display| self.row.quantified(value);
        Err(Refusal::value(self, quantified(&Number(value)), quantified(&self.row.range)))
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

    /// Whether `value` is the integer of an item.
    pub fn check_item(&self, value: i64) -> Result<(), Refusal> {
        let item = i32::try_from(value).ok();
        match self.row.access {
            Access::Enumeration(enumeration) if item.and_then(|item| enumeration.item(item)).is_none() => {
                Err(Refusal::value(self, value, enumeration))
            }
            _ => Ok(()),
        }
    }

    /// The error for a getter or setter of the wrong type.
    pub fn wrong_type(&self, asked: Type) -> Refusal {
        let actual = self.row.access.data_type();
        Refusal::new(format_args!("{self} is of type {actual:?}, not {asked:?}"))
    }

    /// The value of a real parameter, input, slope or calculated parameter; otherwise none.
    #[inline]
    pub fn real(&self, settings: &Settings) -> Option<f64> {
        match self.row.access {
            Access::Setting { get, .. } => get(settings).get(self.index).copied(),
            Access::Calculated(get) => Some(get(&settings.parameters)),
            _ => None,
        }
    }

    /// The integer of an enumeration; otherwise none.
    pub fn item(&self, settings: &Settings) -> Option<i32> {
        match self.row.access {
            Access::Enumeration(enumeration) => Some((enumeration.get)(settings)),
            _ => None,
        }
    }

    /// The value of a setting without its unit, an item by its name; otherwise none.
    pub fn text(&self, settings: &Settings) -> Option<String> {
        match self.row.access {
            Access::Enumeration(of) => of.item((of.get)(settings)).map(|item| item.name.to_owned()),
            _ => self.real(settings).map(|value| Number(value).to_string()),
        }
    }

    /// Sets a real parameter, input or slope to a checked value. Returns whether it changed.
    pub fn set_real(&self, settings: &mut Settings, value: f64) -> bool {
        let Access::Setting { set, .. } = self.row.access else { return false };
        set(settings).get_mut(self.index).is_some_and(|slot| std::mem::replace(slot, value) != value)
    }

    /// Sets the derivative of an input, of the order that `inputs` holds, to a checked value.
    pub fn set_input(&self, inputs: &mut Inputs, value: f64) {
        match self.row.shape {
            Shape::Scalar => inputs.support_acceleration = value,
            _ => inputs.force[self.index] = value,
        }
    }

    /// Selects a checked item. Returns whether it changed.
    pub fn set_item(&self, settings: &mut Settings, value: i32) -> bool {
        let Access::Enumeration(enumeration) = self.row.access else { return false };
        let before = (enumeration.get)(settings);
        (enumeration.set)(settings, value);
        before != (enumeration.get)(settings)
    }
}
