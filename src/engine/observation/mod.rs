//! What a run shows.
//!
//! The ledger of a contact ([`Ledger`]) and the start of the step under way ([`StepStart`]) are kept while the run moves on
//! (`recording`); all else is evaluated when somebody asks, and moves nothing: the outputs at the current time (`outputs`), and the
//! next onset, which a copy of the run may go ahead to find (`look_ahead`).

mod ledger;
mod look_ahead;
mod outputs;
mod recording;
mod step_start;

pub(crate) use ledger::{LARGEST_COUNT, Ledger, RAPID};
pub(crate) use step_start::{BallStart, ContactStart, StepStart};
