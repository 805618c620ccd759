//! The next onset, with the inputs held.

use super::run::Exchange;
use crate::engine::observer::Unrecorded;
use crate::model::{Mode, ONSET_PERIODS};
use crate::next::Next;
use crate::solver::double_double::DoubleDouble;

/// Effort, in units of about a tenth of a microsecond, that one look ahead may take; what comes then is left to the
/// next event.
const LOOK_AHEAD: u64 = 40_000;

impl Exchange {
    /// Finds the next onset later than now by more than the same time; a time up to which there is none where the look
    /// ends; never if there is none within 1000 periods of the first ball.
    pub(super) fn foresee(&mut self) {
        (self.next, self.next_contact) = self.next_onset();
    }

    fn next_onset(&self) -> (Next, Option<usize>) {
        if !self.is_rigid() && self.modes.iter().any(|mode| *mode != Mode::Open) {
            return (Next::not_before(self.time, self.time), None);
        }
        let mut engine = self.engine_at(&self.flights(), &(0..self.balls()), 0.0, &self.closed(), &mut Unrecorded);
        let limit = DoubleDouble::from(ONSET_PERIODS * self.cradle.period());
        let earliest = (self.time + self.margin()).max(self.time.next_up());
        let later = |tau: DoubleDouble| (DoubleDouble::from(self.time) + tau).value_up().max(earliest);
        // What is due now comes as soon as there is another time.
        match engine.seek_onset(engine.onsets, f64::NEG_INFINITY, limit, LOOK_AHEAD) {
            Next::At((tau, contact)) => (Next::At(later(tau)), contact.filter(|_| !self.is_rigid())),
            Next::NotBefore((tau, _)) => (Next::NotBefore(later(tau)), None),
            Next::Never => (Next::Never, None),
        }
    }
}
