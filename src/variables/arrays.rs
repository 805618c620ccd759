//! The interface of FMI 3.0: the same table, with an array for each row that has an index, and what only FMI 3.0 has.
//!
//! The arrays have `n` elements, those over contacts as well, since n - 1 cannot be a dimension: the last element
//! belongs to no contact. A value reference does not depend on `n`.

use super::table::TABLE;
use super::table::enumeration::Item;
use super::table::row::{Access, Causality, Row, Shape, Type, Variability};
use super::table::unit::{FORCE, IMPULSE, LENGTH, Quantity, TIME, VELOCITY};
use super::variable::Variable;

/// A variable of FMI 3.0: a scalar or an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Array {
    /// The row at this position of the table.
    Row(usize),
    /// The slope over a step of the input at this position.
    Slope(usize),
    /// A variable that only FMI 3.0 has.
    Extra(Extra),
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
/// Value reference of the slope of the first input. Extra variables with smaller ones come before the rows, the others
/// behind them.
const SLOPES: u32 = 4;

/// What a variable is that only FMI 3.0 has.
struct ExtraRow {
    id: Extra,
    reference: u32,
    name: &'static str,
    data_type: ArrayType,
    causality: Option<Causality>,
    variability: Variability,
    quantity: Option<&'static Quantity>,
    shape: Shape,
    clock: Option<Extra>,
    description: &'static str,
}

macro_rules! extra {
    ($($id:ident $reference:literal $name:literal $data_type:ident $causality:expr, $variability:ident $quantity:expr,
       $shape:ident $clock:expr, $description:literal;)*) => {
        /// The variables that only FMI 3.0 has.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Extra {
            $(#[doc = concat!("`", $name, "`: ", $description, ".")] $id),*
        }

        /// In the order of their items.
        static EXTRA: &[ExtraRow] = &[$(ExtraRow {
            id: Extra::$id,
            reference: $reference,
            name: $name,
            data_type: ArrayType::$data_type,
            causality: $causality,
            variability: Variability::$variability,
            quantity: $quantity,
            shape: Shape::$shape,
            clock: $clock,
            description: $description,
        }),*];
    };
}

const OUTPUT: Option<Causality> = Some(Causality::Output);
const LOCAL: Option<Causality> = Some(Causality::Local);
const ONSET: Option<Extra> = Some(Extra::OnsetClock);
const RELEASE: Option<Extra> = Some(Extra::ReleaseClock);

