//! What a host has set: the values of parameters and inputs.

use serde::{Deserialize, Serialize};

use crate::model::{Inputs, Parameters, enumerations};

/// Smallest number of balls.
pub const MIN_BALLS: usize = 1;
/// Largest number of balls; every index fits into a value reference.
pub const MAX_BALLS: usize = 10_000;
/// Number of balls of an FMU without resources.
pub const DEFAULT_BALLS: usize = 5;

/// What an instance does for its host.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kind {
    /// The instance solves the equations.
    #[default]
    CoSimulation,
    /// The host solves the equations.
    ModelExchange,
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::CoSimulation => "co-simulation",
            Self::ModelExchange => "model exchange",
        })
    }
}

/// Everything a host can set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Parameters of the cradle.
    pub parameters: Parameters,
    /// Inputs as last set.
    pub inputs: Inputs,
    /// Slopes of the inputs over each step, 1/s times their units (FMI 3.0 only).
    pub slopes: Inputs,
    /// What directional and adjoint derivatives refer to (FMI 3.0 only).
    pub derivatives_of: DerivativesOf,
}

enumerations! {
    /// What directional and adjoint derivatives refer to after initialization, `derivatives.of`.
    DerivativesOf {
        Point = 1 "point" "outputs by inputs at the same time, as the standard defines it",
        LastStep "lastStep" "outputs at the end of the last step, by the inputs held over it",
        Run "run" "outputs at the end of the last step, by real parameters and by inputs over the whole run",
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self::default_for(DEFAULT_BALLS)
    }
}

impl Settings {
    /// The defaults for `balls` balls.
    pub fn default_for(balls: usize) -> Self {
        Self {
            parameters: Parameters::default_for(balls),
            inputs: Inputs::zero(balls),
            slopes: Inputs::zero(balls),
            derivatives_of: DerivativesOf::Point,
        }
    }

    /// Number of balls n.
    pub fn balls(&self) -> usize {
        self.parameters.balls()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variables::{Causality, Shape, Variable, variables};

    #[test]
    fn settings_of_a_part_are_those_of_its_balls_and_contacts() {
        let mut all = Settings::default_for(6);
        for variable in variables(6).filter(|variable| variable.row.shape != Shape::Scalar) {
            variable.set(&mut all, 0.5 + 0.01 * variable.index as f64);
        }
        let part = Settings { parameters: all.parameters.part(&(2..5)), ..Settings::default_for(3) };
        for variable in variables(3).filter(|variable| variable.row.causality == Causality::Parameter) {
            let offset = if variable.row.shape == Shape::Scalar { 0 } else { 2 };
            let same = Variable { index: variable.index + offset, ..variable };
            assert_eq!(variable.value(&part), same.value(&all), "{variable}");
        }
        assert!(part.are_sound(3));
    }
}
