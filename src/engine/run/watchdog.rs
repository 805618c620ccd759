//! Gives up steps whose end is out of reach, and reports progress.

use crate::engine::{EngineError, Observer, Progress};
use crate::solver::DoubleDouble;

/// Watches a call of [`advance`](super::Engine::advance): reports progress, and gives up where it would take days.
pub(super) struct Watchdog {
    until: DoubleDouble,
    /// Effort from one look at the clock to the next.
    look: u64,
    events: u64,
    /// Effort up to which no progress is reported.
    quiet_until: u64,
    /// Time, events and effort at the last look at the clock, and the number of hopeless looks in a row.
    last: (DoubleDouble, u64, u64),
    hopeless: u32,
}

impl Watchdog {
    /// Effort (see [`Engine::effort`](super::Engine)) from one report to the next: some milliseconds.
    const REPORT: u64 = 50_000;
    /// Effort from one look at the clock to the next, and more for each contact, so that a single wave through a long
    /// cradle does not decide. Effort to the end that is hopeless, and for how many looks.
    const LOOK: u64 = 1 << 22;
    const LOOK_OF_A_CONTACT: u64 = 1 << 12;
    const HOPELESS: f64 = 1e12;
    const LOOKS: u32 = 8;

    /// For a call from the time `from` (s) to `until`, with this effort of earlier calls.
    pub fn new(from: f64, until: DoubleDouble, contacts: usize, effort: u64) -> Self {
        let look = Self::LOOK + Self::LOOK_OF_A_CONTACT * contacts as u64;
        let last = (from.into(), 0, effort);
        Self { until, look, events: 0, quiet_until: effort.saturating_add(Self::REPORT), last, hopeless: 0 }
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
        if effort > self.quiet_until {
            self.quiet_until = effort.saturating_add(Self::REPORT);
            observer.progress(Progress { time: t.value(), events: self.events, contact: Some(contact) });
        }
        let (last, events_then, effort_then) = self.last;
        if effort - effort_then < self.look {
            return Ok(());
        }
        let per_second = |count: u64| count as f64 / (t - last).value();
        let to_the_end = per_second(effort - effort_then) * (self.until - t).value();
        self.hopeless = if to_the_end > Self::HOPELESS { self.hopeless + 1 } else { 0 };
        self.last = (t, self.events, effort);
        if self.hopeless < Self::LOOKS {
            return Ok(());
        }
        Err(EngineError::TooFast { time: t.value(), contact, event_rate: per_second(self.events - events_then) })
    }
}
