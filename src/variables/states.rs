//! The continuous states of model exchange, in their order, and their derivatives.

use super::arrays::Array;
use super::variable::Variable;

/// Each state with its derivative: of `q` the first position and the overlaps, from which other positions follow.
pub fn states(balls: usize) -> impl Iterator<Item = (Variable, Variable)> {
    Array::states().flat_map(move |(state, derivative)| {
        let element = move |i| Some((state.element(i, balls)?, derivative.element(i, balls)?));
        (0..balls).filter_map(element)
    })
}

impl Variable {
    /// Its place among the states of a cradle of `balls` balls, if it is one.
    pub fn state_place(&self, balls: usize) -> Option<usize> {
        let first = match self.row.name {
            "x" => return (self.index == 0).then_some(0),
            "overlap" => 1,
            "v" => balls,
            "impulse" => 2 * balls,
            "E_dissipated" => 3 * balls - 1,
            "W_external" => 3 * balls,
            _ => return None,
        };
        Some(first + self.index)
    }
}
