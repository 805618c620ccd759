//! The 3D animation of a run. The Python package makes it, because it runs the FMU through FMPy and brings three.js.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::error::Error;

const PACKAGE: &str = "newtons_cradle";

/// Where a virtual environment has its Python.
const IN_VENV: &str = if cfg!(windows) { ".venv/Scripts/python.exe" } else { ".venv/bin/python" };

/// Runs `python -m newtons_cradle page` with `arguments`; its exit code. Without a `python` to run it takes that of the `.venv` in
/// this folder or the nearest one above, else `python3` or `python`.
pub fn make(python: Option<OsString>, arguments: &[OsString]) -> Result<u8, Error> {
    let python = python.map_or_else(find, Ok)?;
    let status = Command::new(&python)
        .args(["-m", PACKAGE, "page"])
        .args(arguments)
        .status()
        .map_err(|error| Error::Failure(format!("cannot run {}: {error}; {}", python.display(), advice())))?;
    // A package that is missing, or misses another one, has ended Python with its own words.
    if !status.success() && !imports(&python) {
        let python = python.display();
        return Err(Error::Failure(format!("{python} cannot import {PACKAGE}; {}", advice())));
    }
    // Killed by a signal it has no code.
    Ok(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1))
}

fn find() -> Result<OsString, Error> {
    let here = std::env::current_dir().unwrap_or_default();
    let venv = here.ancestors().map(|folder| folder.join(IN_VENV)).find(|python| python.exists());
    let starts = |name: &&str| Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success());
    venv.map(PathBuf::into_os_string)
        .or_else(|| ["python3", "python"].into_iter().find(starts).map(OsString::from))
        .ok_or_else(|| Error::Failure(format!("there is no Python; {}", advice())))
}

fn imports(python: &OsStr) -> bool {
    let code = format!("import {PACKAGE}.animation");
    Command::new(python).args(["-c", &code]).output().is_ok_and(|output| output.status.success())
}

fn advice() -> String {
    let python = Path::new(IN_VENV).display();
    format!(
        "`python3 cradle.py paper` in the folder of the sources makes {python} with all it needs; --python takes another one"
    )
}
