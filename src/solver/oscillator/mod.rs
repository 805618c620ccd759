//! The damped linear oscillator in closed form.
//!
//! [`Oscillator`] has the functions that every motion under polynomial forces is a sum of (`closed_form`);
//! [`ForcedOscillator`] is one motion under a constant force as a search for its crossings wants it (`response`,
//! `decays`), [`Steady`] one as a steady part and a free swing. Phases are reduced in double-double (`trigonometry`).

mod closed_form;
mod decays;
mod response;
mod steady;

pub use closed_form::{BASIS, MAX_FORCE_ORDER, Oscillator};
pub use response::{ForcedOscillator, Response};
pub use steady::Steady;
