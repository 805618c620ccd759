//! Runs an FMU by the simulation loops of the crate `fmi-rs` and writes the result as it does:
//!
//!     run FMU OUT.csv INPUT.csv|- NAMES STEP STOP [exchange] [events] [early] [NAME=VALUE ...]
//!
//! NAMES are joined by `;`. Model exchange is by the crate's Euler method, with steps of STEP / 512.

use std::fs::read_to_string;
use std::path::Path;

use cradle_host_fmi_rs::simulate;
use fmi_rs::sim::solver::ForwardEulerFactory;
use fmi_rs::zip::extract_zip_archive;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [fmu, out, input, names, step, stop, options @ ..] = arguments.as_slice() else { panic!("see the source") };
    let folder = tempfile::TempDir::new().unwrap();
    extract_zip_archive(Path::new(fmu), &folder).unwrap();
    let (step, stop): (f64, f64) = (step.parse().unwrap(), stop.parse().unwrap());
    let given = |name: &str| options.iter().any(|option| option == name);
    let solver = || given("exchange").then_some(ForwardEulerFactory { fixed_step_size: step / 512.0 });
    let start = options.iter().filter_map(|option| option.split_once('='));
    let start: Vec<_> = start.map(|(name, value)| (name.to_owned(), value.to_owned())).collect();
    macro_rules! written {
        ($version:tt, $sim:ident) => {{
            let input = (input != "-").then_some(input.as_str());
            let modes = [given("events"), given("early")];
            let (recorder, ended) =
                simulate!($version, folder.path(), names.split(';'), input, solver(), step, stop, start, modes);
            fmi_rs::sim::$sim::csv::write_csv(&recorder.trajectories.borrow(), out).unwrap();
            ended.err().map(|problem| format!("{problem:?}"))
        }};
    }
    let is_3 = read_to_string(folder.path().join("modelDescription.xml")).unwrap().contains("fmiVersion=\"3.0\"");
    if let Some(problem) = if is_3 { written!(3, fmi3) } else { written!(2, fmi2) } {
        eprintln!("error: {problem}");
        std::process::exit(1);
    }
}
