//! Where the FMUs are, and runs by the crate `fmi-rs`; the hosts are the tests.

use std::path::PathBuf;

/// Relative, to tell times apart: contacts of a row may close within some 1e-14 s.
pub const CLOCK: f64 = 1e-15;

/// A run of an FMU in `$folder` by the crate's simulation loops of version 2 or 3, which have types of their own: in
/// model exchange with this solver, if there is one, else in co-simulation. Gives what it has recorded of the variables
/// `$names`, and how it ended. `$options`: event mode, and early return.
#[macro_export]
macro_rules! simulate {
    (2, $($given:tt)*) => { $crate::simulate!(@fmi2 {} $($given)*) };
    (3, $($given:tt)*) => {
        $crate::simulate!(@fmi3 {
            library_kind: fmi_rs::fmi3::LibraryKind::Native,
            enable_dae: false,
            visible: false,
            // The crate takes a callback for it and does not hand it on.
            intermediate_update: false,
        } $($given)*)
    };
    (@$version:ident { $($own:tt)* }
        $folder:expr, $names:expr, $input:expr, $solver:expr, $step:expr, $stop:expr, $start:expr, $options:expr) => {{
        use fmi_rs::sim::$version as sim;
        let (folder, [events, early]) = ($folder, $options);
        let description = folder.join("modelDescription.xml");
        let model = fmi_rs::model_description::$version::ModelDescription::from_path(&description).unwrap();
        let model = std::sync::Arc::new(model);
        let indices = $names.into_iter().map(|name| model.variable_index_by_name(name.as_ref()).unwrap()).collect();
        let trajectories = sim::Trajectories::new(model.clone(), indices);
        let recorder = std::sync::Arc::new(sim::recorder::Recorder::new(trajectories));
        let input: Option<&str> = $input;
        let input = input.map(|path| {
            let trajectories = sim::csv::read_csv(std::fs::File::open(path).unwrap(), model.clone()).unwrap();
            std::sync::Arc::new(sim::input::StaticInput::new(trajectories, $crate::CLOCK))
        });
        let settings = sim::SimulationSettings {
            unzipdir: folder.to_owned(),
            model_description: model,
            start_time: 0.0,
            stop_time: $stop,
            set_stop_time: true,
            output_interval: $step,
            tolerance: $crate::CLOCK,
            set_tolerance: false,
            start_values: $start,
            event_mode_used: events,
            early_return_allowed: early,
            input_file: None,
            logging_on: false,
            log_time_scale: false,
            log_fmi_calls: false,
            log_file: None,
            initial_fmu_state_file: None,
            final_fmu_state_file: None,
            $($own)*
        };
        let ended = match $solver {
            Some(solver) => sim::me::simulate(&settings, &solver, input, recorder.clone()),
            None => sim::cs::simulate(&settings, input, recorder.clone()),
        };
        (recorder, ended)
    }};
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
