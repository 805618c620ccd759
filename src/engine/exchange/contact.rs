//! The record of a contact's pulses.

use serde::{Deserialize, Serialize};

use crate::engine::{Ledger, Observer};
use crate::solver::DoubleDouble;

/// The record of a contact at the last event.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Contact {
    /// Its impulse is the state at the last onset or, after a pulse, at its release.
    pub ledger: Ledger,
    /// Largest force of the last pulse as the last event saw it, N.
    pub peak: f64,
    /// Largest force of the pulse that the host has evaluated, N; many report only steps to communication points.
    pub seen: f64,
    /// Time up to which the last event has followed it, s: until then its states are those of a flight yet to begin.
    pub followed_until: Option<f64>,
    /// Time (s), force (N) and its rate (N/s) at the end of the host's last step, while the contact is closed.
    pub last: Option<(f64, f64, f64)>,
}

impl Contact {
    /// Begins a pulse at `time`, with this impulse so far (N.s).
    pub fn open_pulse(&mut self, time: DoubleDouble, impulse: f64) {
        self.ledger.open_pulse(time, 0);
        self.ledger.impulse = impulse.into();
        (self.last, self.peak, self.seen) = (None, 0.0, 0.0);
    }

    /// Enters a force (N) within a pulse, with its rate (N/s), at the end of a step to `time` (s). The largest force
    /// within the step is the maximum of the cubic through both ends.
    pub fn pass(&mut self, time: f64, force: f64, slope: f64) {
        let mut peak = force;
        if let Some((before, then, slope_then)) = self.last
            && let h = time - before
            && h > 0.0
            && slope_then > 0.0
            && slope < 0.0
        {
            let mean = (force - then) / h;
            let [b, c] = [3.0 * mean - 2.0 * slope_then - slope, slope_then + slope - 2.0 * mean];
            // Of slope_then + 2 b s + 3 c s^2, the root where it falls.
            let s = slope_then / (-b + (b * b - 3.0 * c * slope_then).max(0.0).sqrt());
            if (0.0..=1.0).contains(&s) {
                peak = peak.max(then + h * s * (slope_then + s * (b + s * c)));
            }
        }
        self.ledger.add(0.0, peak, peak);
        self.last = Some((time, force, slope));
    }

    /// Ends a pulse of contact `i` at `time`, with this impulse so far (N.s).
    pub fn close_pulse(&mut self, i: usize, time: DoubleDouble, impulse: f64, observer: &mut dyn Observer) {
        self.ledger.add(impulse - self.ledger.impulse.value(), self.seen, 0.0);
        (self.last, self.peak) = (None, self.ledger.pulse_peak);
        observer.pulse(self.ledger.close_pulse(i, time));
    }
}
