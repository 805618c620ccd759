//! Recording what the FMU's own binary computes, in a child process.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use newtons_cradle::variables::{
    Description, FILE_NAME, MODEL_IDENTIFIER, Number, Recipe, STEP_SIZE, STOP_TIME, Settings, Variable,
};

use super::case::{Case, cases, recorded, times};
use super::child::{Folder, supervise};
use super::host::{Run, load};
use super::parameter_set::parameters;
use crate::archive::Entries;
use crate::error::Error;
use crate::platform::Platform;

/// The name of the results of the default experiment.
const EXPERIMENT: &str = "experiment";

/// What the binary is called in the folder that it is run in. Only Windows minds the extension.
const BINARY: &str = "binary.dll";

/// Results as CSV.
pub struct Results {
    /// One for each case, in their order.
    pub cases: Vec<String>,
    /// With the FMU's start values over its default experiment.
    pub experiment: Option<String>,
}

/// The FMU's binary for this machine, if it has one; else what it lacks.
pub fn own_binary(entries: &Entries) -> Result<&[u8], String> {
    let platform = Platform::host().map_err(|error| error.to_string())?;
    // In an FMU of FMI 3.0 it is elsewhere, but the same: both versions get the same numbers from it.
    let paths = [Some(platform.binary_path(MODEL_IDENTIFIER)), platform.host_path(MODEL_IDENTIFIER)];
    let binary = paths.iter().flatten().find_map(|path| entries.get(path));
    binary.map(Vec::as_slice).ok_or_else(|| format!("the FMU has no binary for this machine, {}", platform.folder))
}

/// What the FMU's binary for this machine computes for each case, and for the default experiment if asked for; else why
/// not.
pub fn record(entries: &Entries, cases: &[Case], experiment: bool) -> Result<Results, String> {
    let folder = Folder::new()?;
    folder.write(BINARY, own_binary(entries)?)?;
    for (name, contents) in entries.iter().filter(|(name, _)| name.starts_with("resources/")) {
        folder.write(name, contents)?;
    }
    let mut arguments = vec![Path::new("record"), &folder.0];
    if experiment {
        arguments.push(Path::new("--experiment"));
    }
    let status = supervise(&arguments)?;
    let read = |name: &str| fs::read_to_string(folder.0.join(name));
    match status {
        None => return Err("its runs take more than a minute".to_owned()),
        Some(status) if !status.success() => {
            return Err(read("problem").unwrap_or_else(|_| format!("its binary crashed ({status})")));
        }
        Some(_) => {}
    }
    let read = |name: &str| read(&format!("{name}.csv")).map_err(|error| error.to_string());
    Ok(Results {
        cases: cases.iter().map(|case| read(case.name)).collect::<Result<_, _>>()?,
        experiment: experiment.then(|| read(EXPERIMENT)).transpose()?,
    })
}

/// The child: runs the binary of the FMU unpacked in `folder` and leaves its results, or the file `problem`, there.
pub fn run(folder: &Path, experiment: bool) -> Result<(), Error> {
    run_all(folder, experiment).map_err(|problem| {
        // Without the file the parent knows from the exit code that something is wrong.
        let _ = fs::write(folder.join("problem"), &problem);
        Error::Failure(problem)
    })
}

fn run_all(folder: &Path, experiment: bool) -> Result<(), String> {
    let text = |error: &dyn std::fmt::Display| error.to_string();
    let resources = folder.join("resources");
    let recipe = fs::read(resources.join(FILE_NAME)).map_err(|error| text(&error))?;
    let recipe = Recipe::from_json(&recipe).map_err(|error| text(&error))?;
    let own = recipe.settings().map_err(|error| text(&error))?;
    let library = load(&folder.join(BINARY))?;
    let guid = Description::of(&own).guid();
    let write = |name: &str, wanted: &Settings, times: &[f64]| {
        let run = Run::start(&library, &resources, &guid, &parameters(wanted, &own), wanted);
        let csv = run.and_then(|run| csv(run, &recorded(recipe.balls), times));
        let csv = csv.map_err(|problem| format!("{name}: {problem}"))?;
        fs::write(folder.join(format!("{name}.csv")), csv).map_err(|error| error.to_string())
    };
    for case in cases(&recipe).map_err(|error| text(&error))? {
        write(case.name, &case.settings, &times(recipe.balls))?;
    }
    if experiment {
        let steps = (STOP_TIME / STEP_SIZE).round() as u32;
        let times: Vec<f64> = (0..=steps).map(|step| f64::from(step) * STOP_TIME / f64::from(steps)).collect();
        write(EXPERIMENT, &own, &times)?;
    }
    Ok(())
}

/// The results in the form that FMI's cross-check asks for: quoted names, commas, numbers as in C.
fn csv(mut run: Run, variables: &[Variable], times: &[f64]) -> Result<String, String> {
    let mut csv = String::from("\"time\"");
    for variable in variables {
        // Writing to a string cannot fail, here and below.
        let _ = write!(csv, ",\"{variable}\"");
    }
    csv.push('\n');
    for time in times {
        run.step_to(*time)?;
        let _ = write!(csv, "{}", Number(*time));
        for value in run.get(variables)? {
            let _ = write!(csv, ",{}", Number(value));
        }
        csv.push('\n');
    }
    Ok(csv)
}
