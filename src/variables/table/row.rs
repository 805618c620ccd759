//! A row of the table: everything about a family of variables.

use super::types::{Enumeration, Quantity};
use crate::model::{Differential, Parameters, Results};
use crate::number::Number;
use crate::variables::settings::{Kind, Settings};

/// How many variables a row stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One variable, without an index.
    Scalar,
    /// One for each ball, `[1]` to `[n]`.
    Balls,
    /// One for each contact, `[1]` to `[n-1]`.
    Contacts,
}

impl Shape {
    /// Number of variables for `balls` balls.
    pub const fn len(self, balls: usize) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Balls => balls,
            Self::Contacts => balls.saturating_sub(1),
        }
    }
}

/// The data types of the interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Type {
    /// A double.
    Real,
    /// 32 bits, with a sign.
    Integer,
    /// True or false.
    Boolean,
    /// Its values travel as integers.
    Enumeration,
    /// No variable has this type, but hosts may ask for it.
    String,
    /// Active or not, in FMI 3.0.
    Clock,
    /// Bytes, in FMI 3.0.
    Binary,
}

impl Type {
    /// Its name in FMI 3.0.
    pub fn fmi3(self) -> &'static str {
        match self {
            Self::Real => "Float64",
            Self::Integer => "UInt64",
            Self::Boolean => "Boolean",
            Self::Enumeration => "Enumeration",
            Self::String => "String",
            Self::Clock => "Clock",
            Self::Binary => "Binary",
        }
    }
}

/// What a variable is to the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// The time.
    Independent,
    /// The host may set it in Configuration Mode of FMI 3.0.
    StructuralParameter,
    /// The host may set it.
    Parameter,
    /// It follows from the parameters.
    CalculatedParameter,
    /// The host may set it between steps.
    Input,
    /// Another model may take it as its input.
    Output,
    /// For inspection only.
    Local,
}

/// When a variable may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variability {
    /// Not after initialization.
    Fixed,
    /// Also by the host, between steps.
    Tunable,
    /// Only at communication points and events.
    Discrete,
    /// At any time.
    Continuous,
}

/// A text of the table, and the quantity of a real variable.
type Text = &'static str;
type Of = &'static Quantity;

/// Reads a result for ball or contact `i`.
pub type Get<T> = fn(&dyn Results, usize) -> T;

/// How the value is accessed. The data type follows from it, so the two cannot disagree.
#[derive(Clone, Copy)]
pub enum Access {
    /// Real parameters, inputs or slopes; the slice has one element for each variable of the row.
    Setting {
        /// Reads the values.
        get: fn(&Settings) -> &[f64],
        /// Gives the values that a setter overwrites.
        set: fn(&mut Settings) -> &mut [f64],
    },
    /// A parameter with named items.
    Enumeration(&'static Enumeration),
    /// A real number that follows from the parameters alone.
    Calculated(fn(&Parameters) -> f64),
    /// A real result for ball or contact `i`.
    Real(Get<f64>),
    /// A count.
    Count(Get<u64>),
    /// A truth value.
    Flag(Get<bool>),
    /// A value of the instance, in FMI 3.0.
    Instance(Type, Extra),
}

/// A switching of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edge {
    /// It closes.
    Onset,
    /// It opens.
    Release,
}

/// Values of FMI 3.0 variables beside parameters, inputs and results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extra {
    /// The time, s.
    Time,
    /// Number of balls n.
    Balls,
    /// Whether the clock of onsets or releases is active.
    Clock(Edge),
    /// When this clock last ticked, s.
    TickTime(Edge),
    /// Whether a contact was part of the last tick of this clock.
    TickOf(Edge),
    /// The value of this name of a contact's pulse that ended at the last tick.
    Ended(&'static str),
    /// The first element of one row, then all of another.
    Joined(&'static str, &'static str),
    /// Event indicator of a contact.
    ContactIndicator,
    /// Event indicator of the law of a contact.
    ClipIndicator,
    /// The last pulses as text.
    Pulses,
}

