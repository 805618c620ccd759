//! What is summed up over a whole run.

use serde::{Deserialize, Serialize};

use crate::model::WorkCounters;
use crate::solver::double_double::DoubleDouble;

/// The sums of an event-driven run so far.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Totals {
    /// Energy lost in the contacts up to the start of their current segments, J.
    pub contact_loss: f64,
    /// Total energy at the start, J.
    pub energy_at_start: f64,
    pub work: WorkCounters,
    /// Time of the last event and how many came without any progress of time.
    pub last_event: DoubleDouble,
    pub standstill: usize,
}
