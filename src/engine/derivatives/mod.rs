//! Derivatives of the outputs: by time, and along inputs or parameters.
//!
//! Those by time are read off the Taylor series of the whole chain about its state ([`by_time`]). Those along a direction follow
//! the last step once more in dual numbers ([`LastStep`]). Both need only a state of the chain ([`ChainState`]) and the inputs
//! held: they serve every method. No differences are taken.

mod by_time;
mod chain_state;
mod last_step;
mod of_run;
mod tangent;

pub(crate) use by_time::by_time;
pub(crate) use chain_state::ChainState;
pub(crate) use last_step::LastStep;
pub use tangent::NotFollowed;
