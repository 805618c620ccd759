//! Recording the results of the FMU's own binary. A child process, this program again, loads it, so that a binary may
//! crash or hang. The child also owns the files that the binary needs, and removes them even if the parent is ended
//! from the terminal or killed; on Windows all but the binary, which cannot be removed while it is loaded.

use std::fmt::{Display, Formatter};
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

/// The name of the run with the FMU's start values over the default experiment.
pub const EXPERIMENT: &str = "experiment";

/// Name of the binary in the folder of the run; the extension matters on Windows only.
const BINARY: &str = "binary.dll";

/// Begin of the line with which the child reports its outcome; what went wrong follows.
const OUTCOME: &[u8] = b"cradle-fmu has ended the runs: ";

/// Begin of the outcome if this machine cannot run the binary.
const MACHINE: &str = "machine";

/// Extensions of the files with the results of a case, and with the reason why there are none.
const RESULTS: &str = "csv";
const REASON: &str = "txt";

/// The longest part of a line that is kept, bytes: much more than the outcome has. A binary may write without end.
const LONGEST_LINE: u64 = 1 << 16;

/// A flag of Windows: a terminal's interrupt does not reach the process.
#[cfg(windows)]
const CREATE_NEW_PROCESS_GROUP: u32 = 0x200;

/// The longest time that a run may take.
const PATIENCE: Duration = Duration::from_secs(60);

/// Why there are no results of an FMU's binary.
#[derive(Debug)]
pub enum Failure {
    /// This machine cannot run the binary, which says nothing about the FMU.
    Machine(String),
    /// The binary is at fault.
    Binary(String),
}

impl Display for Failure {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Machine(reason) => write!(f, "this machine cannot run the FMU: {reason}"),
            Self::Binary(reason) => f.write_str(reason),
        }
    }
}

/// The FMU's binary for this machine, in the folder of either version of FMI.
fn own_binary(entries: &Entries) -> Result<&[u8], Failure> {
    let unknown = || Failure::Machine(format!("FMI 2.0 has no name for its platform, {}", host_tuple()));
    let platform = Platform::host().ok_or_else(unknown)?;
    let folders = [platform.folder, &host_tuple()];
    let binary = folders.iter().find_map(|folder| entries.get(&platform.path(folder, MODEL_IDENTIFIER)));
    let missing = || Failure::Machine(format!("there is no binary for {} in it", platform.folder));
    binary.map(Vec::as_slice).ok_or_else(missing)
}

/// Runs the FMU's binary for this machine. For each of these cases (or `EXPERIMENT`) returns its results as CSV, or why
/// there are none; an error if there are none at all.
pub fn record(entries: &Entries, names: &[&str]) -> Result<Vec<Result<String, String>>, Failure> {
    let binary = own_binary(entries)?;
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos();
    let folder = env::temp_dir().join(format!("cradle-fmu-{}-{now}", std::process::id()));
    let resources = entries.get(&format!("resources/{FILE_NAME}")).map_or(&[][..], Vec::as_slice);
    let cannot_start = |error| Failure::Machine(format!("cannot start this program again: {error}"));
    let mut child = child(&folder, names).map_err(cannot_start)?;
    let mut input = child.stdin.take();
    for block in [resources, binary] {
        // An error means that the child has ended, which shows below.
        let _ = input.as_mut().map(|input| write_block(input, block));
    }
    let outcome = child.stdout.take().and_then(|output| outcome(BufReader::new(output)));
    let read = |name: &&str| {
        let text = |extension| files::read(&folder.join(name).with_extension(extension), MAX_BYTES);
        let failed = |error: io::Error| Failure::Machine(error.to_string());
        let csv = text(RESULTS).map(|csv| Ok(String::from_utf8_lossy(&csv).into_owned()));
        csv.or_else(|_| text(REASON).map(|why| Err(String::from_utf8_lossy(&why).into_owned()))).map_err(failed)
    };
    let results = outcome.map(|outcome| match outcome.split_once(' ') {
        Some((MACHINE, reason)) => Err(Failure::Machine(reason.to_owned())),
        Some((_, reason)) => Err(Failure::Binary(reason.to_owned())),
        None => names.iter().map(read).collect(),
    });
    drop(input);
    let status = child.wait();
    // A child that crashes leaves its folder, and on Windows the loaded binary always stays. If this fails, files in
    // the system's temporary folder do no harm.
    let _ = fs::remove_dir_all(&folder);
    let status = status.map_err(|error| Failure::Machine(error.to_string()))?;
    results.unwrap_or_else(|| Err(Failure::Binary(format!("its binary crashed ({status})"))))
}

