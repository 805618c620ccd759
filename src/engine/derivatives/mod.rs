//! Derivatives of the outputs: by time ([`by_time()`]), along inputs or parameters over the last step or the whole run
//! ([`LastStep`], [`History`]), and gradients ([`Tape`]). See "Derivatives" in docs/theory.md. All but tapes need only
//! a state of the chain ([`ChainState`]) and the inputs, so they serve every method.

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
