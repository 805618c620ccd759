//! The methods for motions in contact, their tolerances, and the history of the segments of a cluster.

use serde::{Deserialize, Serialize};

use super::window::Window;
use crate::engine::flight::Rounding;

/// Longest segment, s; for a window in which nothing varies.
const LONGEST_SEGMENT: f64 = 1e6;

/// Local error of a segment over the tolerance of a whole run, so that thousands of pulses together stay within the
/// tolerance; and the smallest local error, below which rounding dominates. A larger one makes runs less exact
/// (`tests/rust/reference.rs`).
const LOCAL: f64 = 1e-5;
const LEAST_EPSILON: f64 = 1e-18;

/// Segments without a switching before implicit collocation is tried. With fewer it is tried within impacts, where it
/// does not pay; with more, balls at rest take short segments for longer (`tests/rust/work.rs`).
const PATIENCE: u32 = 24;

/// The methods for motions in contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Method {
    /// The closed form of the impact of two balls, which never describes a window.
    PairImpact,
    /// Natural modes of linear contacts.
    Modes,
    /// Implicit collocation.
    Radau,
    /// Explicit collocation.
    Gauss,
    /// Taylor series.
    #[default]
    Series,
}

#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Control {
    /// A method to leave out, to test the others.
    pub forbidden: Option<Method>,
    /// Local error over the scale of the velocities.
    pub epsilon: f64,
    /// Order of the series of the velocities.
    pub order: usize,
    /// Relative tolerance of a whole run.
    pub tolerance: f64,
    /// Longest segment, s, where nothing varies.
    pub longest: f64,
}

impl Control {
    /// For this relative tolerance of a whole run of thousands of pulses.
    pub fn new(tolerance: f64) -> Self {
        let epsilon = (LOCAL * tolerance).max(LEAST_EPSILON);
        Self {
            epsilon,
            order: (1.0 - 0.5 * libm::log(epsilon)) as usize,
            tolerance,
            longest: LONGEST_SEGMENT,
            forbidden: None,
        }
    }

    /// Error that a step may make in velocities of this scale, m/s.
    pub fn local_error(&self, scale: f64) -> f64 {
        self.epsilon * scale
    }

    pub fn allows(&self, method: Method) -> bool {
        self.forbidden != Some(method)
    }
}

/// The initial value problem of a segment, with the scales of its errors.
pub(crate) struct Problem<'a> {
    pub window: &'a Window<'a>,
    pub control: &'a Control,
    pub rounding: Rounding,
    /// Scale of the velocities, and the error allowed in them, m/s.
    pub speed: f64,
    pub local_error: f64,
}

/// History of the segments of a cluster, from which the next one is planned.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct StepHistory {
    /// Segments since the last switching.
    pub quiet: u32,
    /// Number of such segments before implicit collocation is tried.
    pub patience: u32,
    /// Length of its next step, s; 0 if another method described the last segment.
    pub implicit_length: f64,
    /// Length of the next explicit step by series or Gauss collocation, from the last one, s.
    pub explicit_length: f64,
}

impl Default for StepHistory {
    fn default() -> Self {
        Self { quiet: 0, patience: PATIENCE, implicit_length: 0.0, explicit_length: 0.0 }
    }
}

impl StepHistory {
    pub fn is_sound(&self) -> bool {
        [self.implicit_length, self.explicit_length].iter().all(|length| (0.0..=LONGEST_SEGMENT).contains(length))
    }
}
