//! The continuous states of model exchange, in their order, and their derivatives.

use super::table::TABLE;
use super::variable::Variable;

/// Rows of states and of their derivatives; of `x` only the first is a state, from which the others follow.
const STATES: [(&str, &str); 6] = [
    ("x", "v"),
    ("overlap", "der(overlap)"),
    ("v", "a"),
    ("impulse", "F"),
    ("E_dissipated", "der(E_dissipated)"),
    ("W_external", "der(W_external)"),
];

/// The first variable of the row of this name.
fn first(name: &str) -> Option<Variable> {
    let (position, row) = TABLE.iter().enumerate().find(|(_, row)| row.name == name)?;
    Some(Variable { row, position, index: 0 })
}

/// How many states the row of this one has.
fn count(state: &Variable, balls: usize) -> usize {
    if state.row.name == "x" { 1 } else { state.row.shape.len(balls) }
}

/// Each state with its derivative.
pub fn states(balls: usize) -> impl Iterator<Item = (Variable, Variable)> {
    STATES
        .iter()
        .flat_map(move |(state, derivative)| {
            let (state, derivative) = (first(state)?, first(derivative)?);
            let at = move |index: usize| (Variable { index, ..state }, Variable { index, ..derivative });
            Some((0..count(&state, balls)).map(at))
        })
        .flatten()
}

impl Variable {
    /// Its place among the states of a cradle of `balls` balls, if it is one.
    pub fn state_place(&self, balls: usize) -> Option<usize> {
        let mut before = 0;
        for state in STATES.iter().filter_map(|(state, _)| first(state)) {
            let count = count(&state, balls);
            if state.position == self.position {
                return (self.index < count).then_some(before + self.index);
            }
            before += count;
        }
        None
    }

    /// The state whose derivative it is, if it is one.
    pub fn state(&self) -> Option<Self> {
        let (state, _) = STATES.iter().find(|(_, derivative)| *derivative == self.row.name)?;
        (*state != "x" || self.index == 0).then_some(Self { index: self.index, ..first(state)? })
    }

    /// Whether it is a state or the derivative of one.
    pub fn is_exchanged(&self) -> bool {
        let whole = STATES.iter().any(|(state, derivative)| *derivative == self.row.name || *state == self.row.name);
        whole && (self.row.name != "x" || self.index == 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variables::Shape;

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
        for (place, (state, rate)) in states(3).enumerate() {
            assert_eq!(state.state_place(3), Some(place));
            assert_eq!(rate.state().unwrap().to_string(), state.to_string());
            assert_eq!(state.row.shape == Shape::Scalar, rate.row.shape == Shape::Scalar);
        }
        assert_eq!(states(1).count(), 4);
        assert!(Variable::named("x[2]", 3).unwrap().state_place(3).is_none());
        assert!(Variable::named("v[2]", 3).unwrap().state().is_none());
    }
}
