//! The findings of a check: problems and remarks, each one line.

use std::fmt::{Display, Formatter};

/// Most findings of one kind in a report; each of many thousand entries may have one.
const MAX_FINDINGS: usize = 100;

/// What was found.
#[derive(Default)]
pub struct Report {
    /// Violations of the standard, and contradictions.
    pub problems: Vec<String>,
    /// Allowed, but known to break some importers.
    pub remarks: Vec<String>,
    omitted: usize,
}

impl Report {
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

    /// The value of a result; an error becomes a problem of `what`.
    pub(crate) fn accept<T, E: Display>(&mut self, what: impl Display, result: Result<T, E>) -> Option<T> {
        result.inspect_err(|error| self.problem(format_args!("{what}: {error}"))).ok()
    }

    fn add(list: &mut Vec<String>, omitted: &mut usize, text: impl Display) {
        if list.len() < MAX_FINDINGS {
            // Foreign names may contain line breaks; a finding stays one line.
            list.push(text.to_string().replace(char::is_control, "?"));
        } else {
            *omitted += 1;
        }
    }
}

/// One line for each finding, and a summary.
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
