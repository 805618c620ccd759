//! Events: onsets, releases, clipping, groups followed to their end; for rigid contacts impacts, chatter and parting.

mod group;

use super::contact::{ContactRecord, Reached};
use super::run::Exchange;
use crate::engine::run::Engine;
use crate::engine::{EngineError, Fault, Forecast, Observer, Unrecorded, flight::Ball};
use crate::model::{Chain, Mode};
use crate::solver::DoubleDouble;
use group::START;

/// The result of an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Update {
    /// Whether a flag or a state has changed.
    pub changed: bool,
    /// When the next event is due with the inputs held, s, later than now.
    pub next: Option<f64>,
}

/// Most groups in one event; after a long step, many may come one after another.
const GROUPS: usize = 10_000;

impl Exchange {
    /// Handles all events due now; `observer` is notified of finished pulses. Without due events nothing changes.
    pub fn update(&mut self, observer: &mut dyn Observer) -> Result<Update, EngineError> {
        if let Some(lost) = self.lost() {
            return Err(lost);
        }
        if self.cradle.on_arcs() {
            let balls = if self.is_rigid() { self.engine_now().balls } else { self.flights() };
            let mut flying = (0..).zip(&balls).filter(|(i, _)| self.is_rigid() || self.flies(*i));
            let fault = |ball: &Ball| ball.fault_within(ball.anchor, u64::MAX).unwrap_or_default();
            if let Some((ball, fault)) = flying.find_map(|(i, ball)| Some((i, fault(ball)?.1))) {
                return Err(EngineError::OffArc { time: self.time, ball, fault });
            }
            if let Some(ball) = self.crossed() {
                return Err(EngineError::OffArc { time: self.time, ball, fault: Fault::Sides });
            }
        }
        self.pass();
        let before = (self.y.clone(), self.modes.clone());
        let at_start = std::mem::take(&mut self.at_start);
        if self.is_rigid() {
            self.rigid_event(observer)?;
        } else {
            self.open_and_clip(observer);
            if self.is_mapped() {
                let closed = if at_start { self.closed() } else { Vec::new() };
                self.follow_due(closed, observer)?;
            } else {
                self.close_due();
            }
        }
        self.refresh();
        for j in self.closed() {
            let now = self.reached(j);
            self.contacts[j].go_on(now);
        }
        self.check_finite()?;
        (self.next, self.next_contact) = self.find_next_onset();
        let resolved = !self.is_rigid() && self.modes.iter().any(|mode| *mode != Mode::Open);
        let next = Some(self.next).filter(|next| !resolved && *next != Forecast::Never).map(Forecast::time);
        Ok(Update { changed: (&self.y, &self.modes) != (&before.0, &before.1), next })
    }

    /// Fails if an event or a step has taken a state, or the record of a contact, beyond the range of doubles.
    pub fn check_finite(&self) -> Result<(), EngineError> {
        let (time, n) = (self.time, self.balls());
        if let Some(contact) = self.contacts.iter().position(|contact| !contact.ledger.is_sound()) {
            return Err(EngineError::ContactNotFinite { time, contact });
        }
        let Some(place) = self.y.iter().position(|y| !y.is_finite()) else { return Ok(()) };
        Err(match place {
            0 => EngineError::NotFinite { time, ball: 0 },
            j if j < n => EngineError::ContactNotFinite { time, contact: j - 1 },
            i if i < 2 * n => EngineError::NotFinite { time, ball: i - n },
            j if j < 3 * n - 1 => EngineError::ContactNotFinite { time, contact: j - 2 * n },
            _ => EngineError::EnergyNotFinite { time },
        })
    }

    /// Ends a step of the host. Returns whether an event is due.
    pub fn complete_step(&mut self) -> bool {
        self.pass();
        self.is_event_due()
    }

    /// Enters the forces at the end of this step in the records.
    fn pass(&mut self) {
        for j in 0..self.modes.len() {
            if self.modes[j] == Mode::Pressing && !self.is_rigid() {
                let now = self.reached(j);
                self.contacts[j].pass(now);
            }
        }
    }

    /// The state of the closed contact `j` now.
    fn reached(&self, j: usize) -> Reached {
        let ((overlap, rate), law) = (self.overlap_and_rate(j), &self.cradle.contacts[j]);
        // A contact that has yet to open has the slope at its opening.
        let (by_overlap, by_rate) = law.force_slopes(overlap.max(f64::MIN_POSITIVE), rate);
        let slope = by_overlap * rate + by_rate * self.overlap_acceleration(j);
        Reached { time: self.time, force: self.state.forces[j], slope, impulse: self.y[self.impulse_place(j)] }
    }

    /// Time, near now, at which contact `j` had the overlap 0.
    fn time_of_switch(&self, j: usize) -> DoubleDouble {
        let (overlap, rate) = self.overlap_and_rate(j);
        let since = if overlap.abs() <= 2.0 * self.scales.shift(j) && rate != 0.0 { overlap / rate } else { 0.0 };
        DoubleDouble::from(self.time) + -since
    }

