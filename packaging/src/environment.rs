//! The Python environment that this program is installed in, and other Pythons that have the package.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// The Python package of this product.
pub const PACKAGE: &str = "newtons_cradle";

/// Where a virtual environment has its Python.
const IN_VENV: &str = if cfg!(windows) { ".venv/Scripts/python.exe" } else { ".venv/bin/python" };

/// The FMU that the installed package brings along, if this program lies in an environment that has it.
pub fn fmu() -> Option<PathBuf> {
    file("NewtonsCradle.fmu")
}

/// A file that the installed package brings along, if this program lies in an environment that has it.
pub fn file(name: &str) -> Option<PathBuf> {
    let mut files = packages(&program_folder()?).into_iter().map(|packages| packages.join(PACKAGE).join(name));
    files.find(|file| file.is_file())
}

/// A Python that finds the package: that of the environment this program is installed in, one on the PATH, or that of
/// `.venv` in this folder or one above.
pub fn python() -> Option<OsString> {
    let beside = program_folder().into_iter().flat_map(|folder| {
        let names = if cfg!(windows) { ["python.exe", "../python.exe"] } else { ["python3", "python"] };
        names.map(|name| folder.join(name))
    });
    let here = env::current_dir().unwrap_or_default();
    let above = here.ancestors().map(|folder| folder.join(IN_VENV)).collect::<Vec<_>>();
    let existing = |path: &PathBuf| path.is_file();
    let on_path = if cfg!(windows) { ["py", "python"] } else { ["python3", "python"] };
    beside
        .filter(existing)
        .map(PathBuf::into_os_string)
        .chain(on_path.map(OsString::from))
        .chain(above.into_iter().filter(existing).map(PathBuf::into_os_string))
        .find(|python| has_package(python))
}

/// Whether a Python finds the package. It is not imported, which would take a while.
pub fn has_package(python: &OsStr) -> bool {
    let code = format!("import importlib.util as u, sys; sys.exit(u.find_spec('{PACKAGE}') is None)");
    Command::new(python).args(["-c", &code]).output().is_ok_and(|output| output.status.success())
}

/// The folder of this program, where a link to it leads.
fn program_folder() -> Option<PathBuf> {
    let program = env::current_exe().ok()?;
    // On Windows this would give a path in a form that not every program takes.
    let program = if cfg!(windows) { program } else { fs::canonicalize(program).ok()? };
    program.parent().map(Path::to_path_buf)
}

/// The folders for packages of an environment whose programs lie in `programs`, the newest Python first.
fn packages(programs: &Path) -> Vec<PathBuf> {
    let Some(root) = programs.parent() else { return Vec::new() };
    let mut pythons: Vec<PathBuf> = ["lib", "lib64"]
        .iter()
        .filter_map(|lib| fs::read_dir(root.join(lib)).ok())
        .flat_map(|folder| folder.filter_map(Result::ok).map(|entry| entry.path()))
        .filter(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("python")))
        .collect();
    let version = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        name.rsplit('.').next().and_then(|minor| minor.parse::<u32>().ok())
    };
    pythons.sort_by_key(|path| std::cmp::Reverse(version(path)));
    // Those of Debian, and of Windows.
    let mut all: Vec<PathBuf> =
        pythons.iter().flat_map(|python| ["site-packages", "dist-packages"].map(|name| python.join(name))).collect();
    all.extend(["Lib/site-packages", "site-packages"].map(|name| root.join(name)));
    all
}
