//! One running instance of the FMU, for hosts of both versions of the standard.
//!
//! [`Instance`] has Rust types; the folders `fmi2` and `fmi3` translate from C. Before each call they ask
//! [`Instance::require`] whether it is legal in the current phase. An instance calculates with a
//! [`Simulation`](crate::engine::Simulation) and reads and sets [`Variable`](crate::variables::Variable)s.
//!
//! Values are read and set (`values`) as arrays, whose elements are FMI 2.0's scalars. FMI 3.0 adds steps
//! that end or pause at an onset or a release (`step`), and clocks that tick once for each such instant (`clocks`).

mod clocks;
mod derivatives;
mod exchange;
mod legality;
mod lifecycle;
mod log;
mod report;
mod saved;
mod step;
mod values;

pub use legality::{Call, Kind, Phase, Purpose};
pub use lifecycle::{Experiment, Instance, Start};
pub use log::{Log, LogSink, Severity};
pub use saved::SavedState;
pub use step::{Handled, StepEnd};
