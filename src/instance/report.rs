//! What an instance does with the events of a communication step: log lines, and ticks of the clocks.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::clocks::Clocks;
use super::legality::Purpose;
use super::log::{Log, Severity};
use crate::engine::{Activity, Observer, Progress, Pulse};
use crate::variables::{LogCategory, Number};

/// When the progress of a long step is first logged, and how often from then on.
const FIRST: Duration = Duration::from_secs(2);
const EVERY: Duration = Duration::from_secs(10);

/// Logs each pulse as it finishes, and how far the step has come if it takes long. Passes onsets and releases to the
/// clocks; if asked, ends the step at the first of them.
pub(super) struct StepLogger<'a> {
    log: &'a Log,
    clocks: &'a mut Clocks,
    /// What the instance is for: whether it has clocks or their log.
    purpose: Purpose,
    until: f64,
    stops: bool,
    /// Time of the first onset or release, s, if the step stops there.
    pub stopped: Option<f64>,
    /// Time of the first progress callback; most steps have none.
    since: Option<Instant>,
    /// Time after that at which the next line is due.
    due: Duration,
    /// What the step was computing, and how often.
    seen: BTreeMap<Activity, u64>,
}

impl<'a> StepLogger<'a> {
    /// A logger for a step to the time `until` (s).
    #[inline]
    pub fn new(log: &'a Log, clocks: &'a mut Clocks, purpose: Purpose, until: f64, stops: bool) -> Self {
        let seen = BTreeMap::new();
        Self { log, clocks, purpose, until, stops, stopped: None, since: None, due: FIRST, seen }
    }

    fn stop_at(&mut self, time: f64) {
        if self.stops {
            self.stopped.get_or_insert(time);
        }
    }
}

impl Observer for StepLogger<'_> {
    fn pulse(&mut self, pulse: Pulse) {
        self.log.pulse(pulse);
        self.stop_at(pulse.release);
        if self.purpose.events {
            self.clocks.end(pulse);
        } else if self.purpose.fmi3 {
            self.clocks.log.enter(pulse);
        }
    }

    fn onset(&mut self, contact: usize, time: f64) {
        self.stop_at(time);
        if self.purpose.events {
            self.clocks.close(contact, time);
        }
    }

    fn stop(&self) -> Option<f64> {
        self.stopped
    }

    #[cold]
    fn progress(&mut self, Progress { time, rounds, activity }: Progress) {
        let taken = self.since.get_or_insert_with(Instant::now).elapsed();
        *self.seen.entry(activity).or_default() += 1;
        if taken < self.due {
            return;
        }
        self.due = taken + EVERY;
        let most = self.seen.iter().max_by_key(|(_, times)| **times).map_or(activity, |(activity, _)| *activity);
        let work = match most {
            Activity::Contact(contact) => format!("{rounds} steps and events, most of them in contact {}", contact + 1),
            Activity::Flight(ball) => format!("{rounds} steps, most of them for the flight of ball {}", ball + 1),
            Activity::Solver => format!("{rounds} steps of the solver"),
        };
        let (until, time, taken) = (Number(self.until), Number(time), taken.as_secs());
        // A warning, so that it is seen without switching anything on: the host is waiting.
        self.log.write(
            Severity::Warning,
            LogCategory::Warning,
            format_args!(
                "the step to t = {until} s has taken {taken} s so far: it has reached t = {time} s after {work}"
            ),
        );
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::rc::Rc;

    use super::*;
    use crate::instance::Kind;

    #[test]
    fn long_step_is_logged_and_not_too_often() {
        let lines = Rc::new(RefCell::new(Vec::new()));
        let kept = lines.clone();
        let sink = move |severity, category, text: &str| kept.borrow_mut().push((severity, category, text.to_owned()));
        let log = Log::new(Some(Box::new(sink)), false, true);
        let (mut clocks, purpose) = (Clocks::default(), Purpose::fmi2(Kind::CoSimulation));
        let mut recorder = StepLogger::new(&log, &mut clocks, purpose, 1e300, false);
        let mut progress = |seconds: Option<u64>, activity: Activity| {
            let since = |seconds| Instant::now().checked_sub(Duration::from_secs(seconds));
            recorder.since = seconds.map_or(recorder.since, since);
            recorder.progress(Progress { time: 2.5e-7, rounds: 1000, activity });
        };
        progress(None, Activity::Contact(3));
        assert!(lines.borrow().is_empty());
        // At first both contacts have been seen once.
        for seconds in [3, 9, 14] {
            progress(Some(seconds), Activity::Contact(2));
        }
        (0..4).for_each(|_| progress(None, Activity::Flight(0)));
        progress(Some(25), Activity::Flight(0));
        (0..9).for_each(|_| progress(None, Activity::Solver));
        progress(Some(36), Activity::Solver);
        let work = [
            (3, "1000 steps and events, most of them in contact 4"),
            (14, "1000 steps and events, most of them in contact 3"),
            (25, "1000 steps, most of them for the flight of ball 1"),
            (36, "1000 steps of the solver"),
        ];
        let expected = work.map(|(seconds, work)| {
            let text = format!(
                "the step to t = 1e300 s has taken {seconds} s so far: it has reached t = 2.5e-7 s after {work}"
            );
            (Severity::Warning, LogCategory::Warning, text)
        });
        assert_eq!(*lines.borrow(), expected);
    }
}