impl Access {
    /// Data type of the variables behind it.
    pub const fn data_type(&self) -> Type {
        match self {
            Self::Setting { .. } | Self::Calculated(_) | Self::Real(_) => Type::Real,
            Self::Enumeration(_) => Type::Enumeration,
            Self::Count(_) => Type::Integer,
            Self::Flag(_) => Type::Boolean,
            Self::Instance(of, _) => *of,
        }
    }
}

/// Values a real variable may take, all of them finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Smallest value, if there is one.
    pub min: Option<f64>,
    /// Largest value, if there is one.
    pub max: Option<f64>,
    /// Whether `min` itself is refused.
    pub above_min: bool,
}

/// Any finite value.
pub const ANY: Range = Range { min: None, max: None, above_min: false };
/// Zero or more.
pub const NOT_NEGATIVE: Range = Range { min: Some(0.0), max: None, above_min: false };
/// More than zero. The description can only say `min="0"`; its text adds that 0 itself is refused.
pub const POSITIVE: Range = Range { min: Some(0.0), max: None, above_min: true };

/// `min` to `max`, both included.
pub const fn between(min: f64, max: f64) -> Range {
    Range { min: Some(min), max: Some(max), above_min: false }
}

impl Range {
    /// Whether `value` is finite and inside.
    pub fn contains(&self, value: f64) -> bool {
        let above = self.min.is_none_or(|min| value > min || value == min && !self.above_min);
        value.is_finite() && above && self.max.is_none_or(|max| value <= max)
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.min, self.max) {
            (Some(min), Some(max)) => write!(f, "{} to {}", Number(min), Number(max)),
            (Some(min), None) if self.above_min => write!(f, "finite and > {}", Number(min)),
            (Some(min), None) => write!(f, "finite and >= {}", Number(min)),
            (None, _) => write!(f, "any finite value"),
        }
    }
}

/// Dependencies of a value, as names of rows, or of one variable as `name[i]`. A scalar is meant as such. An array is
/// meant at the same ball or contact, at the contacts of the ball, or at the balls of the contact; as a whole if the
/// dependent value is a scalar. `name*` means, for arrays over balls, the balls next to this one as well. `position`
/// means the states that the position follows from.
pub type Groups = &'static [&'static [&'static str]];

/// A choice without which a parameter has no effect.
#[derive(Clone, Copy)]
pub struct Need {
    /// The choice, as a message names it: a setting and its values, or a kind of instance.
    pub choice: &'static str,
    /// Whether the choice is made; if no kind is given, whether it is in an instance of either kind.
    pub is_met: fn(&Parameters, Option<Kind>) -> bool,
}

/// A family of variables.
pub struct Row {
    /// Name without index.
    pub name: &'static str,
    /// Scalar or array.
    pub shape: Shape,
    /// What it is to the host.
    pub causality: Causality,
    /// When it may change.
    pub variability: Variability,
    /// Declared type of a real, with its unit.
    pub quantity: Option<&'static Quantity>,
    /// Values it may take.
    pub range: Range,
    /// Order of magnitude, where it is far from 1.
    pub nominal: Option<f64>,
    /// Where the value is.
    pub access: Access,
    /// What a parameter needs to have an effect.
    pub needs: &'static [Need],
    /// Derivative of a real result, for ball or contact `i`; outputs and calculated parameters have one.
    pub derivative: Option<fn(&Differential, usize) -> f64>,
    /// Dependencies of a calculated value at initialization; everything if none are given.
    pub initially: Option<Groups>,
    /// Dependencies on states and inputs in model exchange.
    pub follows: Groups,
    /// Name of the clock that it belongs to, in FMI 3.0.
    pub clock: Option<&'static str>,
    /// Text; `{i}` and `{j}` stand for the index and the one after it.
    pub description: &'static str,
}

impl Row {
    /// Whether the host may set it.
    pub const fn settable(&self) -> bool {
        matches!(self.causality, Causality::Parameter | Causality::Input)
    }

    /// The row of which it is the time derivative, by its name `der(...)`.
    pub fn rate_of(&self) -> Option<&'static str> {
        self.name.strip_prefix("der(").and_then(|name| name.strip_suffix(')'))
    }

    /// The name of its variable with this index, such as `x[1]` or `der(overlap[1])`.
    pub fn name_of(&self, index: impl std::fmt::Display) -> String {
        match (self.shape, self.rate_of()) {
            (Shape::Scalar, _) => self.name.to_owned(),
            (_, Some(family)) => format!("der({family}[{index}])"),
            (_, None) => format!("{}[{index}]", self.name),
        }
    }

    /// Unit, or nothing for counts, truth values and enumerations.
    pub fn unit(&self) -> &'static str {
        self.quantity.map_or("", |quantity| quantity.unit)
    }

    /// A value with its unit, for messages.
    pub fn quantified(&self, value: impl std::fmt::Display) -> String {
        match self.unit() {
            "" | "1" => value.to_string(),
            unit => format!("{value} {unit}"),
        }
    }
}

