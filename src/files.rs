//! Reads files that somebody else has named: only regular files, up to a size limit.

use std::fs::{self, File, Metadata};
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// Largest file of start values that is read, bytes. With n = 10000 and every value changed, a file has 3 MB.
pub const MAX_START_VALUES: u64 = 32 << 20;

/// The contents of a regular file of at most `limit` bytes; links are followed.
///
/// # Errors
/// Errors of the system, a file that is too large, or anything but a regular file: a device may have no end, and a pipe
/// waits for a writer.
pub fn read(path: &Path, limit: u64) -> Result<Vec<u8>> {
    // Checked before opening, because opening a pipe waits and opening a device may act on it; and again afterwards, in
    // case the file was replaced meanwhile.
    regular(&fs::metadata(path)?)?;
    let file = File::open(path)?;
    regular(&file.metadata()?)?;
    let mut contents = Vec::new();
    // One byte more than allowed shows that the file is too large, whatever length the system reports.
    file.take(limit.saturating_add(1)).read_to_end(&mut contents)?;
    if contents.len() as u64 > limit {
        return Err(Error::new(ErrorKind::FileTooLarge, format!("it is too large; allowed: at most {limit} bytes")));
    }
    Ok(contents)
}

/// Refuses anything but a regular file.
///
/// # Errors
/// `InvalidInput`, with what the file is instead.
pub fn regular(metadata: &Metadata) -> Result<()> {
    let what = if metadata.is_dir() { "a folder" } else { "a device, a pipe or a socket" };
    if metadata.is_file() {
        return Ok(());
    }
    Err(Error::new(ErrorKind::InvalidInput, format!("it is {what}; allowed: a regular file")))
}
