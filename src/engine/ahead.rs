//! The next onset: read off the forecasts, or found by a copy of the run that goes ahead.

use std::cell::{Cell, RefCell};

use super::{Engine, NextOnset, Unrecorded};
use crate::solver::double_double::DoubleDouble;

/// Periods of the first ball within which the next onset is looked for.
pub(super) const ONSET_PERIODS: f64 = 1000.0;

/// Work that one look ahead may take, in the units of [`Engine::effort`]: some tenths of a millisecond. The event that exceeds it is
/// still handled.
const LOOK_AHEAD: u64 = 4_000;

/// The same for copying a ball and its contact.
const COPY: u64 = 3;

/// What has been seen of the future. It is good until the inputs change.
#[derive(Clone, Debug, Default)]
pub(super) struct Ahead {
    /// A copy of the run that has gone ahead on the same trajectory.
    pub scout: RefCell<Option<Box<Engine>>>,
    /// What was found last, and when it was asked for, s.
    pub found: Cell<Option<(f64, NextOnset)>>,
}

impl Engine {
    /// First onset strictly after the current time with the inputs continued, or none within 1000 periods of the first ball. Where a
    /// fixed amount of work does not show it, it is the time up to which there is none; the next look, at a later time, goes on
    /// from there.
    pub fn next_onset(&self) -> NextOnset {
        if let Some((asked_at, answer)) = self.ahead.found.get() {
            // An onset stays the next one until it comes. That there is none within the horizon holds for now only.
            if asked_at == self.time || answer.found().is_some_and(|onset| onset > self.time) {
                return answer;
            }
        }
        // Taken out while it is at work: a copy of the run is not to copy it.
        let mut scout = self.ahead.scout.take();
        let answer = self.look_ahead(&mut scout);
        self.ahead.scout.replace(scout);
        self.ahead.found.set(Some((self.time, answer)));
        answer
    }

    /// A copy that goes ahead. Nobody reads a step of it, so that it need not know how one began.
    fn scout(&self) -> Box<Self> {
        Box::new(Self { step_start: f64::MAX, ..self.clone() })
    }

    fn look_ahead(&self, scout: &mut Option<Box<Self>>) -> NextOnset {
        if self.step == 0 {
            // Made here, where all balls are set up anyway, so that no later look has to copy all of them.
            scout.get_or_insert_with(|| self.scout());
        }
        let period = std::f64::consts::TAU / self.balls[0].oscillator.omega();
        let limit = DoubleDouble::from(self.time + ONSET_PERIODS * period);
        if let Some(answer) = self.read_off(self.time, limit) {
            return answer;
        }
        // Where it has fallen behind, a copy may be cheaper than what it would have to make up for.
        let copying = COPY * self.balls.len() as u64;
        let useful = |scout: &Self| scout.handled >= self.handled || self.effort.saturating_sub(scout.effort) < copying;
        let scout = match scout {
            Some(scout) if useful(scout) => scout,
            slot => slot.insert(self.scout()),
        };
        while scout.handled < self.handled
            && let Some((t, key)) = scout.queue.first()
            && scout.process(t, key, &mut Unrecorded).is_ok()
        {}
        let enough = scout.effort.saturating_add(LOOK_AHEAD);
        let mut passed = self.onsets;
        loop {
            let onset = scout.last_event;
            if scout.onsets > passed && onset > limit {
                return NextOnset::NONE;
            }
            if scout.onsets > passed && onset.value_up() > self.time {
                return NextOnset::at(onset.value_up());
            }
            // Those that are due right now are not ahead.
            passed = scout.onsets;
            if let Some(answer) = scout.read_off(self.time, limit) {
                return answer;
            }
            let Some((t, key)) = scout.queue.first() else { return NextOnset::NONE };
            // What would fail now fails again: the run itself will tell.
            if scout.effort >= enough || scout.process(t, key, &mut Unrecorded).is_err() {
                return NextOnset::not_before(t.value_down(), self.time);
            }
        }
    }

    /// The first onset after `now` (s), if the first entry of the queue tells it: the entry is that onset, or beyond `limit`.
    fn read_off(&self, now: f64, limit: DoubleDouble) -> Option<NextOnset> {
        let Some((t, key)) = self.queue.first().filter(|(t, _)| *t <= limit) else { return Some(NextOnset::NONE) };
        let contact = &self.contacts[key];
        let in_flight = contact.cluster.is_none() && contact.impact.is_none() && contact.bond.is_none();
        (in_flight && contact.due && t.value_up() > now).then(|| NextOnset::at(t.value_up()))
    }
}
