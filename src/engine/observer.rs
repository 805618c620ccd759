//! Observers of a run.

use serde::{Deserialize, Serialize};

use crate::solver::DoubleDouble;

/// The largest force of a contact in a span of time, and when it was first reached.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Peak {
    /// Force, N.
    pub force: f64,
    /// Time, s; within the engine often counted from the start of a span.
    pub time: f64,
}

impl Peak {
    /// Rounding error of a force, relative.
    const ROUNDING: f64 = 16.0 * f64::EPSILON;

    /// Takes `force` at `time` if it is larger.
    pub(crate) fn raise(&mut self, force: f64, time: f64) {
        if force > self.force {
            *self = Self { force, time };
        }
    }

    /// Takes a `force` whose rate is 0 at `time`, if it is larger. Between the two times `near` the force has only one
    /// maximum, so a force found there before is not larger, whatever its rounding.
    pub(crate) fn raise_to_maximum(&mut self, force: f64, time: f64, near: [f64; 2]) {
        self.take(Self { force, time }, near[0] <= self.time && self.time <= near[1]);
    }

    /// Takes the largest force of a part that began at `begun` (s), if it is larger. If the largest force so far was at
    /// `begun`, the force was still rising there, so the maximum is later.
    pub(crate) fn continue_with(&mut self, next: Self, begun: f64) {
        self.take(next, self.time == begun);
    }

    /// Takes another peak if it is larger by more than rounding; if the known one `precedes` it, also if it is not
    /// smaller by more.
    fn take(&mut self, other: Self, precedes: bool) {
        let least = self.force * (1.0 + if precedes { -Self::ROUNDING } else { Self::ROUNDING });
        if other.force > least {
            self.time = other.time;
        }
        self.force = self.force.max(other.force);
    }

    /// The peak with its time counted from the zero of the clock instead of from `start`.
    pub(crate) fn after(self, start: DoubleDouble) -> Self {
        Self { time: (start + self.time).value_up(), ..self }
    }
}

/// One finished contact pulse.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pulse {
    /// Index of the contact, from 0.
    pub contact: usize,
    /// When the contact closed, s.
    pub onset: f64,
    /// When it opened again, s.
    pub release: f64,
    /// Largest contact force.
    pub peak: Peak,
    /// Integral of the contact force, N.s.
    pub impulse: f64,
}

/// Reads a value of a pulse.
pub type OfPulse = fn(&Pulse) -> f64;

impl Pulse {
    /// The values of a pulse in the log besides its contact, by name, in SI units. The log line, `log.pulses` and the
    /// instance's checks follow from this list.
    pub const VALUES: [(&'static str, OfPulse); 5] = [
        ("onset", |pulse| pulse.onset),
        ("release", |pulse| pulse.release),
        ("peak", |pulse| pulse.peak.force),
        ("impulse", |pulse| pulse.impulse),
        ("peakTime", |pulse| pulse.peak.time),
    ];

    /// The value of this name: one of [`Self::VALUES`] or the duration, s.
    pub fn value(&self, name: &str) -> Option<f64> {
        if name == "duration" {
            return Some(self.release - self.onset);
        }
        Self::VALUES.iter().find(|(known, _)| *known == name).map(|(_, of)| of(self))
    }

    /// Whether the contact is below `contacts` and all values are finite.
    pub fn is_sound(&self, contacts: usize) -> bool {
        self.contact < contacts && Self::VALUES.iter().all(|(_, of)| of(self).is_finite())
    }
}

/// Progress of a call of [`advance`](super::Simulation::advance).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Time reached, s.
    pub time: f64,
    /// Rounds of work in this call so far: steps and events.
    pub rounds: u64,
    /// What the last round was about.
    pub activity: Activity,
}

/// What a run is computing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Activity {
    /// Steps and events of this contact, from 0, and of those that press at the same time.
    Contact(usize),
    /// The flight of this ball on its arc, from 0: power series, or implicit steps, one after the other.
    Flight(usize),
    /// Steps of a general-purpose solver for the whole chain.
    Solver,
}

/// Is notified of events during a run. It can change nothing but the end of a call, by [`stop`](Self::stop).
pub trait Observer {
    /// A pulse has finished.
    fn pulse(&mut self, _pulse: Pulse) {}

    /// Contact `contact`, counted from 0, has closed at `time` (s).
    fn onset(&mut self, _contact: usize, _time: f64) {}

    /// An earlier end for the call of `advance`, s, if wanted; not before the last event notified.
    fn stop(&self) -> Option<f64> {
        None
    }

    /// Called every few milliseconds of work, at reproducible points.
    fn progress(&mut self, _progress: Progress) {}
}

/// Collects the pulses.
impl Observer for Vec<Pulse> {
    fn pulse(&mut self, pulse: Pulse) {
        self.push(pulse);
    }
}

/// Discards the pulses.
#[derive(Clone, Copy, Debug)]
pub struct Unrecorded;

impl Observer for Unrecorded {}
