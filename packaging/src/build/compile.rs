//! Compiling the FMU's binary with Cargo.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use newtons_cradle::files;

use crate::error::Error;
use crate::platform::Platform;

const PACKAGE: &str = "newtons-cradle";
/// Largest Cargo.toml that is read, bytes: the project's has some kB.
const MAX_MANIFEST: u64 = 1 << 20;

/// The folders of the sources and of Cargo's builds.
pub struct Workspace {
    /// Cargo's target folder.
    pub target: PathBuf,
    root: PathBuf,
}

impl Workspace {
    /// The workspace of the sources that contain the current folder.
    pub fn find() -> Option<Self> {
        let here = std::env::current_dir().ok()?;
        let is_ours = |folder: &&Path| {
            let manifest = files::read(&folder.join("Cargo.toml"), MAX_MANIFEST).unwrap_or_default();
            String::from_utf8_lossy(&manifest).lines().any(|line| line == format!("name = \"{PACKAGE}\""))
        };
        let root = here.ancestors().find(is_ours)?.to_owned();
        let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), |named| here.join(named));
        Some(Self { target, root })
    }

    /// Builds the shared library for this machine, or for each of the target triples. Returns the paths, in the same
    /// order. Cargo shows its progress on standard error. cargo-zigbuild links targets that end in a version of glibc,
    /// for systems from that version on.
    pub fn libraries(&self, targets: &[String], release: bool) -> Result<Vec<(&'static Platform, PathBuf)>, Error> {
        let here = [rustc("host-tuple")?];
        let all = if targets.is_empty() { &here } else { targets };
        let platforms = all.iter().map(|target| Platform::of_target(target)).collect::<Result<Vec<_>, _>>()?;
        let (zig, plain): (Vec<&str>, Vec<&str>) =
            all.iter().map(String::as_str).partition(|target| target.contains("-gnu."));
        self.cargo("build", &plain, release)?;
        self.cargo("zigbuild", &zig, release)?;
        let library = |(target, platform): (&String, &'static Platform)| {
            // In Cargo's folder, the target's name has no version of glibc.
            let triple = target.split('.').next().unwrap_or_default();
            let prefix = if triple.contains("windows") { "" } else { "lib" };
            let name = platform.library_name(&format!("{prefix}{}", PACKAGE.replace('-', "_")));
            (platform, self.target.join(triple).join(if release { "release" } else { "debug" }).join(name))
        };
        Ok(all.iter().zip(platforms).map(library).collect())
    }

    /// Runs `cargo build` or `cargo zigbuild` for these targets, if there are any.
    fn cargo(&self, build: &str, targets: &[&str], release: bool) -> Result<(), Error> {
        if targets.is_empty() {
            return Ok(());
        }
        let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        command.args([build, "--package", PACKAGE, "--lib"]).arg("--manifest-path").arg(self.root.join("Cargo.toml"));
        command.arg("--target-dir").arg(&self.target);
        // The target is always named, even for this machine: so the flags do not apply to build scripts, which then can
        // be shared with this program's build.
        command.args(targets.iter().flat_map(|target| ["--target", target]));
        command.args(release.then_some("--release"));
        command.env("CARGO_ENCODED_RUSTFLAGS", self.flags()?);
        if command.status().map_err(|error| Error::Failure(format!("cannot run cargo: {error}")))?.success() {
            return Ok(());
        }
        let advice = if build == "zigbuild" {
            "a target with a version of glibc needs `pip install ziglang cargo-zigbuild`"
        } else {
            "`rustup target add` installs what Rust needs for a target"
        };
        let of = targets.join(", ");
        Err(Error::Failure(format!("the FMU's binary does not compile for {of}, see above; {advice}")))
    }

    /// The user's compiler flags, and those that keep this machine's paths out of the binary.
    fn flags(&self) -> Result<OsString, Error> {
        let given = std::env::var("RUSTFLAGS").unwrap_or_default();
        let mut flags: Vec<OsString> = given.split_whitespace().map(OsString::from).collect();
        let mut remap = |from: &Path, to: &str| {
            flags.extend([OsString::from("--remap-path-prefix"), [from.as_os_str(), to.as_ref()].join("=".as_ref())]);
        };
        remap(&self.root, "@newtons-cradle");
        let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
        let home = home.or_else(|| Some(std::env::home_dir()?.join(".cargo")));
        let missing = || Error::Failure("there is neither CARGO_HOME nor a home folder".to_owned());
        remap(&home.ok_or_else(missing)?, "@cargo");
        // The sources of the standard library, for targets for which it is compiled.
        let library = Path::new(&rustc("sysroot")?).join("lib/rustlib/src/rust");
        remap(&library, "@rust");
        // Cargo uses relative paths within the workspace.
        if let Ok(inside) = library.strip_prefix(&self.root) {
            remap(inside, "@rust");
        }
        Ok(flags.join("\x1f".as_ref()))
    }
}

/// What `rustc --print` prints for `what`.
fn rustc(what: &str) -> Result<String, Error> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc)
        .args(["--print", what])
        .output()
        .map_err(|error| Error::Failure(format!("cannot run rustc: {error}; --from and --binary do without it")))?;
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
