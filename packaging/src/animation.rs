//! The 3D animation of a run. The Python package makes it, because it runs the FMU through FMPy and brings three.js.

use std::ffi::{OsStr, OsString};
use std::process::Command;

use crate::environment::{self, PACKAGE};
use crate::error::Error;

/// Runs `python -m newtons_cradle page` with `arguments`; its exit code. Without a `python` to run it takes the first
/// that has the package, see [`environment::python`].
pub fn make(python: Option<OsString>, arguments: &[OsString]) -> Result<u8, Error> {
    let none = || Error::Failure(format!("there is no Python that has {PACKAGE}; {ADVICE}"));
    let python = python.or_else(environment::python).ok_or_else(none)?;
    let status = Command::new(&python)
        .args(["-m", PACKAGE, "page"])
        .args(arguments)
        .status()
        .map_err(|error| Error::Failure(format!("cannot run {}: {error}; {ADVICE}", python.display())))?;
    // A package that is missing, or misses another one, has ended Python with its own words.
    if !status.success() && !imports(&python) {
        let python = python.display();
        return Err(Error::Failure(format!("{python} cannot import {PACKAGE}; {ADVICE}")));
    }
    // Killed by a signal it has no code.
    Ok(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1))
}

fn imports(python: &OsStr) -> bool {
    let code = format!("import {PACKAGE}.animation");
    Command::new(python).args(["-c", &code]).output().is_ok_and(|output| output.status.success())
}

const ADVICE: &str = "install it with `pip install newtons-cradle` or, in the folder of the sources, `python3 cradle.py paper`; \
                      --python selects another Python";
