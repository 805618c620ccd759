//! Derivatives of the outputs: by time, and along inputs or parameters.
//!
//! Those by time are read off the Taylor series of the whole chain about its state ([`by_time()`]). Those along a
//! direction follow the last step, or the whole run with its [`History`], once more in dual numbers ([`LastStep`]).
//! Both need only a state of the chain ([`ChainState`]) and the inputs, so they serve every method. Runs of elastic
//! contacts have a [`Tape`], which also gives gradients. No finite differences are taken.

mod adjoint;
mod by_time;
mod chain_state;
mod history;
mod last_step;
mod tangent;

pub(crate) use adjoint::Recorder;
pub use adjoint::{Gradient, Tape};
pub(crate) use by_time::by_time;
pub(crate) use chain_state::ChainState;
pub use history::History;
pub(crate) use history::Stretch;
pub use last_step::LastStep;
