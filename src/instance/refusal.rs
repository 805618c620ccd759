//! Why a call was refused.

use super::legality::{Call, Kind, Phase};
use crate::engine::{EngineError, Unsound};
use crate::variables::{Number, VariableError};

/// Why a call was refused. Unless it says otherwise, the instance is as it was before the call.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// The call is not legal in this phase.
    Phase {
        /// What was asked.
        call: Call,
        /// Where the instance is.
        phase: Phase,
        /// What it was created for.
        kind: Kind,
        /// The phases in which it would be legal.
        allowed: Vec<Phase>,
        /// The refused call that ended the run before, if one did.
        ended_by: Option<String>,
    },
    /// A value, a value reference, a name or a type is not accepted.
    Value(VariableError),
    /// An argument is not accepted.
    Argument {
        /// Its name in the standard.
        name: &'static str,
        /// What was given, with its unit.
        value: String,
        /// What would have been accepted.
        allowed: String,
    },
    /// A saved state is not accepted.
    State(StateError),
    /// A derivative cannot be given.
    Derivative(String),
    /// What the run has been given, which its derivatives need, was not kept.
    NoHistory(&'static str),
    /// A value does not exist at this time.
    NotANumber {
        /// Name of the variable.
        variable: String,
        /// The time of the instance, s.
        time: f64,
    },
    /// Something has to happen first.
    Missing(&'static str),
    /// The FMU does not offer this.
    Unsupported(&'static str),
    /// The run cannot start with these parameters.
    Start(EngineError),
    /// The run cannot go on; the instance is in the error state.
    Step(EngineError),
}

impl Refusal {
    /// An argument that is a number.
    pub(crate) fn number(name: &'static str, value: f64, unit: &str, allowed: impl Into<String>) -> Self {
        Self::Argument { name, value: format!("{} {unit}", Number(value)), allowed: allowed.into() }
    }
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Phase { call, kind, .. } if call.kind().is_some_and(|other| other != *kind) => {
                write!(f, "not allowed in {kind}, which the instance was created for")
            }
            Self::Phase { phase, ended_by: Some(function), .. } => {
                write!(f, "not allowed in {phase}: the refused call of {function} ended the run; allowed: a reset")
            }
            Self::Phase { phase, allowed, .. } => {
                let legal: Vec<String> = allowed.iter().map(Phase::to_string).collect();
                let allowed = if legal.is_empty() { "" } else { "; allowed: in " };
                write!(f, "not allowed in {phase}{allowed}{}", legal.join(", "))
            }
            Self::Value(refused) => write!(f, "{refused}"),
            Self::Argument { name, value, allowed } => write!(f, "{name} = {value} is refused; allowed: {allowed}"),
            Self::State(error) => write!(f, "the state is refused: {error}"),
            Self::Derivative(variable) => {
                write!(
                    f,
                    "{variable} has no derivative here: it is not finite, or the step has too many switchings, or contacts too stiff for its length"
                )
            }
            Self::NotANumber { variable, time } => write!(
                f,
                "{variable} has no value at t = {} s: what it is calculated from is beyond the range of doubles",
                Number(*time)
            ),
            Self::NoHistory(what) | Self::Missing(what) | Self::Unsupported(what) => write!(f, "{what}"),
            Self::Start(error) => write!(f, "the run cannot start: {error}"),
            Self::Step(error) => write!(f, "the run cannot go on: {error}"),
        }
    }
}

impl std::error::Error for Refusal {}

impl From<StateError> for Refusal {
    fn from(error: StateError) -> Self {
        Self::State(error)
    }
}

impl From<VariableError> for Refusal {
    fn from(error: VariableError) -> Self {
        Self::Value(error)
    }
}

/// Why a state or its bytes are not accepted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StateError {
    /// The bytes are something else.
    NoState,
    /// Written by another version, in a format that is not the one known.
    Format {
        /// Its number.
        format: u32,
        /// The one that this version writes and reads.
        known: u32,
    },
    /// Not the bytes that were written.
    Damaged,
    /// Of another FMU.
    Foreign {
        /// Whose state it is.
        theirs: String,
        /// Who was to take it.
        ours: String,
    },
    /// Of an instance that was created for something else.
    OtherKind {
        /// What for.
        theirs: Kind,
        /// What the one is for that was to take it.
        ours: Kind,
    },
    /// Of an instance whose host takes part in events, or does not, unlike that of this one.
    OtherEvents,
    /// No instance can have been in this state.
    Unsound(Unsound),
}

impl std::fmt::Display for StateError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoState => write!(f, "these are not the bytes of a state of this FMU, or they are cut short"),
            Self::Format { format, known } => {
                let version = if format < known { "an earlier" } else { "a later" };
                write!(f, "its format, {format}, is that of {version} version; allowed: {known}")
            }
            Self::Damaged => write!(f, "the bytes are damaged"),
            Self::Foreign { theirs, ours } => write!(f, "it belongs to {theirs}; allowed: states of {ours}"),
            Self::OtherKind { theirs, ours } => {
                write!(f, "it is one of {theirs}; allowed: states of {ours}, which the instance was created for")
            }
            Self::OtherEvents => write!(f, "it is one of an instance that was created with another eventModeUsed"),
            Self::Unsound(Unsound(reason)) => write!(f, "no run can reach it: {reason}"),
        }
    }
}
