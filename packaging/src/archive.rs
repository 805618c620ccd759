//! Writing the zip file: deflated, sorted, with forward slashes and the earliest date of zip files, so that the same
//! contents give the same bytes.

use std::collections::BTreeMap;
use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;

use zip::result::ZipResult;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::error::Error;

/// Files of an FMU by their path in it.
pub type Entries = BTreeMap<String, Vec<u8>>;

/// Writes a file, which appears only when it is complete.
pub fn replace(path: &Path, contents: &[u8]) -> Result<(), Error> {
    let failed = |error: &dyn std::fmt::Display| Error::Failure(format!("cannot write {}: {error}", path.display()));
    let name = path.file_name().ok_or_else(|| failed(&"it names no file"))?;
    let draft = path.with_file_name(format!(".{}.{}", name.to_string_lossy(), std::process::id()));
    let written = path.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(&draft, contents));
    written.and_then(|()| fs::rename(&draft, path)).map_err(|error| {
        // It may not be there.
        let _ = fs::remove_file(&draft);
        failed(&error)
    })
}

/// The zip file of `entries`.
pub fn bytes(entries: Entries) -> ZipResult<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options =
        SimpleFileOptions::default().compression_method(CompressionMethod::Deflated).compression_level(Some(6));
    for (name, contents) in entries {
        zip.start_file(name, options)?;
        zip.write_all(&contents)?;
    }
    Ok(zip.finish()?.into_inner())
}
