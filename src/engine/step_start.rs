//! The start of the step under way, which the values over a step refer to.
//!
//! What no event has moved within the step is still on the closed form that it was on when the step began, and is evaluated there.
//! Only what an event is about to move is taken down before, so that a step costs what happens in it, not the number of balls.

use serde::{Deserialize, Serialize};

use super::Engine;
use super::expansion::State;
use super::window::Mode;
use crate::solver::double_double::DoubleDouble;

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

impl Engine {
    /// Starts a new step at the current time.
    pub(super) fn begin_step(&mut self) {
        self.step += 1;
        self.step_start = self.time;
        self.moved.clear();
    }

    /// Length of the last step, s; 0 before the first.
    pub(super) fn step_length(&self) -> f64 {
        self.time - self.step_start
    }

    /// To be called before an event at `t` moves ball `i` or what it touches off its closed form. An event at the very start of the
    /// step has not moved it yet.
    pub(super) fn before_move(&mut self, i: usize, t: DoubleDouble) {
        if t > self.step_start.into() {
            self.take_down(i);
        }
    }

    /// Takes down how ball `i` and its contacts stood at the start of the step, unless that has been done.
    pub(super) fn take_down(&mut self, i: usize) {
        let step = self.step;
        if self.is_scout() || self.balls[i].at_start.step == step {
            return;
        }
        let start = self.step_start.into();
        for j in i.saturating_sub(1)..(i + 1).min(self.contacts.len()) {
            if self.contacts[j].at_start.step != step {
                let (overlap, mode) = self.overlap_at(j, start);
                self.contacts[j].at_start = ContactStart { step, overlap, mode };
            }
        }
        let (x, v) = self.state_at(i, start);
        self.balls[i].at_start = BallStart { step, x, v, support_impulse: self.support_impulse_of(i, start) };
        self.moved.push(i as u32);
    }

    /// To be called before an event at `t` enters anything in the ledger of contact `i`: what its impulse was at the start of the
    /// step.
    pub(super) fn begin_ledger(&mut self, i: usize, t: DoubleDouble) {
        if t > self.step_start.into() && self.contacts[i].ledger.impulse_at_start(self.step).is_none() {
            let impulse = self.impulse_at(i, self.step_start.into());
            self.contacts[i].ledger.begin_step(self.step, impulse);
        }
    }

    /// The part of ball `i` in the integral of the force on the support up to the start of the step, N.s.
    pub(super) fn support_impulse_at_start(&self, i: usize) -> f64 {
        let taken = &self.balls[i].at_start;
        if taken.step == self.step { taken.support_impulse } else { self.support_impulse_of(i, self.step_start.into()) }
    }

    /// The whole chain at the start of the step.
    pub(super) fn state_at_start(&self) -> State {
        let start = self.step_start.into();
        let ball = |i: usize| match self.balls[i].at_start {
            BallStart { step, x, v, .. } if step == self.step => (x, v),
            _ => self.state_at(i, start),
        };
        let contact = |i: usize| match self.contacts[i].at_start {
            ContactStart { step, overlap, mode } if step == self.step => (overlap, mode),
            _ => self.overlap_at(i, start),
        };
        let (x, v) = (0..self.balls.len()).map(ball).unzip();
        let (overlaps, modes) = (0..self.contacts.len()).map(contact).unzip();
        State { x, v, overlaps, modes }
    }
}
