//! Compiling the FMU's binary with Cargo.

use std::path::PathBuf;
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::Error;

const PACKAGE: &str = "newtons-cradle";

/// Where the sources are and where Cargo puts what it builds.
pub struct Workspace {
    /// Cargo's target folder.
    pub target: PathBuf,
    manifest: PathBuf,
}

impl Workspace {
    /// The workspace of the current folder.
    pub fn find() -> Result<Self, Error> {
        let output = cargo()
            .args(["metadata", "--format-version", "1", "--no-deps"])
            .stderr(Stdio::inherit())
            .output()
            .map_err(|error| format!("cannot run cargo: {error}"))?;
        if !output.status.success() {
            return Err("this must be run in the folder of the sources: cargo metadata failed".to_owned());
        }
        let metadata = json(&output.stdout)?;
        let path = |key: &str| metadata.get(key).and_then(Value::as_str).map(PathBuf::from);
        match (path("target_directory"), path("workspace_root")) {
            (Some(target), Some(root)) => Ok(Self { target, manifest: root.join("Cargo.toml") }),
            _ => Err("cargo metadata names no target_directory and workspace_root".to_owned()),
        }
    }
}

/// Builds the shared library and tells where it is. Cargo shows its progress on standard error.
pub fn library(workspace: &Workspace, release: bool) -> Result<PathBuf, Error> {
    let mut command = cargo();
    command.args(["build", "--package", PACKAGE, "--lib", "--message-format=json-render-diagnostics"]);
    command.arg("--manifest-path").arg(&workspace.manifest);
    if release {
        command.arg("--release");
    }
    let output =
        command.stderr(Stdio::inherit()).output().map_err(|error| format!("cannot run cargo build: {error}"))?;
    if !output.status.success() {
        return Err("the FMU's binary does not compile, see above".to_owned());
    }
    let mut artifact = None;
    for line in output.stdout.split(|byte| *byte == b'\n').filter(|line| !line.is_empty()) {
        artifact = shared_library(&json(line)?).or(artifact);
    }
    artifact.ok_or_else(|| format!("cargo built no shared library of {PACKAGE}"))
}

/// The shared library that a message of Cargo tells of, if it is ours.
fn shared_library(message: &Value) -> Option<PathBuf> {
    let text = |value: &Value, key: &str| value.get(key).and_then(Value::as_str).map(str::to_owned);
    let library = text(message.get("target")?, "name")?;
    if text(message, "reason")? != "compiler-artifact" || library != PACKAGE.replace('-', "_") {
        return None;
    }
    let mut files = message.get("filenames")?.as_array()?.iter().filter_map(Value::as_str).map(PathBuf::from);
    files.rfind(|file| file.extension().is_some_and(|extension| extension == std::env::consts::DLL_EXTENSION))
}

fn cargo() -> Command {
    Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

fn json(text: &[u8]) -> Result<Value, Error> {
    serde_json::from_slice(text).map_err(|error| format!("cargo answered what is no JSON: {error}"))
}
