//! What the segments of a cluster so far say about the next one.

use serde::{Deserialize, Serialize};

use super::cluster::LONGEST;

/// What the segments of a cluster so far say about the next one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Pace {
    /// Segments since the last switching.
    pub quiet: u32,
    /// How many of them must have passed before implicit collocation is tried.
    pub patience: u32,
    /// Length of its next step, s; 0 if the last segment was of another kind.
    pub implicit_length: f64,
    /// What the last Taylor series converged for, s.
    pub explicit_length: f64,
    /// Segments since its balls were in flight, across switchings.
    pub age: u32,
}

impl Default for Pace {
    fn default() -> Self {
        Self { quiet: 0, patience: 24, implicit_length: 0.0, explicit_length: 0.0, age: 0 }
    }
}

impl Pace {
    /// Right after a switching, `age` segments after the balls were in flight.
    pub fn aged(age: u32) -> Self {
        Self { age, ..Self::default() }
    }

    /// Whether the balls have been pressed together for so long that they will hardly part: no impact takes as many segments.
    pub fn is_lasting(&self) -> bool {
        self.age >= 1 << 15
    }

    /// Whether its lengths are lengths.
    pub fn is_sound(&self) -> bool {
        [self.implicit_length, self.explicit_length].iter().all(|length| (0.0..=LONGEST).contains(length))
    }
}
