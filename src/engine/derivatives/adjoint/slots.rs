//! What varies from one part of a run to the next.

use crate::solver::double_double::DoubleDouble;

/// One number for each position, velocity and impulse at one time: how much it changes, or how much something changes
/// with it.
///
/// Within a contact a change of a position makes one of velocities that is `omega` times as large, most of which is
/// gone at its end. That would cost doubles five digits, and both directions of a tape would lose different ones.
#[derive(Clone, Debug, Default)]
pub(super) struct Slots {
    pub x: Vec<DoubleDouble>,
    pub v: Vec<DoubleDouble>,
    pub impulse: Vec<DoubleDouble>,
}

impl Slots {
    pub fn zero(balls: usize) -> Self {
        let zero = DoubleDouble::ZERO;
        Self { x: vec![zero; balls], v: vec![zero; balls], impulse: vec![zero; balls.saturating_sub(1)] }
    }
}

/// The same numbers as double-doubles.
pub(super) fn exactly(values: &[f64]) -> Vec<DoubleDouble> {
    values.iter().map(|value| DoubleDouble::from(*value)).collect()
}

/// The numbers rounded.
pub(super) fn rounded(values: &[DoubleDouble]) -> Vec<f64> {
    values.iter().map(|value| value.value()).collect()
}

/// The sum of the products. A direction `b` is mostly zeros.
pub(super) fn dot(a: &[DoubleDouble], b: &[f64]) -> DoubleDouble {
    a.iter().zip(b).filter(|(_, b)| **b != 0.0).fold(DoubleDouble::ZERO, |sum, (a, b)| sum + *a * *b)
}
