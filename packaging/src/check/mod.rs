//! What is wrong with an FMU: its entries, its description, its binaries, and what the binary answers. Damage of any kind is
//! reported, whoever wrote the FMU.

pub mod binary;
pub mod model;
mod own;
pub mod probe;
mod reader;
mod structure;
mod unpack;
mod variables;

use std::fmt::{Display, Formatter};
use std::fs;
use std::path::Path;

use model::Model;
pub use unpack::unpack;

use crate::Error;
use crate::archive::Entries;
use crate::contents::binary_path;
use crate::platform::{PLATFORMS, Platform};

/// Largest FMU that is read, and largest contents, bytes.
pub const MAX_BYTES: u64 = 512 << 20;
/// Findings of one kind that a report has; there may be one for each of many thousand variables.
const MAX_FINDINGS: usize = 100;

/// What was found.
#[derive(Default)]
pub struct Report {
    /// What is against the standard, or does not fit together.
    pub problems: Vec<String>,
    /// What is allowed, yet trips over somebody.
    pub remarks: Vec<String>,
    omitted: usize,
}

impl Report {
    /// Whether there is no problem; there may be remarks.
    pub fn is_clean(&self) -> bool {
        self.problems.is_empty()
    }

    fn problem(&mut self, text: impl Display) {
        Self::add(&mut self.problems, &mut self.omitted, text);
    }

    fn remark(&mut self, text: impl Display) {
        Self::add(&mut self.remarks, &mut self.omitted, text);
    }

    fn add(list: &mut Vec<String>, omitted: &mut usize, text: impl Display) {
        if list.len() < MAX_FINDINGS {
            // Foreign names may hold anything; a finding stays one line.
            list.push(text.to_string().chars().map(|c| if c.is_control() { '?' } else { c }).collect());
        } else {
            *omitted += 1;
        }
    }
}

/// One line for each finding, and one that sums up.
impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        for problem in &self.problems {
            writeln!(f, "problem: {problem}")?;
        }
        for remark in &self.remarks {
            writeln!(f, "remark: {remark}")?;
        }
        if self.omitted > 0 {
            writeln!(f, "and {} more", self.omitted)?;
        }
        writeln!(f, "{} problem(s), {} remark(s)", self.problems.len(), self.remarks.len())
    }
}

/// Checks the FMU in a file; `load` says whether its binary for this machine is loaded, in another process.
pub fn file(path: &Path, load: bool) -> Result<Report, Error> {
    let bytes = read(path)?;
    let mut report = Report::default();
    let Some((entries, model)) = contents(&bytes, MAX_BYTES, &mut report) else { return Ok(report) };
    if load {
        probe::check(&entries, &model, &mut report)?;
    }
    Ok(report)
}

/// Checks an FMU in memory without loading its binary; of its contents at most `limit` bytes are unpacked.
pub fn bytes(bytes: &[u8], limit: u64) -> Report {
    let mut report = Report::default();
    contents(bytes, limit, &mut report);
    report
}

/// The bytes of a file that is not too large.
pub fn read(path: &Path) -> Result<Vec<u8>, Error> {
    let told = |reason: &dyn Display| Error::Usage(format!("cannot read {}: {reason}", path.display()));
    let length = fs::metadata(path).map_err(|error| told(&error))?.len();
    if length > MAX_BYTES {
        return Err(told(&format_args!("{length} bytes; allowed: at most {MAX_BYTES}")));
    }
    fs::read(path).map_err(|error| told(&error))
}

fn contents(bytes: &[u8], limit: u64, report: &mut Report) -> Option<(Entries, Model)> {
    let entries = unpack(bytes, limit, report)?;
    let model = Model::read(entries.get("modelDescription.xml")?, report)?;
    model::attributes(&model, &entries, report);
    variables::check(&model, report);
    structure::check(&model, report);
    binaries(&entries, &model, report);
    own::check(&entries, &model, report);
    Some((entries, model))
}

/// Every shared library that a host would look for, and files that no host will find.
fn binaries(entries: &Entries, model: &Model, report: &mut Report) {
    for interface in model.interfaces() {
        let path = |platform: &Platform| binary_path(platform, &interface.identifier);
        let found: Vec<&Platform> = PLATFORMS.iter().filter(|platform| entries.contains_key(&path(platform))).collect();
        if found.is_empty() && !entries.keys().any(|name| name.starts_with("sources/")) {
            report.problem(format_args!("binaries: none for {} on any platform", interface.identifier));
        }
        for platform in found {
            let path = path(platform);
            if let Err(error) = platform.check(&entries[&path]) {
                report.problem(format_args!("{path}: {error}"));
                continue;
            }
            binary::check(&path, &entries[&path], interface.kind, model.is_own(), report);
        }
    }
}
