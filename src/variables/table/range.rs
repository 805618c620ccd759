//! Values that variables may take.

use crate::variables::text::Number;

/// Values a real variable may take, all of them finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Smallest value, if there is one.
    pub min: Option<f64>,
    /// Largest value, if there is one.
    pub max: Option<f64>,
    /// Whether `min` itself is refused.
    pub above_min: bool,
}

/// Any finite value.
pub const ANY: Range = Range { min: None, max: None, above_min: false };
/// Zero or more.
pub const NOT_NEGATIVE: Range = Range { min: Some(0.0), max: None, above_min: false };
/// More than zero. The description can only say `min="0"`; its text adds that 0 itself is refused.
pub const POSITIVE: Range = Range { min: Some(0.0), max: None, above_min: true };

/// `min` to `max`, both included.
pub const fn between(min: f64, max: f64) -> Range {
    Range { min: Some(min), max: Some(max), above_min: false }
}

impl Range {
    /// Whether `value` is finite and inside.
    pub fn contains(&self, value: f64) -> bool {
        let above = self.min.is_none_or(|min| value > min || value == min && !self.above_min);
        value.is_finite() && above && self.max.is_none_or(|max| value <= max)
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.min, self.max) {
            (Some(min), Some(max)) => write!(f, "{} to {}", Number(min), Number(max)),
            (Some(min), None) if self.above_min => write!(f, "finite and > {}", Number(min)),
            (Some(min), None) => write!(f, "finite and >= {}", Number(min)),
            (None, _) => write!(f, "any finite value"),
        }
    }
}
