//! Gives up steps whose end is out of reach, and reports progress.

use crate::engine::error::EngineError;
use crate::engine::observer::{Observer, Progress};
use crate::solver::double_double::DoubleDouble;

/// Watches a call of [`advance`](super::Engine::advance): tells how far it has come, and gives up where the events follow each
/// other so fast that the end of the step would not be reached in days: the values of a cradle may be any numbers above 0.
pub(super) struct Watchdog {
    until: DoubleDouble,
    /// Events so far.
    events: u64,
    /// Effort up to which nobody need be told of the progress.
    quiet_until: Option<u64>,
    /// Number and time of the events at the last look at the clock, and how often in a row it was hopeless then.
    last: (u64, DoubleDouble),
    hopeless: u32,
}

impl Watchdog {
    /// Effort (see [`Engine::effort`](super::Engine)) from one report to the next: some milliseconds.
    const REPORT: u64 = 50_000;
    /// Events from one look at the clock to the next, how many to the end are hopeless, and for how many looks.
    const EVENTS: u64 = 1 << 17;
    const HOPELESS: f64 = 1e11;
    const LOOKS: u32 = 8;

    pub fn new(start: DoubleDouble, until: DoubleDouble) -> Self {
        Self { until, events: 0, quiet_until: None, last: (0, start), hopeless: 0 }
    }

    /// Counts the event of `contact` at `t`, before which the run had taken this `effort`.
    #[inline]
    pub fn check(
        &mut self,
        t: DoubleDouble,
        contact: usize,
        effort: u64,
        observer: &mut dyn Observer,
    ) -> Result<(), EngineError> {
        self.events += 1;
        let quiet_until = *self.quiet_until.get_or_insert(effort.saturating_add(Self::REPORT));
        if effort > quiet_until {
            self.quiet_until = None;
            observer.progress(Progress { time: t.value(), events: self.events, contact: Some(contact) });
        }
        let (before, since) = self.last;
        if self.events - before < Self::EVENTS {
            return Ok(());
        }
        let event_rate = (self.events - before) as f64 / (t - since).value();
        self.hopeless = if event_rate * (self.until - t).value() > Self::HOPELESS { self.hopeless + 1 } else { 0 };
        self.last = (self.events, t);
        if self.hopeless < Self::LOOKS {
            return Ok(());
        }
        Err(EngineError::TooFast { time: t.value(), contact, event_rate })
    }
}
