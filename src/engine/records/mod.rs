//! What a run records while it moves on: the ledger of each contact, and how the step under way began. Plain data,
//! for every method.

mod ledger;
mod step_start;

pub(crate) use ledger::{Ledger, RAPID};
pub(crate) use step_start::{BallStart, StepStart};
