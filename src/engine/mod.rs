//! Drives a run. [`Simulation`] is one by any method: the event-driven [`Engine`], or a general solver, [`Continuous`].
//!
//! | module | what it does | needs |
//! |---|---|---|
//! | `flight` | balls that touch nothing: closed forms, series on arcs, the next onset of two | |
//! | `records` | what a run records: ledgers, the start of the step | |
//! | `cluster` | balls in contact: Taylor series, natural modes, collocation | `flight` |
//! | `pair_impact`, `pair_on_arcs` | elastic impacts of two: outcome known at the onset | `flight`, `cluster` |
//! | `rigid` | impacts without duration, balls that move as one body | `flight` |
//! | `run` | the state of an event-driven run and its events | all above |
//! | `derivatives` | of the outputs: by time, along inputs and parameters | `run` and all above |
//! | `observation` | the outputs of a run at the current time, the next onset | `run`, `derivatives` and all above |
//! | `exchange` | a run that its host integrates | `flight`, `records`, `rigid`, `run`, `observation` |
//! | `continuous` | BDF, Adams and Runge-Kutta over the whole chain | `flight`, `records`, `run`, `derivatives` |
//!
//! Events come at their own times, so communication points change no bit of a trajectory; nor does reading results. A
//! run can be saved as plain data and restored.

mod cluster;
mod continuous;
mod derivatives;
mod error;
mod exchange;
mod flight;
mod inputs;
mod observation;
mod observer;
mod pair_impact;
mod pair_on_arcs;
mod records;
mod rigid;
mod run;
mod simulation;

pub use crate::model::{Chain, Differential, MAX_INPUT_DERIVATIVE, MAX_OUTPUT_DERIVATIVE, Results, WorkCounters};
pub use crate::next::{NEVER, Next};
pub use continuous::Continuous;
pub use derivatives::{Gradient, History, LastStep, Tape};
pub use error::{EngineError, Fault};
pub use exchange::{Exchange, Update, state_count};
pub(crate) use inputs::HeldInputs;
pub use observer::{Observer, Progress, Pulse, Unrecorded};
pub(crate) use records::{Ledger, RAPID, StepStart};
pub(crate) use run::require;
pub use run::{Engine, Snapshot, Unsound};
pub use simulation::{Simulation, SimulationSnapshot};
