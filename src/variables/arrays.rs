//! The interface of FMI 3.0: the same table, with an array for each row that has an index, and what only FMI 3.0 has.
//!
//! The arrays have `n` elements, those over contacts as well, since n - 1 cannot be a dimension: the last element belongs to no
//! contact. A value reference does not depend on `n`.

use super::table::TABLE;
use super::table::enumeration::Item;
use super::table::row::{Access, Causality, Row, Shape, Type, Variability};
use super::table::unit::{FORCE, IMPULSE, LENGTH, Quantity, TIME, VELOCITY};
use super::variable::Variable;

/// What happens to a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edge {
    /// It closes.
    Onset,
    /// It opens.
    Release,
}

/// What a clock tells of its last tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Told {
    /// When it ticked, s.
    Time(Edge),
    /// Whether the contact has closed, or opened.
    Which(Edge),
    /// Impulse of the pulse that has ended, N.s.
    Impulse,
    /// Its largest force, N.
    Peak,
    /// How long it lasted, s.
    Duration,
}

/// What model exchange has beside the rows. States are whole variables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exchanged {
    /// `q`: the position of the first ball and the overlaps, m.
    Position,
    /// `der(q)`, m/s.
    Rate,
    /// `z.contact`: event indicators, negative while contacts are open.
    Contact,
    /// `z.clip`: event indicators, negative while the laws of contacts are clipped.
    Clip,
}

/// A variable of FMI 3.0: a scalar or an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Array {
    /// The independent variable.
    Time,
    /// `n`, the structural parameter that the arrays are sized by.
    Balls,
    /// `derivatives.of`, one of [`DERIVATIVES_OF`].
    DerivativesOf,
    /// The row at this position of the table.
    Row(usize),
    /// The slope over a step of the input at this position.
    Slope(usize),
    /// A clock.
    Clock(Edge),
    /// A variable of a clock.
    Told(Told),
    /// A variable of model exchange.
    Exchanged(Exchanged),
    /// `log.pulses`, the last pulses as CSV, at most [`MAX_LOG`] bytes.
    Pulses,
}

/// The data types of these variables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArrayType {
    /// A double.
    Float64,
    /// A count.
    UInt64,
    /// Its values travel as `Int64`.
    Enumeration,
    /// True or false.
    Boolean,
    /// Active or not.
    Clock,
    /// Bytes.
    Binary,
}

/// Items of `derivatives.of`.
pub static DERIVATIVES_OF: &[Item] = &[
    Item {
        name: "point",
        value: 1,
        description: "what depends on the inputs at the same time, as the standard has it",
    },
    Item { name: "lastStep", value: 2, description: "the end of the last step, by the inputs held over it" },
    Item {
        name: "run",
        value: 3,
        description: "the end of the last step, by real parameters, and inputs over the run",
    },
];

/// Largest size of `log.pulses`, bytes.
pub const MAX_LOG: usize = 1 << 16;

/// Row of the table that has no place here: a Boolean that changes between events.
const LEFT_OUT: &str = "t_next_isOnset";
/// Value reference of the first row.
const ROWS: u32 = 32;
/// What comes before the rows, by its value reference, but for the slopes of inputs, which take two places from `SLOPES` on.
const FIRST: [Array; 3] = [Array::Time, Array::Balls, Array::DerivativesOf];
const SLOPES: u32 = 4;
const BESIDE: u32 = 8;
/// What clocks and model exchange have beside the rows.
const LAST: [Array; 14] = [
    Array::Clock(Edge::Onset),
    Array::Clock(Edge::Release),
    Array::Told(Told::Time(Edge::Onset)),
    Array::Told(Told::Which(Edge::Onset)),
    Array::Told(Told::Time(Edge::Release)),
    Array::Told(Told::Which(Edge::Release)),
    Array::Told(Told::Impulse),
    Array::Told(Told::Peak),
    Array::Told(Told::Duration),
    Array::Exchanged(Exchanged::Position),
    Array::Exchanged(Exchanged::Rate),
    Array::Exchanged(Exchanged::Contact),
    Array::Exchanged(Exchanged::Clip),
    Array::Pulses,
];
/// Continuous states with their derivatives, in their order.
const STATES: [(&str, &str); 5] = [
    ("q", "der(q)"),
    ("v", "a"),
    ("impulse", "F"),
    ("E_dissipated", "der(E_dissipated)"),
    ("W_external", "der(W_external)"),
];

fn inputs() -> impl Iterator<Item = usize> + Clone {
    TABLE.iter().enumerate().filter(|(_, row)| row.causality == Causality::Input).map(|(position, _)| position)
}

