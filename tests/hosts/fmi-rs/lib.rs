//! Where the FMUs are, and settings for the crate `fmi-rs`; the hosts are the tests.

use std::path::PathBuf;

/// Relative, to tell times apart: contacts of a row may close within some 1e-14 s.
pub const CLOCK: f64 = 1e-15;

/// The settings of the crate `fmi-rs` for its module `sim2` or `sim3`: these fields, and the others as all hosts here
/// have them. They are a type for each version.
#[macro_export]
macro_rules! settings {
    (sim2, $($field:ident: $value:expr),*) => { $crate::settings!(@sim2, $($field: $value),*) };
    (sim3, $($field:ident: $value:expr),*) => {
        $crate::settings!(
            @sim3, $($field: $value),*,
            library_kind: fmi_rs::fmi3::LibraryKind::Native,
            enable_dae: false,
            visible: false,
            // The crate takes a callback for it and does not hand it on.
            intermediate_update: false
        )
    };
    (@$sim:ident, $($field:ident: $value:expr),*) => {
        $sim::SimulationSettings {
            start_time: 0.0,
            logging_on: false,
            set_stop_time: true,
            log_time_scale: false,
            tolerance: $crate::CLOCK,
            set_tolerance: false,
            log_fmi_calls: false,
            input_file: None,
            log_file: None,
            initial_fmu_state_file: None,
            final_fmu_state_file: None,
            $($field: $value),*
        }
    };
}

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
