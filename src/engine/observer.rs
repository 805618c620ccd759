//! Who is notified of what happens while a run moves on.

use serde::{Deserialize, Serialize};

use crate::solver::double_double::DoubleDouble;

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

/// How far a call of [`advance`](super::Simulation::advance) has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Time reached, s.
    pub time: f64,
    /// Events handled, or steps of a general-purpose solver made, in this call so far.
    pub events: u64,
    /// The contact that the last event was about, from 0; none for a step of the whole chain.
    pub contact: Option<usize>,
}

/// Is notified of what happens while a run moves on. It sees, and changes nothing but where a call ends.
pub trait Observer {
    /// A pulse has finished.
    fn pulse(&mut self, pulse: Pulse);

    /// Contact `contact`, counted from 0, has closed at `time` (s).
    fn onset(&mut self, _contact: usize, _time: f64) {}

    /// Contact `contact` has closed, or else opened, at `time` (s), which event-driven runs give to all its
    /// digits.
    fn switching(&mut self, _contact: usize, _time: DoubleDouble, _closes: bool) {}

    /// Where the call of `advance` is to end, s, if that is before its own end: not before the last event that it was
    /// notified of.
    fn stop(&self) -> Option<f64> {
        None
    }

    /// The run is still on its way. Called every few milliseconds of work, as often in every run.
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

impl Observer for Unrecorded {
    fn pulse(&mut self, _pulse: Pulse) {}
}
