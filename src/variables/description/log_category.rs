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

/// Every category of log lines, in the order of the enumeration.
pub const LOG_CATEGORIES: [LogCategory; 5] =
    [LogCategory::Events, LogCategory::Solver, LogCategory::Warning, LogCategory::Discard, LogCategory::Error];

impl LogCategory {
    /// Name in the description and in the host's log.
    pub const fn name(self) -> &'static str {
        self.texts().0
    }

    /// That name, and a text for the user.
    pub(super) const fn texts(self) -> (&'static str, &'static str) {
        match self {
            Self::Events => {
                ("logEvents", "One line for each finished pulse: contact, onset, release, peak force and impulse")
            }
            Self::Solver => ("logSolver", "What the solver does with the settings it was given"),
            Self::Warning => ("logStatusWarning", "Warnings"),
            Self::Discard => ("logStatusDiscard", "Refused values that leave the instance as it was, with the reason"),
            Self::Error => ("logStatusError", "Refused calls and failed steps, with the reason"),
        }
    }
}
