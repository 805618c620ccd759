//! Categories of log lines.

macro_rules! categories {
    ($count:literal: $($category:ident $name:literal $text:literal,)*) => {
        /// A category of log lines.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum LogCategory {
            $(#[doc = $text] $category),*
        }

        /// Every category in the order of the enumeration, with its name in the description and in the host's log, and
        /// a text for the user.
        pub const LOG_CATEGORIES: [(LogCategory, &str, &str); $count] = [$((LogCategory::$category, $name, $text)),*];
    };
}

categories! {
    5:
    Events "logEvents" "One line for each finished pulse: contact, onset, release, peak force and impulse",
    Solver "logSolver" "What the solver does with the settings it was given",
    Warning "logStatusWarning" "Warnings",
    Discard "logStatusDiscard" "Refused values that leave the instance as it was, with the reason",
    Error "logStatusError" "Refused calls and failed steps, with the reason",
}
