//! The start of the step under way, which the values over a step refer to.
//!
//! What no event has moved within the step is still on the closed form that it was on when the step began, and is evaluated there.
//! Only what an event is about to move is recorded before, so that a step costs what happens in it, not the number of balls.

use serde::{Deserialize, Serialize};

use crate::model::Mode;

/// How a ball stood at the start of the step.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct BallStart {
    /// Position, m, and velocity, m/s.
    pub x: f64,
    pub v: f64,
    /// Integral of its part of the force on the support since the start of the run up to a constant, N.s.
    pub support_impulse: f64,
}

impl BallStart {
    /// Whether its values are finite.
    pub fn is_finite(&self) -> bool {
        [self.x, self.v, self.support_impulse].iter().all(|value| value.is_finite())
    }
}

/// How a contact stood at the start of the step.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct ContactStart {
    /// In m.
    pub overlap: f64,
    pub mode: Mode,
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
    /// How these stood, and the contacts on either side of them.
    balls: Vec<Option<BallStart>>,
    contacts: Vec<Option<ContactStart>>,
}

impl StepStart {
    /// Before the first step of so many balls and contacts, at `time` (s).
    pub fn new(balls: usize, contacts: usize, time: f64) -> Self {
        Self { number: 0, time, moved: Vec::new(), balls: vec![None; balls], contacts: vec![None; contacts] }
    }

    /// A new step begins at `time` (s).
    pub fn begin(&mut self, time: f64) {
        self.number += 1;
        self.time = time;
        for i in self.moved.drain(..).map(|i| i as usize) {
            self.balls[i] = None;
            let beside = i.saturating_sub(1)..(i + 1).min(self.contacts.len());
            self.contacts[beside].fill(None);
        }
    }

    /// How ball `i` stood, if that has been recorded.
    pub fn ball(&self, i: usize) -> Option<&BallStart> {
        self.balls[i].as_ref()
    }

    /// How contact `i` stood, if that has been recorded.
    pub fn contact(&self, i: usize) -> Option<&ContactStart> {
        self.contacts[i].as_ref()
    }

    /// Records how ball `i` stood, which is about to move.
    pub fn record_ball(&mut self, i: usize, start: BallStart) {
        self.balls[i] = Some(start);
        self.moved.push(i as u32);
    }

    /// Records how contact `i` stood.
    pub fn record_contact(&mut self, i: usize, start: ContactStart) {
        self.contacts[i] = Some(start);
    }

    /// Takes over what a saved state has recorded.
    pub fn restore(&mut self, balls: Vec<Option<BallStart>>, contacts: Vec<Option<ContactStart>>) {
        self.moved = (0..balls.len()).filter(|&i| balls[i].is_some()).map(|i| i as u32).collect();
        (self.balls, self.contacts) = (balls, contacts);
    }
}
