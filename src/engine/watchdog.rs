//! Gives up steps that would take days, and reports progress: in runs by every method.

use super::{Activity, EngineError, Observer, Progress};
use crate::solver::DoubleDouble;

/// Watches a call of [`advance`](super::Simulation::advance): reports progress, and gives up if the call would take
/// days. Whatever may take long within the call passes [`check`](Self::check) every few milliseconds. Effort is counted
/// work, in units of about a tenth of a microsecond, so that a run ends in the same way on every computer.
pub(super) struct Watchdog {
    until: DoubleDouble,
    /// Effort between two looks at the progress.
    look: u64,
    /// Effort up to which no progress is reported.
    quiet_until: u64,
    /// Steps and events so far.
    rounds: u64,
    /// Time, rounds and effort at the last look, and the number of hopeless looks in a row.
    last: (DoubleDouble, u64, u64),
    hopeless: u32,
}

impl Watchdog {
    /// Effort between two reports: some milliseconds.
    const REPORT: u64 = 50_000;
    /// Effort between two looks, plus some for each contact, so that a single wave through a long cradle does not
    /// decide. The run ends after `LOOKS` looks in a row at which the rest takes more than `HOPELESS`, more than a day.
    const LOOK: u64 = 1 << 22;
    const LOOK_OF_A_CONTACT: u64 = 1 << 12;
    const HOPELESS: f64 = 1e12;
    const LOOKS: u32 = 8;

    /// For a call from the time `from` to `until`, after this `effort` in earlier calls.
    pub fn new(from: DoubleDouble, until: f64, contacts: usize, effort: u64) -> Self {
        let look = Self::LOOK + Self::LOOK_OF_A_CONTACT * contacts as u64;
        let quiet_until = effort.saturating_add(Self::REPORT);
        Self { until: until.into(), look, quiet_until, rounds: 0, last: (from, 0, effort), hopeless: 0 }
    }

    /// Counts `rounds` of this `activity`, with which the run has come to the time `t`, after this `effort` in all.
    #[inline]
    pub fn check(
        &mut self,
        t: DoubleDouble,
        (rounds, activity): (u64, impl Fn() -> Activity),
        effort: u64,
        observer: &mut dyn Observer,
    ) -> Result<(), EngineError> {
        self.rounds += rounds;
        if effort > self.quiet_until {
            self.quiet_until = effort.saturating_add(Self::REPORT);
            observer.progress(Progress { time: t.value(), rounds: self.rounds, activity: activity() });
        }
        let (last, rounds_then, effort_then) = self.last;
        if effort - effort_then < self.look {
            return Ok(());
        }
        let per_second = |count: u64| count as f64 / (t - last).value();
        let to_the_end = per_second(effort - effort_then) * (self.until - t).value();
        self.hopeless = if to_the_end > Self::HOPELESS { self.hopeless + 1 } else { 0 };
        self.last = (t, self.rounds, effort);
        if self.hopeless < Self::LOOKS {
            return Ok(());
        }
        let rate = per_second(self.rounds - rounds_then).min(f64::MAX);
        Err(EngineError::OutOfReach { time: t.value(), activity: activity(), rate })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Reports(u64);

    impl Observer for Reports {
        fn progress(&mut self, _: Progress) {
            self.0 += 1;
        }
    }

    /// A step of 1e6 s in pieces of this effort and these lengths (s): its error, and the number of reports.
    fn watch(effort: u64, lengths: impl Iterator<Item = f64>) -> (Option<EngineError>, u64) {
        let (mut watchdog, mut reports) = (Watchdog::new(1.0.into(), 1e6, 4, 7), Reports(0));
        let (mut t, mut so_far) = (DoubleDouble::from(1.0), 7);
        let mut piece = |length: f64| {
            t += length;
            so_far += effort;
            watchdog.check(t, (2, || Activity::Flight(3)), so_far, &mut reports)
        };
        let error = lengths.map(&mut piece).find_map(Result::err);
        (error, reports.0)
    }

    #[test]
    fn watchdog_gives_up_after_hopeless_looks_in_a_row() {
        let look = Watchdog::LOOK + 4 * Watchdog::LOOK_OF_A_CONTACT;
        // At this pace a look comes after 1 s, and the end after 4e12 units.
        let (error, reports) = watch(look, std::iter::repeat_n(1.0, 8));
        assert_eq!(error, Some(EngineError::OutOfReach { time: 9.0, activity: Activity::Flight(3), rate: 2.0 }));
        assert_eq!(reports, 8);
        let (error, reports) = watch(look / 8, std::iter::repeat_n(0.125, 1000));
        assert_eq!(error, Some(EngineError::OutOfReach { time: 9.0, activity: Activity::Flight(3), rate: 16.0 }));
        assert_eq!(reports, 64);
        // Bursts of seven hopeless looks; and a pace that comes to the end within a day.
        assert_eq!(watch(look, (1..8000).map(|i| if i % 8 == 0 { 100.0 } else { 1.0 })).0, None);
        assert_eq!(watch(look, std::iter::repeat_n(5.0, 1000)).0, None);
        // No progress at all.
        let error = watch(look, std::iter::repeat(0.0)).0.unwrap().to_string();
        let words =
            "the step would take days: at t = 1 s, the flight of ball 4 needs 1.8e308 steps per second of the run";
        assert_eq!(error, words);
    }
}
