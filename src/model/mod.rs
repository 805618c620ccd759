//! The physics of the cradle in SI units. Knows neither FMI nor numerical methods.

mod parameters;

pub use parameters::{ContactModel, DampingLaw, Inputs, Parameters};
