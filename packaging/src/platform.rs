//! Platforms of the FMI standard: folders for binaries, and the platform of a binary.

use object::BinaryFormat::{self, Elf, MachO, Pe};
use object::{Architecture, Object, ObjectKind};

use crate::archive::Entries;
use crate::error::Error;
use crate::universal;

/// A platform of the FMI 2.0 standard, with its names in FMI 3.0.
#[derive(Debug, PartialEq, Eq)]
pub struct Platform {
    /// Folder below `binaries/`.
    pub folder: &'static str,
    /// Platform tuples of FMI 3.0, which are folders below `binaries/` there: one for each processor.
    pub tuples: &'static [&'static str],
    /// Extension of its shared libraries, and the format they have.
    library: (&'static str, BinaryFormat),
}

/// Every platform that the standard names and, since 2.0.4 by its tuple of FMI 3.0, Linux on ARM. Hosts of FMI 2.0 look
/// for macOS in `darwin64`, for either processor.
pub static PLATFORMS: &[Platform] = &[
    Platform { folder: "linux64", tuples: &["x86_64-linux"], library: ("so", Elf) },
    Platform { folder: "linux32", tuples: &["x86-linux"], library: ("so", Elf) },
    Platform { folder: "win64", tuples: &["x86_64-windows"], library: ("dll", Pe) },
    Platform { folder: "win32", tuples: &["x86-windows"], library: ("dll", Pe) },
    Platform { folder: ARM_LINUX, tuples: &[ARM_LINUX], library: ("so", Elf) },
    Platform { folder: "darwin64", tuples: &["x86_64-darwin", "aarch64-darwin"], library: ("dylib", MachO) },
];

const ARM_LINUX: &str = "aarch64-linux";

impl Platform {
    /// The platform with this folder; the error lists all folders.
    pub fn named(folder: &str) -> Result<&'static Self, String> {
        PLATFORMS.iter().find(|platform| platform.folder == folder).ok_or_else(|| {
            let folders: Vec<&str> = PLATFORMS.iter().map(|platform| platform.folder).collect();
            format!("allowed platforms: {}", folders.join(", "))
        })
    }

    fn of_tuple(tuple: &str) -> Option<&'static Self> {
        PLATFORMS.iter().find(|platform| platform.tuples.contains(&tuple))
    }

    /// The platform this program runs on, if the standard has a name for it.
    pub fn host() -> Option<&'static Self> {
        Self::of_tuple(&host_tuple())
    }

    /// The platform of a target triple of Rust, such as `x86_64-pc-windows-gnu`.
    pub fn of_target(triple: &str) -> Result<&'static Self, Error> {
        let (processor, system) = triple.split_once('-').unwrap_or_default();
        let processor = if matches!(processor, "i586" | "i686") { "x86" } else { processor };
        let found = system.split('-').find_map(|os| Self::of_tuple(&format!("{processor}-{os}")));
        found.ok_or_else(|| {
            let allowed = targets();
            Error::Usage(format!("--target {triple} is refused: FMI 2.0 has no name for it; allowed: {allowed}"))
        })
    }

    fn os(&self) -> &'static str {
        self.tuples[0].split_once('-').unwrap_or_default().1
    }

    /// Name of a shared library; hosts use the model's identifier as `stem`.
    pub fn library_name(&self, stem: &str) -> String {
        format!("{stem}.{}", self.library.0)
    }

    /// Path in an FMU of the shared library in the platform's folder, or in the one with the name of a tuple.
    pub fn path(&self, folder: &str, identifier: &str) -> String {
        format!("binaries/{folder}/{}", self.library_name(identifier))
    }

    /// The parts of a shared library by their place in an FMU of FMI 3.0: a universal one is for several processors.
    pub fn by_tuple(&self, identifier: &str, binary: &[u8]) -> object::Result<Vec<(String, Vec<u8>)>> {
        let place = |slice: &[u8]| {
            let processor = processor(object::File::parse(slice)?.architecture());
            Ok((self.path(&format!("{processor}-{}", self.os()), identifier), slice.to_vec()))
        };
        universal::slices(binary)?.into_iter().map(place).collect()
    }

    /// Checks that `binary` is a shared library for this platform; otherwise says what it is.
    pub fn check(&self, binary: &[u8]) -> Result<(), String> {
        let wanted = format!("not a shared library for {}", self.folder);
        for slice in universal::slices(binary).map_err(|error| format!("{wanted}: {error}"))? {
            let file = object::File::parse(slice).map_err(|error| format!("{wanted}: {error}"))?;
            let (format, architecture, kind) = (file.format(), file.architecture(), file.kind());
            let tuple = format!("{}-{}", processor(architecture), self.os());
            // Hosts of FMI 2.0 on ARM look in `linux64`, too, against the standard.
            let fits = self.tuples.contains(&tuple.as_str()) || (self.folder == "linux64" && tuple == ARM_LINUX);
            if format != self.library.1 || !fits || kind != ObjectKind::Dynamic {
                let is_library = kind == ObjectKind::Dynamic;
                let kind = if is_library { "shared library".to_owned() } else { format!("{kind:?} file") };
                return Err(format!("{wanted}, but a {format:?} {kind} for {architecture:?}"));
            }
        }
        Ok(())
    }
}

/// The shared libraries in an FMU, each with its platform and its path.
pub fn libraries<'a>(entries: &'a Entries, identifier: &str, fmi3: bool) -> Vec<(&'static Platform, String, &'a [u8])> {
    let mut found = Vec::new();
    for platform in PLATFORMS {
        for folder in if fmi3 { platform.tuples } else { std::slice::from_ref(&platform.folder) } {
            let path = platform.path(folder, identifier);
            if let Some(library) = entries.get(&path) {
                found.push((platform, path, library.as_slice()));
            }
        }
    }
    found
}

/// The platforms as targets of Rust, for messages.
fn targets() -> String {
    let tuples = PLATFORMS.iter().flat_map(|platform| platform.tuples);
    tuples.map(|tuple| tuple.replace("x86-", "i686-").replace('-', "-*-")).collect::<Vec<_>>().join(", ")
}

/// The platform tuple of this machine.
pub fn host_tuple() -> String {
    let os = if cfg!(target_os = "macos") { "darwin" } else { std::env::consts::OS };
    format!("{}-{os}", std::env::consts::ARCH)
}

/// What the standard calls a processor.
fn processor(architecture: Architecture) -> &'static str {
    match architecture {
        Architecture::Aarch64 => "aarch64",
        Architecture::I386 => "x86",
        Architecture::X86_64 => "x86_64",
        _ => "other",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn platform_triples_have_the_folders_of_the_standard() {
        for (triple, folder) in [
            ("x86_64-unknown-linux-gnu", "linux64"),
            ("x86_64-unknown-linux-gnu.2.17", "linux64"),
            ("i686-unknown-linux-gnu", "linux32"),
            ("x86_64-pc-windows-msvc", "win64"),
            ("x86_64-win7-windows-gnu", "win64"),
            ("i686-pc-windows-gnu", "win32"),
            ("aarch64-unknown-linux-gnu.2.17", "aarch64-linux"),
            ("x86_64-apple-darwin", "darwin64"),
            ("aarch64-apple-darwin", "darwin64"),
        ] {
            assert_eq!(Platform::of_target(triple).unwrap().folder, folder, "{triple}");
        }
    }
}
