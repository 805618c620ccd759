//! Compiling the FMU's binary with Cargo.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::error::Error;
use crate::platform::Platform;

const PACKAGE: &str = "newtons-cradle";

/// Where the sources are and where Cargo puts what it builds.
pub struct Workspace {
    /// Cargo's target folder.
    pub target: PathBuf,
    root: PathBuf,
}

impl Workspace {
    /// The workspace of the current folder.
    pub fn find() -> Result<Self, Error> {
        let output = cargo()
            .args(["metadata", "--format-version", "1", "--no-deps"])
            .stderr(Stdio::inherit())
            .output()
            .map_err(|error| Error::Failure(format!("cannot run cargo: {error}; with --binary it is not needed")))?;
        if !output.status.success() {
            let reason = "without --binary this must be run in the folder of the sources: cargo metadata failed";
            return Err(Error::Failure(reason.to_owned()));
        }
        let metadata = json(&output.stdout)?;
        let path = |key: &str| metadata.get(key).and_then(Value::as_str).map(PathBuf::from);
        match (path("target_directory"), path("workspace_root")) {
            (Some(target), Some(root)) => Ok(Self { target, root }),
            _ => Err(Error::Failure("cargo metadata names no target_directory and workspace_root".to_owned())),
        }
    }

    /// Builds the shared library for a target triple, or for this machine, and tells where it is. Cargo shows its progress on
    /// standard error. A triple that ends with a version of glibc is built by cargo-zigbuild, for systems from that version on.
    pub fn library(&self, target: Option<&str>, release: bool) -> Result<PathBuf, Error> {
        let platform = target.map_or_else(Platform::host, Platform::of_target)?;
        let old_glibc = target.is_some_and(|target| target.contains("-gnu."));
        let mut command = cargo();
        command.arg(if old_glibc { "zigbuild" } else { "build" });
        command.args(["--package", PACKAGE, "--lib", "--message-format=json-render-diagnostics"]);
        command.arg("--manifest-path").arg(self.root.join("Cargo.toml"));
        // Also named where it is this machine's: the flags are then not those of what runs while compiling, which can be shared
        // with what has compiled this program.
        command.arg("--target").arg(target.map_or_else(|| rustc("host-tuple"), |target| Ok(target.to_owned()))?);
        if release {
            command.arg("--release");
        }
        command.env("CARGO_ENCODED_RUSTFLAGS", self.flags(target)?);
        // `pip install cargo-zigbuild` may have put it, and the Python that knows where zig is, into the .venv of the sources.
        let programs = self.root.join(".venv/bin");
        if old_glibc && programs.join("cargo-zigbuild").is_file() {
            let path = std::env::var_os("PATH").unwrap_or_default();
            let all = std::iter::once(programs).chain(std::env::split_paths(&path));
            command.env("PATH", std::env::join_paths(all).unwrap_or(path));
        }
        let output = command
            .stderr(Stdio::inherit())
            .output()
            .map_err(|error| Error::Failure(format!("cannot run cargo: {error}")))?;
        if !output.status.success() {
            let advice = match target {
                Some(_) if old_glibc => "; a target with a version of glibc needs `pip install ziglang cargo-zigbuild`",
                Some(_) => "; `rustup target add` installs what Rust needs for a target",
                None => "",
            };
            let of = target.map(|target| format!(" for --target {target}")).unwrap_or_default();
            return Err(Error::Failure(format!("the FMU's binary does not compile{of}, see above{advice}")));
        }
        let mut artifact = None;
        for line in output.stdout.split(|byte| *byte == b'\n').filter(|line| line.starts_with(b"{")) {
            artifact = shared_library(&json(line)?, platform).or(artifact);
        }
        artifact.ok_or_else(|| Error::Failure(format!("cargo built no shared library of {PACKAGE}")))
    }

    /// The user's flags for the compiler, and those that keep this machine's paths and the time out of the binary.
    fn flags(&self, target: Option<&str>) -> Result<OsString, Error> {
        let mut flags: Vec<OsString> = Vec::new();
        if let Some(encoded) = std::env::var_os("CARGO_ENCODED_RUSTFLAGS") {
            flags.push(encoded);
        } else if let Ok(text) = std::env::var("RUSTFLAGS") {
            flags.extend(text.split_whitespace().map(OsString::from));
        }
        let mut remap = |from: &Path, to: &str| {
            flags.extend([OsString::from("--remap-path-prefix"), [from.as_os_str(), to.as_ref()].join("=".as_ref())]);
        };
        remap(&self.root, "newtons-cradle");
        remap(&cargo_home()?, "cargo");
        // Where the standard library's sources are, for targets for which it is compiled along.
        let library = Path::new(&rustc("sysroot")?).join("lib/rustlib/src/rust");
        remap(&library, "rust");
        // Cargo names what lies within the workspace from there.
        if let Ok(inside) = library.strip_prefix(&self.root) {
            remap(inside, "rust");
        }
        let windows = target.map_or(cfg!(windows), |target| target.contains("-windows-"));
        if windows {
            let gnu = target.map_or(cfg!(target_env = "gnu"), |target| target.ends_with("-gnu"));
            flags.push("-C".into());
            flags.push(if gnu { "link-arg=-Wl,--no-insert-timestamp" } else { "link-arg=/Brepro" }.into());
        }
        Ok(flags.join("\x1f".as_ref()))
    }
}

/// The shared library that a message of Cargo tells of, if it is ours.
fn shared_library(message: &Value, platform: &Platform) -> Option<PathBuf> {
    let text = |value: &Value, key: &str| value.get(key).and_then(Value::as_str).map(str::to_owned);
    let library = text(message.get("target")?, "name")?;
    if text(message, "reason")? != "compiler-artifact" || library != PACKAGE.replace('-', "_") {
        return None;
    }
    let mut files = message.get("filenames")?.as_array()?.iter().filter_map(Value::as_str).map(PathBuf::from);
    files.rfind(|file| file.extension().is_some_and(|extension| extension == platform.extension))
}

fn cargo() -> Command {
    Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

fn cargo_home() -> Result<PathBuf, Error> {
    let home = || std::env::home_dir().map(|home| home.join(".cargo"));
    std::env::var_os("CARGO_HOME")
        .map(PathBuf::from)
        .or_else(home)
        .ok_or_else(|| Error::Failure("there is neither CARGO_HOME nor a home folder".to_owned()))
}

/// What `rustc --print` says.
fn rustc(what: &str) -> Result<String, Error> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc)
        .args(["--print", what])
        .output()
        .map_err(|error| Error::Failure(format!("cannot run rustc: {error}")))?;
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn json(text: &[u8]) -> Result<Value, Error> {
    serde_json::from_slice(text).map_err(|error| Error::Failure(format!("cargo answered what is no JSON: {error}")))
}
