//! The next onset: read off the forecasts, or found by a copy of the run that goes ahead.

use std::cell::RefCell;

use super::{Engine, NextOnset, Unrecorded};
use crate::solver::double_double::DoubleDouble;

/// Periods of the first ball within which the next onset is looked for.
pub(super) const ONSET_PERIODS: f64 = 1000.0;

/// Work that one look ahead may take, in the units of [`Engine::effort`]: some tenths of a millisecond. The event that exceeds it is
/// still handled.
const LOOK_AHEAD: u64 = 3_000;

/// A copy of a run that has gone ahead of it on the same trajectory. A copy of the run begins without one.
#[derive(Debug, Default)]
pub(super) struct Ahead(RefCell<Option<Box<Engine>>>);

impl Clone for Ahead {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl Ahead {
    /// The trajectory changes from here on.
    pub fn forget(&mut self) {
        self.0.take();
    }
}

impl Engine {
    /// First onset strictly after the current time with the inputs continued, or none within 1000 periods of the first ball. Where a
    /// fixed amount of work does not show it, it is the time up to which there is none; the next look, at a later time, goes on
    /// from there.
    pub fn next_onset(&self) -> NextOnset {
        if let Some((asked_at, answer)) = self.foreseen.get() {
            // An onset stays the next one until it comes. That there is none within the horizon holds for now only.
            if asked_at == self.time || answer.found().is_some_and(|onset| onset > self.time) {
                return answer;
            }
        }
        let answer = self.look_ahead();
        self.foreseen.set(Some((self.time, answer)));
        answer
    }

    fn look_ahead(&self) -> NextOnset {
        if self.step == 0 {
            // Made here, where all balls are set up anyway, so that no later look has to copy all of them.
            self.ahead.0.borrow_mut().get_or_insert_with(|| Box::new(self.clone()));
        }
        let period = std::f64::consts::TAU / self.balls[0].oscillator.omega();
        let limit = DoubleDouble::from(self.time + ONSET_PERIODS * period);
        if let Some(answer) = self.read_off(limit) {
            return answer;
        }
        let mut ahead = self.ahead.0.borrow_mut();
        // One that is far behind would have more to do than a copy.
        let far = self.balls.len() as u64;
        let ahead = match &mut *ahead {
            Some(ahead) if ahead.handled.saturating_add(far) >= self.handled => ahead,
            slot => slot.insert(Box::new(self.clone())),
        };
        let enough = ahead.effort.saturating_add(LOOK_AHEAD);
        loop {
            let level = ahead.handled >= self.handled;
            if ahead.onsets > self.onsets {
                let onset = ahead.last_event;
                return if onset <= limit { NextOnset::at(onset.value_up()) } else { NextOnset::NONE };
            }
            if level && let Some(answer) = ahead.read_off(limit) {
                return answer;
            }
            let Some((t, key)) = ahead.queue.first() else { return NextOnset::NONE };
            let no_further = level && ahead.effort >= enough;
            // What would fail now fails again: the run itself will tell.
            if no_further || ahead.process(t, key, &mut Unrecorded).is_err() {
                return NextOnset::not_before(t.value_down(), self.time);
            }
        }
    }

    /// The next onset, if the first entry of the queue tells it: the entry is an onset, or beyond `limit`.
    fn read_off(&self, limit: DoubleDouble) -> Option<NextOnset> {
        let Some((t, key)) = self.queue.first().filter(|(t, _)| *t <= limit) else { return Some(NextOnset::NONE) };
        let contact = &self.contacts[key];
        let in_flight = contact.cluster.is_none() && contact.impact.is_none() && contact.bond.is_none();
        (in_flight && contact.due).then(|| NextOnset::at(t.value_up()))
    }
}
