//! The physics of the cradle in SI units. Knows neither FMI nor numerical methods; its formulas take doubles and dual numbers.

mod contact;
mod cradle;

pub use contact::{ContactLaw, Damping, Mode};
pub use cradle::{BallModel, Cradle, hertz_stiffness};
pub use cradle_interface::parameters::{ContactModel, DampingLaw, Inputs, Parameters, SolverMethod, Tunables};
