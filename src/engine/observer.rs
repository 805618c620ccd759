//! Observers of a run.

use serde::{Deserialize, Serialize};

/// One finished contact pulse.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pulse {
    /// Index of the contact, from 0.
    pub contact: usize,
    /// When the contact closed, s.
    pub onset: f64,
    /// When it opened again, s.
    pub release: f64,
    /// Largest contact force, N.
    pub peak: f64,
    /// Integral of the contact force, N.s.
    pub impulse: f64,
}

impl Pulse {
    /// Whether it is one of so many contacts, and finite.
    pub fn is_sound(&self, contacts: usize) -> bool {
        self.contact < contacts && (self.onset + self.release + self.peak + self.impulse).is_finite()
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
