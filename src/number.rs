//! Numbers in messages and files.

use std::fmt::{self, Display, Formatter};

/// A number in the shortest form that reads back as the same double: `0.1`, `2.6e-6`, `1e10`.
pub struct Number(pub f64);

impl Display for Number {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let magnitude = self.0.abs();
        if magnitude != 0.0 && magnitude.is_finite() && !(1e-3..1e5).contains(&magnitude) {
            write!(f, "{:e}", self.0)
        } else {
            write!(f, "{}", self.0)
        }
    }
}
