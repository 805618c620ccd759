//! Writing the zip file: deflated, sorted, with forward slashes and the earliest date of zip files, so that the same
//! contents give the same bytes.

use std::collections::BTreeMap;
use std::fs;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::error::Error;

/// Files of an FMU by their path in it.
pub type Entries = BTreeMap<String, Vec<u8>>;

/// Writes `entries` to `path` and tells the size in bytes. The file appears only when it is complete.
pub fn write(path: &Path, entries: Entries) -> Result<u64, Error> {
    let bytes = bytes(entries).map_err(|error| cannot_write(path, &error))?;
    replace(path, &bytes)?;
    Ok(bytes.len() as u64)
}

/// Writes a file, which appears only when it is complete.
pub fn replace(path: &Path, contents: &[u8]) -> Result<(), Error> {
    let told = |error: &dyn std::fmt::Display| cannot_write(path, error);
    let name = path.file_name().ok_or_else(|| told(&"it names no file"))?;
    let folder = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    fs::create_dir_all(folder).map_err(|error| told(&error))?;
    let unfinished = Unfinished(folder.join(format!(".{}.{}", name.to_string_lossy(), std::process::id())));
    fs::write(&unfinished.0, contents).map_err(|error| told(&error))?;
    fs::rename(&unfinished.0, path).map_err(|error| told(&error))
}

fn cannot_write(path: &Path, error: &dyn std::fmt::Display) -> Error {
    Error::Failure(format!("cannot write {}: {error}", path.display()))
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
pub fn bytes(entries: Entries) -> Result<Vec<u8>, zip::result::ZipError> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options =
        SimpleFileOptions::default().compression_method(CompressionMethod::Deflated).compression_level(Some(6));
    for (name, contents) in entries {
        zip.start_file(name, options)?;
        zip.write_all(&contents)?;
    }
    Ok(zip.finish()?.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries() -> Entries {
        [("b/c".to_owned(), vec![7; 10_000]), ("a".to_owned(), b"text".to_vec())].into()
    }

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("cradle-archive-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    #[test]
    fn the_same_contents_give_the_same_bytes() {
        let folder = folder("same");
        let (one, two) = (folder.join("new/one.fmu"), folder.join("two.fmu"));
        assert_eq!(write(&one, entries()).unwrap(), fs::metadata(&one).unwrap().len());
        write(&two, entries()).unwrap();
        assert_eq!(fs::read(&one).unwrap(), fs::read(&two).unwrap());
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_failure_leaves_nothing_behind() {
        let folder = folder("failure");
        fs::create_dir_all(folder.join("taken.fmu/full")).unwrap();
        let error = write(&folder.join("taken.fmu"), entries()).unwrap_err();
        assert!(error.to_string().contains("taken.fmu"), "{error}");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        assert!(write(Path::new("/"), entries()).is_err());
        fs::remove_dir_all(&folder).unwrap();
    }
}
