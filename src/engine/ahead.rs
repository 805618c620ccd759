//! The next onset: read off the forecasts, or found by a copy of the run that goes ahead.

use super::{Engine, NEVER};
use crate::solver::double_double::DoubleDouble;

/// Periods of the first ball within which the next onset is looked for.
pub(super) const ONSET_PERIODS: f64 = 1000.0;

/// Entries of the queue that the search handles at most: a fraction of a second of work.
const AHEAD: u64 = 20_000;

impl Engine {
    /// First onset strictly after the current time, s, with the inputs continued; [`NEVER`] if there is none within 1000
    /// periods of the first ball, or among the next 20,000 events that do not follow from closed forms.
    pub fn next_onset(&self) -> f64 {
        if let Some(onset) = self.known_onset.get().filter(|&onset| onset > self.time) {
            return onset;
        }
        let onset = self.find_next_onset();
        // That there is none so far ahead holds for now only.
        self.known_onset.set((onset < NEVER).then_some(onset));
        onset
    }

    fn find_next_onset(&self) -> f64 {
        let period = std::f64::consts::TAU / self.balls[0].oscillator.omega();
        let limit = DoubleDouble::from(self.time + ONSET_PERIODS * period);
        let Some((t, key)) = self.queue.first() else { return NEVER };
        let contact = &self.contacts[key];
        if contact.cluster.is_none() && contact.impact.is_none() && contact.bond.is_none() && contact.due {
            return if t <= limit { t.value_up() } else { NEVER };
        }
        // A contact phase is under way, or the forecasts do not reach far enough: follow a copy.
        let ahead = self.ahead.take().filter(|ahead| ahead.handled >= self.handled && ahead.onsets >= self.onsets);
        let mut ahead = ahead.unwrap_or_else(|| Box::new(self.clone()));
        let last = self.handled.saturating_add(AHEAD);
        let mut found = NEVER;
        if ahead.onsets > self.onsets {
            // It stands at an onset that is yet to come, found when the limit was nearer.
            found = ahead.last_event.value_up();
        }
        while found == NEVER
            && ahead.handled < last
            && let Some((t, key)) = ahead.queue.first().filter(|(t, _)| *t <= limit)
        {
            if ahead.process(t, key, &mut Vec::new()).is_err() {
                break;
            }
            if ahead.onsets > self.onsets {
                found = t.value_up();
            }
        }
        self.ahead.replace(Some(ahead));
        found
    }
}
