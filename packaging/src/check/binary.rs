//! Inspection of a shared library without loading it: exported functions, linked libraries, the glibc or macOS it
//! needs, its signature, and paths of the build machine.

use std::collections::BTreeSet;

use object::read::elf::{ElfFile, FileHeader};
use object::read::macho::{LoadCommandVariant, MachOFile64};
use object::{Architecture, File, Object, ReadRef, elf, macho};

use super::report::{Report, one_line};
use crate::universal;

/// Functions of FMI 2.0, without the prefix `fmi2`.
const FMI2: &str =
    "GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment EnterInitializationMode
    ExitInitializationMode Terminate Reset GetReal GetInteger GetBoolean GetString SetReal SetInteger SetBoolean
    SetString GetFMUstate SetFMUstate FreeFMUstate SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate
    GetDirectionalDerivative SetRealInputDerivatives GetRealOutputDerivatives DoStep CancelStep GetStatus GetRealStatus
    GetIntegerStatus GetBooleanStatus GetStringStatus EnterEventMode NewDiscreteStates EnterContinuousTimeMode
    CompletedIntegratorStep SetTime SetContinuousStates GetDerivatives GetEventIndicators GetContinuousStates
    GetNominalsOfContinuousStates";

/// Functions of FMI 3.0, without the prefix `fmi3`, except getters and setters of types.
const FMI3: &str =
    "GetVersion SetDebugLogging InstantiateModelExchange InstantiateCoSimulation InstantiateScheduledExecution
    FreeInstance EnterInitializationMode ExitInitializationMode EnterEventMode Terminate Reset
    GetNumberOfVariableDependencies GetVariableDependencies GetFMUState SetFMUState FreeFMUState SerializedFMUStateSize
    SerializeFMUState DeserializeFMUState GetDirectionalDerivative GetAdjointDerivative EnterConfigurationMode
    ExitConfigurationMode GetIntervalDecimal GetIntervalFraction GetShiftDecimal GetShiftFraction SetIntervalDecimal
    SetIntervalFraction SetShiftDecimal SetShiftFraction EvaluateDiscreteStates UpdateDiscreteStates
    EnterContinuousTimeMode CompletedIntegratorStep SetTime SetContinuousStates GetContinuousStateDerivatives
    GetEventIndicators GetContinuousStates GetNominalsOfContinuousStates GetNumberOfEventIndicators
    GetNumberOfContinuousStates EnterStepMode GetOutputDerivatives DoStep ActivateModelPartition";
const TYPES_OF_FMI3: &str =
    "Float32 Float64 Int8 UInt8 Int16 UInt16 Int32 UInt32 Int64 UInt64 Boolean String Binary Clock";

/// Beginnings of paths on somebody's machine, wherever they are.
const PATHS: [&[u8]; 5] = [b"/home/", b"/root/", b"/Users/", b"/tmp/", b":\\Users\\"];

/// What absolute paths begin with of the sources of Rust's standard library and of what it uses: those of no machine.
const OF_RUST: [&[u8]; 2] = [b"/rustc/", b"/rust/deps/"];

/// What paths begin with that the producer has mapped, see `build`.
const MAPPED: [&[u8]; 3] = [b"@newtons-cradle/", b"@cargo/", b"@rust/"];

/// The extension of sources.
const RUST: &[u8] = b".rs";

/// Libraries that every system of a kind has: of glibc, of Windows, of macOS.
const SYSTEM: &str =
    "ld-linux libc.so. libm.so. libdl.so. libpthread.so. librt.so. advapi32.dll api-ms-win- bcrypt kernel32.dll
    msvcrt.dll ntdll.dll ucrtbase.dll user32.dll userenv.dll ws2_32.dll /usr/lib/libsystem";

/// The glibc of the oldest systems still in use (2012).
const OLD_GLIBC: (u32, u32) = (2, 17);

/// The first macOS for ARM, of 2020.
const OLD_MACOS: (u32, u32) = (11, 0);

