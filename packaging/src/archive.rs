//! Writing the zip file: deflated, sorted, with forward slashes and the earliest date of zip files, so that the same
//! contents give the same bytes.

use std::collections::BTreeMap;
use std::io::{self, Cursor, Write};
use std::path::{Path, PathBuf};
use std::{fs, process};

use newtons_cradle::files;
use zip::result::ZipResult;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::error::Error;

/// Files of an FMU by their path in it.
pub type Entries = BTreeMap<String, Vec<u8>>;

/// Where a file of this name is to be written: a link leads to the file that is replaced. Only regular files are.
pub fn target(path: &Path) -> io::Result<PathBuf> {
    let is_link = match fs::symlink_metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(path.to_owned()),
        found => found?.is_symlink(),
    };
    files::regular(&fs::metadata(path)?)?;
    if is_link { fs::canonicalize(path) } else { Ok(path.to_owned()) }
}

/// Writes a file, which appears only when it is complete.
pub fn replace(path: &Path, contents: &[u8]) -> Result<(), Error> {
    let failed = |error: io::Error| Error::Failure(format!("cannot write {}: {error}", path.display()));
    let target = target(path).map_err(failed)?;
    let name = target.file_name().ok_or_else(|| failed(io::Error::other("it names no file")))?;
    let draft = target.with_file_name(format!(".{}.{}", name.to_string_lossy(), process::id()));
    let write = || {
        target.parent().map_or(Ok(()), fs::create_dir_all)?;
        // A leftover of a killed process with this number; or a link, which would lead elsewhere.
        let _ = fs::remove_file(&draft);
        fs::File::create_new(&draft)?.write_all(contents)?;
        fs::rename(&draft, &target)
    };
    write().map_err(|error| {
        let _ = fs::remove_file(&draft);
        failed(error)
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
