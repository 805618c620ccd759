//! Finds the Python package, in the environment of this program or in other Pythons, and hands commands over to it. The
//! package contains an FMU, and makes pages, for which it runs FMUs through FMPy.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use crate::error::Error;

const PACKAGE: &str = "newtons_cradle";
/// The package, or a file that refers to it, in a folder of Python packages.
const PARTS: [&str; 2] = [PACKAGE, "newtons_cradle.pth"];

/// Path of Python in a virtual environment.
const IN_VENV: &str = if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" };

const ADVICE: &str = "install it with `pip install newtons-cradle` or, in the folder of the sources, \
                      `python3 cradle.py paper`; --python selects another Python";

/// The FMU of the installed package, if this program lies in its environment. If several Pythons in it have the
/// package, as in `~/.local`, the newest FMU.
pub fn fmu() -> Option<PathBuf> {
    let programs = program_folder()?;
    let fmus = packages(programs.parent()?)
        .map(|folder| folder.join(PACKAGE).join("NewtonsCradle.fmu"))
        .filter(|fmu| fmu.is_file());
    fmus.max_by_key(|fmu| fmu.metadata().and_then(|fmu| fmu.modified()).ok())
}

/// Whether the package is installed in this program's environment or in `.venv`, where a file may refer to it. No
/// Python is started, which would take longer than packing an FMU.
pub fn has_package() -> bool {
    let has_part = |folder: PathBuf| PARTS.iter().any(|part| folder.join(part).exists());
    fmu().is_some() || venv().is_some_and(|venv| packages(&venv).any(has_part))
}

/// The folders in which the Pythons in the folder `root` have packages.
fn packages(root: &Path) -> impl Iterator<Item = PathBuf> {
    let libraries = ["lib", "lib64"].into_iter().filter_map(|lib| fs::read_dir(root.join(lib)).ok());
    let pythons = libraries.flatten().filter_map(Result::ok).map(|entry| entry.path());
    // Debian has `dist-packages`; Windows has them elsewhere.
    let pythons = pythons.chain([root.join("Lib"), root.to_path_buf()]);
    pythons.flat_map(|python| ["site-packages", "dist-packages"].map(|name| python.join(name)))
}

/// Runs `python -m newtons_cradle` with a command and its arguments, by default with the first Python that has the
/// package. Returns the exit code.
pub fn hand_over(command: &str, python: Option<OsString>, arguments: &[OsString]) -> Result<u8, Error> {
    let none = || Error::Failure(format!("there is no Python that has {PACKAGE}; {ADVICE}"));
    let python = python.or_else(self::python).ok_or_else(none)?;
    let status = Command::new(&python)
        .args(["-m", PACKAGE, command])
        .args(arguments)
        .status()
        .map_err(|error| Error::Failure(format!("cannot run {}: {error}; {ADVICE}", python.display())))?;
    // Python itself has printed which package is missing.
    if !status.success() && !succeeds(&python, &format!("import {PACKAGE}.page")) {
        let python = python.display();
        return Err(Error::Failure(format!("{python} cannot import {PACKAGE}; {ADVICE}")));
    }
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    code.ok_or_else(|| Error::Failure(format!("{} has ended early: {status}", python.display())))
}

/// A Python that has the package: in this program's environment, on the PATH, or in `.venv` in this folder or one
/// above. The package is not imported, which would take time.
fn python() -> Option<OsString> {
    let (beside, on_path) = if cfg!(windows) {
        (["python.exe", "../python.exe"], ["py", "python"])
    } else {
        (["python3", "python"], ["python3", "python"])
    };
    let beside = program_folder().into_iter().flat_map(|folder| beside.map(|name| folder.join(name)));
    let beside = beside.filter(|path| path.is_file());
    let all = beside
        .chain(on_path.map(PathBuf::from))
        .chain(venv().map(|venv| venv.join(IN_VENV)))
        .map(PathBuf::into_os_string);
    let code = format!("import importlib.util as u, sys; sys.exit(u.find_spec('{PACKAGE}') is None)");
    all.into_iter().find(|python| succeeds(python, &code))
}

fn succeeds(python: &OsStr, code: &str) -> bool {
    Command::new(python).args(["-c", code]).output().is_ok_and(|output| output.status.success())
}

/// `.venv` in this folder or the first above that has one with a Python.
fn venv() -> Option<PathBuf> {
    let here = env::current_dir().unwrap_or_default();
    here.ancestors().map(|folder| folder.join(".venv")).find(|venv| venv.join(IN_VENV).is_file())
}

/// The folder of this program, with links resolved.
fn program_folder() -> Option<PathBuf> {
    let program = env::current_exe().ok()?;
    // On Windows, `canonicalize` gives a path that not every program accepts.
    let program = if cfg!(windows) { program } else { fs::canonicalize(program).ok()? };
    program.parent().map(Path::to_path_buf)
}
