//! The damped linear oscillator in closed form.
//!
//! [`Oscillator`] has the functions of which every motion under polynomial forces is a sum (`closed_form`);
//! [`ForcedOscillator`] is a motion under a constant force with bounds of its derivatives, [`Steady`] a motion as a
//! steady part and a free swing.

mod closed_form;
mod response;
mod steady;

pub use closed_form::{BASIS, MAX_FORCE_ORDER, Oscillator};
pub use response::ForcedOscillator;
pub use steady::Steady;
