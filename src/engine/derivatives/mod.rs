//! Derivatives of the outputs: by time ([`by_time()`]), and along inputs or parameters, over the last step or the whole
//! run ([`LastStep`], [`History`]). See "Derivatives" in docs/theory.md. They need only a state of the chain and the
//! inputs, so they serve every method.

mod by_time;
mod history;
mod last_step;

pub(crate) use by_time::by_time;
pub use history::History;
pub(crate) use history::Stretch;
pub use last_step::LastStep;
pub(crate) use last_step::StepEnds;
