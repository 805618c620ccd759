//! An event-driven run.
//!
//! [`Engine`] is its state; `hold`, `retune` and `advance` move it on. Between events every ball is in flight, in an
//! impact of known outcome, in a cluster or in a body, and every contact has a phase (`contact`); the next event of
//! each is in a queue. An event regroups the balls about one contact: onsets, releases and forecasts (`events`),
//! clusters (`clusters`), impacts of two (`pair_impacts`), rigid contacts (`rigid_contacts`). A run can be saved and
//! restored (`snapshot`).

mod caches;
mod clusters;
mod contact;
mod engine;
mod events;
mod pair_impacts;
mod rigid_contacts;
mod snapshot;
mod watchdog;

pub(crate) use contact::{Keep, Phase, around};
pub use engine::Engine;
pub(crate) use engine::NO_STEP;
pub(crate) use snapshot::require;
pub use snapshot::{Snapshot, Unsound};