impl Array {
    /// Every variable, in the order of the description.
    pub fn all() -> impl Iterator<Item = Self> + Clone {
        let rows = (0..TABLE.len()).filter(|position| TABLE[*position].name != LEFT_OUT).map(Self::Row);
        FIRST.into_iter().chain(rows).chain(inputs().map(Self::Slope)).chain(LAST)
    }

    /// The variable behind a value reference.
    #[inline]
    pub fn at(reference: u32) -> Option<Self> {
        let within = |first: u32| reference.checked_sub(first).map(|place| place as usize);
        if let Some(position) = within(ROWS) {
            return TABLE.get(position).filter(|row| row.name != LEFT_OUT).map(|_| Self::Row(position));
        }
        let last = within(BESIDE).map(|place| LAST.get(place).copied());
        let slope = || within(SLOPES).map(|place| inputs().nth(place).map(Self::Slope));
        last.or_else(slope).unwrap_or_else(|| FIRST.get(reference as usize).copied())
    }

    /// Its value reference.
    pub fn reference(self) -> u32 {
        let place =
            |places: &[Self]| places.iter().position(|other| other.kind() == self.kind()).unwrap_or_default() as u32;
        match self {
            // It fits: the table is short.
            Self::Row(position) => ROWS + position as u32,
            Self::Slope(position) => SLOPES + inputs().position(|input| input == position).unwrap_or_default() as u32,
            Self::Clock(_) | Self::Told(_) | Self::Exchanged(_) | Self::Pulses => BESIDE + place(&LAST),
            Self::Time | Self::Balls | Self::DerivativesOf => place(&FIRST),
        }
    }

    /// A number for each kind. The comparison that Rust derives for nested enumerations may branch on bytes without a value, which does
    /// no harm, but memory checkers report it.
    fn kind(self) -> u8 {
        match self {
            Self::Time => 0,
            Self::Balls => 1,
            Self::DerivativesOf => 2,
            Self::Row(_) => 3,
            Self::Slope(_) => 4,
            Self::Pulses => 5,
            Self::Clock(edge) => 6 + edge as u8,
            Self::Told(Told::Time(edge)) => 8 + edge as u8,
            Self::Told(Told::Which(edge)) => 10 + edge as u8,
            Self::Told(Told::Impulse) => 12,
            Self::Told(Told::Peak) => 13,
            Self::Told(Told::Duration) => 14,
            Self::Exchanged(exchanged) => 15 + exchanged as u8,
        }
    }

