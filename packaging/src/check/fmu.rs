//! Checking a whole FMU: one check after another, from the zip file to what the binary answers.

use std::fmt::Display;
use std::fs;
use std::path::Path;

use super::description::model::{Interface, Kind, Model};
use super::description::{arrays, attributes, structure, variables};
use super::report::Report;
use super::unpack::unpack;
use super::{binary, own, probe};
use crate::archive::Entries;
use crate::error::Error;
use crate::platform::{PLATFORMS, Platform};

/// Largest FMU that is read, and largest contents, bytes.
pub const MAX_BYTES: u64 = 512 << 20;

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
    attributes::check(&model, &entries, report);
    if model.is_fmi3() {
        arrays::check(&model, report);
    } else {
        variables::check(&model, report);
        structure::check(&model, report);
    }
    binaries(&entries, &model, report);
    own::check(&entries, &model, report);
    Some((entries, model))
}

/// Every shared library that a host would look for, and files that no host will find.
fn binaries(entries: &Entries, model: &Model, report: &mut Report) {
    let interfaces: Vec<&Interface> = model.interfaces().collect();
    for (place, interface) in interfaces.iter().enumerate() {
        let same = |other: &&Interface| other.identifier == interface.identifier;
        if interfaces[..place].iter().copied().any(|other| same(&other)) {
            continue;
        }
        let kinds: Vec<Kind> = interfaces.iter().copied().filter(same).map(|interface| interface.kind).collect();
        let paths = |platform: &'static Platform| platform.paths(&interface.identifier, model.is_fmi3());
        let found: Vec<(&Platform, String)> = PLATFORMS
            .iter()
            .flat_map(|platform| paths(platform).into_iter().map(move |path| (platform, path)))
            .filter(|(_, path)| entries.contains_key(path))
            .collect();
        if found.is_empty() && !entries.keys().any(|name| name.starts_with("sources/")) {
            report.problem(format_args!("binaries: none for {} on any platform", interface.identifier));
        }
        for (platform, path) in found {
            if report.accept(&path, platform.check(&entries[&path])).is_some() {
                binary::check(&path, &entries[&path], &kinds, model, report);
            }
        }
    }
}
