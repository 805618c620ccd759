//! When something happens next, as far as has been looked.

use serde::{Deserialize, Serialize};

/// Time given for "never" where an event lies ahead, s.
pub const NEVER: f64 = 1e30;

/// When something happens next.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Forecast<T = f64> {
    /// At this time.
    At(T),
    /// Not before this time; what comes then has not been looked at.
    NotBefore(T),
    /// Never, or not as long as was asked for.
    Never,
}

impl<T> Forecast<T> {
    /// When it happens, or up to when it does not; `None` if it does not at all.
    pub fn until(self) -> Option<T> {
        match self {
            Self::At(time) | Self::NotBefore(time) => Some(time),
            Self::Never => None,
        }
    }
}

impl Forecast {
    /// After the time `now` (s) not before `time` (s). Between one double and the next there is no time, so that the
    /// answer can always be later than now.
    pub fn not_before(time: f64, now: f64) -> Self {
        Self::NotBefore(time.max(now.next_up()))
    }

    /// When it happens, s, if that is known.
    pub fn found(self) -> Option<f64> {
        if let Self::At(time) = self { Some(time) } else { None }
    }

    /// When it happens, or up to when it does not, s; [`NEVER`] if it does not at all.
    pub fn time(self) -> f64 {
        self.until().unwrap_or(NEVER)
    }

    /// Whether the search has come to an end.
    pub fn is_settled(self) -> bool {
        !matches!(self, Self::NotBefore(_))
    }
}
