//! Drives a run. [`Simulation`] is a run by any method: by the event-driven [`Engine`] or by a general solver,
//! [`Continuous`].
//!
//! Each module imports only from those before it: `flight`, `records`, `cluster`, `arc_impact`, `pair_impact`,
//! `rigid`, `tape`, `run`, `derivatives`, `observation`, `exchange`, `continuous`.
//!
//! Events have their own times: between changes of the inputs, neither communication points nor reading results change
//! a bit of a trajectory.

mod arc_impact;
mod chain_state;
mod cluster;
mod continuous;
mod derivatives;
mod equations;
mod error;
mod exchange;
mod flight;
mod inputs;
mod observation;
mod observer;
mod pair_impact;
mod records;
mod rigid;
mod run;
mod simulation;
mod tape;
mod watchdog;

pub use crate::forecast::{Forecast, NEVER};
pub use crate::model::{Chain, Differential, MAX_INPUT_DERIVATIVE, MAX_OUTPUT_DERIVATIVE, Results, WorkCounters};
pub use continuous::Continuous;
pub use derivatives::{History, LastStep};
pub use error::{EngineError, Fault};
pub use exchange::{Exchange, Update, state_count};
pub(crate) use inputs::HeldInputs;
pub use observer::{Activity, Observer, Peak, Progress, Pulse, Unrecorded};
pub(crate) use records::{Ledger, RAPID, StepStart};
pub(crate) use run::require;
pub use run::{Engine, InvalidState, Snapshot};
pub use simulation::{Simulation, SimulationSnapshot};
pub use tape::{Gradient, Tape, Unfollowed};
use watchdog::Watchdog;
