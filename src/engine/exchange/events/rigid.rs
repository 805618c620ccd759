//! Rigid contacts in an event: impacts, chatter to its end, balls that stay in contact, and their parting.
//!
//! The event-driven engine takes all balls from the earliest onset that is due to the end of what comes about there.
//! Then all return to the current time along what governs them then, flight or the motion of a body.

use super::group::Followed;
use crate::engine::error::EngineError;
use crate::engine::exchange::run::Exchange;
use crate::engine::flight::Ball;
use crate::engine::inputs::HeldInputs;
use crate::engine::observer::{Observer, Unrecorded};
use crate::engine::records::RAPID;
use crate::engine::run::{Engine, Keep, Phase};
use crate::model::{Mode, ONSET_PERIODS};
use crate::next::Next;
use crate::solver::double_double::DoubleDouble;

/// Effort, in units of about a tenth of a microsecond, that the impacts of one event and a look ahead may take.
const EFFORT: u64 = 1_000_000;
const LOOK_AHEAD: u64 = 40_000;

/// Part of the period of ball 1 that impacts may be followed for, and the same without gravity, s.
const LONGEST: f64 = 1e-3;

/// Instants of impacts that one event may follow: after a long step, one after the other.
const INSTANTS: usize = 10_000;

const NOW: DoubleDouble = DoubleDouble::ZERO;

impl Exchange {
    /// What is due between rigid balls.
    pub(super) fn rigid_event(&mut self, observer: &mut dyn Observer) -> Result<(), EngineError> {
        for _ in 0..INSTANTS {
            let mut engine = self.settled();
            let balls = engine.balls.clone();
            let open = |j: usize| engine.contacts[j].constraint().is_none();
            let Some((onset, first)) = self.earliest_due(&balls, open) else {
                return self.rest(&mut engine, observer);
            };
            let mut later = self.engine_from(&balls, onset);
            let mut followed = Followed::of(&later);
            later.meet(first, NOW, &mut followed);
            let end = self.while_rapid(&mut later, &mut followed)?;
            self.return_from(&balls, &engine, &later, (onset, end), &followed, observer);
        }
        Ok(())
    }

    /// An engine of all balls as they are now, its time 0: those that are pressed together move as bodies.
    fn settled(&self) -> Engine {
        let mut engine = self.engine_from(&self.flights(), 0.0);
        engine.initializing = false;
        engine
    }

    /// The same `onset` (s) from now, along the motions of `balls`.
    fn engine_from(&self, balls: &[Ball], onset: f64) -> Engine {
        let mut parameters = self.parameters.clone();
        for (k, ball) in balls.iter().enumerate() {
            let (displacement, v) = ball.moved(onset.into());
            (parameters.x_start[k], parameters.v_start[k]) = (ball.flight.x + displacement, v);
        }
        let inputs = HeldInputs { since: 0.0, values: self.inputs.clone(), derivatives: Vec::new() };
        let mut engine = Engine::apart(&parameters, inputs, 0.0);
        let closed = |j: &usize| self.modes[*j] != Mode::Open;
        for (j, contact) in engine.contacts.iter_mut().enumerate() {
            match closed(&j) {
                true => contact.unassign(0.0, Mode::Pressing),
                false => contact.unassign(self.overlap_in_flight(balls, j, onset).0.min(0.0), Mode::Open),
            }
        }
        let contacts: Vec<usize> = (0..self.modes.len()).filter(closed).collect();
        for run in contacts.chunk_by(|left, right| left + 1 == *right) {
            // They differ by rounding only.
            let members = &mut engine.balls[run[0]..run[0] + run.len() + 1];
            let mass: f64 = members.iter().map(|ball| ball.mass).sum();
            let first = members[0].flight.v;
            let mean = first + members.iter().map(|ball| ball.mass * (ball.flight.v - first)).sum::<f64>() / mass;
            members.iter_mut().for_each(|ball| ball.flight.v = mean);
        }
        engine.settle(0..engine.contacts.len(), NOW, Keep::Closed, &mut Unrecorded);
        engine
    }

