//! Rigid contacts in an event: impacts, chatter to its end, balls that stay in contact, and their parting.

use super::GROUPS;
use super::group::START;
use crate::engine::error::EngineError;
use crate::engine::exchange::run::Exchange;
use crate::engine::observer::{Observer, Unrecorded};
use crate::engine::run::{Engine, Phase};
use crate::model::Mode;

impl Exchange {
    /// What is due between rigid balls: all of them go from the earliest onset to the end of what comes about there.
    pub(super) fn rigid_event(&mut self, observer: &mut dyn Observer) -> Result<(), EngineError> {
        for _ in 0..GROUPS {
            // Balls that are pressed together move as bodies.
            let closed = self.closed();
            let mut engine = self.engine_at(&self.flights(), &(0..self.balls()), 0.0, &closed, &mut Unrecorded);
            let balls = engine.balls.clone();
            let open = |j: usize| engine.contacts[j].constraint().is_none();
            let Some((onset, first)) = self.earliest_due(&balls, open) else {
                return self.rest(&mut engine, observer);
            };
            let before = |j: usize| engine.impulse_at(j, onset.into()).value();
            if let Some(group) = self.follow(&balls, first, onset, &closed)? {
                self.apply(&balls, &group, before, observer);
            }
        }
        Ok(())
    }

    /// Nothing meets now: balls at rest against each other stay so if they are pressed, and part if they are not.
    fn rest(&mut self, engine: &mut Engine, observer: &mut dyn Observer) -> Result<(), EngineError> {
        while let Some((t, key)) = engine.queue.first()
            && t <= START
            && matches!(engine.contacts[key].phase, Phase::Constraint(..))
        {
            engine.process(t, key, &mut Unrecorded)?;
        }
        let n = self.balls();
        for j in 0..self.modes.len() {
            let (closed, was_closed) = (engine.contacts[j].constraint().is_some(), self.modes[j] != Mode::Open);
            let impulse = self.y[self.impulse_place(j)];
            match (closed, was_closed) {
                (true, false) => {
                    self.modes[j] = Mode::Pressing;
                    self.contacts[j].open_pulse(self.time.into(), impulse);
                    (self.y[1 + j], self.y[n + j]) = (0.0, engine.balls[j].flight.v);
                    self.y[n + j + 1] = engine.balls[j + 1].flight.v;
                }
                (false, true) => {
                    self.modes[j] = Mode::Open;
                    self.contacts[j].close_pulse(j, self.time.into(), impulse, observer);
                }
                _ => {}
            }
        }
        self.refresh();
        Ok(())
    }
}
