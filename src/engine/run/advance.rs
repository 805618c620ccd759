//! The calls that advance a run: from event to event, and along the flights between them, which may take long.

use std::ops::Range;

use super::contact::{ContactRole, contiguous_range};
use super::engine::Engine;
use crate::engine::{Activity, EngineError, Forecast, Observer, Watchdog};
use crate::solver::DoubleDouble;

/// Number of series of a flight on an arc from one look of the watchdog to the next, and the effort of one.
const SERIES_AT_ONCE: u64 = 1 << 10;
const EFFORT_OF_SERIES: u64 = 16;

impl Engine {
    /// Begins a step: values "over the last step" refer to it from now on.
    pub fn begin_step(&mut self) {
        self.step.begin(self.time);
    }

    /// Makes a step: moves the current time to `time` (s, not before the current one). `observer` is notified of the
    /// pulses that finish on the way, in the order of their release.
    pub fn advance(&mut self, time: f64, observer: &mut dyn Observer) -> Result<(), EngineError> {
        self.advance_within(time, u64::MAX, observer)
    }

    /// Goes on to `time` (s) within the current step.
    pub fn continue_step(&mut self, time: f64, observer: &mut dyn Observer) -> Result<(), EngineError> {
        self.follow_events(time, u64::MAX, observer)
    }

    /// Like [`Self::advance`], but stops before an event once it has spent this `effort`, in units of about a tenth of
    /// a microsecond, at [`Self::time`]. The trajectory does not depend on it.
    pub fn advance_within(&mut self, time: f64, effort: u64, observer: &mut dyn Observer) -> Result<(), EngineError> {
        self.begin_step();
        self.follow_events(time, effort, observer)
    }

    fn follow_events(&mut self, time: f64, effort: u64, observer: &mut dyn Observer) -> Result<(), EngineError> {
        let followed = self.follow_events_until(time, effort, observer);
        if followed.is_err() {
            // Where balls were before their last event is no longer known.
            let anchors = self.balls.iter().map(|ball| ball.anchor.value_up());
            self.time = anchors.fold(self.time, f64::max).min(time);
        }
        followed
    }

    fn follow_events_until(&mut self, time: f64, effort: u64, observer: &mut dyn Observer) -> Result<(), EngineError> {
        let (mut until, enough) = (DoubleDouble::from(time), self.effort.saturating_add(effort));
        let mut reached = time;
        let mut watchdog = Watchdog::new(self.time.into(), time, self.contacts.len(), self.effort);
        while let Some((t, key)) = self.queue.first()
            && t <= until
        {
            if self.effort >= enough
                && let between = t.value_down()
                && between >= self.time
                && DoubleDouble::from(between) >= self.totals.last_event
            {
                reached = between;
                break;
            }
            watchdog.check(t, (1, || self.activity(key)), self.effort, observer)?;
            if self.is_rigid() {
                // The balls of a body fly on from event to event; for other neighbours, events renew the series.
                let body = contiguous_range(key, self.contacts.len(), |j| self.constraint(j).is_some());
                self.follow_flights(body.start..body.end + 1, t, &mut watchdog, observer)?;
            }
            self.process(t, key, observer)?;
            if self.fault.is_some() {
                // Another ball may have a fault before that.
                self.follow_flights(0..self.balls.len(), t, &mut watchdog, observer)?;
                self.check_fault(0.0)?;
            }
            if let Some(stop) = observer.stop().filter(|stop| *stop < reached) {
                (reached, until) = (stop, stop.into());
            }
        }
        self.follow_flights(0..self.balls.len(), reached.into(), &mut watchdog, observer)?;
        self.check_fault(0.0)?;
        self.time = reached;
        if self.step.moved.is_empty() {
            return Ok(());
        }
        self.check_finite(self.step.moved.iter().map(|&ball| ball as usize))
    }

    /// Follows the flights of `balls` on arcs to the time `t`, which may take long although nothing happens; notes
    /// faults.
    fn follow_flights(
        &mut self,
        balls: Range<usize>,
        t: DoubleDouble,
        watchdog: &mut Watchdog,
        observer: &mut dyn Observer,
    ) -> Result<(), EngineError> {
        let balls = if self.cradle.on_arcs() { balls } else { 0..0 };
        for ball in balls {
            let mut at_once = 0;
            let fault = loop {
                match self.fault_within(ball, t, at_once) {
                    Ok(fault) => break fault,
                    Err(_) if at_once == 0 => {
                        self.balls[ball].keep_part();
                        at_once = SERIES_AT_ONCE;
                    }
                    Err(reached) => {
                        self.effort = self.effort.saturating_add(EFFORT_OF_SERIES * at_once);
                        watchdog.check(reached, (at_once, || Activity::Flight(ball)), self.effort, observer)?;
                    }
                }
            };
            self.note(ball, fault);
        }
        Ok(())
    }

    /// What the event of the queue entry `key` is about; on arcs it may be the series of two flights, to be renewed.
    fn activity(&self, key: usize) -> Activity {
        match self.contacts[key].role {
            ContactRole::Open(_, Forecast::NotBefore(_)) if self.cradle.on_arcs() => Activity::Flight(key),
            _ => Activity::Contact(self.switching(key)),
        }
    }
}
