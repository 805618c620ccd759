//! Log lines during a communication step.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::log::{Log, Severity};
use crate::engine::{Observer, Progress, Pulse};
use crate::variables::LogCategory;

/// When the progress of a long step is first logged, and how often from then on.
const FIRST: Duration = Duration::from_secs(2);
const EVERY: Duration = Duration::from_secs(10);

/// Writes each pulse to the log as it finishes, and how far the step has come if it takes long.
pub(super) struct Reporter<'a> {
    log: &'a Log,
    until: f64,
    /// Time of the first progress callback; most steps have none.
    since: Option<Instant>,
    /// When the next line is due, after that.
    due: Duration,
    /// Events of each contact seen so far.
    seen: BTreeMap<usize, u64>,
}

impl<'a> Reporter<'a> {
    /// For a step to the time `until` (s).
    #[inline]
    pub fn new(log: &'a Log, until: f64) -> Self {
        Self { log, until, since: None, due: FIRST, seen: BTreeMap::new() }
    }
}

impl Observer for Reporter<'_> {
    /// 17 digits, so that they read back as the same doubles.
    fn pulse(&mut self, Pulse { contact, onset, release, peak, impulse }: Pulse) {
        let contact = contact + 1;
        self.log.write(
            Severity::Ok,
            LogCategory::Events,
            format_args!(
                "contact={contact} onset={onset:.16e} release={release:.16e} peak={peak:.16e} impulse={impulse:.16e}"
            ),
        );
    }

    #[cold]
    fn progress(&mut self, Progress { time, events, contact }: Progress) {
        let taken = self.since.get_or_insert_with(Instant::now).elapsed();
        if let Some(contact) = contact {
            *self.seen.entry(contact).or_default() += 1;
        }
        if taken < self.due {
            return;
        }
        self.due = taken + EVERY;
        // A warning, so that it is seen without switching anything on: the host is waiting.
        let busiest = self.seen.iter().max_by_key(|(_, times)| **times);
        let busiest = busiest.map(|(contact, _)| format!(", most of them in contact {}", contact + 1));
        self.log.write(
            Severity::Warning,
            LogCategory::Warning,
            format_args!(
                "the step to t = {} s has taken {} s so far: it has reached t = {time} s after {events} events{}",
                self.until,
                taken.as_secs(),
                busiest.unwrap_or_default()
            ),
        );
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::rc::Rc;

    use super::*;

    #[test]
    fn a_step_that_takes_long_is_logged_and_not_too_often() {
        let lines = Rc::new(RefCell::new(Vec::new()));
        let kept = lines.clone();
        let sink = move |severity, category, text: &str| kept.borrow_mut().push((severity, category, text.to_owned()));
        let log = Log::new(Some(Box::new(sink)), false);
        let mut reporter = Reporter::new(&log, 7.0);
        let progress = |contact: usize| Progress { time: 0.25, events: 1000, contact: Some(contact) };
        reporter.progress(progress(3));
        assert!(lines.borrow().is_empty());
        for seconds in [3, 9, 14] {
            reporter.since = Instant::now().checked_sub(Duration::from_secs(seconds));
            reporter.progress(progress(2));
        }
        // At first both contacts have been seen once.
        let expected = [(3, 4), (14, 3)].map(|(seconds, contact)| {
            let text = format!(
                "the step to t = 7 s has taken {seconds} s so far: it has reached t = 0.25 s after 1000 events, most \
                 of them in contact {contact}"
            );
            (Severity::Warning, LogCategory::Warning, text)
        });
        assert_eq!(*lines.borrow(), expected);
    }
}
