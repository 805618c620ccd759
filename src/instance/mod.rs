//! One running instance of the FMU, independent of the version of the standard.
//!
//! [`Instance`] takes what the host wants in Rust types; the folder of an FMI version translates. That folder asks
//! [`Instance::require`] whether a call is legal in the current phase before it makes the call: once, in one place.
//! What an instance calculates with is a [`Simulation`](crate::engine::Simulation), what it can be asked for a
//! [`Variable`](crate::variables::Variable).

mod calls;
mod hybrid;
mod legality;
mod lifecycle;
mod log;
mod refusal;
mod run;

pub use calls::SavedState;
pub use hybrid::{Handled, StepEnd, UpdateAnswer, Value};
pub use legality::{Call, Kind, Phase};
pub use lifecycle::Instance;
pub use log::{Log, Severity, Sink};
pub use refusal::{Refusal, StateError};
pub use run::Experiment;
