//! What the tests of the program share.

use std::collections::BTreeSet;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;
use std::{env, fs};

use cradle_packaging::archive::Entries;
use cradle_packaging::build::{self, Binary};
use cradle_packaging::check::{MAX_BYTES, bytes};
use cradle_packaging::platform::Platform;
use newtons_cradle::variables::{DEFAULT_BALLS, Description, Recipe, Settings};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

pub const PROGRAM: &str = env!("CARGO_BIN_EXE_cradle-fmu");

/// How a program ended and what it said.
#[derive(Debug)]
pub struct Ended {
    pub code: i32,
    pub output: String,
    pub error: String,
}

/// Runs a command to its end.
pub fn ended(command: &mut Command) -> Ended {
    let output = command.output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    Ended { code: output.status.code().unwrap(), output: text(output.stdout), error: text(output.stderr) }
}

/// Runs the program.
pub fn run(arguments: &[&str]) -> Ended {
    ended(Command::new(PROGRAM).args(arguments))
}

/// Runs the program in a folder.
pub fn run_in(folder: &Folder, arguments: &[&str]) -> Ended {
    ended(Command::new(PROGRAM).args(arguments).current_dir(&folder.0))
}

/// Writes an FMU with the library for this machine, unless the arguments name another source: the warnings.
pub fn warnings(folder: &Folder, name: &str, arguments: &[&str]) -> String {
    let (out, library) = (folder.file(name), library());
    let has_source = arguments.iter().any(|argument| ["--from", "--binary"].contains(argument));
    let ours = if has_source { vec![] } else { vec!["--binary", &library] };
    let built = run(&[&["build", "--out", &out], &ours[..], arguments].concat());
    assert_eq!(built.code, 0, "{arguments:?}: {}", built.error);
    built.error
}

/// The same without a warning: the path.
pub fn build(folder: &Folder, name: &str, arguments: &[&str]) -> String {
    assert_eq!(warnings(folder, name, arguments), "", "{arguments:?}");
    folder.file(name)
}

/// What `check` and `info` say of a sound FMU.
pub fn sound(fmu: &str) -> String {
    let checked = run(&["check", fmu]);
    assert!(checked.code == 0 && !checked.output.contains("which may clash"), "{}", checked.output);
    let info = run(&["info", fmu]);
    assert_eq!(info.code, 0, "{}", info.error);
    info.output
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

    /// Writes a file, in folders that are made; its path.
    pub fn write(&self, name: &str, contents: impl AsRef<[u8]>) -> String {
        let path = self.0.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, contents).unwrap();
        self.file(name)
    }

    /// Writes a program of a Unix shell; its path.
    #[cfg(unix)]
    pub fn script(&self, name: &str, text: &str) -> String {
        use std::os::unix::fs::PermissionsExt;

        let path = self.write(name, format!("#!/bin/sh\n{text}\n"));
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
        path
    }

    /// Compiles a shared library, with more options for the compiler; its path.
    #[cfg(target_os = "linux")]
    pub fn compile(&self, source: &str, options: &[&str]) -> String {
        let (source, library) = (self.write("x.c", source), self.file("x.so"));
        let compiled = ended(Command::new("cc").args(["-shared", "-fPIC", "-o", &library, &source]).args(options));
        assert_eq!(compiled.code, 0, "{}", compiled.error);
        library
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
    let name = format!("{}newtons_cradle{}", env::consts::DLL_PREFIX, env::consts::DLL_SUFFIX);
    env::current_exe().unwrap().with_file_name(name)
}

/// The same as an argument of `--binary`.
pub fn library() -> String {
    format!("{}={}", Platform::host().unwrap().folder, library_path().display())
}

/// The start values of the default FMU.
pub static START: LazyLock<Settings> = LazyLock::new(|| Settings::default_for(DEFAULT_BALLS));

/// The default FMU for this machine, with this description.
pub fn fmu(description: &Description) -> Vec<u8> {
    let binary = Binary { platform: Platform::host().unwrap(), contents: fs::read(library_path()).unwrap() };
    zip(&build::entries(&Recipe::default(), description, vec![binary]).unwrap(), CompressionMethod::Stored)
}

/// The entries of an FMU.
pub fn entries(fmu: &[u8]) -> Entries {
    bytes(fmu, MAX_BYTES).1.unwrap()
}

/// Those of a file.
pub fn entries_of(path: impl AsRef<Path>) -> Entries {
    entries(&fs::read(path).unwrap())
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

/// The text of an entry.
pub fn text(entries: &Entries, name: &str) -> String {
    String::from_utf8(entries[name].clone()).unwrap()
}
