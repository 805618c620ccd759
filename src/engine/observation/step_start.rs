//! The start of the step under way, which the values over a step refer to.
//!
//! What no event has moved within the step is still on the closed form that it was on when the step began, and is evaluated there.
//! Only what an event is about to move is recorded before, so that a step costs what happens in it, not the number of balls.

use serde::{Deserialize, Serialize};

use crate::model::Mode;

/// No step has this number.
const NO_STEP: u64 = u64::MAX;

/// How a ball stood at the start of the step with this number.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct BallStart {
    pub step: u64,
    /// Position, m, and velocity, m/s.
    pub x: f64,
    pub v: f64,
    /// Integral of its part of the force on the support since the start of the run up to a constant, N.s.
    pub support_impulse: f64,
}

impl Default for BallStart {
    fn default() -> Self {
        Self { step: NO_STEP, x: 0.0, v: 0.0, support_impulse: 0.0 }
    }
}

impl BallStart {
    /// Whether its values are finite.
    pub fn is_finite(&self) -> bool {
        [self.x, self.v, self.support_impulse].iter().all(|value| value.is_finite())
    }
}

/// How a contact stood at the start of the step with this number.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct ContactStart {
    pub step: u64,
    /// In m.
    pub overlap: f64,
    pub mode: Mode,
}

impl Default for ContactStart {
    fn default() -> Self {
        Self { step: NO_STEP, overlap: 0.0, mode: Mode::Open }
    }
}

/// The start of the step under way.
#[derive(Clone, Debug)]
pub(crate) struct StepStart {
    /// Number of the step; 0 before the first.
    pub number: u64,
    /// When it began, s.
    pub time: f64,
    /// Balls that have moved off their closed forms since.
    pub moved: Vec<u32>,
    balls: Vec<BallStart>,
    contacts: Vec<ContactStart>,
}

impl StepStart {
    /// Before the first step of so many balls and contacts, at `time` (s).
    pub fn new(balls: usize, contacts: usize, time: f64) -> Self {
        Self {
            number: 0,
            time,
            moved: Vec::new(),
            balls: vec![BallStart::default(); balls],
            contacts: vec![ContactStart::default(); contacts],
        }
    }

    /// A new step begins at `time` (s).
    pub fn begin(&mut self, time: f64) {
        self.number += 1;
        self.time = time;
        self.moved.clear();
    }

    /// How ball `i` stood, if that has been recorded.
    pub fn ball(&self, i: usize) -> Option<&BallStart> {
        Some(&self.balls[i]).filter(|start| start.step == self.number)
    }

    /// How contact `i` stood, if that has been recorded.
    pub fn contact(&self, i: usize) -> Option<&ContactStart> {
        Some(&self.contacts[i]).filter(|start| start.step == self.number)
    }

    /// Records how ball `i` stood, which is about to move.
    pub fn record_ball(&mut self, i: usize, start: BallStart) {
        self.balls[i] = start;
        self.moved.push(i as u32);
    }

    /// Records how contact `i` stood.
    pub fn record_contact(&mut self, i: usize, start: ContactStart) {
        self.contacts[i] = start;
    }

    /// Takes over what a saved state has recorded.
    pub fn restore(&mut self, balls: Vec<Option<BallStart>>, contacts: Vec<Option<ContactStart>>) {
        self.balls = balls.into_iter().map(Option::unwrap_or_default).collect();
        self.contacts = contacts.into_iter().map(Option::unwrap_or_default).collect();
    }
}
