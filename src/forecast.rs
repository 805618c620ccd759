//! Forecasts: the next time at which something happens, as far as it is known.

use serde::{Deserialize, Serialize};

/// Time that stands for "never", s.
pub const NEVER: f64 = 1e30;

/// The next time at which something happens, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Forecast<T = f64> {
    /// It happens at this time.
    At(T),
    /// It does not happen before this time; the search has not gone further.
    NotBefore(T),
    /// It never happens, or not within the time searched.
    Never,
}

impl<T> Forecast<T> {
    /// The time at which it happens, or before which it does not; `None` if it never does.
    pub fn until(self) -> Option<T> {
        match self {
            Self::At(time) | Self::NotBefore(time) => Some(time),
            Self::Never => None,
        }
    }
}

impl Forecast {
    /// Not before `time` (s), but always after `now` (s): at the earliest at the next double, so that a search
    /// advances.
    pub fn not_before(time: f64, now: f64) -> Self {
        Self::NotBefore(time.max(now.next_up()))
    }

    /// The time at which it happens, s, if that is known.
    pub fn found(self) -> Option<f64> {
        if let Self::At(time) = self { Some(time) } else { None }
    }

    /// The time at which it happens, or before which it does not, s; [`NEVER`] if it never does.
    pub fn time(self) -> f64 {
        self.until().unwrap_or(NEVER)
    }

    /// Whether the search is complete.
    pub fn is_settled(self) -> bool {
        !matches!(self, Self::NotBefore(_))
    }
}
