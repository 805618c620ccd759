//! What a shared library shows without being loaded: exported functions, linked libraries, the glibc it needs, and paths of the
//! machine it was built on.

use std::collections::BTreeSet;

use object::read::elf::{ElfFile, FileHeader};
use object::{File, Object, ReadRef, elf};

use super::description::model::Kind;
use super::report::Report;

/// Functions of every FMI 2.0 binary, without the `fmi2` that all of them begin with.
const COMMON: &str = "GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance
    SetupExperiment EnterInitializationMode ExitInitializationMode Terminate Reset
    GetReal GetInteger GetBoolean GetString SetReal SetInteger SetBoolean SetString
    GetFMUstate SetFMUstate FreeFMUstate SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate
    GetDirectionalDerivative";

/// Functions for co-simulation.
const CO_SIMULATION: &str = "SetRealInputDerivatives GetRealOutputDerivatives DoStep CancelStep
    GetStatus GetRealStatus GetIntegerStatus GetBooleanStatus GetStringStatus";

/// Functions for model exchange.
const MODEL_EXCHANGE: &str = "EnterEventMode NewDiscreteStates EnterContinuousTimeMode CompletedIntegratorStep
    SetTime SetContinuousStates GetDerivatives GetEventIndicators GetContinuousStates GetNominalsOfContinuousStates";

/// What a path of somebody's machine begins with.
const PATHS: [&[u8]; 5] = [b"/home/", b"/root/", b"/Users/", b"/tmp/", b":\\Users\\"];

/// Libraries that every system of a kind has: of glibc, of Windows, of macOS.
const SYSTEM: &str = "ld-linux libc.so. libm.so. libdl.so. libpthread.so. librt.so.
    advapi32.dll api-ms-win- bcrypt kernel32.dll msvcrt.dll ntdll.dll ucrtbase.dll user32.dll userenv.dll ws2_32.dll
    /usr/lib/libsystem";

/// The glibc of systems that are still about (2012).
const OLD_GLIBC: (u32, u32) = (2, 17);

/// What a shared library shows.
#[derive(Debug, Default)]
pub struct Library {
    /// Names of the functions it exports.
    pub exports: BTreeSet<String>,
    /// Libraries it is linked with.
    pub libraries: BTreeSet<String>,
    /// The newest version of glibc that it needs something of, such as (2, 17).
    pub glibc: Option<(u32, u32)>,
    /// Paths of the machine it was built on.
    pub paths: BTreeSet<String>,
}

impl Library {
    /// Reads a shared library of any platform.
    pub fn read(bytes: &[u8]) -> Result<Self, String> {
        let mut library = Self { paths: paths(bytes), ..Self::default() };
        let file = File::parse(bytes).map_err(|error| error.to_string())?;
        let text = |name: &[u8]| String::from_utf8_lossy(name).into_owned();
        let exports = file.exports().map_err(|error| error.to_string())?;
        library.exports = exports.iter().map(|export| text(export.name())).collect();
        // Symbols of macOS begin with an underscore.
        if matches!(file, File::MachO32(_) | File::MachO64(_)) {
            library.exports = library.exports.iter().map(|name| name.trim_start_matches('_').to_owned()).collect();
        }
        match &file {
            File::Elf32(file) => library.elf(file),
            File::Elf64(file) => library.elf(file),
            _ => file.imports().map(|imports| {
                library.libraries = imports.iter().map(|import| text(import.library())).collect();
            }),
        }
        .map_err(|error| error.to_string())?;
        Ok(library)
    }

    fn elf<'data, Elf: FileHeader, R: ReadRef<'data>>(&mut self, file: &ElfFile<'data, Elf, R>) -> object::Result<()> {
        let table = file.elf_dynamic_table()?;
        for entry in table.iter().filter(|entry| entry.tag == elf::DT_NEEDED) {
            self.libraries.insert(String::from_utf8_lossy(table.string(entry)?).into_owned());
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

/// `GLIBC_2.17` to (2, 17).
fn glibc(version: &[u8]) -> Option<(u32, u32)> {
    let mut numbers = std::str::from_utf8(version).ok()?.strip_prefix("GLIBC_")?.split('.').map(str::parse);
    Some((numbers.next()?.ok()?, numbers.next()?.ok()?))
}

fn paths(bytes: &[u8]) -> BTreeSet<String> {
    let mut paths = BTreeSet::new();
    for begin in 0..bytes.len() {
        if PATHS.iter().any(|path| bytes[begin..].starts_with(path)) {
            let path = bytes[begin..].iter().take(80).take_while(|byte| byte.is_ascii_graphic());
            paths.insert(path.map(|byte| char::from(*byte)).collect());
        }
    }
    paths
}

/// Names of the functions of a binary that has those of its kind.
fn functions(of_kind: &str) -> impl Iterator<Item = String> {
    COMMON.split_whitespace().chain(of_kind.split_whitespace()).map(|name| format!("fmi2{name}"))
}

/// Checks a shared library of an FMU that is `own` or somebody else's.
pub(super) fn check(place: &str, bytes: &[u8], kind: Kind, own: bool, report: &mut Report) {
    let Some(library) = report.accept(place, Library::read(bytes)) else { return };
    let of_kind = if kind == Kind::CoSimulation { CO_SIMULATION } else { MODEL_EXCHANGE };
    for function in functions(of_kind) {
        let exported = library.exports.contains(&function);
        report.require(exported, format_args!("{place}: {function} is not exported"));
    }
    if own {
        let known: BTreeSet<String> = functions(CO_SIMULATION).collect();
        for name in library.exports.difference(&known) {
            report.remark(format_args!("{place}: exports {name}, which may clash with what others load"));
        }
    }
    let system = |name: &str| SYSTEM.split_whitespace().any(|known| name.to_lowercase().starts_with(known));
    for name in library.libraries.iter().filter(|name| !system(name)) {
        report.remark(format_args!("{place}: is linked with {name}, which not every system has"));
    }
    if let Some((major, minor)) = library.glibc.filter(|version| *version > OLD_GLIBC) {
        report.remark(format_args!("{place}: needs glibc {major}.{minor}, which older systems lack"));
    }
    for path in &library.paths {
        report.remark(format_args!("{place}: holds a path of the machine it was built on: {path}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_of_glibc_are_ordered_as_numbers() {
        assert_eq!(glibc(b"GLIBC_2.2.5"), Some((2, 2)));
        assert!(glibc(b"GLIBC_2.17") > glibc(b"GLIBC_2.4"));
        assert_eq!(glibc(b"GCC_3.0"), None);
    }

    #[test]
    fn paths_of_a_machine_are_found() {
        let found = paths(b"..\0/home/somebody/x.rs\0 /usr/lib C:\\Users\\me\\x");
        assert_eq!(found.into_iter().collect::<Vec<_>>(), ["/home/somebody/x.rs", ":\\Users\\me\\x"]);
    }
}
