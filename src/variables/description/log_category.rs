//! Categories of log lines.

/// A category of log lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogCategory {
    /// A line for each finished pulse.
    Events,
    /// Notes on the solver's settings.
    Solver,
    /// Warnings of calls that succeed, such as the progress of a slow step.
    Warning,
    /// Refused values of FMI 3.0, which change nothing.
    Discard,
    /// Refused and failed calls.
    Error,
}

/// Every category in the order of the enumeration, with its name in the description and in the host's log, and a text
/// for the user.
pub const LOG_CATEGORIES: [(LogCategory, &str, &str); 5] = [
    (
        LogCategory::Events,
        "logEvents",
        "One line for each finished pulse: contact, onset, release, peak force and impulse",
    ),
    (LogCategory::Solver, "logSolver", "What the solver does with the settings it was given"),
    (LogCategory::Warning, "logStatusWarning", "Warnings"),
    (LogCategory::Discard, "logStatusDiscard", "Refused values that leave the instance as it was, with the reason"),
    (LogCategory::Error, "logStatusError", "Refused calls and failed steps, with the reason"),
];

const _: () = {
    let mut i = 0;
    while i < LOG_CATEGORIES.len() {
        assert!(LOG_CATEGORIES[i].0 as usize == i, "not in the order of the enumeration");
        i += 1;
    }
};

impl LogCategory {
    /// Name in the description and in the host's log.
    pub const fn name(self) -> &'static str {
        LOG_CATEGORIES[self as usize].1
    }
}
