//! The start of the step under way, which the values over a step refer to.
//!
//! What no event has moved within the step is still on the closed form that it was on when the step began, and is
//! evaluated there. Only what an event is about to move is recorded before, so that a step costs what happens in it,
//! not the number of balls.

use serde::{Deserialize, Serialize};

use crate::model::Mode;

/// How a ball stood at the start of the step.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct BallStart {
    /// Position, m, and velocity, m/s.
    pub state: (f64, f64),
    /// Integral of its part of the force on the support since the start of the run up to a constant, N.s.
    pub support_impulse: f64,
}

/// The start of the step under way.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct StepStart {
    /// Number of the step; 0 before the first.
    pub number: u64,
    /// When it began, s.
    pub time: f64,
    /// Balls that have moved off their closed forms since.
    #[serde(skip)]
    pub moved: Vec<u32>,
    /// How these stood, and the contacts on either side of them: overlap (m) and mode.
    pub balls: Vec<Option<BallStart>>,
    pub contacts: Vec<Option<(f64, Mode)>>,
}

impl StepStart {
    /// Before the first step of so many balls and contacts, at `time` (s).
    pub fn new(balls: usize, contacts: usize, time: f64) -> Self {
        Self { number: 0, time, moved: Vec::new(), balls: vec![None; balls], contacts: vec![None; contacts] }
    }

    /// A new step begins at `time` (s).
    pub fn begin(&mut self, time: f64) {
        self.number = self.number.saturating_add(1);
        self.time = time;
        for i in self.moved.drain(..).map(|i| i as usize) {
            self.balls[i] = None;
            let beside = i.saturating_sub(1)..(i + 1).min(self.contacts.len());
            self.contacts[beside].fill(None);
        }
    }

    /// Whether all values are finite, and contacts recorded with their balls.
    pub fn is_sound(&self) -> bool {
        let finite = |start: &BallStart| {
            let BallStart { state: (x, v), support_impulse } = start;
            x.is_finite() && v.is_finite() && support_impulse.is_finite()
        };
        let contact = |(contact, balls): (&Option<(f64, Mode)>, &[Option<BallStart>])| {
            contact.is_none_or(|(overlap, _)| overlap.is_finite() && balls.iter().any(Option::is_some))
        };
        self.balls.iter().flatten().all(finite) && self.contacts.iter().zip(self.balls.windows(2)).all(contact)
    }

    /// What was put down as plain data, taken up again.
    pub fn restored(self) -> Self {
        let moved = (0..self.balls.len()).filter(|&i| self.balls[i].is_some()).map(|i| i as u32).collect();
        Self { moved, ..self }
    }
}
