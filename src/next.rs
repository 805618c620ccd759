//! When something happens next, as far as has been looked.

use serde::{Deserialize, Serialize};

/// When something happens next.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Next<T = f64> {
    /// At this time.
    At(T),
    /// Not before this time; what comes then has not been looked at.
    NotBefore(T),
    /// Never, or not as long as was asked for.
    Never,
}
