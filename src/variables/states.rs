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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_come_in_the_order_of_the_contract() {
        let names: Vec<String> = states(3).map(|(state, rate)| format!("{state} {rate}")).collect();
        let expected = [
            "x[1] v[1]",
            "overlap[1] der(overlap[1])",
            "overlap[2] der(overlap[2])",
            "v[1] a[1]",
            "v[2] a[2]",
            "v[3] a[3]",
            "impulse[1] F[1]",
            "impulse[2] F[2]",
            "E_dissipated der(E_dissipated)",
            "W_external der(W_external)",
        ];
        assert_eq!(names, expected);
        for (place, (state, _)) in states(3).enumerate() {
            assert_eq!(state.state_place(3), Some(place));
        }
        assert_eq!(states(1).count(), 4);
    }
}
