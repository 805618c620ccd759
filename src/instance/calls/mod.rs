//! What a host asks of an [`Instance`](super::Instance) on its way through the phases: values and their derivatives,
//! steps, integration by the host, and saved states. Each module adds methods to it.

mod derivatives;
mod exchange;
mod report;
mod state;
mod step;
mod values;

pub(super) use report::Reporter;
pub use state::SavedState;
pub(super) use step::CLOCK_TOLERANCE;
