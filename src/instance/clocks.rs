//! The clocks: what has happened in the contacts, instant by instant, and how far the clocks have ticked for it.

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
    Release(usize, Ended),
}

/// A pulse that has ended.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Ended {
    /// N.s.
    pub impulse: f64,
    /// The largest force, N.
    pub peak: f64,
    /// s.
    pub duration: f64,
}

impl Transition {
    /// The end of a pulse.
    fn of(pulse: Pulse) -> Self {
        let duration = pulse.release - pulse.onset;
        Self::Release(pulse.contact, Ended { impulse: pulse.impulse, peak: pulse.peak, duration })
    }

    fn contact(&self) -> usize {
        match self {
            Self::Onset(contact) | Self::Release(contact, _) => *contact,
        }
    }

    fn edge(&self) -> Edge {
        if matches!(self, Self::Onset(_)) { Edge::Onset } else { Edge::Release }
    }
}

/// What happens at one instant. A contact closes and opens in it once at most, in this order: more takes another tick.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Tick {
    /// In s.
    time: f64,
    transitions: Vec<Transition>,
}

impl Tick {
    /// Whether this may be a part of it.
    fn takes(&self, transition: &Transition) -> bool {
        let mut of_contact = self.transitions.iter().filter(|other| other.contact() == transition.contact());
        match transition {
            Transition::Onset(_) => of_contact.next().is_none(),
            Transition::Release(..) => of_contact.all(|other| other.edge() == Edge::Onset),
        }
    }

    fn has(&self, edge: Edge) -> bool {
        self.transitions.iter().any(|transition| transition.edge() == edge)
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

/// The clocks of an instance.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Clocks {
    /// Ticks to come, in order.
    pending: VecDeque<Tick>,
    /// Whether the clocks of the last tick are active.
    active: bool,
    /// The last ticks of the two clocks; before the first there is none.
    last_onset: Option<Tick>,
    last_release: Option<Tick>,
    /// Whether the last tick was one of each.
    ticked: [bool; 2],
    discrete: Vec<Discrete>,
    pub work: WorkCounters,
    /// The pulses that have ended by the last tick.
    pub log: Pulses,
}

impl Clocks {
    pub fn new(contacts: usize) -> Self {
        let none = Discrete { pulses: 0, closed: false, onset: -NEVER, release: -NEVER };
        Self {
            pending: VecDeque::new(),
            active: false,
            last_onset: None,
            last_release: None,
            ticked: [false; 2],
            discrete: vec![none; contacts],
            work: WorkCounters::default(),
            log: Pulses::default(),
        }
    }

    pub fn are_sound(&self, contacts: usize) -> bool {
        let tick = |tick: &Tick| {
            let known = |transition: &Transition| match transition {
                Transition::Onset(contact) => *contact < contacts,
                Transition::Release(contact, Ended { impulse, peak, duration }) => {
                    *contact < contacts && (impulse + peak + duration).is_finite()
                }
            };
            tick.time.is_finite() && !tick.transitions.is_empty() && tick.transitions.iter().all(known)
        };
        let discrete = |of: &Discrete| (of.onset + of.release).is_finite() && of.pulses < 1 << 62;
        self.discrete.len() == contacts
            && self.log.are_sound(contacts)
            && self.discrete.iter().all(discrete)
            && self.pending.iter().chain(&self.last_onset).chain(&self.last_release).all(tick)
    }

    /// Whether there are ticks to come.
    pub fn are_due(&self) -> bool {
        !self.pending.is_empty()
    }

    fn push(&mut self, time: f64, transition: Transition) {
        match self.pending.back_mut().filter(|tick| tick.time == time && tick.takes(&transition)) {
            Some(tick) => tick.transitions.push(transition),
            None => self.pending.push_back(Tick { time, transitions: vec![transition] }),
        }
    }

