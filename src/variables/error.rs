//! Why a variable, or a value for it, is not accepted.

use std::fmt::Display;

use super::table::row::{Causality, Type};

/// A variable or value that is not accepted, and what would be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum VariableError {
    /// No variable has this value reference.
    UnknownReference {
        /// What was asked for.
        reference: u32,
        /// Number of balls n.
        balls: usize,
    },
    /// No variable has this name.
    UnknownName {
        /// What was asked for.
        name: String,
        /// Number of balls n.
        balls: usize,
    },
    /// The variable has another type.
    WrongType {
        /// Name of the variable.
        variable: String,
        /// Its type.
        actual: Type,
        /// The type of the call.
        asked: Type,
    },
    /// The variable cannot be set at all.
    NotSettable {
        /// Name of the variable.
        variable: String,
        /// What it is.
        causality: Causality,
    },
    /// Derivatives can only be given for inputs.
    NotInput {
        /// Name of the variable.
        variable: String,
        /// What it is.
        causality: Causality,
    },
    /// The variable has no derivative of the kind asked for.
    NotDifferentiable {
        /// Name of the variable.
        variable: String,
        /// Of which there are derivatives.
        allowed: &'static str,
    },
    /// The variable cannot be set any more.
    Fixed {
        /// Name of the variable.
        variable: String,
    },
    /// The variable can only be set in Configuration Mode.
    Structural {
        /// Name of the variable.
        variable: String,
    },
    /// The variable cannot be set while the host integrates.
    NotContinuous {
        /// Name of the variable.
        variable: String,
    },
    /// The value is outside of what is allowed.
    NotAllowed {
        /// Name of the variable.
        variable: String,
        /// The value, as it was given.
        value: String,
        /// The range or the items, with the unit.
        allowed: String,
    },
}

impl VariableError {
    /// A `value` that is not among those `allowed` for the `variable`.
    pub(crate) fn not_allowed(variable: impl Display, value: impl Display, allowed: impl Display) -> Self {
        Self::NotAllowed { variable: variable.to_string(), value: value.to_string(), allowed: allowed.to_string() }
    }
}

impl Display for VariableError {
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
                    "{variable} cannot be set: only parameters and inputs can, and its causality is {causality:?}"
                )
            }
            Self::NotInput { variable, causality } => {
                write!(
                    f,
                    "no derivative of {variable} can be set: only those of inputs can, and its causality is {causality:?}"
                )
            }
            Self::NotDifferentiable { variable, allowed } => {
                write!(f, "{variable} has no such derivative; allowed: {allowed}")
            }
            Self::Fixed { variable } => {
                write!(f, "{variable} cannot be set after initialization: only inputs and tunable parameters can")
            }
            Self::Structural { variable } => write!(f, "{variable} can only be set in Configuration Mode"),
            Self::NotContinuous { variable } => {
                write!(
                    f,
                    "{variable} cannot be set in Continuous-Time Mode: only inputs can; tunable parameters in Event Mode"
                )
            }
            Self::NotAllowed { variable, value, allowed } => {
                write!(f, "{variable} = {value} is refused; allowed: {allowed}")
            }
        }
    }
}

impl std::error::Error for VariableError {}
