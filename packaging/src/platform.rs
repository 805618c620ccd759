//! Platforms of the FMI standard: the folders for binaries, and what a binary is made for.

use object::{Architecture, BinaryFormat, Object, ObjectKind};

use crate::error::Error;
use crate::universal;

/// A platform of the FMI 2.0 standard.
#[derive(Debug, PartialEq, Eq)]
pub struct Platform {
    /// Folder below `binaries/`.
    pub folder: &'static str,
    /// Extension of its shared libraries.
    pub extension: &'static str,
    /// Operating system as Rust calls it.
    os: &'static str,
    /// What a target triple begins with.
    processors: &'static [&'static str],
    format: BinaryFormat,
    architectures: &'static [Architecture],
}

/// Every platform that the standard names, and what it names since 2.0.4 by the tuple of FMI 3.0: Linux on ARM. Hosts of FMI 2.0
/// look for macOS in `darwin64`, whatever the processor.
pub static PLATFORMS: &[Platform] = &[
    Platform {
        folder: "linux64",
        extension: "so",
        os: "linux",
        processors: &["x86_64"],
        format: BinaryFormat::Elf,
        // Hosts of FMI 2.0 on ARM look here, too, though the standard has another name for it.
        architectures: &[Architecture::X86_64, Architecture::Aarch64],
    },
    Platform {
        folder: "linux32",
        extension: "so",
        os: "linux",
        processors: &["i586", "i686"],
        format: BinaryFormat::Elf,
        architectures: &[Architecture::I386],
    },
    Platform {
        folder: "win64",
        extension: "dll",
        os: "windows",
        processors: &["x86_64"],
        format: BinaryFormat::Pe,
        architectures: &[Architecture::X86_64],
    },
    Platform {
        folder: "win32",
        extension: "dll",
        os: "windows",
        processors: &["i586", "i686"],
        format: BinaryFormat::Pe,
        architectures: &[Architecture::I386],
    },
    Platform {
        folder: "aarch64-linux",
        extension: "so",
        os: "linux",
        processors: &["aarch64"],
        format: BinaryFormat::Elf,
        architectures: &[Architecture::Aarch64],
    },
    Platform {
        folder: "darwin64",
        extension: "dylib",
        os: "darwin",
        processors: &["x86_64", "aarch64"],
        format: BinaryFormat::MachO,
        architectures: &[Architecture::X86_64, Architecture::Aarch64],
    },
];

impl Platform {
    /// The platform with this folder.
    pub fn named(folder: &str) -> Option<&'static Self> {
        PLATFORMS.iter().find(|platform| platform.folder == folder)
    }

    /// The platform this program runs on.
    pub fn host() -> Result<&'static Self, Error> {
        let os = if cfg!(target_os = "macos") { "darwin" } else { std::env::consts::OS };
        let processor = if cfg!(target_arch = "x86") { "i686" } else { std::env::consts::ARCH };
        find(os, processor)
            .ok_or_else(|| Error::Failure(format!("FMI 2.0 has no name for this platform, {os} on {processor}")))
    }

    /// The platform of a target triple of Rust, such as `x86_64-pc-windows-gnu`.
    pub fn of_target(triple: &str) -> Result<&'static Self, Error> {
        let mut parts = triple.split('-');
        let processor = parts.next().unwrap_or_default();
        parts.find_map(|os| find(os, processor)).ok_or_else(|| {
            Error::Usage(format!("--target {triple} is refused: FMI 2.0 has no name for it; allowed: {}", allowed()))
        })
    }

    /// Where an FMU has its shared library for this platform.
    pub fn binary_path(&self, identifier: &str) -> String {
        format!("binaries/{}/{identifier}.{}", self.folder, self.extension)
    }

    /// Whether `binary` is a shared library for this platform; else what it is instead.
    pub fn check(&self, binary: &[u8]) -> Result<(), String> {
        let wanted = format!("a shared library for {}", self.folder);
        let slices = universal::slices(binary).map_err(|error| format!("not {wanted}: {error}"))?;
        slices.into_iter().try_for_each(|slice| self.check_one(slice, &wanted))
    }

    fn check_one(&self, binary: &[u8], wanted: &str) -> Result<(), String> {
        let file = object::File::parse(binary).map_err(|error| format!("not {wanted}: {error}"))?;
        let (format, architecture, kind) = (file.format(), file.architecture(), file.kind());
        if format != self.format || !self.architectures.contains(&architecture) || kind != ObjectKind::Dynamic {
            let kind = if kind == ObjectKind::Dynamic { "shared library".to_owned() } else { format!("{kind:?} file") };
            return Err(format!("not {wanted}, but a {format:?} {kind} for {architecture:?}"));
        }
        Ok(())
    }
}

/// The folders, for messages.
pub fn folders() -> String {
    let folders: Vec<&str> = PLATFORMS.iter().map(|platform| platform.folder).collect();
    folders.join(", ")
}

fn find(os: &str, processor: &str) -> Option<&'static Platform> {
    PLATFORMS.iter().find(|platform| platform.os == os && platform.processors.contains(&processor))
}

fn allowed() -> String {
    let each = |platform: &Platform| {
        let of = |processor: &&str| format!("{processor}-*-{}", platform.os);
        platform.processors.iter().map(of).collect::<Vec<_>>()
    };
    PLATFORMS.iter().flat_map(each).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triples_have_the_folders_of_the_standard() {
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
        for triple in ["", "linux", "riscv64gc-unknown-linux-gnu", "wasm32-unknown-unknown"] {
            let error = Platform::of_target(triple).unwrap_err().to_string();
            assert!(error.contains("allowed: x86_64-*-linux, "), "{error}");
        }
    }

    #[test]
    fn what_is_no_shared_library_of_the_platform_is_refused() {
        let host = Platform::host().unwrap();
        let program = std::fs::read(std::env::current_exe().unwrap()).unwrap();
        for platform in PLATFORMS.iter().filter(|platform| platform.format != host.format) {
            let error = platform.check(&program).unwrap_err();
            assert!(error.contains(platform.folder), "{error}");
        }
        for text in [&b""[..], b"text", b"\x7fELF", b"MZ"] {
            assert!(host.check(text).unwrap_err().starts_with("not a shared library for "));
        }
    }
}
