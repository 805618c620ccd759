//! A variable of the interface: found by name or value reference, listed in the order of the description; its value in
//! the settings read, checked and changed.
//!
//! The value reference of a scalar is the row's position times 16384 plus the zero-based index, so that it does not
//! depend on n and a getter finds its row by one array access. FMI 3.0 has an array for each row that has an index,
//! with a value reference of its own. Arrays over contacts have `n` elements, too, since n - 1 cannot be a
//! dimension: the last element belongs to no contact. For hosts without arrays, each element is a scalar with the name
//! and the value reference of FMI 2.0.

use super::settings::{MAX_BALLS, Settings};
use super::table::TABLE;
use super::table::extra::{BEFORE, EXTRA, INTERMEDIATE, STATES};
use super::table::row::{ANY, Access, Causality, Extra, Row, Shape, Type, Variability};
use super::table::types::Enumeration;
use super::text::{Refusal, ensure};
use crate::model::{Inputs, MAX_INPUT_DERIVATIVE};
use crate::number::Number;

const INDEX_BITS: u32 = 14;
const INDEX_MASK: u32 = (1 << INDEX_BITS) - 1;
const _: () = assert!(MAX_BALLS <= 1 << INDEX_BITS);

/// Row of the table without a variable in FMI 3.0: a Boolean that changes between events.
const LEFT_OUT: &str = "t_next_isOnset";
/// Value reference of the array of the first row.
const ARRAYS: u32 = 32;

/// A scalar, as all variables of FMI 2.0 are, or a variable of FMI 3.0, which may be an array.
#[derive(Clone, Copy)]
pub struct Variable {
    /// Its row.
    pub row: &'static Row,
    /// Position of its row in [`TABLE`]; behind these, among the rows that only FMI 3.0 has.
    pub position: usize,
    /// Zero-based ball or contact; 0 for scalars without one and for arrays.
    pub index: usize,
    /// Whether it stands for its whole row, under the name and the value reference that FMI 3.0 with arrays has.
    pub whole: bool,
}

impl Variable {
    /// The scalar behind a value reference of FMI 2.0 in a cradle of `balls` balls.
    #[inline]
    pub fn at(reference: u32, balls: usize) -> Option<Self> {
        let (position, index) = place(reference);
        let row = TABLE.get(position)?;
        (index < row.shape.len(balls)).then_some(Self { row, position, index, whole: false })
    }

    /// The scalar behind a value reference of FMI 3.0 without arrays.
    #[inline]
    pub fn scalar_at(reference: u32, balls: usize) -> Option<Self> {
        let (position, index) = place(reference);
        Self::of_row(position)?.scalar(index, balls)
    }

    /// The variable behind a value reference of FMI 3.0 with arrays.
    #[inline]
    pub fn array_at(reference: u32) -> Option<Self> {
        match reference.checked_sub(ARRAYS) {
            Some(position) => Self::of_row(position as usize).filter(|array| array.position < TABLE.len()),
            None => Self::of_row(TABLE.len() + EXTRA.iter().position(|(own, _)| *own == reference)?),
        }
    }

    #[inline]
    fn of_row(position: usize) -> Option<Self> {
        let row = match position.checked_sub(TABLE.len()) {
            None => TABLE.get(position).filter(|row| row.name != LEFT_OUT)?,
            Some(extra) => &EXTRA.get(extra)?.1,
        };
        Some(Self { row, position, index: 0, whole: true })
    }

    /// The scalar of this name, such as `x[1]` or `ball.mass`, in a cradle of `balls` balls.
    pub fn named(name: &str, balls: usize) -> Option<Self> {
        let index = match name.split(['[', ']']).nth(1) {
            Some(digits) => digits.parse::<usize>().ok()?.checked_sub(1)?,
            None => 0,
        };
        let inner = name.strip_prefix("der(").unwrap_or(name);
        // A name that is written differently, such as `x[01]`, is unknown.
        let is_named = |row: &Row| {
            inner.starts_with(row.rate_of().unwrap_or(row.name))
                && index < row.shape.len(balls)
                && row.name_of(index + 1) == name
        };
        let (position, row) = TABLE.iter().enumerate().find(|(_, row)| is_named(row))?;
        Some(Self { row, position, index, whole: false })
    }

    /// The variable of this name in FMI 3.0 with arrays.
    pub fn array(name: &str) -> Option<Self> {
        Self::arrays().find(|array| array.row.name == name)
    }

