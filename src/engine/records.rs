//! The records of a run, for every method: pulses, impulse and peak of each contact, in total and in the current step
//! ([`Ledger`]), and the start of that step ([`StepStart`]).
//!
//! Only balls that an event is about to move are recorded. The others are still on their closed forms, which give their
//! state at the start of the step. So the cost of a step depends on its events, not on the number of balls.

use serde::{Deserialize, Serialize};

use super::observer::{Peak, Pulse};
use crate::model::{Mode, Record};
use crate::solver::{DoubleDouble, all_finite};

/// Onsets closer together than this, s, belong to one chatter.
pub(crate) const RAPID: f64 = 1e-5;

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Ledger {
    pub record: Record,
    /// Number of the last onsets, each of which came within [`RAPID`] of the one before.
    pub rapid: u64,
    /// Integral of the force up to the start of the current segment, N.s. Where that integral is a state (`continuous`,
    /// `exchange`), its value at the last onset or, once that pulse has ended, at its release.
    pub impulse: DoubleDouble,
    /// Part of `impulse` that belongs to the last pulse, N.s.
    pulse_impulse: f64,
    /// Largest force of the last pulse up to the start of the current segment.
    pub pulse_peak: Peak,
    /// Number of the step that the two fields below belong to.
    step: u64,
    /// `impulse` at the start of that step, N.s.
    step_impulse: DoubleDouble,
    /// Largest force in that step up to the start of the current segment, N.
    step_peak: f64,
}

impl Ledger {
    pub fn is_sound(&self) -> bool {
        let Self { record, pulse_peak: peak, .. } = self;
        let values = [record.onset, record.release, self.pulse_impulse, peak.force, peak.time, self.step_peak];
        all_finite(values) && self.impulse.is_sound() && self.step_impulse.is_sound()
    }

    /// Begins step number `step`, at whose start the impulse was `impulse`.
    pub fn begin_step(&mut self, step: u64, impulse: DoubleDouble) {
        if self.step != step {
            (self.step, self.step_impulse, self.step_peak) = (step, impulse, 0.0);
        }
    }

    /// The contact closes at `time`, in step number `step`.
    pub fn open_pulse(&mut self, time: DoubleDouble, step: u64) {
        self.begin_step(step, self.impulse);
        self.record.pulses = self.record.pulses.saturating_add(1);
        self.rapid = if time.value() - self.record.onset < RAPID { self.rapid.saturating_add(1) } else { 0 };
        self.record.onset = time.value_up();
        (self.pulse_impulse, self.pulse_peak) = (0.0, Peak { force: 0.0, time: self.record.onset });
    }

    /// Adds a part of the impulse of a pulse, N.s.
    pub fn add(&mut self, impulse: f64) {
        self.impulse += impulse;
        self.pulse_impulse += impulse;
    }

    /// Enters the largest force of a part of a pulse that began at `begun`.
    pub fn raise_peak(&mut self, peak: Peak, begun: DoubleDouble) {
        self.pulse_peak.continue_with(peak, begun.value_up());
    }

    /// Enters a force within the current step, N.
    pub fn raise_peak_of_step(&mut self, force: f64) {
        self.step_peak = self.step_peak.max(force);
    }

    pub fn close_pulse(&mut self, contact: usize, time: DoubleDouble) -> Pulse {
        self.record.release = time.value_up();
        Pulse {
            contact,
            onset: self.record.onset,
            release: self.record.release,
            peak: self.pulse_peak,
            impulse: self.pulse_impulse,
        }
    }

    /// The impulse at the start of step number `step`, N.s, if it has changed since.
    pub fn impulse_at_start(&self, step: u64) -> Option<DoubleDouble> {
        (self.step == step).then_some(self.step_impulse)
    }

    /// Largest force in step number `step` up to the start of the current segment, N.
    pub fn peak_in_step(&self, step: u64) -> f64 {
        if self.step == step { self.step_peak } else { 0.0 }
    }
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct BallStart {
    /// Position, m, and velocity, m/s.
    pub state: (f64, f64),
    /// Integral of its force on the support over its mass, up to a constant, m/s.
    pub support: DoubleDouble,
}

impl BallStart {
    fn is_finite(&self) -> bool {
        let Self { state: (x, v), support } = self;
        all_finite([*x, *v, support.value()])
    }
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct StepStart {
    /// Number of the step; 0 before the first.
    pub number: u64,
    /// Time at which it began, s.
    pub time: f64,
    /// Time up to which the ledgers hold the largest forces of the step, s. If it ends where inputs change, what acts
    /// from then on is not part of it.
    pub entered: f64,
    /// Balls that have left their closed forms since the step began.
    #[serde(skip)]
    pub moved: Vec<u32>,
    /// Their states when the step began, and overlap (m) and mode of the contacts beside them.
    pub balls: Vec<Option<BallStart>>,
    pub contacts: Vec<Option<(f64, Mode)>>,
}

impl StepStart {
    /// The record before the first step, at `time` (s).
    pub fn new(balls: usize, contacts: usize, time: f64) -> Self {
        Self {
            number: 0,
            time,
            entered: time,
            moved: Vec::new(),
            balls: vec![None; balls],
            contacts: vec![None; contacts],
        }
    }

    /// A new step begins at `time` (s).
    pub fn begin(&mut self, time: f64) {
        self.number = self.number.saturating_add(1);
        (self.time, self.entered) = (time, time);
        for i in self.moved.drain(..).map(|i| i as usize) {
            self.balls[i] = None;
            let beside = i.saturating_sub(1)..(i + 1).min(self.contacts.len());
            self.contacts[beside].fill(None);
        }
    }

    /// Whether the record of this ball is finite.
    pub fn is_finite_at(&self, ball: usize) -> bool {
        self.balls[ball].as_ref().is_none_or(BallStart::is_finite)
    }

    /// Whether all values are finite, and each recorded contact has a recorded ball.
    pub fn is_sound(&self) -> bool {
        let contact = |(contact, balls): (&Option<(f64, Mode)>, &[Option<BallStart>])| {
            contact.is_none_or(|(overlap, _)| overlap.is_finite() && balls.iter().any(Option::is_some))
        };
        self.balls.iter().flatten().all(BallStart::is_finite)
            && self.contacts.iter().zip(self.balls.windows(2)).all(contact)
    }

    pub fn restored(self) -> Self {
        let moved = (0..self.balls.len()).filter(|&i| self.balls[i].is_some()).map(|i| i as u32).collect();
        Self { moved, ..self }
    }
}
