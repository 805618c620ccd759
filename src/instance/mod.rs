//! One running instance of the FMU, for hosts of both versions of the standard.
//!
//! [`Instance`] takes what the host wants in Rust types; the folder of an FMI version translates. That folder asks
//! [`Instance::require`] whether a call is legal in the current phase before it makes the call: once, in one place.
//! What an instance calculates with is a [`Simulation`](crate::engine::Simulation), what it can be asked for a
//! [`Variable`](crate::variables::Variable).
//!
//! What FMI 3.0 adds is variables as arrays (`arrays`, `array_derivatives`), and hosts that take part in events: steps
//! that end or are interrupted at an onset or a release (`step`), and clocks that tick once for each such instant
//! (`clocks`).

mod array_derivatives;
mod arrays;
mod clocks;
mod derivatives;
mod exchange;
mod legality;
mod lifecycle;
mod log;
mod pulses;
mod report;
mod run;
mod saved;
mod step;
mod values;

pub use arrays::Value;
pub use legality::{Call, Kind, Phase, Purpose};
pub use lifecycle::Instance;
pub use log::{Log, Severity, Sink};
pub use run::Experiment;
pub use saved::SavedState;
pub use step::{Handled, StepEnd};
