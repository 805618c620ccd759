//! What the tests of the program share.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::Command;
use std::sync::LazyLock;
use std::{env, fs};

use cradle_packaging::archive::{self, Entries};
use cradle_packaging::build;
use cradle_packaging::check::{MAX_BYTES, bytes};
use cradle_packaging::platform::Platform;
use newtons_cradle::variables::{DEFAULT_BALLS, Description, Recipe, Settings};

pub const PROGRAM: &str = env!("CARGO_BIN_EXE_cradle-fmu");

/// Names the FMU's library for this machine, in what [`Folder::run`] takes.
pub const BINARY: &str = "--binary HOST=LIBRARY";

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

impl Ended {
    /// Asserts that it ended with this code and said all of this; refusals, with the code 2, are errors.
    #[track_caller]
    pub fn with(self, code: i32, parts: &[&str]) -> Self {
        let said = if code == 2 { self.error.clone() } else { format!("{}{}", self.output, self.error) };
        assert!(self.code == code && parts.iter().all(|part| said.contains(part)), "{code}, {parts:?}: {self:?}");
        self
    }

    /// Asserts that it succeeded without a warning.
    #[track_caller]
    pub fn quiet(self) -> Self {
        assert_eq!((self.code, self.error.as_str()), (0, ""));
        self
    }
}

/// A folder of its own, removed in the end.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new(name: &str) -> Self {
        let path = env::temp_dir().join(format!("cradle-fmu-test-{}", std::process::id())).join(name);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    /// A command to run a program in the folder with these words.
    pub fn command(&self, program: &str, words: &str) -> Command {
        let (host, library) = (Platform::host().unwrap().folder, library_path());
        let library = library.to_str().unwrap();
        let word = |word: &str| word.replace("HOST", host).replace("LIBRARY", library).replace("PROGRAM", PROGRAM);
        let mut command = Command::new(program);
        command.args(words.split_whitespace().map(word)).current_dir(&self.0);
        command
    }

    /// Runs cradle-fmu in the folder with these words.
    pub fn run(&self, words: &str) -> Ended {
        ended(&mut self.command(PROGRAM, words))
    }

    /// Writes an FMU without a warning, with the library for this machine unless the words name another source: its
    /// entries.
    #[track_caller]
    pub fn build(&self, name: &str, words: &str) -> Entries {
        let source = if words.contains("--from") { "" } else { BINARY };
        self.run(&format!("build --out {name} {source} {words}")).quiet();
        self.entries(name)
    }

    /// The entries of an FMU.
    pub fn entries(&self, name: &str) -> Entries {
        bytes(&self.read(name), MAX_BYTES).1.unwrap()
    }

    /// What `info` says of an FMU in which `check` finds no problem.
    #[track_caller]
    pub fn sound(&self, name: &str) -> Ended {
        let checked = self.run(&format!("check {name}")).with(0, &[]);
        assert!(!checked.output.contains("which may clash"), "{}", checked.output);
        self.run(&format!("info {name}")).with(0, &[])
    }

    pub fn file(&self, name: &str) -> String {
        self.0.join(name).to_str().unwrap().to_owned()
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.0.join(name)).unwrap()
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

    /// Compiles the shared library `x.so`, with more options for the compiler.
    #[cfg(target_os = "linux")]
    pub fn compile(&self, source: &str, options: &str) -> Vec<u8> {
        self.write("x.c", source);
        ended(&mut self.command("cc", &format!("-shared -fPIC -o x.so x.c {options}"))).with(0, &[]);
        self.read("x.so")
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

/// The start values of the default FMU.
pub static START: LazyLock<Settings> = LazyLock::new(|| Settings::default_for(DEFAULT_BALLS));

/// The default FMU for this machine, with this description.
pub fn fmu(description: &Description) -> Entries {
    let binary = (Platform::host().unwrap(), fs::read(library_path()).unwrap());
    build::entries(&Recipe::default(), description, vec![binary]).unwrap()
}

/// The zip file of an FMU.
pub fn zip(entries: &Entries) -> Vec<u8> {
    archive::bytes(entries.clone()).unwrap()
}

/// The text of an entry.
pub fn text(entries: &Entries, name: &str) -> String {
    String::from_utf8(entries[name].clone()).unwrap()
}
