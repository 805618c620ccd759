//! Platforms of the FMI standard: the folders for binaries, and what a binary is made for.

use object::{Architecture, BinaryFormat, Object, ObjectKind};

use crate::error::Error;
use crate::universal;

/// A platform of the FMI 2.0 standard, with its names in FMI 3.0.
#[derive(Debug, PartialEq, Eq)]
pub struct Platform {
    /// Folder below `binaries/`.
    pub folder: &'static str,
    /// Platform tuples of FMI 3.0, which are folders below `binaries/` there: one for each processor.
    pub tuples: &'static [&'static str],
    /// Extension of its shared libraries.
    pub extension: &'static str,
    /// Operating system as Rust calls it.
    os: &'static str,
    /// What a target triple begins with.
    processors: &'static [&'static str],
    format: BinaryFormat,
    architectures: &'static [Architecture],
}

/// Every platform that the standard names, and what it names since 2.0.4 by the tuple of FMI 3.0: Linux on ARM. Hosts
/// of FMI 2.0 look for macOS in `darwin64`, whatever the processor.
pub static PLATFORMS: &[Platform] = &[
    Platform {
        folder: "linux64",
        tuples: &["x86_64-linux"],
        extension: "so",
        os: "linux",
        processors: &["x86_64"],
        format: BinaryFormat::Elf,
        // Hosts of FMI 2.0 on ARM look here, too, though the standard has another name for it.
        architectures: &[Architecture::X86_64, Architecture::Aarch64],
    },
    Platform {
        folder: "linux32",
        tuples: &["x86-linux"],
        extension: "so",
        os: "linux",
        processors: &["i586", "i686"],
        format: BinaryFormat::Elf,
        architectures: &[Architecture::I386],
    },
    Platform {
        folder: "win64",
        tuples: &["x86_64-windows"],
        extension: "dll",
        os: "windows",
        processors: &["x86_64"],
        format: BinaryFormat::Pe,
        architectures: &[Architecture::X86_64],
    },
    Platform {
        folder: "win32",
        tuples: &["x86-windows"],
        extension: "dll",
        os: "windows",
        processors: &["i586", "i686"],
        format: BinaryFormat::Pe,
        architectures: &[Architecture::I386],
    },
    Platform {
        folder: "aarch64-linux",
        tuples: &["aarch64-linux"],
        extension: "so",
        os: "linux",
        processors: &["aarch64"],
        format: BinaryFormat::Elf,
        architectures: &[Architecture::Aarch64],
    },
    Platform {
        folder: "darwin64",
        tuples: &["x86_64-darwin", "aarch64-darwin"],
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

    /// Where an FMU of FMI 3.0 has its shared library for this platform and processor, such as `x86_64`.
    pub fn tuple_path(&self, identifier: &str, processor: &str) -> Option<String> {
        let tuple = self.tuples.iter().find(|tuple| tuple.split('-').next() == Some(processor))?;
        Some(format!("binaries/{tuple}/{identifier}.{}", self.extension))
    }

    /// The shared library that an FMU of FMI 3.0 has for the platform this program runs on.
    pub fn host_path(&self, identifier: &str) -> Option<String> {
        self.tuple_path(identifier, if cfg!(target_arch = "x86") { "x86" } else { std::env::consts::ARCH })
    }

    /// Where an FMU may have shared libraries for this platform.
    pub fn paths(&self, identifier: &str, fmi3: bool) -> Vec<String> {
        if !fmi3 {
            return vec![self.binary_path(identifier)];
        }
        self.tuples.iter().map(|tuple| format!("binaries/{tuple}/{identifier}.{}", self.extension)).collect()
    }

    /// The platform whose shared library is at this path, in FMUs of either version.
    pub fn of_path(path: &str, identifier: &str) -> Option<&'static Self> {
        let folders = |platform: &Self| platform.tuples.iter().copied().chain([platform.folder]).collect::<Vec<_>>();
        PLATFORMS.iter().find(|platform| {
            let at = |folder: &str| format!("binaries/{folder}/{identifier}.{}", platform.extension) == path;
            folders(platform).into_iter().any(at)
        })
    }

    /// The parts of a shared library by their place in an FMU of FMI 3.0: a universal one is for several processors.
    pub fn by_tuple(&self, identifier: &str, binary: &[u8]) -> Result<Vec<(String, Vec<u8>)>, String> {
        let slices = universal::slices(binary).map_err(|error| error.to_string())?;
        let place = |slice: &[u8]| {
            let file = object::File::parse(slice).map_err(|error| error.to_string())?;
            let processor = match file.architecture() {
                Architecture::Aarch64 => "aarch64",
                Architecture::I386 => "x86",
                _ => "x86_64",
            };
            // Hosts of FMI 2.0 may have Linux on ARM in `linux64`.
            let platform =
                if processor == "aarch64" && self.os == "linux" { Self::named("aarch64-linux") } else { Some(self) };
            let path = platform.and_then(|platform| platform.tuple_path(identifier, processor));
            Ok((path.ok_or_else(|| format!("FMI 3.0 has no name for {processor} here"))?, slice.to_vec()))
        };
        slices.into_iter().map(place).collect()
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
