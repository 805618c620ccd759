//! The findings of a check: problems and remarks, each one line.

use std::fmt::{Display, Formatter};

/// The largest number of findings of a kind that are shown: each of many thousand entries may have one.
const SHOWN: usize = 100;

/// The findings.
#[derive(Default)]
pub struct Report {
    /// Violations of the standard, and contradictions.
    pub problems: Vec<String>,
    /// Allowed, but known to break some importers.
    pub remarks: Vec<String>,
}

impl Report {
    pub(crate) fn problem(&mut self, text: impl Display) {
        self.problems.push(one_line(text));
    }

    pub(crate) fn remark(&mut self, text: impl Display) {
        self.remarks.push(one_line(text));
    }

    /// Adds the problem unless `holds`.
    pub(crate) fn require(&mut self, holds: bool, problem: impl Display) {
        if !holds {
            self.problem(problem);
        }
    }

    /// The value of a result; an error becomes a problem of `what`.
    pub(crate) fn accept<T, E: Display>(&mut self, what: impl Display, result: Result<T, E>) -> Option<T> {
        result.inspect_err(|error| self.problem(format_args!("{what}: {error}"))).ok()
    }
}

/// Foreign text, fit for a terminal: control characters become question marks, among them line breaks and characters
/// that change the direction of writing.
pub(crate) fn one_line(text: impl Display) -> String {
    let turns =
        |c| matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    text.to_string().replace(|c: char| c.is_control() || turns(c) || matches!(c, '\u{2028}' | '\u{2029}'), "?")
}

/// One line for each finding, and a summary.
impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        for (kind, found) in [("problem", &self.problems), ("remark", &self.remarks)] {
            found.iter().take(SHOWN).try_for_each(|text| writeln!(f, "{kind}: {text}"))?;
            if let more @ 1.. = found.len().saturating_sub(SHOWN) {
                writeln!(f, "and {more} more")?;
            }
        }
        writeln!(f, "{} problem(s), {} remark(s)", self.problems.len(), self.remarks.len())
    }
}
