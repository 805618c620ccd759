//! The variables as FMI 3.0 has them: an array for each row of the table that has an index, and some of its own.
//!
//! The arrays have `n` elements, those over contacts as well, since n - 1 cannot be a dimension: the last element
//! belongs to no contact. A value reference does not depend on `n`. For hosts without arrays, each element is a scalar
//! with the name and the value reference of FMI 2.0.

use std::slice::{from_mut, from_ref};

use super::settings::DerivativesOf;
use super::table::TABLE;
use super::table::enumeration::{Enumeration, item};
use super::table::range::between;
use super::table::row::Causality::{Independent, Input, Local, Output, StructuralParameter};
use super::table::row::Shape::{Balls, Contacts, Scalar};
use super::table::row::Type::{Binary, Boolean, Clock, Integer, Real};
use super::table::row::{Access, Edge, Extra, Row, Variability, enumeration, extra, row};
use super::table::unit::{FORCE_KN, IMPULSE, LENGTH, TIME, TIME_US, VELOCITY};
use super::variable::{MAX_BALLS, MIN_BALLS, Variable};

/// A variable: an array, a scalar, or an element of an array as a scalar, which is all that FMI 2.0 has.
#[derive(Clone, Copy)]
pub struct Array {
    /// Its row.
    pub row: &'static Row,
    /// Position among the rows of the table and those of [`EXTRA`] behind them.
    position: usize,
    /// The only element that it stands for, counted from 0, where variables are scalars.
    only: Option<usize>,
}

/// Largest size of `log.pulses`, bytes.
pub const MAX_LOG: usize = 1 << 16;

/// Row of the table without a variable here: a Boolean that changes between events.
const LEFT_OUT: &str = "t_next_isOnset";
/// Value reference of the first row of the table.
const ROWS: u32 = 32;
/// How many of the other rows come before those of the table in the description.
const BEFORE: usize = 3;

const ONSET: &str = "onset.clock";
const RELEASE: &str = "release.clock";

/// The variables that only FMI 3.0 has, with their value references.
#[rustfmt::skip]
static EXTRA: &[(u32, Row)] = &[
    (0, extra("time", Scalar, Independent, Real, Extra::Time,
        "Time").of(&TIME).continuous()),
    (1, extra("n", Scalar, StructuralParameter, Integer, Extra::Balls,
        "Number of balls; changing it resets all arrays to their defaults")
        .within(between(MIN_BALLS as f64, MAX_BALLS as f64))),
    (2, enumeration("derivatives.of", item!(derivatives_of: DerivativesOf),
        "What directional and adjoint derivatives refer to after initialization").tunable()),
    (4, row("der(F_ext)", Balls, Input, Access::Setting { get: |s| &s.slopes.force, set: |s| &mut s.slopes.force },
        "Slope of F_ext over the next steps, from the value it is set to")),
    (5, row("der(a_support)", Scalar, Input, Access::Setting {
        get: |s| from_ref(&s.slopes.support_acceleration), set: |s| from_mut(&mut s.slopes.support_acceleration),
    }, "Slope of a_support over the next steps, from the value it is set to")),
    (8, extra(ONSET, Scalar, Output, Clock, Extra::Clock(Edge::Onset),
        "Ticks when contacts close")),
    (9, extra(RELEASE, Scalar, Output, Clock, Extra::Clock(Edge::Release),
        "Ticks when contacts open")),
    (10, extra("onset.time", Scalar, Output, Real, Extra::TickTime(Edge::Onset),
        "Time of the last tick").of(&TIME).clocked(ONSET)),
    (11, extra("onset.closed", Contacts, Output, Boolean, Extra::TickOf(Edge::Onset),
        "Which contacts closed at the last tick").clocked(ONSET)),
    (12, extra("release.time", Scalar, Output, Real, Extra::TickTime(Edge::Release),
        "Time of the last tick").of(&TIME).clocked(RELEASE)),
    (13, extra("release.opened", Contacts, Output, Boolean, Extra::TickOf(Edge::Release),
        "Which contacts opened at the last tick").clocked(RELEASE)),
    (14, extra("release.impulse", Contacts, Output, Real, Extra::EndedImpulse,
        "Impulse of the pulses that ended at the last tick").of(&IMPULSE).clocked(RELEASE)),
    (15, extra("release.peak", Contacts, Output, Real, Extra::EndedPeak,
        "Largest force of the pulses that ended at the last tick").of(&FORCE_KN).clocked(RELEASE)),
    (16, extra("release.duration", Contacts, Output, Real, Extra::EndedDuration,
        "Duration of the pulses that ended at the last tick").of(&TIME_US).clocked(RELEASE)),
    (17, extra("q", Balls, Local, Real, Extra::Joined("x", "overlap"),
        "Position of the first ball, then the overlaps").of(&LENGTH).continuous()
        .initially(&[&["contact.deadBand", "contact.gap", "x_start"]])),
    (18, extra("der(q)", Balls, Local, Real, Extra::Joined("v", "der(overlap)"),
        "Velocity of the first ball, then the rates of the overlaps").of(&VELOCITY).continuous()
        .initially(&[&["v_start"]]).follows(&[&["v"]])),
    (19, extra("z.contact", Contacts, Local, Real, Extra::ContactIndicator,
        "Event indicators of the contacts: negative while open").continuous()),
    (20, extra("z.clip", Contacts, Local, Real, Extra::ClipIndicator,
        "Event indicators of the laws: negative while clipped").continuous()),
    (21, extra("log.pulses", Scalar, Local, Binary, Extra::Pulses,
        "The last pulses as CSV: contact, onset, release, largest force, impulse")),
];

