//! Text for hosts and readers: refusals, and XML escapes.

use std::fmt::{self, Display, Formatter};

use crate::number::Number;

/// Why a variable, a value or a call is refused: what was wrong, and what is allowed. Unless it says otherwise, nothing
/// has changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    text: String,
    pub(crate) cause: RefusalCause,
}

/// What causes a refusal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RefusalCause {
    /// The call as a whole.
    Call,
    /// A value: the run can go on, and FMI 3.0 returns fmi3Discard.
    Value,
    /// The states that a solver tries in model exchange: FMI 2.0 returns fmi2Discard as well, and the
    /// solver takes a shorter step.
    #[cfg(feature = "engine")]
    State,
}

impl Refusal {
    /// A refusal with this text.
    #[cold]
    pub fn new(text: impl Display) -> Self {
        Self { text: text.to_string(), cause: RefusalCause::Call }
    }

    /// An argument whose `value` is not among those `allowed`.
    #[cold]
    pub fn argument(name: impl Display, value: impl Display, allowed: impl Display) -> Self {
        Self::new(format_args!("{name} = {value} is refused; allowed: {allowed}"))
    }

    /// Refuses a number of values `given` for the argument `name`, unless it is `wanted`.
    #[cfg(feature = "engine")]
    pub(crate) fn unless_count(name: &str, given: usize, wanted: usize) -> Result<(), Self> {
        ensure(given == wanted, || Self::argument(name, given, wanted))
    }

    /// A number as an argument, refused.
    pub fn number(name: &str, value: f64, unit: &str, allowed: impl Display) -> Self {
        Self::argument(name, format_args!("{} {unit}", Number(value)), allowed)
    }

    /// A value of a variable that is not among those `allowed`.
    pub fn value(variable: impl Display, value: impl Display, allowed: impl Display) -> Self {
        Self { cause: RefusalCause::Value, ..Self::argument(variable, value, allowed) }
    }

    /// A value that does not exist, with this text.
    pub fn no_value(text: impl Display) -> Self {
        Self { cause: RefusalCause::Value, ..Self::new(text) }
    }

    /// A value that does not exist in the states that a solver tries, with this text.
    #[cfg(feature = "engine")]
    pub(crate) fn of_state(text: impl Display) -> Self {
        Self { cause: RefusalCause::State, ..Self::new(text) }
    }

    /// No variable has this `key`, a name or a value reference, in a cradle of `balls` balls.
    pub fn unknown(key: impl Display, balls: usize) -> Self {
        Self::new(format_args!("no variable has the {key} in this FMU of {balls} ball(s)"))
    }
}

/// Refuses unless something `holds`.
#[inline]
pub fn ensure(holds: bool, refusal: impl FnOnce() -> Refusal) -> Result<(), Refusal> {
    if holds { Ok(()) } else { Err(refusal()) }
}

impl Display for Refusal {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl std::error::Error for Refusal {}

/// The standard's name of an item: its name in Rust with the first letter in lower case.
pub(crate) fn camel(item: &impl fmt::Debug) -> String {
    let name = format!("{item:?}");
    name[..1].to_lowercase() + &name[1..]
}

/// Text that may stand in an XML attribute between double quotes.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
