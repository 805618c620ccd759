//! The damped linear oscillator in closed form, [`Oscillator`]; its motion under a constant force,
//! [`ForcedOscillator`]; and that motion split into a steady part and a free swing, [`Steady`].

mod closed_form;
mod response;
mod sensitivity;
mod steady;

pub use closed_form::{BASIS, MAX_FORCE_ORDER, Oscillator};
pub use response::ForcedOscillator;
pub use steady::Steady;