/// Continuous states with their derivatives, in their order.
const STATES: [(&str, &str); 5] = [
    ("q", "der(q)"),
    ("v", "a"),
    ("impulse", "F"),
    ("E_dissipated", "der(E_dissipated)"),
    ("W_external", "der(W_external)"),
];

/// What a host may read or set in the middle of a step.
const INTERMEDIATE: [&str; 10] =
    ["time", "F_ext", "a_support", "x", "F", "v", "E_total", "p_total", "F_support", "impulse"];

impl Array {
    #[inline]
    fn in_place(position: usize) -> Option<Self> {
        let row = match position.checked_sub(TABLE.len()) {
            None => TABLE.get(position).filter(|row| row.name != LEFT_OUT)?,
            Some(extra) => &EXTRA.get(extra)?.1,
        };
        Some(Self { row, position, only: None })
    }

    /// Every variable, in the order of the description.
    pub fn all() -> impl Iterator<Item = Self> + Clone {
        let rows = TABLE.len();
        (rows..rows + BEFORE).chain(0..rows).chain(rows + BEFORE..rows + EXTRA.len()).filter_map(Self::in_place)
    }

    /// The variable behind a value reference.
    #[inline]
    pub fn at(reference: u32) -> Option<Self> {
        match reference.checked_sub(ROWS) {
            Some(position) => Self::in_place(position as usize).filter(|array| array.position < TABLE.len()),
            None => Self::in_place(TABLE.len() + EXTRA.iter().position(|(own, _)| *own == reference)?),
        }
    }

    /// The scalar behind a value reference in a cradle of `balls` balls.
    #[inline]
    pub fn scalar_at(reference: u32, balls: usize) -> Option<Self> {
        let (position, index) = Variable::place(reference);
        Self::in_place(position)?.scalar(index, balls)
    }

    /// An element, counted from 0, as a scalar; none for `n`, which is then fixed, and for variables that FMI 2.0 has
    /// under other names.
    pub fn scalar(self, index: usize, balls: usize) -> Option<Self> {
        let listed = !matches!(self.row.access, Access::Instance(_, Extra::Balls | Extra::Joined(..)));
        (listed && index < self.row.shape.len(balls)).then_some(Self { only: Some(index), ..self })
    }

    /// The index of an element, counted from 0: that of the scalar, if it is one.
    pub fn index(self, element: usize) -> usize {
        self.only.unwrap_or(element)
    }

    /// Whether it is a scalar of a description without arrays.
    pub fn is_single(self) -> bool {
        self.only.is_some()
    }

    /// Its value reference.
    pub fn reference(self) -> u32 {
        if let Some(index) = self.only {
            return self.variable(index).reference();
        }
        // It fits: the table is short.
        self.position.checked_sub(TABLE.len()).map_or(ROWS + self.position as u32, |extra| EXTRA[extra].0)
    }

