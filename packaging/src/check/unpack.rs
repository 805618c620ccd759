//! The entries of the zip file: names that every host can unpack, methods that every host knows, sizes within reason.

use std::collections::BTreeSet;
use std::io::{Cursor, Read};

use zip::{CompressionMethod, ZipArchive};

use super::model;
use super::report::{Report, one_line};
use crate::archive::Entries;

/// Longer paths, in bytes, may exceed the limit of Windows once a host has unpacked them.
const LONG_PATH: usize = 160;

/// Offset of the Unix file type in an entry of the zip file's directory, and its mask. The type is `FILE` or `FOLDER`,
/// or 0 if unset; it counts, whatever system made the file.
const KIND: (usize, u16) = (40, 0o170_000);
const FILE: u16 = 0o100_000;
const FOLDER: u16 = 0o040_000;

/// Every entry that can be read, at most `limit` bytes together.
pub fn unpack(bytes: &[u8], limit: u64, report: &mut Report) -> Entries {
    let mut entries = Entries::new();
    let Some(mut archive) = report.accept("zip", ZipArchive::new(Cursor::new(bytes))) else { return entries };
    let mut left = limit;
    report.require(!archive.has_duplicate_names(), "zip: several entries have the same name");
    let mut names = BTreeSet::new();
    for index in 0..archive.len() {
        let entry = archive.by_index_raw(index).map(|entry| {
            let name = String::from_utf8_lossy(entry.name_raw()).into_owned();
            (name, kind(bytes, entry.central_header_start()), entry.compression())
        });
        let Some((name, kind, method)) = report.accept(format_args!("zip: entry {}", index + 1), entry) else {
            continue;
        };
        check_name(&name, report);
        let same = !names.insert(name.trim_end_matches('/').to_lowercase());
        report.require(!same, format_args!("{name}: on some systems, another entry has the same name"));
        report.require(
            matches!(kind, 0 | FILE | FOLDER),
            format_args!("{name}: a link, a pipe or a device; allowed: a file"),
        );
        if !matches!(method, CompressionMethod::Stored | CompressionMethod::Deflated) {
            report.problem(format_args!("{name}: compressed by {method}; allowed: deflated, stored"));
            continue;
        }
        let mut contents = Vec::new();
        // One byte more than allowed is read, to see whether there are too many.
        let length = archive
            .by_index(index)
            .and_then(|entry| Ok(entry.take(left.saturating_add(1)).read_to_end(&mut contents)?));
        let Some(length) = report.accept(format_args!("{name}: cannot be unpacked"), length) else { continue };
        if length as u64 > left {
            report.problem(format_args!("{name}: the unpacked files exceed {limit} bytes; the rest is not read"));
            break;
        }
        left -= length as u64;
        if !name.ends_with('/') {
            entries.insert(name, contents);
        }
    }
    report.require(entries.contains_key(model::FILE), "modelDescription.xml: missing");
    entries
}

/// The Unix file type of an entry, by its place in the directory.
fn kind(bytes: &[u8], entry: u64) -> u16 {
    let (offset, mask) = KIND;
    let at = usize::try_from(entry).ok().and_then(|entry| bytes.get(entry.checked_add(offset)?..));
    at.and_then(|at| at.first_chunk()).map_or(0, |kind| u16::from_le_bytes(*kind) & mask)
}

fn check_name(name: &str, report: &mut Report) {
    report.require(!name.contains('\\'), format_args!("{name}: a backslash in the name; allowed: forward slashes"));
    let parts = || name.trim_end_matches('/').split(['/', '\\']);
    let leaves = parts().any(|part| part.is_empty() || part == "." || part == ".." || part.contains(':'));
    report.require(!leaves, format_args!("{name}: not a path that stays in the folder of the FMU"));
    report.require(one_line(name) == name, format_args!("{name}: a name with control characters"));
    if name.len() > LONG_PATH || parts().any(|part| part.len() > 100) {
        report.remark(format_args!("{name}: a path of {} bytes, too long for some hosts on Windows", name.len()));
    }
    if !name.is_ascii() {
        report.remark(format_args!("{name}: not in ASCII; hosts differ in how they unpack such names"));
    }
}
