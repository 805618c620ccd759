//! Observers of a run.

use serde::{Deserialize, Serialize};

use crate::solver::DoubleDouble;

/// The largest force of a contact in a span of time, and when it was first reached.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Peak {
    /// In N.
    pub force: f64,
    /// In s; within the engine often from the start of what is looked at.
    pub time: f64,
}

impl Peak {
    /// Part of a force that is rounding.
    const ROUNDING: f64 = 16.0 * f64::EPSILON;

    /// Takes a `force` at another `time` if it is larger.
    pub(crate) fn raise(&mut self, force: f64, time: f64) {
        if force > self.force {
            *self = Self { force, time };
        }
    }

    /// Takes a `force` whose rate is 0 at another `time` if it is larger. Within `near`, two times, the force has one
    /// maximum: what has been found there is no larger, whatever its rounding.
    pub(crate) fn turn(&mut self, force: f64, time: f64, near: [f64; 2]) {
        self.take(Self { force, time }, near[0] <= self.time && self.time <= near[1]);
    }

    /// Takes the largest force of what began at `begun` (s) if it is larger. Where that began, the force may have been
    /// rising: the place of the maximum is a later one.
    pub(crate) fn continue_with(&mut self, next: Self, begun: f64) {
        self.take(next, self.time == begun);
    }

    /// Takes another peak if it is larger by more than rounding or, if what is known `precedes` it, not smaller by more.
    fn take(&mut self, other: Self, precedes: bool) {
        let least = self.force * (1.0 + if precedes { -Self::ROUNDING } else { Self::ROUNDING });
        if other.force > least {
            self.time = other.time;
        }
        self.force = self.force.max(other.force);
    }

    /// The same, its time counted from the zero of the clock and not from `start`.
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
    /// What the log says of a pulse besides its contact, by name, in SI units: the log line, `log.pulses` and the
    /// instance's checks follow from it.
    pub const VALUES: [(&'static str, OfPulse); 5] = [
        ("onset", |pulse| pulse.onset),
        ("release", |pulse| pulse.release),
        ("peak", |pulse| pulse.peak.force),
        ("impulse", |pulse| pulse.impulse),
        ("peakTime", |pulse| pulse.peak.time),
    ];

    /// The value of this name: one of [`Self::VALUES`] or the duration.
    pub fn value(&self, name: &str) -> Option<f64> {
        if name == "duration" {
            return Some(self.release - self.onset);
        }
        Self::VALUES.iter().find(|(known, _)| *known == name).map(|(_, of)| of(self))
    }

    /// Whether it is one of so many contacts, and finite.
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
    /// What the last one was about.
    pub by: Busy,
}

/// What a run is busy with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Busy {
    /// Steps and events of this contact, from 0, and of those that press at the same time.
    Contact(usize),
    /// The flight of this ball on its arc, from 0: power series, or implicit steps, one after the other.
    Flight(usize),
    /// Steps of a general-purpose solver for the whole chain.
    Solver,
}

/// Is notified of events during a run. It can change nothing but the end of a call.
pub trait Observer {
    /// A pulse has finished.
    fn pulse(&mut self, _pulse: Pulse) {}

    /// Contact `contact`, counted from 0, has closed at `time` (s).
    fn onset(&mut self, _contact: usize, _time: f64) {}

    /// An earlier end for the call of `advance`, s; not before the last event notified.
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
