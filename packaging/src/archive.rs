//! Writing the zip file: deflated, sorted, with forward slashes and the earliest date of zip files, so that the same
//! contents give the same bytes.

use std::collections::BTreeMap;
use std::fs;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};

use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::error::Error;

/// Files of an FMU by their path in it.
pub type Entries = BTreeMap<String, Vec<u8>>;

/// Writes a file, which appears only when it is complete.
pub fn replace(path: &Path, contents: &[u8]) -> Result<(), Error> {
    let failed = |error: &dyn std::fmt::Display| Error::Failure(format!("cannot write {}: {error}", path.display()));
    let name = path.file_name().ok_or_else(|| failed(&"it names no file"))?;
    let folder = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let unfinished = Unfinished(folder.join(format!(".{}.{}", name.to_string_lossy(), std::process::id())));
    fs::create_dir_all(folder)
        .and_then(|()| fs::write(&unfinished.0, contents))
        .and_then(|()| fs::rename(&unfinished.0, path))
        .map_err(|error| failed(&error))
}

/// A file that is removed unless it was renamed.
struct Unfinished(PathBuf);

impl Drop for Unfinished {
    fn drop(&mut self) {
        // After the rename there is nothing left to remove.
        let _ = fs::remove_file(&self.0);
    }
}

/// The zip file of `entries`.
pub fn bytes(entries: Entries) -> Result<Vec<u8>, Error> {
    let write = || {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        let options =
            SimpleFileOptions::default().compression_method(CompressionMethod::Deflated).compression_level(Some(6));
        for (name, contents) in entries {
            zip.start_file(name, options)?;
            zip.write_all(&contents)?;
        }
        Ok(zip.finish()?.into_inner())
    };
    write().map_err(|error: ZipError| Error::Failure(format!("cannot pack the FMU: {error}")))
}
