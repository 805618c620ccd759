//! Categories of log lines.

use crate::model::enumerations;

enumerations! {
    /// A category of log lines, with its name in the description and in the host's log, and a text for the user.
    LogCategory {
        Events = 0 "logEvents" "One line for each finished pulse: contact, onset, release, peak force and impulse",
        Solver "logSolver" "What the solver does with the settings it was given",
        Warning "logStatusWarning" "Warnings",
        Discard "logStatusDiscard" "Refused values that leave the instance as it was, with the reason",
        Error "logStatusError" "Refused calls and failed steps, with the reason",
    }
}
