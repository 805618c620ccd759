//! Records the start of the step under way before an event moves anything off its closed form.

use crate::engine::derivatives::ChainState;
use crate::engine::records::BallStart;
use crate::engine::run::{Engine, NO_STEP};
use crate::solver::double_double::DoubleDouble;

impl Engine {
    /// Length of the last step, s; 0 before the first.
    pub(crate) fn step_length(&self) -> f64 {
        self.time - self.step.time
    }

    /// To be called before an event at `t` moves ball `i` or what it touches off its closed form. An event at the very start of the
    /// step has not moved it yet.
    pub(crate) fn before_move(&mut self, i: usize, t: DoubleDouble) {
        if t > self.step.time.into() {
            self.record_start(i);
        }
    }

    /// Records how ball `i` and its contacts stood at the start of the step, unless that has been done.
    pub(crate) fn record_start(&mut self, i: usize) {
        // Nobody reads a step of a copy that goes ahead.
        if self.step.time == NO_STEP || self.step.balls[i].is_some() {
            return;
        }
        let start = self.step.time.into();
        for j in i.saturating_sub(1)..(i + 1).min(self.contacts.len()) {
            if self.step.contacts[j].is_none() {
                self.step.contacts[j] = Some(self.overlap_at(j, start));
            }
        }
        let (state, support_impulse) = (self.state_at(i, start), self.support_impulse_of(i, start));
        self.step.balls[i] = Some(BallStart { state, support_impulse });
        self.step.moved.push(i as u32);
    }

    /// To be called before an event at `t` enters anything in the ledger of contact `i`: what its impulse was at the start of the
    /// step.
    pub(crate) fn begin_ledger(&mut self, i: usize, t: DoubleDouble) {
        if t > self.step.time.into() && self.contacts[i].ledger.impulse_at_start(self.step.number).is_none() {
            let impulse = self.impulse_at(i, self.step.time.into());
            self.contacts[i].ledger.begin_step(self.step.number, impulse);
        }
    }

    /// The part of ball `i` in the integral of the force on the support up to the start of the step, N.s.
    pub(crate) fn support_impulse_at_start(&self, i: usize) -> f64 {
        let at = self.step.time.into();
        self.step.balls[i].map_or_else(|| self.support_impulse_of(i, at), |start| start.support_impulse)
    }

    /// The whole chain at the start of the step.
    pub(crate) fn state_at_start(&self) -> ChainState {
        let at = self.step.time.into();
        let ball = |i: usize| self.step.balls[i].map_or_else(|| self.state_at(i, at), |start| start.state);
        let contact = |i: usize| self.step.contacts[i].unwrap_or_else(|| self.overlap_at(i, at));
        let (x, v) = (0..self.balls.len()).map(ball).unzip();
        let (overlaps, modes) = (0..self.contacts.len()).map(contact).unzip();
        ChainState { x, v, overlaps, modes }
    }
}
