//! What the tests of the program share.

use std::collections::BTreeSet;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use cradle_packaging::archive::Entries;
use cradle_packaging::build::{self, Binary};
use cradle_packaging::check::{MAX_BYTES, Report, unpack};
use cradle_packaging::platform::Platform;
use newtons_cradle::variables::Recipe;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// How a program ended and what it said.
pub struct Ended {
    pub code: i32,
    pub output: String,
    pub error: String,
}

/// Runs the program.
pub fn run(arguments: &[&str]) -> Ended {
    output(env!("CARGO_BIN_EXE_cradle-fmu"), arguments)
}

/// Runs the program in a folder.
pub fn run_in(folder: &str, arguments: &[&str]) -> Ended {
    ended(Command::new(env!("CARGO_BIN_EXE_cradle-fmu")).args(arguments).current_dir(folder))
}

/// Runs any program.
pub fn output(program: &str, arguments: &[&str]) -> Ended {
    ended(Command::new(program).args(arguments))
}

/// Runs the program with a variable of the environment.
pub fn with_environment(variable: &str, value: &str, arguments: &[&str]) -> Ended {
    ended(Command::new(env!("CARGO_BIN_EXE_cradle-fmu")).args(arguments).env(variable, value))
}

fn ended(command: &mut Command) -> Ended {
    let output = command.output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    Ended { code: output.status.code().unwrap(), output: text(output.stdout), error: text(output.stderr) }
}

/// A folder of its own, removed in the end.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new(name: &str) -> Self {
        let path = env::temp_dir().join(format!("cradle-fmu-test-{}", std::process::id())).join(name);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn file(&self, name: &str) -> String {
        self.0.join(name).to_str().unwrap().to_owned()
    }

    pub fn list(&self) -> BTreeSet<PathBuf> {
        fs::read_dir(&self.0).unwrap().map(|entry| entry.unwrap().path()).collect()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The FMU's library for this machine, which Cargo has built along with the tests.
pub fn library_path() -> PathBuf {
    let tests = env::current_exe().unwrap();
    let name = format!("{}newtons_cradle{}", env::consts::DLL_PREFIX, env::consts::DLL_SUFFIX);
    tests.parent().unwrap().join(name)
}

/// The same as an argument of `--binary`.
pub fn library() -> String {
    format!("{}={}", Platform::host().unwrap().folder, library_path().display())
}

/// The default FMU for this machine.
pub fn fmu() -> Vec<u8> {
    fmu_of(build::Standard::Fmi2)
}

/// The same of a version of the standard.
pub fn fmu_of(standard: build::Standard) -> Vec<u8> {
    let binary = Binary { platform: Platform::host().unwrap(), contents: fs::read(library_path()).unwrap() };
    zip(&build::entries(&Recipe::default(), vec![binary], standard).unwrap(), CompressionMethod::Stored)
}

/// Its entries.
pub fn entries(fmu: &[u8]) -> Entries {
    unpack(fmu, MAX_BYTES, &mut Report::default()).unwrap()
}

/// A zip file, of whatever names.
pub fn zip(entries: &Entries, method: CompressionMethod) -> Vec<u8> {
    let options = SimpleFileOptions::default().compression_method(method);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, contents) in entries {
        zip.start_file(name, options).unwrap();
        zip.write_all(contents).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// Writes a zip file; its path.
pub fn write(folder: &Folder, name: &str, entries: &Entries) -> String {
    let path = folder.file(name);
    fs::write(Path::new(&path), zip(entries, CompressionMethod::Stored)).unwrap();
    path
}