/// Starts the child. Signals by which a terminal ends this program do not reach it.
fn child(folder: &Path, names: &[&str]) -> io::Result<Child> {
    let mut command = Command::new(env::current_exe()?);
    // The binary's own output is discarded, or skipped where the outcome is read.
    command.arg("record").arg(folder).args(names).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    #[cfg(windows)]
    std::os::windows::process::CommandExt::creation_flags(&mut command, CREATE_NEW_PROCESS_GROUP);
    command.spawn()
}

/// The outcome that the child reports: empty on success, else what failed and why. None if the child ends before.
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

/// The child. It makes the folder, reads resources and binary from standard input, runs the binary for the cases of
/// these names, and writes their results to the folder as CSV. It removes the folder when its input ends, which it does
/// however its parent ends.
pub fn run(folder: PathBuf, names: Vec<String>) -> ! {
    let mut input = io::stdin().lock();
    let made = fs::create_dir(&folder);
    let is_made = made.is_ok();
    let written = made.and_then(|()| {
        let resources = folder.join("resources");
        fs::create_dir(&resources)?;
        fs::write(resources.join(FILE_NAME), read_block(&mut input)?)?;
        fs::write(folder.join(BINARY), read_block(&mut input)?)?;
        if host::may_execute(&folder) { Ok(()) } else { Err(io::Error::other("programs there are not run (noexec)")) }
    });
    let place = folder.clone();
    thread::spawn(move || {
        let failed = match written {
            Ok(()) => results(place, names).err(),
            Err(error) => Some(unusable(&place, &error)),
        };
        let problem = match failed {
            Some(Failure::Machine(reason)) => format!("{MACHINE} {reason}"),
            Some(Failure::Binary(reason)) => format!("binary {reason}"),
            None => String::new(),
        };
        // The outcome begins a line, whatever the binary has written before.
        let said = [b"\n", OUTCOME, problem.replace('\n', " ").as_bytes(), b"\n"].concat();
        let _ = io::stdout().write_all(&said);
    });
    let _ = io::copy(&mut input, &mut io::sink());
    // Tried again, because results may be written meanwhile.
    let _ = is_made && (0..10).any(|_| fs::remove_dir_all(&folder).is_ok());
    host::end();
}

/// The failure of a machine whose temporary folder cannot be used.
fn unusable(folder: &Path, error: &io::Error) -> Failure {
    let (folder, variable) = (folder.display(), if cfg!(windows) { "TMP" } else { "TMPDIR" });
    Failure::Machine(format!("cannot use {folder}: {error}; {variable} selects another temporary folder"))
}

/// Writes the results of these cases, or why a case has none.
fn results(folder: PathBuf, names: Vec<String>) -> Result<(), Failure> {
    let (sender, receiver) = mpsc::channel();
    let (place, all) = (folder.clone(), names.clone());
    thread::spawn(move || {
        all.iter().try_for_each(|name| sender.send(csv(&place, name).map_err(|problem| problem.to_string())))
    });
    for name in names {
        let result = receiver.recv_timeout(PATIENCE).map_err(|error| {
            let problem = match error {
                RecvTimeoutError::Timeout => "its run takes more than a minute",
                RecvTimeoutError::Disconnected => "an internal error of this program has ended its run",
            };
            Failure::Binary(format!("{name}: {problem}"))
        })?;
        let (extension, text) = match result {
            Ok(csv) => (RESULTS, csv),
            Err(reason) => (REASON, reason),
        };
        fs::write(folder.join(&name).with_extension(extension), text).map_err(|error| unusable(&folder, &error))?;
    }
    Ok(())
}

/// Writes the number of bytes, then the bytes.
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
