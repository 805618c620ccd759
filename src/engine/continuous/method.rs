//! Which solver integrates the chain.

use serde::{Deserialize, Serialize};

use crate::model::{Parameters, SolverMethod};
use crate::solver::ode::Family;

/// What the solver is started with.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Method {
    Multistep(Family),
    /// With the step, s.
    RungeKutta(f64),
}

impl Method {
    /// The one that the parameters select, if it is not the event-driven one.
    pub fn of(parameters: &Parameters) -> Option<Self> {
        match parameters.method {
            SolverMethod::EventDriven => None,
            SolverMethod::Bdf => Some(Self::Multistep(Family::Bdf)),
            SolverMethod::Adams => Some(Self::Multistep(Family::Adams)),
            SolverMethod::Rk4 => Some(Self::RungeKutta(parameters.fixed_step)),
        }
    }
}
