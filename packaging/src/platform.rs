//! Folders of the standard for binaries.

use crate::Error;

/// A platform of the FMI standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Platform {
    /// Folder below `binaries/`.
    pub folder: &'static str,
    /// Extension of its shared libraries.
    pub extension: &'static str,
}

const PLATFORMS: [(&str, &str, Platform); 5] = [
    ("linux", "64", Platform { folder: "linux64", extension: "so" }),
    ("linux", "32", Platform { folder: "linux32", extension: "so" }),
    ("windows", "64", Platform { folder: "win64", extension: "dll" }),
    ("windows", "32", Platform { folder: "win32", extension: "dll" }),
    ("macos", "64", Platform { folder: "darwin64", extension: "dylib" }),
];

/// The platform this program was compiled for.
pub fn host() -> Result<Platform, Error> {
    let (os, bits) = (std::env::consts::OS, if cfg!(target_pointer_width = "64") { "64" } else { "32" });
    PLATFORMS
        .into_iter()
        .find_map(|(known_os, known_bits, platform)| (known_os == os && known_bits == bits).then_some(platform))
        .ok_or_else(|| format!("FMI 2.0 has no name for this platform, {os} with {bits} bits"))
}
