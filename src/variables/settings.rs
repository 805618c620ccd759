//! What a host has set: the values of parameters and inputs.

use serde::{Deserialize, Serialize};

use crate::model::{Inputs, Parameters};

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

/// What directional and adjoint derivatives refer to after initialization, `derivatives.of`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum DerivativesOf {
    /// The equations at the current time.
    Point = 1,
    /// The end of the last step, by the inputs held over it.
    LastStep,
    /// The end of the last step, by parameters and by inputs over the whole run.
    Run,
}

impl Settings {
    /// These parameters and inputs; the rest has its defaults.
    pub fn new(parameters: Parameters, inputs: Inputs) -> Self {
        let slopes = Inputs::zero(parameters.balls());
        Self { parameters, inputs, slopes, derivatives_of: DerivativesOf::Point }
    }

    /// The defaults for `balls` balls.
    pub fn default_for(balls: usize) -> Self {
        Self::new(Parameters::default_for(balls), Inputs::zero(balls))
    }

    /// Number of balls n.
    pub fn balls(&self) -> usize {
        self.parameters.balls()
    }
}
