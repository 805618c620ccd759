//! A folder for the time that a binary is loaded.

use std::path::{Component, Path, PathBuf};
use std::{env, fs};

use crate::error::Error;

/// A new folder that is removed in the end.
pub(crate) struct Folder(pub(crate) PathBuf);

impl Folder {
    pub(crate) fn new() -> Result<Self, Error> {
        let mut attempt = 0;
        loop {
            let path = env::temp_dir().join(format!("cradle-fmu-{}-{attempt}", std::process::id()));
            match fs::create_dir(&path) {
                Ok(()) => return Ok(Self(path)),
                Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists && attempt < 1000 => attempt += 1,
                Err(error) => return Err(failed(&format!("make the folder {}", path.display()), error)),
            }
        }
    }

    /// Writes an entry of the zip file, unless its path leaves the folder.
    pub(crate) fn write(&self, name: &str, contents: &[u8]) -> Result<(), Error> {
        let relative = Path::new(name);
        if !relative.components().all(|part| matches!(part, Component::Normal(_))) {
            return Ok(());
        }
        let path = self.0.join(relative);
        let written = path.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(&path, contents));
        written.map_err(|error| failed(&format!("write {}", path.display()), error))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What is left in the system's folder for temporary files is no harm.
        let _ = fs::remove_dir_all(&self.0);
    }
}

pub(super) fn failed(what: &str, error: std::io::Error) -> Error {
    Error::Failure(format!("cannot {what}: {error}"))
}
