//! The process that a binary is loaded in, which is this program once more, and a folder for that time: a binary that
//! crashes or hangs takes nothing with it.

use std::path::{Component, Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use std::{env, fs, thread};

/// How long a binary may take for all of it.
const PATIENCE: Duration = Duration::from_secs(60);

/// Runs this program with other arguments, silently and not for longer than `PATIENCE`; nothing if it took longer.
pub fn supervise(arguments: &[&Path]) -> Result<Option<ExitStatus>, String> {
    let program = env::current_exe().map_err(|error| failed("find this program", error))?;
    let mut child = Command::new(program)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|error| failed("start this program again", error))?;
    let deadline = Instant::now() + PATIENCE;
    loop {
        match child.try_wait().map_err(|error| failed("wait for the binary", error))? {
            None if Instant::now() < deadline => thread::sleep(Duration::from_millis(2)),
            Some(status) => return Ok(Some(status)),
            None => break,
        }
    }
    // It may just have ended by itself.
    let _ = child.kill();
    let _ = child.wait();
    Ok(None)
}

/// A new folder that is removed in the end.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new() -> Result<Self, String> {
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
    pub fn write(&self, name: &str, contents: &[u8]) -> Result<(), String> {
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

fn failed(what: &str, error: std::io::Error) -> String {
    format!("cannot {what}: {error}")
}
