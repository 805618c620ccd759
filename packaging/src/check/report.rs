//! The findings of a check: problems and remarks, each one line.

use std::fmt::{Display, Formatter};

/// Findings of one kind that a report has; there may be one for each of many thousand entries.
const MAX_FINDINGS: usize = 100;

/// What was found.
#[derive(Default)]
pub struct Report {
    /// What is against the standard, or does not fit together.
    pub problems: Vec<String>,
    /// What is allowed but causes trouble in some hosts.
    pub remarks: Vec<String>,
    omitted: usize,
}

impl Report {
    /// Whether there is no problem; there may be remarks.
    pub fn is_clean(&self) -> bool {
        self.problems.is_empty()
    }

    pub(crate) fn problem(&mut self, text: impl Display) {
        Self::add(&mut self.problems, &mut self.omitted, text);
    }

    pub(crate) fn remark(&mut self, text: impl Display) {
        Self::add(&mut self.remarks, &mut self.omitted, text);
    }

    /// A problem unless this `holds`.
    pub(crate) fn require(&mut self, holds: bool, problem: impl Display) {
        if !holds {
            self.problem(problem);
        }
    }

    /// What has gone well; where it has not, that is a problem of `what`.
    pub(crate) fn accept<T, E: Display>(&mut self, what: impl Display, result: Result<T, E>) -> Option<T> {
        result.inspect_err(|error| self.problem(format_args!("{what}: {error}"))).ok()
    }

    fn add(list: &mut Vec<String>, omitted: &mut usize, text: impl Display) {
        if list.len() < MAX_FINDINGS {
            // Foreign names may hold anything; a finding stays one line.
            list.push(text.to_string().replace(char::is_control, "?"));
        } else {
            *omitted += 1;
        }
    }
}

/// One line for each finding, and one that sums up.
impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        self.problems.iter().try_for_each(|problem| writeln!(f, "problem: {problem}"))?;
        self.remarks.iter().try_for_each(|remark| writeln!(f, "remark: {remark}"))?;
        if self.omitted > 0 {
            writeln!(f, "and {} more", self.omitted)?;
        }
        writeln!(f, "{} problem(s), {} remark(s)", self.problems.len(), self.remarks.len())
    }
}
