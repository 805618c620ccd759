//! The damped linear oscillator in closed form.
//!
//! [`Oscillator`] has the functions that every motion under polynomial forces is a sum of (`closed_form`);
//! [`ForcedOscillator`] is one motion under a constant force as a search for its crossings wants it, [`Steady`] one as
//! a steady part and a free swing.

mod closed_form;
mod response;
mod steady;

pub use closed_form::{BASIS, MAX_FORCE_ORDER, Oscillator};
pub use response::ForcedOscillator;
pub use steady::Steady;
