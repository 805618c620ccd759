//! Where the FMUs are; the hosts are the tests.

use std::path::PathBuf;

/// The FMU of FMI 2.0 under test.
pub fn fmu() -> PathBuf {
    given("CRADLE_FMU", "NewtonsCradle.fmu")
}

/// The same as one of FMI 3.0.
pub fn fmu3() -> PathBuf {
    given("CRADLE_FMU3", "NewtonsCradle.fmi3.fmu")
}

fn given(variable: &str, name: &str) -> PathBuf {
    let default = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../target/fmu")).join(name);
    let path = std::env::var_os(variable).map_or(default, PathBuf::from);
    assert!(path.exists(), "there is no {}: see Cargo.toml", path.display());
    path
}
