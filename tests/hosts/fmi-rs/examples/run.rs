//! Runs an FMU by the simulation loops of the crate `fmi-rs` and writes the result as it does:
//!
//!     run FMU OUT.csv INPUT.csv|- NAMES STEP STOP [exchange] [events] [early] [NAME=VALUE ...]
//!
//! NAMES are joined by `;`. Model exchange is by the crate's Euler method, with steps of STEP / 512.

use std::fs::{File, read_to_string};
use std::path::Path;
use std::sync::Arc;

use cradle_host_fmi_rs::{CLOCK, settings};
use fmi_rs::model_description::{fmi2, fmi3};
use fmi_rs::sim::solver::ForwardEulerFactory;
use fmi_rs::sim::{fmi2 as sim2, fmi3 as sim3};
use fmi_rs::zip::extract_zip_archive;

macro_rules! simulate {
    ($sim:ident, $description:ident, $folder:ident, $arguments:ident) => {{
        let [_, out, input, names, step, stop, options @ ..] = $arguments else { panic!("see the source") };
        let given = |name: &str| options.iter().any(|option| option == name);
        let (step, stop): (f64, f64) = (step.parse().unwrap(), stop.parse().unwrap());
        let path = $folder.join("modelDescription.xml");
        let model = Arc::new($description::ModelDescription::from_path(&path).unwrap());
        let indices = names.split(';').map(|name| model.variable_index_by_name(name).unwrap()).collect();
        let recorder = Arc::new($sim::recorder::Recorder::new($sim::Trajectories::new(model.clone(), indices)));
        let input = (input != "-").then(|| {
            let trajectories = $sim::csv::read_csv(File::open(input).unwrap(), model.clone()).unwrap();
            Arc::new($sim::input::StaticInput::new(trajectories, CLOCK))
        });
        let start = options.iter().filter_map(|option| option.split_once('='));
        let settings = settings!(
            $sim,
            unzipdir: $folder.to_owned(),
            model_description: model,
            stop_time: stop,
            output_interval: step,
            start_values: start.map(|(name, value)| (name.to_owned(), value.to_owned())).collect(),
            event_mode_used: given("events"),
            early_return_allowed: given("early")
        );
        let ended = if given("exchange") {
            let solver = ForwardEulerFactory { fixed_step_size: step / 512.0 };
            $sim::me::simulate(&settings, &solver, input, recorder.clone())
        } else {
            $sim::cs::simulate(&settings, input, recorder.clone())
        };
        $sim::csv::write_csv(&recorder.trajectories.borrow(), out).unwrap();
        if let Err(problem) = ended {
            eprintln!("error: {problem:?}");
            std::process::exit(1);
        }
    }};
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let unpacked = tempfile::TempDir::new().unwrap();
    extract_zip_archive(Path::new(&arguments[0]), &unpacked).unwrap();
    let (folder, arguments) = (unpacked.path(), arguments.as_slice());
    if read_to_string(folder.join("modelDescription.xml")).unwrap().contains("fmiVersion=\"3.0\"") {
        simulate!(sim3, fmi3, folder, arguments);
    } else {
        simulate!(sim2, fmi2, folder, arguments);
    }
}
