//! Checking a whole FMU of this program: one check after another, from the zip file to its shared libraries.

use std::fmt::Display;
use std::fs;
use std::path::Path;

use newtons_cradle::variables::MODEL_IDENTIFIER;

use super::model::Model;
use super::report::Report;
use super::unpack::unpack;
use super::{binary, own};
use crate::archive::Entries;
use crate::error::Error;
use crate::platform::PLATFORMS;

/// Largest FMU that is read, and largest contents, bytes.
pub const MAX_BYTES: u64 = 512 << 20;

/// Checks an FMU in memory, without loading its binaries; of its contents at most `limit` bytes are unpacked. The
/// entries are for more checks; there are none if it is not an FMU of this version of this program.
pub fn bytes(bytes: &[u8], limit: u64) -> (Report, Option<Entries>) {
    let mut report = Report::default();
    let entries = contents(bytes, limit, &mut report);
    (report, entries)
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

fn contents(bytes: &[u8], limit: u64, report: &mut Report) -> Option<Entries> {
    let entries = unpack(bytes, limit, report)?;
    let model = Model::read(entries.get("modelDescription.xml")?, report)?;
    if !model.is_own() {
        let (name, tool) = (&model.name, &model.tool);
        report.problem(format_args!(
            "\"{name}\" of \"{tool}\" is not an FMU of this program; `fmpy validate FILE` checks those of others"
        ));
        return None;
    }
    binaries(&entries, &model, report);
    own::check(&entries, &model, report).then_some(entries)
}

/// Every shared library that a host would look for.
fn binaries(entries: &Entries, model: &Model, report: &mut Report) {
    let mut found = false;
    for platform in PLATFORMS {
        for path in platform.paths(MODEL_IDENTIFIER, model.is_fmi3()) {
            let Some(library) = entries.get(&path) else { continue };
            found = true;
            if report.accept(&path, platform.check(library)).is_some() {
                binary::check(&path, library, report);
            }
        }
    }
    report.require(found, format_args!("binaries: none for {MODEL_IDENTIFIER} on any platform"));
}