/// The findings of an inspection.
#[derive(Debug)]
pub struct Library {
    /// The processor it is made for.
    pub architecture: Architecture,
    /// Names of the functions it exports.
    pub exports: BTreeSet<String>,
    /// Libraries it is linked with.
    pub libraries: BTreeSet<String>,
    /// The newest version of glibc that it needs, such as (2, 17).
    pub glibc: Option<(u32, u32)>,
    /// The oldest macOS that it supports, such as (11, 0).
    pub macos: Option<(u32, u32)>,
    /// Whether it has a signature, without which macOS loads nothing on ARM. It is not verified.
    pub signed: bool,
    /// Paths of the machine it was built on.
    pub paths: BTreeSet<String>,
}

impl Library {
    /// Reads a shared library of any platform. A universal binary of macOS holds several.
    pub fn read(bytes: &[u8]) -> object::Result<Vec<Self>> {
        universal::slices(bytes)?.into_iter().map(Self::read_one).collect()
    }

    fn read_one(bytes: &[u8]) -> object::Result<Self> {
        let file = File::parse(bytes)?;
        let exports = file.exports()?.iter().map(|export| text(export.name())).collect();
        let mut library = Self {
            architecture: file.architecture(),
            exports,
            libraries: BTreeSet::new(),
            glibc: None,
            macos: None,
            signed: false,
            paths: paths(bytes),
        };
        match &file {
            File::Elf32(file) => library.elf(file)?,
            File::Elf64(file) => library.elf(file)?,
            File::MachO64(file) => library.mach_o(file)?,
            _ => library.libraries = file.imports()?.iter().map(|import| text(import.library())).collect(),
        }
        if let Some(symbols) = file.pdb_info()? {
            library.place(symbols.path());
        }
        Ok(library)
    }

    /// Takes a name or a folder that a linker has written, if it is an absolute path.
    fn place(&mut self, path: &[u8]) {
        if path.starts_with(b"/") || begins_with_drive(path) {
            self.paths.insert(text(path));
        }
    }

