//! The clocks: onsets and releases instant by instant, and which of them have ticked.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::legality::Purpose;
use super::pulses::Pulses;
use super::report::Reporter;
use crate::engine::{NEVER, Observer, Progress, Pulse, Results, WorkCounters};
use crate::variables::Edge;

/// A contact closes, or opens and ends a pulse.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
enum Transition {
    Onset(usize),
    Release(Pulse),
}

impl Transition {
    fn contact(&self) -> usize {
        match self {
            Self::Onset(contact) => *contact,
            Self::Release(pulse) => pulse.contact,
        }
    }

    fn edge(&self) -> Edge {
        if matches!(self, Self::Onset(_)) { Edge::Onset } else { Edge::Release }
    }
}

/// The transitions at one instant. A contact closes and opens in a tick at most once, in this order; more take another
/// tick.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Tick {
    /// In s.
    time: f64,
    transitions: Vec<Transition>,
}

impl Tick {
    fn takes(&self, transition: &Transition) -> bool {
        let mut of_contact = self.transitions.iter().filter(|other| other.contact() == transition.contact());
        match transition {
            Transition::Onset(_) => of_contact.next().is_none(),
            Transition::Release(_) => of_contact.all(|other| other.edge() == Edge::Onset),
        }
    }

    fn of(&self, edge: Edge) -> impl Iterator<Item = &Transition> {
        self.transitions.iter().filter(move |transition| transition.edge() == edge)
    }

    fn is_sound(&self, contacts: usize) -> bool {
        let known = |transition: &Transition| match transition {
            Transition::Onset(contact) => *contact < contacts,
            Transition::Release(pulse) => pulse.is_sound(contacts),
        };
        self.time.is_finite() && !self.transitions.is_empty() && self.transitions.iter().all(known)
    }
}

/// The discrete variables of a contact after the last tick.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Discrete {
    pub pulses: u64,
    pub closed: bool,
    /// Last onset and release, s.
    pub onset: f64,
    pub release: f64,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Clocks {
    pending: VecDeque<Tick>,
    /// Whether the clocks of onsets and of releases are active.
    pub active: [bool; 2],
    /// Their last ticks; before the first there is none.
    last: [Option<Tick>; 2],
    pub discrete: Vec<Discrete>,
    pub work: WorkCounters,
    /// The pulses that have ended by the last tick.
    pub log: Pulses,
}

impl Clocks {
    pub fn new(contacts: usize) -> Self {
        let none = Discrete { pulses: 0, closed: false, onset: -NEVER, release: -NEVER };
        Self { discrete: vec![none; contacts], ..Self::default() }
    }

    pub fn are_sound(&self, contacts: usize) -> bool {
        let discrete = |of: &Discrete| (of.onset + of.release).is_finite() && of.pulses < 1 << 62;
        self.discrete.len() == contacts
            && self.log.are_sound(contacts)
            && self.discrete.iter().all(discrete)
            && self.pending.iter().chain(self.last.iter().flatten()).all(|tick| tick.is_sound(contacts))
    }

    pub fn are_due(&self) -> bool {
        !self.pending.is_empty()
    }

    fn push(&mut self, time: f64, transition: Transition) {
        match self.pending.back_mut().filter(|tick| tick.time == time && tick.takes(&transition)) {
            Some(tick) => tick.transitions.push(transition),
            None => self.pending.push_back(Tick { time, transitions: vec![transition] }),
        }
    }

    /// Activates the next pending tick; false if there is none.
    pub fn tick(&mut self) -> bool {
        self.active = [false; 2];
        let Some(tick) = self.pending.pop_front() else { return false };
        for transition in &tick.transitions {
            let discrete = &mut self.discrete[transition.contact()];
            match transition {
                Transition::Onset(_) => {
                    discrete.pulses = discrete.pulses.saturating_add(1);
                    (discrete.closed, discrete.onset) = (true, tick.time);
                }
                Transition::Release(pulse) => {
                    (discrete.closed, discrete.release) = (false, tick.time);
                    self.log.enter(*pulse);
                }
            }
        }
        for edge in [Edge::Onset, Edge::Release] {
            if tick.of(edge).next().is_some() {
                self.active[edge as usize] = true;
                self.last[edge as usize] = Some(tick.clone());
            }
        }
        true
    }

