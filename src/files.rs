//! Reading files that somebody else has named: nothing but regular files, and no more of them than is allowed.

use std::fs::{self, File, Metadata};
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// Largest file of start values that is read, bytes: n = 10000 with every value changed has 3 MB.
pub const MAX_START_VALUES: u64 = 32 << 20;

/// The contents of a regular file, or of one that a link leads to, of at most `limit` bytes.
///
/// # Errors
/// Those of the system; and a refusal of anything else, such as a device, which may have no end, or a pipe, which
/// waits for somebody to write into it.
pub fn read(path: &Path, limit: u64) -> Result<Vec<u8>> {
    // Before it is opened, as opening a pipe waits and opening a device may act on it; and again in case it was
    // replaced meanwhile.
    regular(&fs::metadata(path)?)?;
    let file = File::open(path)?;
    regular(&file.metadata()?)?;
    let mut contents = Vec::new();
    // One byte more than allowed shows that there are too many, whatever length the system says the file has.
    file.take(limit.saturating_add(1)).read_to_end(&mut contents)?;
    if contents.len() as u64 > limit {
        return Err(Error::new(ErrorKind::FileTooLarge, format!("it is too large; allowed: at most {limit} bytes")));
    }
    Ok(contents)
}

/// Refuses what is not a regular file.
///
/// # Errors
/// The refusal.
pub fn regular(metadata: &Metadata) -> Result<()> {
    let what = if metadata.is_dir() { "a folder" } else { "a device, a pipe or a socket" };
    if metadata.is_file() {
        return Ok(());
    }
    Err(Error::new(ErrorKind::InvalidInput, format!("it is {what}; allowed: a regular file")))
}