    /// Every variable of FMI 3.0 with arrays, in the order of the description.
    pub fn arrays() -> impl Iterator<Item = Self> + Clone {
        let rows = TABLE.len();
        (rows..rows + BEFORE).chain(0..rows).chain(rows + BEFORE..rows + EXTRA.len()).filter_map(Self::of_row)
    }

    /// The continuous states of model exchange with their derivatives, in their order.
    pub fn states() -> impl Iterator<Item = (Self, Self)> {
        STATES.iter().filter_map(|(state, derivative)| Some((Self::array(state)?, Self::array(derivative)?)))
    }

    /// Value reference, for any number of balls.
    pub fn reference(&self) -> u32 {
        // All fit: the table is short and n is limited.
        match (self.whole, self.position.checked_sub(TABLE.len())) {
            (false, _) => ((self.position as u32) << INDEX_BITS) | self.index as u32,
            (true, Some(extra)) => EXTRA[extra].0,
            (true, None) => ARRAYS + self.position as u32,
        }
    }

    /// Number of elements in a cradle of `balls` balls.
    pub fn len(&self, balls: usize) -> usize {
        if self.whole && self.row.shape != Shape::Scalar { balls } else { 1 }
    }

    /// An element of an array, counted from 0, whether or not it belongs to a contact; a scalar stays itself.
    #[inline]
    pub fn element(self, index: usize) -> Self {
        Self { index: if self.whole { index } else { self.index }, whole: false, ..self }
    }

    /// All elements of an array that belong to balls or contacts.
    pub fn scalars(self, balls: usize) -> impl Iterator<Item = Self> {
        (0..self.row.shape.len(balls)).map(move |index| self.element(index))
    }

    /// An element of an array, counted from 0, for hosts without arrays. None for `n`, which is then fixed, and for
    /// variables that FMI 2.0 has under other names.
    pub fn scalar(self, index: usize, balls: usize) -> Option<Self> {
        let listed = !matches!(self.row.access, Access::Instance(_, Extra::Balls | Extra::Joined(..)));
        (listed && index < self.row.shape.len(balls)).then(|| self.element(index))
    }

    /// The FMI 2.0 variable that an element corresponds to in a cradle of `balls` balls; none if it belongs to no
    /// contact or exists only in FMI 3.0.
    pub fn of_fmi2(self, balls: usize) -> Option<Self> {
        let variable = match self.row.access {
            Access::Instance(_, Extra::Joined(first, rest)) => {
                let (name, index) = if self.index == 0 { (first, 0) } else { (rest, self.index - 1) };
                let (position, row) = TABLE.iter().enumerate().find(|(_, row)| row.name == name)?;
                Self { row, position, index, whole: false }
            }
            _ => self,
        };
        (variable.position < TABLE.len() && variable.index < variable.row.shape.len(balls)).then_some(variable)
    }

    /// The place of an element among the states of a cradle of `balls` balls, if it is one. The states are `scalars` or
    /// arrays, of which those over contacts have one element more.
    pub fn state_place(&self, balls: usize, scalars: bool) -> Option<usize> {
        let sums = 3 * balls - usize::from(scalars);
        let first = match self.row.name {
            "q" => 0,
            "x" if scalars && self.index == 0 => 0,
            "overlap" if scalars => 1,
            "v" => balls,
            "impulse" => 2 * balls,
            "E_dissipated" => sums,
            "W_external" => sums + 1,
            _ => return None,
        };
        Some(first + self.index)
    }

    /// When it may change in FMI 3.0. Real outputs over a step count as continuous, because discrete ones may change
    /// only in Event Mode.
    pub fn variability(&self) -> Variability {
        match (self.row.causality, self.row.access) {
            (Causality::Output, Access::Real(_)) => Variability::Continuous,
            _ => self.row.variability,
        }
    }

    /// The clock that it belongs to.
    pub fn clock(&self) -> Option<Self> {
        Some(Self { whole: self.whole, ..Self::array(self.row.clock?)? })
    }

    /// Whether it has a start value, which can be read before initialization.
    pub fn has_start(&self) -> bool {
        self.row.settable() || self.row.causality == Causality::StructuralParameter
    }

    /// Whether it is a clock or belongs to one: FMUs for hosts without clocks leave it out.
    pub fn needs_clocks(&self) -> bool {
        self.row.clock.is_some() || self.row.access.data_type() == Type::Clock
    }