    /// Pulses and state of each contact after all pending ticks.
    fn foreseen(&self) -> Vec<(u64, bool)> {
        let mut known: Vec<_> = self.discrete.iter().map(|discrete| (discrete.pulses, discrete.closed)).collect();
        for transition in self.pending.iter().flat_map(|tick| &tick.transitions) {
            let (onsets, closed) = &mut known[transition.contact()];
            *closed = transition.edge() == Edge::Onset;
            *onsets += u64::from(*closed);
        }
        known
    }

    /// Adds the ticks of finished pulses, and of contacts that have closed without an event of a step: at the start, as
    /// inputs changed, or in model exchange.
    pub fn catch_up(&mut self, pulses: &[Pulse], results: &dyn Results) {
        let mut known = self.foreseen();
        let mut new = Vec::new();
        for pulse in pulses {
            let (onsets, closed) = &mut known[pulse.contact];
            if !std::mem::take(closed) {
                *onsets += 1;
                new.push((pulse.onset, Transition::Onset(pulse.contact)));
            }
            new.push((pulse.release, Transition::Release(*pulse)));
        }
        for (contact, (onsets, _)) in known.into_iter().enumerate() {
            if results.pulses(contact) > onsets {
                new.push((results.last_onset(contact), Transition::Onset(contact)));
            }
        }
        new.sort_by(|(time, _), (other, _)| time.total_cmp(other));
        for (time, transition) in new {
            self.push(time, transition);
        }
    }

    /// The time of the last tick of a clock, s; before the first one minus [`NEVER`].
    pub fn time(&self, edge: Edge) -> f64 {
        self.last[edge as usize].as_ref().map_or(-NEVER, |tick| tick.time)
    }

    /// Whether a contact was part of it.
    pub fn is_part(&self, edge: Edge, contact: usize) -> bool {
        let last = self.last[edge as usize].as_ref();
        last.is_some_and(|tick| tick.of(edge).any(|transition| transition.contact() == contact))
    }

    /// The pulse of a contact that ended at the last tick, if one did.
    pub fn ended(&self, contact: usize) -> Option<Pulse> {
        let mut transitions = self.last[Edge::Release as usize].iter().flat_map(|tick| &tick.transitions);
        transitions.find_map(|transition| match transition {
            Transition::Release(pulse) if pulse.contact == contact => Some(*pulse),
            _ => None,
        })
    }
}

/// Passes the onsets and releases of a step to the clocks; if asked, ends the step at the first.
pub(super) struct Recorder<'a> {
    pub reporter: Reporter<'a>,
    pub clocks: &'a mut Clocks,
    /// What the instance is for: whether it has clocks or their log.
    pub purpose: Purpose,
    pub stops: bool,
    /// Time of the first onset or release, s.
    pub stopped: Option<f64>,
}

impl Recorder<'_> {
    fn enter(&mut self, time: f64, transition: Transition) {
        if self.stops {
            self.stopped.get_or_insert(time);
        }
        if self.purpose.events {
            self.clocks.push(time, transition);
        }
    }
}

impl Observer for Recorder<'_> {
    fn pulse(&mut self, pulse: Pulse) {
        self.reporter.pulse(pulse);
        if self.purpose.fmi3 && !self.purpose.events {
            self.clocks.log.enter(pulse);
        }
        self.enter(pulse.release, Transition::Release(pulse));
    }

    fn onset(&mut self, contact: usize, time: f64) {
        self.enter(time, Transition::Onset(contact));
    }

    fn progress(&mut self, progress: Progress) {
        self.reporter.progress(progress);
    }

    fn stop(&self) -> Option<f64> {
        self.stopped
    }
}
