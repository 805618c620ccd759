//! Recording the results of the FMU's own binary. It is loaded in a process of its own, this program again, so that a
//! binary may crash or hang.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio, abort};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use std::{env, fs, io, thread};

use newtons_cradle::variables::{Description, FILE_NAME, MODEL_IDENTIFIER, Number, Recipe, STEP_SIZE, STOP_TIME};

use super::cases::{START, cases, recorded, times};
use super::host;
use crate::archive::Entries;
use crate::error::Error;
use crate::platform::{Platform, host_tuple};

/// The name of the results of the default experiment, with the FMU's start values.
pub const EXPERIMENT: &str = "experiment";

/// Name of the binary in the folder of the run; only on Windows does the extension matter.
const BINARY: &str = "binary.dll";

/// How long a run may take.
const PATIENCE: Duration = Duration::from_secs(60);

/// The FMU's binary for this machine, or an error. An FMU of FMI 3.0 has the same one elsewhere.
pub fn own_binary(entries: &Entries) -> Result<&[u8], String> {
    let unknown = || format!("FMI 2.0 has no name for this platform, {}", host_tuple());
    let platform = Platform::host().ok_or_else(unknown)?;
    let folders = [platform.folder, &host_tuple()];
    let binary = folders.iter().find_map(|folder| entries.get(&platform.path(folder, MODEL_IDENTIFIER)));
    binary.map(Vec::as_slice).ok_or_else(|| format!("the FMU has no binary for this machine, {}", platform.folder))
}

/// The results of the FMU's binary for this machine as CSV, for these cases or for `EXPERIMENT`; otherwise why there
/// are none.
pub fn record(entries: &Entries, names: &[&str]) -> Result<Vec<String>, String> {
    let binary = own_binary(entries)?;
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos();
    let folder = env::temp_dir().join(format!("cradle-fmu-{}-{now}", std::process::id()));
    let place = format!("resources/{FILE_NAME}");
    let resources = entries.get(&place).map_or(&[][..], Vec::as_slice);
    let written = fs::create_dir(&folder)
        .and_then(|()| fs::create_dir(folder.join("resources")))
        .and_then(|()| fs::write(folder.join(BINARY), binary))
        .and_then(|()| fs::write(folder.join(&place), resources));
    let results = match written {
        Ok(()) => names.iter().map(|name| in_child(&folder, name)).collect(),
        Err(error) => Err(format!("cannot write {}: {error}", folder.display())),
    };
    // Files left in the system's temporary folder do no harm.
    let _ = fs::remove_dir_all(&folder);
    results
}

fn in_child(folder: &Path, name: &str) -> Result<String, String> {
    // Output of the binary itself is discarded.
    let started = env::current_exe().and_then(|program| {
        let mut child = Command::new(program);
        child.arg("record").arg(folder).arg(name).stdin(Stdio::null()).stdout(Stdio::null()).output()
    });
    let ended = started.map_err(|error| format!("cannot start this program again: {error}"))?;
    if ended.status.success() {
        return fs::read_to_string(folder.join(name).with_extension("csv")).map_err(|error| error.to_string());
    }
    let problems = String::from_utf8_lossy(&ended.stderr);
    let problem = problems.lines().find_map(|line| line.strip_prefix("error: "));
    Err(problem.map_or_else(|| format!("its binary crashed ({})", ended.status), str::to_owned))
}

/// The child: runs the binary in `folder` for the case of this name, and writes its results there as CSV.
pub fn run(folder: &Path, name: &str) -> Result<(), Error> {
    thread::spawn(|| {
        thread::sleep(PATIENCE);
        // The exit code says the same.
        let _ = io::stderr().write_all(b"error: its run takes more than a minute\n");
        abort();
    });
    let written = csv(folder, name).and_then(|csv| {
        fs::write(folder.join(name).with_extension("csv"), csv).map_err(|error| format!("cannot write: {error}").into())
    });
    written.map_err(|problem| Error::Failure(format!("{name}: {problem}")))
}

/// The results in the form of FMI's cross-check: quoted names, commas, numbers as in C.
fn csv(folder: &Path, name: &str) -> Result<String, Box<dyn std::error::Error>> {
    let resources = folder.join("resources");
    let start = Recipe::from_json(&fs::read(resources.join(FILE_NAME))?)?.settings()?;
    let (of, times) = if name == EXPERIMENT {
        let steps = (STOP_TIME / STEP_SIZE).round() as u32;
        (START, (0..=steps).map(|step| f64::from(step) * STOP_TIME / f64::from(steps)).collect())
    } else {
        (name, times(start.balls()))
    };
    let cases = cases(&start);
    let case = cases.iter().find(|case| case.name == of).ok_or("there is no such case")?;
    let (guid, variables) = (Description::of(&start).guid(), recorded(start.balls()));
    let results = host::run(&folder.join(BINARY), &resources, &guid, case, &times, &variables)?;
    let names = variables.iter().map(|variable| format!(",\"{variable}\""));
    let mut csv = format!("\"time\"{}\n", names.collect::<String>());
    for (time, values) in times.into_iter().zip(results) {
        let values = values.into_iter().map(|value| format!(",{}", Number(value)));
        csv += &format!("{}{}\n", Number(time), values.collect::<String>());
    }
    Ok(csv)
}
