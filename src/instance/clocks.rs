//! The clocks: onsets and releases instant by instant, which of them have ticked, and the last pulses as text:
//! `log.pulses`.

use std::collections::VecDeque;
use std::fmt::Display;

use serde::{Deserialize, Serialize};

use crate::engine::{NEVER, Pulse, Results, WorkCounters};
use crate::variables::{Edge, MAX_LOG};

/// The contacts that close and the pulses that end at one instant. A contact closes and opens at most once in a tick,
/// in this order; the next time is another tick.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Tick {
    /// Time, s.
    time: f64,
    closed: Vec<usize>,
    ended: Vec<Pulse>,
}

impl Tick {
    fn has_closed(&self, contact: usize) -> bool {
        self.closed.contains(&contact)
    }

    fn ended(&self, contact: usize) -> Option<Pulse> {
        self.ended.iter().find(|pulse| pulse.contact == contact).copied()
    }

    fn is_sound(&self, contacts: usize) -> bool {
        let is_empty = self.closed.is_empty() && self.ended.is_empty();
        let known = self.closed.iter().all(|contact| *contact < contacts);
        self.time.is_finite() && !is_empty && known && self.ended.iter().all(|pulse| pulse.is_sound(contacts))
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
    /// The last tick of each clock, if there was one.
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

    /// The last pending tick, if it is at this time and `takes` what is to be added; otherwise a new one.
    fn pending_at(&mut self, time: f64, takes: impl Fn(&Tick) -> bool) -> &mut Tick {
        if !self.pending.back().is_some_and(|tick| tick.time == time && takes(tick)) {
            self.pending.push_back(Tick { time, closed: Vec::new(), ended: Vec::new() });
        }
        let last = self.pending.len() - 1;
        &mut self.pending[last]
    }

    pub fn close(&mut self, contact: usize, time: f64) {
        let takes = |tick: &Tick| !tick.has_closed(contact) && tick.ended(contact).is_none();
        self.pending_at(time, takes).closed.push(contact);
    }

    pub fn end(&mut self, pulse: Pulse) {
        self.pending_at(pulse.release, |tick| tick.ended(pulse.contact).is_none()).ended.push(pulse);
    }

    /// Activates the next pending tick; false if there is none.
    pub fn tick(&mut self) -> bool {
        self.active = [false; 2];
        let Some(tick) = self.pending.pop_front() else { return false };
        for contact in &tick.closed {
            let discrete = &mut self.discrete[*contact];
            discrete.pulses = discrete.pulses.saturating_add(1);
            (discrete.closed, discrete.onset) = (true, tick.time);
        }
        for pulse in &tick.ended {
            let discrete = &mut self.discrete[pulse.contact];
            (discrete.closed, discrete.release) = (false, tick.time);
            self.log.enter(*pulse);
        }
        self.active = [!tick.closed.is_empty(), !tick.ended.is_empty()];
        for (last, _) in self.last.iter_mut().zip(self.active).filter(|(_, active)| *active) {
            *last = Some(tick.clone());
        }
        true
    }

    /// Pulses and state of each contact after all pending ticks.
    fn foreseen(&self) -> Vec<(u64, bool)> {
        let mut known: Vec<_> = self.discrete.iter().map(|discrete| (discrete.pulses, discrete.closed)).collect();
        for tick in &self.pending {
            tick.closed.iter().for_each(|contact| known[*contact] = (known[*contact].0 + 1, true));
            tick.ended.iter().for_each(|pulse| known[pulse.contact].1 = false);
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
                new.push((pulse.onset, pulse.contact, None));
            }
            new.push((pulse.release, pulse.contact, Some(*pulse)));
        }
        for (contact, (onsets, _)) in known.into_iter().enumerate() {
            if results.pulses(contact) > onsets {
                new.push((results.last_onset(contact), contact, None));
            }
        }
        new.sort_by(|(time, ..), (other, ..)| time.total_cmp(other));
        for (time, contact, ended) in new {
            match ended {
                Some(pulse) => self.end(pulse),
                None => self.close(contact, time),
            }
        }
    }

    /// The time of the last tick of a clock, s; before the first one minus [`NEVER`].
    pub fn time(&self, edge: Edge) -> f64 {
        self.last[edge as usize].as_ref().map_or(-NEVER, |tick| tick.time)
    }

    /// Whether a contact was part of the last tick of a clock.
    pub fn is_part(&self, edge: Edge, contact: usize) -> bool {
        self.last[edge as usize].as_ref().is_some_and(|tick| match edge {
            Edge::Onset => tick.has_closed(contact),
            Edge::Release => tick.ended(contact).is_some(),
        })
    }

    /// The pulse of a contact that ended at the last tick, if one did.
    pub fn ended(&self, contact: usize) -> Option<Pulse> {
        self.last[Edge::Release as usize].as_ref()?.ended(contact)
    }
}

/// Most bytes of a line: five digits, numbers of up to 24 bytes, separators. The header is no longer.
const LINE: usize = 5 + 25 * Pulse::VALUES.len() + 1;
const KEPT: usize = MAX_LOG / LINE - 1;

/// The last pulses, in the order in which they ended.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Pulses(VecDeque<Pulse>);

impl Pulses {
    pub fn enter(&mut self, pulse: Pulse) {
        if self.0.len() == KEPT {
            self.0.pop_front();
        }
        self.0.push_back(pulse);
    }

    /// CSV with the units of the variables; contacts are counted from 1, and numbers read back as the same doubles.
    pub fn csv(&self) -> String {
        let line = |contact: &dyn Display, value: &dyn Fn(usize) -> String| {
            let values: Vec<String> = (0..Pulse::VALUES.len()).map(value).collect();
            format!("{contact},{}\n", values.join(","))
        };
        let mut text = line(&"contact", &|k| Pulse::VALUES[k].0.to_owned());
        for pulse in &self.0 {
            text += &line(&(pulse.contact + 1), &|k| format!("{:e}", Pulse::VALUES[k].1(pulse)));
        }
        text
    }

    pub fn are_sound(&self, contacts: usize) -> bool {
        self.0.len() <= KEPT && self.0.iter().all(|pulse| pulse.is_sound(contacts))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Peak;

    #[test]
    fn pulses_text_is_bounded_and_has_the_last_pulses() {
        let mut pulses = Pulses::default();
        let value = -1.234_567_890_123_456_7e-300;
        for contact in 0..10_000 {
            let peak = Peak { force: value, time: value };
            pulses.enter(Pulse { contact, onset: value, release: value, peak, impulse: value });
        }
        let csv = pulses.csv();
        let (header, lines) = csv.split_once('\n').unwrap();
        assert_eq!(header, "contact,onset,release,peak,impulse,peakTime");
        assert!(csv.len() <= MAX_LOG && header.len() < LINE && lines.lines().count() == KEPT);
        let last = csv.lines().last().unwrap();
        assert!(last.starts_with("10000,") && last.len() < LINE);
        assert_eq!(last.rsplit(',').next().unwrap().parse::<f64>().unwrap(), value);
        assert!(pulses.are_sound(10_000) && !pulses.are_sound(9_999));
    }
}
