//! The state of the whole chain at one time.

use serde::{Deserialize, Serialize};

use crate::model::Mode;

/// Positions (m), velocities (m/s), overlaps (m) and modes of a chain at one time: all that its motion depends on but the inputs.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct ChainState<S = f64> {
    pub x: Vec<S>,
    pub v: Vec<S>,
    pub overlaps: Vec<S>,
    pub modes: Vec<Mode>,
}

impl ChainState {
    /// Whether it is one of this many balls.
    pub fn is_of(&self, balls: usize) -> bool {
        let contacts = balls.saturating_sub(1);
        [self.x.len(), self.v.len()] == [balls; 2] && [self.overlaps.len(), self.modes.len()] == [contacts; 2]
    }

    /// Whether all of it is finite.
    pub fn is_finite(&self) -> bool {
        [&self.x, &self.v, &self.overlaps].into_iter().flatten().all(|value| value.is_finite())
    }
}