    /// Makes the next tick the active one. Returns whether there was one.
    pub fn tick(&mut self) -> bool {
        self.active = false;
        let Some(tick) = self.pending.pop_front() else { return false };
        for transition in &tick.transitions {
            let discrete = &mut self.discrete[transition.contact()];
            match transition {
                Transition::Onset(_) => {
                    discrete.pulses = discrete.pulses.saturating_add(1);
                    (discrete.closed, discrete.onset) = (true, tick.time);
                }
                Transition::Release(contact, Ended { impulse, peak, .. }) => {
                    (discrete.closed, discrete.release) = (false, tick.time);
                    self.log.enter(Pulse {
                        contact: *contact,
                        onset: discrete.onset,
                        release: tick.time,
                        peak: *peak,
                        impulse: *impulse,
                    });
                }
            }
        }
        (self.active, self.ticked) = (true, [tick.has(Edge::Onset), tick.has(Edge::Release)]);
        if self.ticked[0] {
            self.last_onset = Some(tick.clone());
        }
        if self.ticked[1] {
            self.last_release = Some(tick);
        }
        true
    }

    /// The clocks of the last tick are no longer active.
    pub fn rest(&mut self) {
        self.active = false;
    }

    /// Adds the contacts that have closed at the time `now` (s) without a tick: at the start, or because inputs have
    /// changed.
    pub fn catch_up(&mut self, results: &dyn Results, now: f64) {
        let mut known: Vec<u64> = self.discrete.iter().map(|discrete| discrete.pulses).collect();
        for transition in self.pending.iter().flat_map(|tick| &tick.transitions) {
            known[transition.contact()] += u64::from(transition.edge() == Edge::Onset);
        }
        for (contact, known) in known.into_iter().enumerate() {
            if results.pulses(contact) > known {
                self.push(now, Transition::Onset(contact));
            }
        }
    }

    /// Adds what an event of model exchange has done: these pulses have finished, and other contacts may have closed.
    pub fn enter(&mut self, pulses: &[Pulse], results: &dyn Results) {
        let mut known: Vec<(u64, bool)> =
            self.discrete.iter().map(|discrete| (discrete.pulses, discrete.closed)).collect();
        for transition in self.pending.iter().flat_map(|tick| &tick.transitions) {
            let (onsets, closed) = &mut known[transition.contact()];
            *closed = transition.edge() == Edge::Onset;
            *onsets += u64::from(*closed);
        }
        let mut new = Vec::new();
        for pulse in pulses {
            let (onsets, closed) = &mut known[pulse.contact];
            if !std::mem::take(closed) {
                *onsets += 1;
                new.push((pulse.onset, Transition::Onset(pulse.contact)));
            }
            new.push((pulse.release, Transition::of(*pulse)));
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

    /// Whether a clock is active.
    pub fn is_active(&self, edge: Edge) -> bool {
        self.active && self.ticked[edge as usize]
    }

    fn last(&self, edge: Edge) -> Option<&Tick> {
        if edge == Edge::Onset { self.last_onset.as_ref() } else { self.last_release.as_ref() }
    }

    /// The time of the last tick of a clock, s; before the first one minus [`NEVER`].
    pub fn time(&self, edge: Edge) -> f64 {
        self.last(edge).map_or(-NEVER, |tick| tick.time)
    }

    /// Whether a contact was part of it.
    pub fn is_part(&self, edge: Edge, contact: usize) -> bool {
        let is_it = |transition: &Transition| transition.contact() == contact && transition.edge() == edge;
        self.last(edge).is_some_and(|tick| tick.transitions.iter().any(is_it))
    }

    /// The pulse of a contact that ended at the last tick; all zero if none did.
    pub fn ended(&self, contact: usize) -> Ended {
        let of_contact = |transition: &Transition| match transition {
            Transition::Release(released, ended) if *released == contact => Some(*ended),
            _ => None,
        };
        let ended = self.last(Edge::Release).and_then(|tick| tick.transitions.iter().find_map(of_contact));
        ended.unwrap_or_default()
    }

    /// The discrete variables of a contact; nothing if there is no such contact.
    pub fn discrete(&self, contact: usize) -> Option<&Discrete> {
        self.discrete.get(contact)
    }
}

/// Hands what happens in a step to the clocks, and ends it at the first onset or release if that is wanted.
pub(super) struct Recorder<'a> {
    pub reporter: Reporter<'a>,
    pub clocks: &'a mut Clocks,
    /// Whether its host has clocks or their log.
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
        if self.purpose.arrays && !self.purpose.events {
            self.clocks.log.enter(pulse);
        }
        self.enter(pulse.release, Transition::of(pulse));
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