// Value reference, name, type, causality (none for what no row is), variability, quantity, shape, clock that it belongs
// to.
extra! {
    Time 0 "time" Float64 None, Continuous Some(&TIME), Scalar None, "Time";
    Balls 1 "n" UInt64 None, Fixed None, Scalar None, "Number of balls; a new one sets all arrays to their defaults";
    DerivativesOf 2 "derivatives.of" Enumeration Some(Causality::Parameter), Tunable None, Scalar None,
        "What directional and adjoint derivatives are those of, after initialization";
    OnsetClock 8 "onset.clock" Clock OUTPUT, Discrete None, Scalar None, "Ticks when contacts close";
    ReleaseClock 9 "release.clock" Clock OUTPUT, Discrete None, Scalar None, "Ticks when contacts open";
    OnsetTime 10 "onset.time" Float64 OUTPUT, Discrete Some(&TIME), Scalar ONSET, "Time of the last tick";
    OnsetClosed 11 "onset.closed" Boolean OUTPUT, Discrete None, Contacts ONSET, "Which contacts closed at the last tick";
    ReleaseTime 12 "release.time" Float64 OUTPUT, Discrete Some(&TIME), Scalar RELEASE, "Time of the last tick";
    ReleaseOpened 13 "release.opened" Boolean OUTPUT, Discrete None, Contacts RELEASE,
        "Which contacts opened at the last tick";
    ReleaseImpulse 14 "release.impulse" Float64 OUTPUT, Discrete Some(&IMPULSE), Contacts RELEASE,
        "Impulse of the pulses that ended at the last tick";
    ReleasePeak 15 "release.peak" Float64 OUTPUT, Discrete Some(&FORCE), Contacts RELEASE,
        "Largest force of the pulses that ended at the last tick";
    ReleaseDuration 16 "release.duration" Float64 OUTPUT, Discrete Some(&TIME), Contacts RELEASE,
        "Duration of the pulses that ended at the last tick";
    Positions 17 "q" Float64 LOCAL, Continuous Some(&LENGTH), Balls None,
        "Position of the first ball, then the overlaps";
    Rates 18 "der(q)" Float64 LOCAL, Continuous Some(&VELOCITY), Balls None,
        "Velocity of the first ball, then the rates of the overlaps";
    ContactIndicators 19 "z.contact" Float64 LOCAL, Continuous None, Contacts None,
        "Event indicators of the contacts: negative while open";
    ClipIndicators 20 "z.clip" Float64 LOCAL, Continuous None, Contacts None,
        "Event indicators of the laws: negative while clipped";
    Pulses 21 "log.pulses" Binary LOCAL, Discrete None, Scalar None,
        "The last pulses as CSV: contact, onset, release, largest force, impulse";
}

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
        let (first, last) = EXTRA.split_at(EXTRA.partition_point(|extra| extra.reference < SLOPES));
        let [first, last] = [first, last].map(|extra| extra.iter().map(|extra| Self::Extra(extra.id)));
        let rows = (0..TABLE.len()).filter(|position| TABLE[*position].name != LEFT_OUT).map(Self::Row);
        first.chain(rows).chain(inputs().map(Self::Slope)).chain(last)
    }

    /// The variable behind a value reference.
    #[inline]
    pub fn at(reference: u32) -> Option<Self> {
        if let Some(position) = reference.checked_sub(ROWS) {
            let position = position as usize;
            return TABLE.get(position).filter(|row| row.name != LEFT_OUT).map(|_| Self::Row(position));
        }
        let extra = EXTRA.iter().find(|extra| extra.reference == reference).map(|extra| Self::Extra(extra.id));
        extra.or_else(|| inputs().nth(reference.checked_sub(SLOPES)? as usize).map(Self::Slope))
    }

    /// Its value reference.
    pub fn reference(self) -> u32 {
        match self {
            // It fits: the table is short.
            Self::Row(position) => ROWS + position as u32,
            Self::Slope(position) => SLOPES + inputs().position(|input| input == position).unwrap_or_default() as u32,
            Self::Extra(extra) => extra.row().reference,
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

    /// The variable of a single element, counted from 0, in a cradle of `balls` balls; nothing for one that belongs to
    /// no contact.
    pub fn element(self, index: usize, balls: usize) -> Option<Variable> {
        let of = |name: &str, index: usize| {
            let (position, row) = TABLE.iter().enumerate().find(|(_, row)| row.name == name)?;
            Some(Variable { row, position, index })
        };
        match (self, index.checked_sub(1)) {
            (Self::Row(position), _) => Some(Variable { row: TABLE.get(position)?, position, index }),
            (Self::Extra(Extra::Positions), None) => of("x", 0),
            (Self::Extra(Extra::Positions), Some(contact)) => of("overlap", contact),
            (Self::Extra(Extra::Rates), None) => of("v", 0),
            (Self::Extra(Extra::Rates), Some(contact)) => of("der(overlap)", contact),
            _ => None,
        }
        .filter(|variable| variable.index < variable.row.shape.len(balls))
    }

    /// Its row, if it is one.
    pub fn row(self) -> Option<&'static Row> {
        if let Self::Row(position) = self { TABLE.get(position) } else { None }
    }

    /// What it has an element for.
    pub fn shape(self) -> Shape {
        match self {
            Self::Row(position) | Self::Slope(position) => TABLE[position].shape,
            Self::Extra(extra) => extra.row().shape,
        }
    }

    /// Whether it is an array; a scalar otherwise.
    pub fn is_array(self) -> bool {
        self.shape() != Shape::Scalar
    }

    /// Number of elements in a cradle of `balls` balls.
    #[inline]
    pub fn len(self, balls: usize) -> usize {
        if self.is_array() { balls } else { 1 }
    }

    /// Its type.
    pub fn data_type(self) -> ArrayType {
        match self {
            Self::Slope(_) => ArrayType::Float64,
            Self::Extra(extra) => extra.row().data_type,
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
            Self::Row(position) => Some(TABLE[position].causality),
            Self::Slope(_) => Some(Causality::Input),
            Self::Extra(extra) => extra.row().causality,
        }
    }

    /// When it changes. Real outputs that hold a value of the step are continuous: a discrete one may change in Event
    /// Mode only.
    pub fn variability(self) -> Variability {
        match self {
            Self::Slope(_) => Variability::Continuous,
            Self::Extra(extra) => extra.row().variability,
            Self::Row(position) => match &TABLE[position] {
                row if row.causality == Causality::Output && matches!(row.access, Access::Real(_)) => {
                    Variability::Continuous
                }
                row => row.variability,
            },
        }
    }

    /// Quantity of a real one; nothing for slopes and indicators.
    pub fn quantity(self) -> Option<&'static Quantity> {
        match self {
            Self::Row(position) => TABLE[position].quantity,
            Self::Slope(_) => None,
            Self::Extra(extra) => extra.row().quantity,
        }
    }

    /// The clock that it belongs to.
    pub fn clock(self) -> Option<Self> {
        if let Self::Extra(extra) = self { extra.row().clock.map(Self::Extra) } else { None }
    }

    /// Whether the description has a start value of it, which is there before initialization.
    pub fn has_start(self) -> bool {
        match self {
            Self::Row(position) => TABLE[position].settable(),
            Self::Slope(_) => true,
            Self::Extra(extra) => matches!(extra, Extra::Balls | Extra::DerivativesOf),
        }
    }

    /// Whether it is a clock or belongs to one: FMUs for hosts without clocks leave it out.
    pub fn needs_clocks(self) -> bool {
        self.data_type() == ArrayType::Clock || self.clock().is_some()
    }

    /// What it is, to its readers.
    pub fn description(self) -> String {
        let text = match self {
            Self::Row(position) => TABLE[position].description,
            Self::Slope(position) => {
                return format!("Slope of {} over the next steps, from the value it is set to", TABLE[position].name);
            }
            Self::Extra(extra) => extra.row().description,
        };
        text.replace("{i}", "i").replace("{j}", "i+1")
    }

    /// Whether a host may read or set it in the middle of a step.
    pub fn is_intermediate(self) -> bool {
        let known = ["F_ext", "a_support", "x", "F", "v", "E_total", "p_total", "F_support", "impulse"];
        self == Self::Extra(Extra::Time) || self.row().is_some_and(|row| known.contains(&row.name))
    }
}

impl Extra {
    fn row(self) -> &'static ExtraRow {
        &EXTRA[self as usize]
    }
}

/// The name: `x`, `der(F_ext)`, `onset.clock`.
impl std::fmt::Display for Array {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Row(position) => f.write_str(TABLE[*position].name),
            Self::Slope(position) => write!(f, "der({})", TABLE[*position].name),
            Self::Extra(extra) => f.write_str(extra.row().name),
        }
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
