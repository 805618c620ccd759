//! Recording the results of the FMU's own binary. It is loaded in a process of its own, this program again, so that a
//! binary may crash or hang. That process also has the files that the binary needs, so that they are removed if this
//! one is ended from the terminal or killed: all but the binary on Windows, where it is not removed while it is loaded.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use std::{env, fs, io, thread};

use newtons_cradle::files;
use newtons_cradle::variables::{Description, FILE_NAME, MODEL_IDENTIFIER, Number, Recipe, STEP_SIZE, STOP_TIME};

use super::cases::{START, cases, recorded, times};
use super::host;
use crate::archive::Entries;
use crate::check::MAX_BYTES;
use crate::platform::{Platform, host_tuple};

/// The name of the results of the default experiment, with the FMU's start values.
pub const EXPERIMENT: &str = "experiment";

/// Name of the binary in the folder of the run; only on Windows does the extension matter.
const BINARY: &str = "binary.dll";

/// What the line begins with by which the child says how it went; the rest is what went wrong.
const OUTCOME: &[u8] = b"cradle-fmu has ended the runs: ";

/// The most that is kept of a line, bytes: a binary may write without end. Much more than the outcome has.
const LONGEST_LINE: u64 = 1 << 16;

/// Of Windows: the interrupt of a terminal does not reach the process.
#[cfg(windows)]
const CREATE_NEW_PROCESS_GROUP: u32 = 0x200;

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
    let resources = entries.get(&format!("resources/{FILE_NAME}")).map_or(&[][..], Vec::as_slice);
    let mut child = child(&folder, names).map_err(|error| format!("cannot start this program again: {error}"))?;
    let mut input = child.stdin.take();
    for block in [resources, binary] {
        // If it fails, the child has ended, which shows below.
        let _ = input.as_mut().map(|input| write_block(input, block));
    }
    let outcome = child.stdout.take().and_then(|output| outcome(BufReader::new(output)));
    let read = |name: &&str| {
        let csv = files::read(&folder.join(name).with_extension("csv"), MAX_BYTES)?;
        String::from_utf8(csv).map_err(io::Error::other)
    };
    let results = match outcome.as_deref() {
        Some("") => names.iter().map(read).collect::<io::Result<_>>().map_err(|error| error.to_string()),
        Some(problem) => Err(problem.to_owned()),
        None => Ok(Vec::new()),
    };
    drop(input);
    let status = child.wait();
    // The child leaves its folder if it crashes, and on Windows the binary that it has loaded. Files in the system's
    // temporary folder do no harm.
    let _ = fs::remove_dir_all(&folder);
    let status = status.map_err(|error| error.to_string())?;
    if outcome.is_none() {
        return Err(format!("its binary crashed ({status})"));
    }
    results
}

/// Starts the child, which does not get the signals that end this program from a terminal.
fn child(folder: &Path, names: &[&str]) -> io::Result<Child> {
    let mut command = Command::new(env::current_exe()?);
    // Output of the binary itself is discarded, or left out where the outcome is read.
    command.arg("record").arg(folder).args(names).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    #[cfg(windows)]
    std::os::windows::process::CommandExt::creation_flags(&mut command, CREATE_NEW_PROCESS_GROUP);
    command.spawn()
}

/// What the child says in the end: nothing if all went well. None if it ends before.
fn outcome(mut output: impl BufRead) -> Option<String> {
    let mut line = Vec::new();
    loop {
        line.clear();
        let read = output.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut line);
        read.ok().filter(|length| *length > 0)?;
        if let Some(problem) = line.strip_prefix(OUTCOME) {
            return Some(String::from_utf8_lossy(problem).trim_end().to_owned());
        }
    }
}

/// The child: makes the folder, takes resources and binary from its standard input, and runs the binary for the cases
/// of these names, whose results it writes there as CSV. It removes the folder when its input ends, which happens when
/// its parent ends in any way.
pub fn run(folder: PathBuf, names: Vec<String>) -> ! {
    let mut input = io::stdin().lock();
    let made = fs::create_dir(&folder);
    let is_made = made.is_ok();
    let written = made.and_then(|()| {
        let resources = folder.join("resources");
        fs::create_dir(&resources)?;
        fs::write(resources.join(FILE_NAME), read_block(&mut input)?)?;
        fs::write(folder.join(BINARY), read_block(&mut input)?)
    });
    let place = folder.clone();
    thread::spawn(move || {
        let written = written.map_err(|error| format!("cannot write {}: {error}", place.display()));
        let problem = written.and_then(|()| results(place, names)).err().unwrap_or_default();
        // On a line of its own, whatever the binary has written.
        let said = [b"\n", OUTCOME, problem.replace('\n', " ").as_bytes(), b"\n"].concat();
        let _ = io::stdout().write_all(&said);
    });
    let _ = io::copy(&mut input, &mut io::sink());
    // Results may be written meanwhile.
    let _ = is_made && (0..10).any(|_| fs::remove_dir_all(&folder).is_ok());
    host::end();
}

/// Writes the results of the cases of these names.
fn results(folder: PathBuf, names: Vec<String>) -> Result<(), String> {
    let (sender, receiver) = mpsc::channel();
    let (place, all) = (folder.clone(), names.clone());
    thread::spawn(move || {
        all.iter().try_for_each(|name| sender.send(csv(&place, name).map_err(|problem| problem.to_string())))
    });
    for name in names {
        let csv = receiver.recv_timeout(PATIENCE).unwrap_or_else(|error| {
            let problem = match error {
                RecvTimeoutError::Timeout => "its run takes more than a minute",
                RecvTimeoutError::Disconnected => "an internal error of this program has ended its run",
            };
            Err(problem.to_owned())
        });
        let file = folder.join(&name).with_extension("csv");
        csv.and_then(|csv| fs::write(file, csv).map_err(|error| format!("cannot write: {error}")))
            .map_err(|problem| format!("{name}: {problem}"))?;
    }
    Ok(())
}

/// Writes bytes after their number.
fn write_block(output: &mut impl Write, bytes: &[u8]) -> io::Result<()> {
    output.write_all(&(bytes.len() as u64).to_le_bytes())?;
    output.write_all(bytes)
}

/// Reads what [`write_block`] has written.
fn read_block(input: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut length = [0; 8];
    input.read_exact(&mut length)?;
    let mut bytes = Vec::new();
    input.take(u64::from_le_bytes(length)).read_to_end(&mut bytes)?;
    Ok(bytes)
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
