//! Why a motion has no derivatives.

use std::fmt::{Display, Formatter, Result};

/// Why a run or a step has no derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unfollowed {
    /// It is at its start, or the history of its inputs is not complete.
    NoHistory,
    /// The run cannot be repeated: it ends elsewhere.
    Another,
    /// It has more parts than memory or time allow.
    TooLong,
    /// A motion varies more than parts of any length resolve.
    Unresolved,
    /// Rigid balls stay in contact, and move as one body.
    RigidBody,
    /// More than two rigid balls collide at once: another order of impacts has another outcome.
    JointImpact,
    /// Rigid balls meet without speed: rounding decides when.
    Grazing,
}

impl Display for Unfollowed {
    fn fmt(&self, f: &mut Formatter) -> Result {
        f.write_str(match self {
            Self::NoHistory => "nothing of it is kept",
            Self::Another => "the run cannot be repeated to the same end",
            Self::TooLong => "what it depends on is too long to be followed",
            Self::Unresolved => "a motion that it depends on cannot be resolved",
            Self::RigidBody => "rigid balls stay in contact in it",
            Self::JointImpact => "more than two rigid balls collide at once in it",
            Self::Grazing => "rigid balls meet in it without speed",
        })
    }
}