/// Any row; the functions below specialise it.
pub const fn row(name: Text, shape: Shape, causality: Causality, access: Access, description: Text) -> Row {
    let variability = match (&causality, &access) {
        (Causality::Parameter | Causality::CalculatedParameter | Causality::StructuralParameter, _) => {
            Variability::Fixed
        }
        (_, Access::Count(_) | Access::Flag(_) | Access::Instance(..)) => Variability::Discrete,
        _ => Variability::Continuous,
    };
    Row {
        name,
        shape,
        causality,
        variability,
        quantity: None,
        range: ANY,
        nominal: None,
        access,
        needs: &[],
        derivative: None,
        initially: None,
        follows: &[],
        clock: None,
        description,
    }
}

/// A real parameter.
pub const fn parameter(name: Text, shape: Shape, quantity: Of, range: Range, access: Access, description: Text) -> Row {
    row(name, shape, Causality::Parameter, access, description).of(quantity).within(range)
}

/// A parameter with named items.
pub const fn enumeration(name: Text, enumeration: &'static Enumeration, description: Text) -> Row {
    row(name, Shape::Scalar, Causality::Parameter, Access::Enumeration(enumeration), description)
}

/// A real result of causality output or local.
pub const fn real(name: Text, shape: Shape, to: Causality, quantity: Of, get: Get<f64>, description: Text) -> Row {
    row(name, shape, to, Access::Real(get), description).of(quantity)
}

/// A count of causality output or local.
pub const fn count(name: Text, shape: Shape, to: Causality, get: Get<u64>, description: Text) -> Row {
    row(name, shape, to, Access::Count(get), description).within(NOT_NEGATIVE)
}

/// A value of the instance, in FMI 3.0.
pub const fn extra(name: Text, shape: Shape, to: Causality, is: Type, what: Extra, description: Text) -> Row {
    row(name, shape, to, Access::Instance(is, what), description)
}

/// Setters of further properties of a row.
macro_rules! builders {
    ($($(#[$doc:meta])* $name:ident($($value:ident: $type:ty)?) $field:ident = $to:expr;)*) => {
        impl Row {
            $($(#[$doc])* pub const fn $name(mut self $(, $value: $type)?) -> Self {
                self.$field = $to;
                self
            })*
        }
    };
}

builders! {
    /// Is of this quantity.
    of(quantity: Of) quantity = Some(quantity);
    /// Takes values within this range only.
    within(range: Range) range = range;
    /// Has this order of magnitude.
    nominal(nominal: f64) nominal = Some(nominal);
    /// May also be set between steps.
    tunable() variability = Variability::Tunable;
    /// Changes only at communication points and events.
    discrete() variability = Variability::Discrete;
    /// Changes at any time.
    continuous() variability = Variability::Continuous;
    /// Has an effect only where all of these are met.
    used_if(needs: &'static [Need]) needs = needs;
    /// Has this derivative, by time or along a direction.
    derivative(derivative: fn(&Differential, usize) -> f64) derivative = Some(derivative);
    /// Depends on these states and inputs.
    follows(on: Groups) follows = on;
    /// Depends at initialization on these rows only.
    initially(on: Groups) initially = Some(on);
    /// Is known while this clock ticks.
    clocked(clock: Text) clock = Some(clock);
}