    fn mach_o(&mut self, file: &MachOFile64) -> object::Result<()> {
        // Symbols of macOS begin with an underscore.
        let plain = |name: &String| name.strip_prefix('_').unwrap_or(name).to_owned();
        self.exports = self.exports.iter().map(plain).collect();
        let endian = file.endian();
        let mut commands = file.macho_load_commands()?;
        while let Some(command) = commands.next()? {
            match command.variant()? {
                LoadCommandVariant::Dylib(dylib) => {
                    self.libraries.insert(text(command.string(endian, dylib.dylib.name)?));
                }
                LoadCommandVariant::IdDylib(own) => self.place(command.string(endian, own.dylib.name)?),
                LoadCommandVariant::Rpath(folder) => self.place(command.string(endian, folder.path)?),
                LoadCommandVariant::BuildVersion(version) => self.macos = Some(macos(version.minos.get(endian))),
                LoadCommandVariant::VersionMin(version) => self.macos = Some(macos(version.version.get(endian))),
                LoadCommandVariant::LinkeditData(data) => {
                    self.signed |= data.cmd.get(endian) == macho::LC_CODE_SIGNATURE;
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn elf<'data, Elf: FileHeader, R: ReadRef<'data>>(&mut self, file: &ElfFile<'data, Elf, R>) -> object::Result<()> {
        let table = file.elf_dynamic_table()?;
        for entry in table.iter() {
            match entry.tag {
                elf::DT_NEEDED => _ = self.libraries.insert(text(table.string(entry)?)),
                elf::DT_SONAME | elf::DT_RPATH | elf::DT_RUNPATH => self.place(table.string(entry)?),
                _ => {}
            }
        }
        let (endian, sections) = (file.endian(), file.elf_section_table());
        let Some((mut needs, link)) = sections.gnu_verneed(endian, file.data())? else { return Ok(()) };
        let strings = sections.strings(endian, file.data(), link)?;
        while let Some((_, mut versions)) = needs.next()? {
            while let Some(version) = versions.next()? {
                self.glibc = self.glibc.max(glibc(version.name(endian, strings)?));
            }
        }
        Ok(())
    }
}

/// A name as it can be shown.
fn text(name: &[u8]) -> String {
    one_line(String::from_utf8_lossy(name))
}

/// 0x000b0000 to (11, 0): the lowest byte is a patch level.
fn macos(version: u32) -> (u32, u32) {
    (version >> 16, version >> 8 & 0xff)
}

/// `GLIBC_2.17` to (2, 17).
fn glibc(version: &[u8]) -> Option<(u32, u32)> {
    let mut numbers = std::str::from_utf8(version).ok()?.strip_prefix("GLIBC_")?.split('.').map(str::parse);
    Some((numbers.next()?.ok()?, numbers.next()?.ok()?))
}

/// Whether this is an absolute path of Windows.
fn begins_with_drive(path: &[u8]) -> bool {
    matches!(path, [drive, b':', b'/' | b'\\', next, ..] if drive.is_ascii_alphabetic() && next.is_ascii_alphanumeric())
}

/// The absolute path of a file of Rust's sources, with which these bytes end; they begin behind the source before. Rust
/// writes texts without a gap: one of Unix is recognized behind what cannot be part of a path, and behind another
/// source, as most are. In front of a mapped path there can be other texts with a slash. Spaces and bytes beyond ASCII
/// are in front of paths more often than within: a path that holds them is only found by what it begins with, `PATHS`.
fn source(bytes: &[u8]) -> Option<&[u8]> {
    let in_path = |byte: &u8| byte.is_ascii_alphanumeric() || b"/\\:._-+@~%".contains(byte);
    let length = bytes.iter().rev().take_while(|byte| in_path(byte)).count();
    let path = &bytes[bytes.len() - length..];
    if let Some(drive) = (0..path.len()).find(|at| begins_with_drive(&path[*at..])) {
        return Some(&path[drive..]);
    }
    let is_mapped = (0..path.len()).any(|at| MAPPED.iter().any(|mapped| path[at..].starts_with(mapped)));
    let is_of_rust = OF_RUST.iter().any(|rust| path.starts_with(rust));
    let is_absolute = path.starts_with(b"/") && path[1..].contains(&b'/') && !is_mapped && !is_of_rust;
    is_absolute.then_some(path)
}

fn paths(bytes: &[u8]) -> BTreeSet<String> {
    let (mut found, mut behind_source) = (BTreeSet::new(), 0);
    // A loop, which is fast enough without optimisation.
    for (begin, byte) in bytes.iter().enumerate() {
        if matches!(byte, b'/' | b':') && PATHS.iter().any(|path| bytes[begin..].starts_with(path)) {
            let path = bytes[begin..].iter().take(80).take_while(|byte| byte.is_ascii_graphic());
            found.insert(path.map(|byte| char::from(*byte)).collect());
        }
        if *byte == b'.' && bytes[begin..].starts_with(RUST) {
            let end = begin + RUST.len();
            found.extend(source(&bytes[behind_source..end]).map(text));
            behind_source = end;
        }
    }
    found
}

/// Names of all functions: the same binary serves both versions.
fn functions() -> impl Iterator<Item = String> {
    let accessors = TYPES_OF_FMI3.split_whitespace().flat_map(|of| [format!("fmi3Get{of}"), format!("fmi3Set{of}")]);
    let of_fmi3 = FMI3.split_whitespace().map(|name| format!("fmi3{name}")).chain(accessors);
    FMI2.split_whitespace().map(|name| format!("fmi2{name}")).chain(of_fmi3)
}

/// Checks a shared library, or each within a universal one.
pub(super) fn check(place: &str, bytes: &[u8], report: &mut Report) {
    let libraries = report.accept(place, Library::read(bytes)).unwrap_or_default();
    for library in &libraries {
        let of = if libraries.len() > 1 { format!(" for {:?}", library.architecture) } else { String::new() };
        check_one(&format!("{place}{of}"), library, report);
    }
}

fn check_one(place: &str, library: &Library, report: &mut Report) {
    let known: BTreeSet<String> = functions().collect();
    let missing: Vec<&str> = known.difference(&library.exports).map(String::as_str).collect();
    report.require(missing.is_empty(), format_args!("{place}: does not export {}", missing.join(", ")));
    let is_arm = library.architecture == Architecture::Aarch64;
    let unsigned = is_arm && library.macos.is_some() && !library.signed;
    report
        .require(!unsigned, format_args!("{place}: is not signed, and macOS on ARM loads nothing without a signature"));
    let mut remark = |text: String| report.remark(format_args!("{place}: {text}"));
    for name in library.exports.difference(&known) {
        remark(format!("exports {name}, which may clash with what others load"));
    }
    let system = |name: &str| SYSTEM.split_whitespace().any(|known| name.to_lowercase().starts_with(known));
    for name in library.libraries.iter().filter(|name| !system(name)) {
        remark(format!("is linked with {name}, which not every system has"));
    }
    for (system, needed, old) in [("glibc", library.glibc, OLD_GLIBC), ("macOS", library.macos, OLD_MACOS)] {
        if let Some((major, minor)) = needed.filter(|version| *version > old) {
            remark(format!("needs {system} {major}.{minor}, which older systems lack"));
        }
    }
    if is_arm && place.starts_with("binaries/linux64/") {
        remark("is for ARM, which the standard calls aarch64-linux, and most hosts linux64".to_owned());
    }
    for path in &library.paths {
        remark(format!("holds a path of the machine it was built on: {path}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn check_reads_versions_and_paths_of_binaries() {
        assert_eq!(glibc(b"GLIBC_2.2.5"), Some((2, 2)));
        assert!(glibc(b"GLIBC_2.17") > glibc(b"GLIBC_2.4"));
        assert_eq!(glibc(b"GCC_3.0"), None);
        assert_eq!((macos(0x000b_0000), macos(0x000a_0d06)), ((11, 0), (10, 13)));
        for (bytes, expected) in [
            ("..\0/home/somebody/x\0 /usr/lib C:\\Users\\me\\x", &["/home/somebody/x", ":\\Users\\me\\x"][..]),
            ("failed/srv/build/src/a.rs/data/x/lib.rs", &["/data/x/lib.rs"]),
            (
                "(/opt/cargo/registry/src/index-1/nalgebra-0.34/src/base.rs",
                &["/opt/cargo/registry/src/index-1/nalgebra-0.34/src/base.rs"],
            ),
            ("failedD:\\a\\src\\x.rsE:/b/y.rs", &["D:\\a\\src\\x.rs", "E:/b/y.rs"]),
            ("/usr/lib/libm.so src/lib.rs/rustc/59807616/library/core/src/x.rs (/x.rs https://docs.rs/getrandom", &[]),
            ("~/~1~~0@rust/library/alloc/src/x.rs/?#@newtons-cradle/src/y.rs/@cargo/registry/z.rs", &[]),
            ("/build/.cargo/registry/src/x/y.rs", &["/build/.cargo/registry/src/x/y.rs"]),
            ("failed/rust/deps/gimli-0.32.3/src/x.rs/rust/deps/gimli-0.32.3/src/y.rs", &[]),
        ] {
            assert_eq!(paths(bytes.as_bytes()).into_iter().collect::<Vec<_>>(), expected);
        }
        // Each byte is looked at a few times, whatever there is.
        let many = format!("{}/srv/x.rs", ".rs".repeat(350_000));
        assert_eq!(paths(many.as_bytes()).into_iter().collect::<Vec<_>>(), ["/srv/x.rs"]);
    }
}