    /// Opens closed contacts without overlap, and switches clipping.
    fn open_and_clip(&mut self, observer: &mut dyn Observer) {
        for j in 0..self.modes.len() {
            let (overlap, rate) = self.overlap_and_rate(j);
            if self.modes[j] == Mode::Open {
                continue;
            }
            if overlap < 0.0 && rate <= 0.0 {
                self.state.modes[j] = Mode::Open;
                let (time, impulse) = (self.time_of_switch(j), self.y[self.impulse_place(j)]);
                self.contacts[j].close_pulse(j, time, impulse, observer);
            } else if (self.clip_indicator(j) < 0.0) != (self.modes[j] == Mode::Clipped) {
                self.state.modes[j] = if self.modes[j] == Mode::Clipped { Mode::Pressing } else { Mode::Clipped };
            }
        }
        self.refresh();
    }

    fn close(&mut self, j: usize) {
        let (overlap, rate) = self.overlap_and_rate(j);
        self.state.modes[j] = self.cradle.contacts[j].mode_when_closed(overlap.max(0.0), rate);
        let (time, impulse) = (self.time_of_switch(j), self.y[self.impulse_place(j)]);
        self.contacts[j].open_pulse(time, impulse);
        self.refresh();
    }

    /// Closes open contacts that overlap, or whose onset is due.
    fn close_due(&mut self) {
        let balls = self.flights();
        for j in 0..self.modes.len() {
            let meets = self.state.overlaps[j] > 0.0 || self.due_onset(&balls, j).is_some();
            if self.modes[j] == Mode::Open && meets {
                self.close(j);
            }
        }
    }

    /// Follows due groups to their end, first those of the contacts `closed` at the start. Contacts of groups that do
    /// not end soon are closed.
    fn follow_due(&mut self, mut closed: Vec<usize>, observer: &mut dyn Observer) -> Result<(), EngineError> {
        for _ in 0..GROUPS {
            let balls = self.flights();
            let due = closed.first().map(|&first| (0.0, first));
            let open = |j: usize| self.modes[j] == Mode::Open;
            let Some((onset, first)) = due.or_else(|| self.earliest_due(&balls, open)) else { break };
            let follows = due.is_some() || !self.is_beside_closed(first);
            match if follows { self.follow(&balls, first, onset, &closed)? } else { None } {
                Some(group) => {
                    for &j in closed.iter().filter(|j| group.contains(**j)) {
                        self.state.modes[j] = Mode::Open;
                        self.contacts[j] = ContactRecord::default();
                    }
                    closed.retain(|j| !group.contains(*j));
                    self.apply(&balls, &group, |_| 0.0, observer);
                }
                None if due.is_some() => closed.retain(|j| *j != first),
                None => self.close(first),
            }
        }
        // Beside contacts that the host integrates, overlapping ones are closed.
        for j in 0..self.modes.len() {
            if self.modes[j] == Mode::Open && self.is_beside_closed(j) && self.state.overlaps[j] > 0.0 {
                self.close(j);
            }
        }
        Ok(())
    }

    /// The earliest due onset of the `open` contacts, relative to now (s), and its contact.
    fn earliest_due(&self, balls: &[Ball], open: impl Fn(usize) -> bool) -> Option<(f64, usize)> {
        let open = (0..self.modes.len()).filter(|&j| open(j));
        let due = open.filter_map(|j| self.due_onset(balls, j).map(|onset| (onset, j)));
        due.reduce(|first, other| if other.0 < first.0 { other } else { first })
    }

    /// The due event of rigid balls: follows all of them from the earliest onset to the end of its impacts.
    fn rigid_event(&mut self, observer: &mut dyn Observer) -> Result<(), EngineError> {
        for _ in 0..GROUPS {
            // Balls that are pressed together move as bodies.
            let mut engine = self.engine_now();
            let balls = engine.balls.clone();
            engine.check_fault(self.time)?;
            let open = |j: usize| engine.constraint(j).is_none();
            let Some((onset, first)) = self.earliest_due(&balls, open) else {
                return self.rest(&mut engine, observer);
            };
            let before = |j: usize| engine.impulse_at(j, onset.into()).value();
            if let Some(group) = self.follow(&balls, first, onset, &self.closed())? {
                self.apply(&balls, &group, before, observer);
            }
        }
        Ok(())
    }

    /// If no impact is due: balls at rest against each other stay if they are pressed, and part otherwise.
    fn rest(&mut self, engine: &mut Engine, observer: &mut dyn Observer) -> Result<(), EngineError> {
        while let Some((t, key)) = engine.queue.first()
            && t <= START
            && engine.constraint(key).is_some()
        {
            engine.process(t, key, &mut Unrecorded)?;
        }
        let n = self.balls();
        for j in 0..self.modes.len() {
            let (closed, was_closed) = (engine.constraint(j).is_some(), self.modes[j] != Mode::Open);
            let impulse = self.y[self.impulse_place(j)];
            match (closed, was_closed) {
                (true, false) => {
                    self.state.modes[j] = Mode::Pressing;
                    self.contacts[j].open_pulse(self.time.into(), impulse);
                    self.y[1 + j] = 0.0;
                    for (i, ball) in (j..).zip(&engine.balls[j..j + 2]) {
                        self.y[n + i] = ball.flight.v * ball.model.place(ball.flight.x).cos;
                    }
                }
                (false, true) => {
                    self.state.modes[j] = Mode::Open;
                    self.contacts[j].close_pulse(j, self.time.into(), impulse, observer);
                }
                _ => {}
            }
        }
        self.refresh();
        Ok(())
    }
}