    /// Nothing meets now: balls at rest against each other stay so if they are pressed, and part if they are not.
    fn rest(&mut self, engine: &mut Engine, observer: &mut dyn Observer) -> Result<(), EngineError> {
        while let Some((t, key)) = engine.queue.first()
            && t <= NOW
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

    /// Moves `engine` on as long as one impact follows the other rapidly, to the end of chatter. Answers when that was.
    fn while_rapid(&self, engine: &mut Engine, followed: &mut Followed) -> Result<DoubleDouble, EngineError> {
        let limit = DoubleDouble::from(LONGEST * self.cradle.period().min(1.0));
        let enough = engine.effort.saturating_add(EFFORT);
        let mut last = NOW;
        while let Some((t, key)) = engine.queue.first()
            && t <= last + RAPID
            && t <= limit
            && engine.effort <= enough
        {
            let before = (engine.onsets, followed.pulses.len());
            engine.process(t, key, followed)?;
            if before != (engine.onsets, followed.pulses.len()) {
                last = t;
            }
        }
        Ok(last)
    }

    /// Goes on from where `later` is at `times.1`, which began `times.0` (s) from now, seen from now; `engine` is where
    /// it would be without.
    fn return_from(
        &mut self,
        balls: &[Ball],
        engine: &Engine,
        later: &Engine,
        times: (f64, DoubleDouble),
        followed: &Followed,
        observer: &mut dyn Observer,
    ) {
        let (onset, end) = times;
        let (n, back, now) = (self.balls(), (DoubleDouble::from(-onset) - end).value(), DoubleDouble::from(-onset));
        let [loss, work] = self.sums_place();
        let mut moved = Vec::with_capacity(n);
        for (i, before) in balls.iter().enumerate() {
            let ((x, v), mut ball) = (later.state_at(i, end), later.balls[i].clone());
            let inputs = later.own_forcing(i, end);
            (ball.flight.x, ball.flight.v, ball.anchor) = (x, v, NOW);
            ball.integrals = later.integrals_at(i, end);
            let (there, before) =
                (ball.integrals_under(&inputs, back.into()), before.integrals_under(&inputs, onset.into()));
            self.y[loss] += there.drag_loss + before.drag_loss;
            self.y[work] += there.work + before.work;
            let (displacement, v) = ball.moved(back.into());
            self.y[n + i] = v;
            if i == 0 {
                self.y[0] = x + displacement;
            }
            moved.push(displacement);
        }
        self.y[loss] += later.totals.contact_loss;
        let start = DoubleDouble::from(self.time) + onset;
        for pulse in &followed.pulses {
            let (j, release) = (pulse.contact, start + pulse.release);
            if pulse.onset < 0.0 {
                // It had begun before.
                let impulse =
                    self.y[self.impulse_place(j)] + engine.impulse_at(j, onset.into()).value() + pulse.impulse;
                self.contacts[j].close_pulse(j, release, impulse, observer);
            } else {
                self.contacts[j].enter(pulse, start + pulse.onset, release, observer);
            }
        }
        for j in 0..n - 1 {
            let closed = later.contacts[j].constraint().is_some();
            let place = self.impulse_place(j);
            let before = self.y[place];
            self.y[place] += engine.impulse_at(j, onset.into()).value() + later.impulse_at(j, now).value();
            self.y[1 + j] = if closed { 0.0 } else { later.overlap_at(j, end).0 + (moved[j] - moved[j + 1]) };
            if closed && later.contacts[j].ledger.pulses > 0 {
                let ended: f64 =
                    followed.pulses.iter().filter(|pulse| pulse.contact == j).map(|pulse| pulse.impulse).sum();
                self.contacts[j].open_pulse(start + later.contacts[j].ledger.onset, before + ended);
            }
            self.modes[j] = if closed { Mode::Pressing } else { Mode::Open };
        }
        self.refresh();
    }

    /// The next onset, from now.
    pub(in crate::engine::exchange) fn foresee_rigid(&self) -> Next<DoubleDouble> {
        let mut engine = self.settled();
        let limit = DoubleDouble::from(ONSET_PERIODS * self.cradle.period());
        while let Some((t, key)) = engine.queue.first().filter(|(t, _)| *t <= limit) {
            if matches!(engine.contacts[key].phase, Phase::Open(_, Next::At(_))) {
                return Next::At(t);
            }
            if engine.effort > LOOK_AHEAD || engine.process(t, key, &mut Unrecorded).is_err() {
                return Next::NotBefore(t);
            }
        }
        Next::Never
    }
}