    /// Whether a host may read or set it in the middle of a step.
    pub fn is_intermediate(&self) -> bool {
        INTERMEDIATE.contains(&self.row.name)
    }

    /// Checks that a host may set it; `between_steps` after initialization.
    pub fn check_settable(&self, between_steps: bool) -> Result<(), Refusal> {
        let (row, causality) = (self.row, self.row.causality);
        let text = format_args!("cannot be set: only parameters and inputs can, and its causality is {causality:?}");
        ensure(row.settable(), || Refusal::new(format_args!("{self} {text}")))?;
        let can_change = causality == Causality::Input || row.variability == Variability::Tunable;
        let text = "cannot be set after initialization: only inputs and tunable parameters can";
        ensure(can_change || !between_steps, || Refusal::new(format_args!("{self} {text}")))
    }

    /// Checks that `value` is finite and in range; for an enumeration, that it is the integer of an item.
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
        let causality = self.row.causality;
        let text = format_args!("can be set: only those of inputs can, and its causality is {causality:?}");
        ensure(causality == Causality::Input, || Refusal::new(format_args!("no derivative of {self} {text}")))?;
        let order = self.check_order(order, MAX_INPUT_DERIVATIVE)?;
        let what = format_args!("derivative {order} of {self}");
        ensure(value.is_finite(), || Refusal::value(what, Number(value), ANY))?;
        Ok(order)
    }

    /// Checks that a derivative of it is of an `order` from 1 to `most`, which it returns.
    pub fn check_order(&self, order: i32, most: usize) -> Result<usize, Refusal> {
        let (what, allowed) = (format_args!("order of the derivative of {self}"), format_args!("1 to {most}"));
        let known = usize::try_from(order).ok().filter(|order| (1..=most).contains(order));
        known.ok_or_else(|| Refusal::value(what, order, allowed))
    }

    /// The value of a parameter, input or slope; for an enumeration, the integer of its item; otherwise none.
    #[inline]
    pub fn value(&self, settings: &Settings) -> Option<f64> {
        match self.row.access {
            Access::Setting { get, .. } => get(settings).get(self.index).copied(),
            Access::Calculated(get) => Some(get(&settings.parameters)),
            Access::Enumeration(enumeration) => Some((enumeration.get)(settings).into()),
            _ => None,
        }
    }

    /// The value of a setting as text without its unit; for an enumeration, the name of its item; otherwise none.
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

impl Settings {
    /// The zero direction: every real setting is zero.
    pub fn zero(balls: usize) -> Self {
        let mut zero = Self::default_for(balls);
        for variable in variables(balls) {
            if variable.row.access.data_type() == Type::Real {
                variable.set(&mut zero, 0.0);
            }
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

/// Position of the row and zero-based index in the value reference of a scalar.
#[inline]
fn place(reference: u32) -> (usize, usize) {
    ((reference >> INDEX_BITS) as usize, (reference & INDEX_MASK) as usize)
}

/// The name of a scalar, with the index counted from 1: `x[1]`, `der(overlap[1])`; or of an array: `x`, `der(F_ext)`.
impl std::fmt::Display for Variable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.whole { f.write_str(self.row.name) } else { f.write_str(&self.row.name_of(self.index + 1)) }
    }
}

/// Every scalar of FMI 2.0 of a cradle of `balls` balls, in the order of the description.
pub fn variables(balls: usize) -> impl Iterator<Item = Variable> {
    TABLE.iter().enumerate().flat_map(move |(position, row)| {
        (0..row.shape.len(balls)).map(move |index| Variable { row, position, index, whole: false })
    })
}

/// Each state with its derivative. For `q` these are the first position and the overlaps; other positions follow from
/// them.
pub fn states(balls: usize) -> impl Iterator<Item = (Variable, Variable)> {
    Variable::states().flat_map(move |pair| {
        let of_fmi2 = move |of: Variable, index| of.element(index).of_fmi2(balls);
        (0..balls).filter_map(move |i| Some((of_fmi2(pair.0, i)?, of_fmi2(pair.1, i)?)))
    })
}

/// The enumerations of FMI 2.0, or of FMI 3.0.
pub fn enumerations(fmi3: bool) -> impl Iterator<Item = &'static Enumeration> {
    let extra = EXTRA.iter().map(|(_, row)| row).filter(move |_| fmi3);
    TABLE.iter().chain(extra).filter_map(|row| match row.access {
        Access::Enumeration(enumeration) => Some(enumeration),
        _ => None,
    })
}