    /// The variable of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().find(|array| array.row().map_or_else(|| array.to_string() == name, |row| row.name == name))
    }

    /// The continuous states of model exchange with their derivatives, in their order.
    pub fn states() -> impl Iterator<Item = (Self, Self)> {
        STATES.iter().filter_map(|(state, derivative)| Some((Self::named(state)?, Self::named(derivative)?)))
    }

    /// The variable of a single element, counted from 0, in a cradle of `balls` balls; nothing for one that belongs to no contact.
    pub fn element(self, index: usize, balls: usize) -> Option<Variable> {
        let of = |name: &str, index: usize| {
            let (position, row) = TABLE.iter().enumerate().find(|(_, row)| row.name == name)?;
            Some(Variable { row, position, index })
        };
        match (self, index.checked_sub(1)) {
            (Self::Row(position), _) => Some(Variable { row: TABLE.get(position)?, position, index }),
            (Self::Exchanged(Exchanged::Position), None) => of("x", 0),
            (Self::Exchanged(Exchanged::Position), Some(contact)) => of("overlap", contact),
            (Self::Exchanged(Exchanged::Rate), None) => of("v", 0),
            (Self::Exchanged(Exchanged::Rate), Some(contact)) => of("der(overlap)", contact),
            _ => None,
        }
        .filter(|variable| variable.index < variable.row.shape.len(balls))
    }

    /// Its row, if it is one.
    pub fn row(self) -> Option<&'static Row> {
        if let Self::Row(position) = self { TABLE.get(position) } else { None }
    }

    /// Whether it is an array; a scalar otherwise.
    pub fn is_array(self) -> bool {
        match self {
            Self::Row(position) | Self::Slope(position) => TABLE[position].shape != Shape::Scalar,
            Self::Told(told) => !matches!(told, Told::Time(_)),
            Self::Exchanged(_) => true,
            Self::Time | Self::Balls | Self::DerivativesOf | Self::Clock(_) | Self::Pulses => false,
        }
    }

    /// Number of elements in a cradle of `balls` balls.
    #[inline]
    pub fn len(self, balls: usize) -> usize {
        if self.is_array() { balls } else { 1 }
    }

    /// Its type.
    pub fn data_type(self) -> ArrayType {
        match self {
            Self::Time | Self::Slope(_) | Self::Exchanged(_) => ArrayType::Float64,
            Self::Balls => ArrayType::UInt64,
            Self::DerivativesOf => ArrayType::Enumeration,
            Self::Clock(_) => ArrayType::Clock,
            Self::Pulses => ArrayType::Binary,
            Self::Told(Told::Which(_)) => ArrayType::Boolean,
            Self::Told(_) => ArrayType::Float64,
            Self::Row(position) => match TABLE[position].access.data_type() {
                Type::Integer => ArrayType::UInt64,
                Type::Boolean => ArrayType::Boolean,
                Type::Enumeration => ArrayType::Enumeration,
                Type::Real | Type::String => ArrayType::Float64,
            },
        }
    }

    /// What it is to the host; nothing for `time` and `n`, whose kind no row has.
    pub fn causality(self) -> Option<Causality> {
        match self {
            Self::Time | Self::Balls => None,
            Self::DerivativesOf => Some(Causality::Parameter),
            Self::Row(position) => Some(TABLE[position].causality),
            Self::Slope(_) => Some(Causality::Input),
            Self::Clock(_) | Self::Told(_) => Some(Causality::Output),
            Self::Exchanged(_) | Self::Pulses => Some(Causality::Local),
        }
    }

    /// When it changes. Real outputs that hold a value of the step are continuous: a discrete one may change in Event Mode only.
    pub fn variability(self) -> Variability {
        match self {
            Self::Time | Self::Slope(_) | Self::Exchanged(_) => Variability::Continuous,
            Self::Balls => Variability::Fixed,
            Self::DerivativesOf => Variability::Tunable,
            Self::Clock(_) | Self::Told(_) | Self::Pulses => Variability::Discrete,
            Self::Row(position) => match &TABLE[position] {
                row if row.causality == Causality::Output && matches!(row.access, Access::Real(_)) => {
                    Variability::Continuous
                }
                row => row.variability,
            },
        }
    }

    /// Quantity of a real one that is no row of the table.
    pub fn quantity(self) -> Option<&'static Quantity> {
        match self {
            Self::Time | Self::Told(Told::Time(_) | Told::Duration) => Some(&TIME),
            Self::Told(Told::Impulse) => Some(&IMPULSE),
            Self::Told(Told::Peak) => Some(&FORCE),
            Self::Exchanged(Exchanged::Position) => Some(&LENGTH),
            Self::Exchanged(Exchanged::Rate) => Some(&VELOCITY),
            _ => None,
        }
    }

    /// The clock that it belongs to.
    pub fn clock(self) -> Option<Edge> {
        match self {
            Self::Told(Told::Time(edge) | Told::Which(edge)) => Some(edge),
            Self::Told(_) => Some(Edge::Release),
            _ => None,
        }
    }

    /// Whether the description has a start value of it, which is there before initialization.
    pub fn has_start(self) -> bool {
        match self {
            Self::Balls | Self::DerivativesOf | Self::Slope(_) => true,
            Self::Row(position) => TABLE[position].settable(),
            Self::Time | Self::Clock(_) | Self::Told(_) | Self::Exchanged(_) | Self::Pulses => false,
        }
    }

    /// Whether it is a clock or belongs to one: FMUs for hosts without clocks leave it out.
    pub fn needs_clocks(self) -> bool {
        matches!(self, Self::Clock(_) | Self::Told(_))
    }

    /// Whether a host may read or set it in the middle of a step.
    pub fn is_intermediate(self) -> bool {
        let known = ["F_ext", "a_support", "x", "F", "v", "E_total", "p_total", "F_support", "impulse"];
        self == Self::Time || self.row().is_some_and(|row| known.contains(&row.name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn names_and_references_are_unique_and_lead_back() {
        let (mut names, mut references) = (HashSet::new(), HashSet::new());
        for array in Array::all() {
            assert_eq!(Array::at(array.reference()), Some(array));
            assert_eq!(Array::named(&array.to_string()), Some(array));
            assert!(names.insert(array.to_string()) && references.insert(array.reference()), "{array}");
        }
        assert_eq!(references.len(), (0..200).filter(|reference| Array::at(*reference).is_some()).count());
        assert!(Array::named(LEFT_OUT).is_none() && Array::at(u32::MAX).is_none());
    }
}
