//! An event-driven run; see "A run" in docs/theory.md. [`Engine`] is its state; `hold`, `retune` and `advance`
//! (`advance`) move it on. An event regroups the balls about one contact (`contact`): onsets, releases and forecasts
//! (`events`), and what balls do together (`interaction`, `segments`): clusters (`clusters`), impacts of two
//! (`pair_impacts`), rigid contacts (`rigid_contacts`). `snapshot` saves and restores it.

mod advance;
mod clusters;
mod contact;
mod engine;
mod events;
mod interaction;
#[cfg(test)]
mod methods;
mod pair_impacts;
mod rigid_contacts;
mod segments;
mod snapshot;

pub(crate) use contact::{ContactRole, RestRule, contiguous_range};
pub use engine::Engine;
pub(crate) use engine::NO_STEP;
pub(crate) use interaction::Interaction;
pub(crate) use segments::SegmentAt;
pub(crate) use snapshot::require;
pub use snapshot::{InvalidState, Snapshot};
