//! The record of a contact's pulses.

use serde::{Deserialize, Serialize};

use crate::engine::{Ledger, Observer, Peak};
use crate::solver::{DoubleDouble, crossing};

/// A closed contact at the end of a step of the host, or at an event.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Reached {
    /// Time, s.
    pub time: f64,
    /// Force, N, and its rate, N/s.
    pub force: f64,
    pub slope: f64,
    /// Impulse since the start, N.s.
    pub impulse: f64,
}

impl Reached {
    /// The largest force on a step from `before` to here, by the polynomial of order 4 that has the forces and rates at
    /// both ends and the step's impulse. A host need not report all steps of its solver, so one step may
    /// hold a whole pulse.
    fn peak_since(&self, before: &Self) -> Peak {
        let h = self.time - before.time;
        if !(h > 0.0 && before.slope >= 0.0 && self.slope <= 0.0 && before.slope > self.slope) {
            return self.peak();
        }
        let (rise, [first, last]) = (self.force - before.force, [before.slope, self.slope].map(|slope| h * slope));
        let cubic = [before.force, first, 3.0 * rise - 2.0 * first - last, first + last - 2.0 * rise];
        let mean = 0.5 * (before.force + self.force) + (first - last) / 12.0;
        // Factor of s^2 (1 - s)^2, whose mean is 1/30.
        let more = 30.0 * ((self.impulse - before.impulse) / h - mean);
        let [a, b, c, d] = cubic;
        let (place, force) = crossing::maximum(&[a, b, c + more, d - 2.0 * more, more], 0.0, 1.0);
        Peak { force, time: if place == 1.0 { self.time } else { before.time + place * h } }
    }

    fn peak(&self) -> Peak {
        Peak { force: self.force, time: self.time }
    }
}

/// The record of a contact at the last event and up to the last step of the host.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct ContactRecord {
    /// Its impulse is the state at the last onset or, after a pulse, at the release.
    pub ledger: Ledger,
    /// Largest force of the last pulse up to the last event, N.
    pub peak: f64,
    /// Time up to which the last event has followed the contact, s; until then its states are those of a flight yet to
    /// begin.
    pub followed_until: Option<f64>,
    /// State at the end of the host's last step, or at the last event, while the contact is closed.
    last: Option<Reached>,
}

impl ContactRecord {
    /// Begins a pulse at `time`, with this impulse so far (N.s).
    pub fn open_pulse(&mut self, time: DoubleDouble, impulse: f64) {
        self.ledger.open_pulse(time, 0);
        self.ledger.impulse = impulse.into();
        (self.last, self.peak) = (None, 0.0);
    }

    /// Enters the end of a step within a pulse, with the largest force on the way.
    pub fn pass(&mut self, now: Reached) {
        let before = self.last.unwrap_or(now);
        self.ledger.raise_peak(now.peak_since(&before), before.time.into());
        self.last = Some(now);
    }

    /// Enters the state after an event, where the force may have jumped.
    pub fn go_on(&mut self, now: Reached) {
        self.ledger.raise_peak(now.peak(), now.time.into());
        (self.last, self.peak) = (Some(now), self.ledger.pulse_peak.force);
    }

    /// Ends a pulse of contact `i` at `time`, with this impulse so far (N.s).
    pub fn close_pulse(&mut self, i: usize, time: DoubleDouble, impulse: f64, observer: &mut dyn Observer) {
        self.ledger.add(impulse - self.ledger.impulse.value());
        (self.last, self.peak) = (None, self.ledger.pulse_peak.force);
        observer.pulse(self.ledger.close_pulse(i, time));
    }
}