    /// The variable of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().find(|array| array.row.name == name)
    }

    /// The continuous states of model exchange with their derivatives, in their order.
    pub fn states() -> impl Iterator<Item = (Self, Self)> {
        STATES.iter().filter_map(|(state, derivative)| Some((Self::named(state)?, Self::named(derivative)?)))
    }

    /// Its place, or that of its first element, among the states of a cradle of `balls` balls, if it is one. In a list
    /// of arrays, those over contacts have an element more than scalars.
    pub fn state_place(self, balls: usize) -> Option<usize> {
        let mut before = 0;
        Self::states().find_map(|(state, _)| {
            let within = match self.only {
                // In a state that joins two rows, elements of the second come one place later.
                Some(index) => {
                    (index..index + 2).find(|i| state.element(*i, balls).is_some_and(|own| own.scalar() == self))
                }
                None => (state == self).then_some(0),
            };
            let place = within.map(|i| before + i);
            before += if self.is_single() { state.row.shape.len(balls) } else { state.len(balls) };
            place
        })
    }

    /// The FMI 2.0 variable of an element, counted from 0, in a cradle of `balls` balls; none if it belongs to no
    /// contact or only FMI 3.0 has it.
    pub fn element(self, index: usize, balls: usize) -> Option<Variable> {
        let index = self.index(index);
        let variable = match self.row.access {
            Access::Instance(_, Extra::Joined(first, rest)) => {
                let (name, index) = if index == 0 { (first, 0) } else { (rest, index - 1) };
                let (position, row) = TABLE.iter().enumerate().find(|(_, row)| row.name == name)?;
                Variable { row, position, index }
            }
            _ => self.variable(index),
        };
        (variable.position < TABLE.len() && variable.index < variable.row.shape.len(balls)).then_some(variable)
    }

    /// An element, counted from 0, whether or not it belongs to a contact.
    pub fn variable(self, index: usize) -> Variable {
        Variable { row: self.row, position: self.position, index: self.index(index) }
    }

    /// All elements that belong to balls or contacts.
    pub fn variables(self, balls: usize) -> impl Iterator<Item = Variable> {
        (0..self.row.shape.len(balls)).map(move |index| self.variable(index))
    }

    /// Number of elements in a cradle of `balls` balls.
    pub fn len(self, balls: usize) -> usize {
        if self.row.shape == Scalar || self.is_single() { 1 } else { balls }
    }

    /// When it changes. Real outputs over a step count as continuous: a discrete one may change in Event Mode only.
    pub fn variability(self) -> Variability {
        match (self.row.causality, self.row.access) {
            (Output, Access::Real(_)) => Variability::Continuous,
            _ => self.row.variability,
        }
    }

    /// The clock that it belongs to.
    pub fn clock(self) -> Option<Self> {
        let clock = self.row.clock.and_then(Self::named)?;
        Some(Self { only: self.only.map(|_| 0), ..clock })
    }

    /// Whether it has a start value, which can be read before initialization.
    pub fn has_start(self) -> bool {
        self.row.settable() || self.row.causality == StructuralParameter
    }

    /// Whether it is a clock or belongs to one: FMUs for hosts without clocks leave it out.
    pub fn needs_clocks(self) -> bool {
        self.row.clock.is_some() || self.row.access.data_type() == Clock
    }

    /// Whether a host may read or set it in the middle of a step.
    pub fn is_intermediate(self) -> bool {
        INTERMEDIATE.contains(&self.row.name)
    }
}

/// Each state with its derivative: of `q` the first position and the overlaps, from which other positions follow.
pub fn states(balls: usize) -> impl Iterator<Item = (Variable, Variable)> {
    Array::states().flat_map(move |(state, derivative)| {
        let element = move |i| Some((state.element(i, balls)?, derivative.element(i, balls)?));
        (0..balls).filter_map(element)
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

impl Variable {
    /// The same as an [`Array`] of one element.
    pub fn scalar(self) -> Array {
        Array { row: self.row, position: self.position, only: Some(self.index) }
    }
}

impl PartialEq for Array {
    fn eq(&self, other: &Self) -> bool {
        (self.position, self.only) == (other.position, other.only)
    }
}

/// The name: `x`, `der(F_ext)`, `onset.clock`; that of a scalar: `x[1]`.
impl std::fmt::Display for Array {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.only {
            Some(index) => f.write_str(&self.row.name_of(index + 1)),
            None => f.write_str(self.row.name),
        }
    }
}
