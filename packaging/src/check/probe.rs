//! What the binary for this machine answers. It is loaded in a child process, which is this program once more, so that one that
//! crashes or hangs takes nothing with it. The child leaves its findings in a file: a binary may print whatever it likes.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::ptr::{null, null_mut};
use std::sync::Mutex;
use std::time::{Duration, Instant};
use std::{env, thread};

use fmi_schema::fmi2::Causality;
use libloading::Library;
use newtons_cradle::variables::Type;

use super::description::model::{Interface, Kind, Model, Variable};
pub(crate) use super::folder::Folder;
use super::folder::failed;
use super::report::Report;
use crate::archive::Entries;
use crate::error::Error;
use crate::platform::Platform;

/// How long a binary may take for all of it.
const PATIENCE: Duration = Duration::from_secs(60);

/// Loads the binaries of an FMU on this machine, if it has any, and reports what is wrong with their answers.
pub fn check(entries: &Entries, model: &Model, report: &mut Report) -> Result<(), Error> {
    let Some((first, platform)) = model.interfaces().next().zip(Platform::host().ok()) else { return Ok(()) };
    let path = |interface: &Interface| model.host_binary(&interface.identifier).unwrap_or_default();
    let binary = path(first);
    for interface in model.interfaces() {
        if interface.needs_tool {
            return Ok(());
        }
        match entries.get(&path(interface)) {
            None => {
                report.remark(format_args!("{}: missing, so nothing was loaded", path(interface)));
                return Ok(());
            }
            Some(bytes) if platform.check(bytes).is_err() => return Ok(()),
            Some(_) => {}
        }
    }
    let is_binary = |name: &str| model.interfaces().any(|interface| path(interface) == name);
    let folder = Folder::new()?;
    for (name, contents) in entries {
        if name == "modelDescription.xml" || is_binary(name) || name.starts_with("resources/") {
            folder.write(name, contents)?;
        }
    }
    let findings = folder.0.join("findings");
    let status = supervise(&[Path::new("probe"), &folder.0, &findings])?;
    collect(&binary, status, &fs::read_to_string(&findings).unwrap_or_default(), report);
    Ok(())
}

/// Runs this program with other arguments, silently and not for longer than `PATIENCE`; nothing if it took longer.
pub(crate) fn supervise(arguments: &[&Path]) -> Result<Option<ExitStatus>, Error> {
    let program = env::current_exe().map_err(|error| failed("find this program", error))?;
    let mut child = Command::new(program)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|error| failed("start this program again", error))?;
    let deadline = Instant::now() + PATIENCE;
    let status = loop {
        match child.try_wait().map_err(|error| failed("wait for the binary", error))? {
            Some(status) => break Some(status),
            None if Instant::now() > deadline => break None,
            None => thread::sleep(Duration::from_millis(2)),
        }
    };
    if status.is_none() {
        // It may just have ended by itself.
        let _ = child.kill();
        let _ = child.wait();
    }
    Ok(status)
}

/// Takes over the child's findings, and tells where it stopped if it did not get to the end.
fn collect(binary: &str, status: Option<ExitStatus>, findings: &str, report: &mut Report) {
    let mut last = "loading";
    for line in findings.lines() {
        match line.split_once(": ") {
            Some(("problem", text)) => report.problem(format_args!("{binary}: {text}")),
            Some(("remark", text)) => report.remark(format_args!("{binary}: {text}")),
            Some(("call", function)) => last = function,
            _ => {}
        }
    }
    match status {
        None => report.problem(format_args!("{binary}: no answer for {} s after {last}", PATIENCE.as_secs())),
        Some(status) if !status.success() => report.problem(format_args!("{binary}: crashed in {last} ({status})")),
        Some(_) => {}
    }
}

/// The child: loads the binary of the FMU unpacked in `folder` and writes to the file `findings` what is wrong.
pub fn run(folder: &Path, findings: &Path) -> Result<(), Error> {
    let text = fs::read(folder.join("modelDescription.xml")).map_err(|error| failed("read the description", error))?;
    let model = Model::read(&text, &mut Report::default());
    let file = File::create(findings).map_err(|error| failed("write the findings", error))?;
    let Some(model) = model.as_ref() else { return Ok(()) };
    let mut findings = Findings(file);
    for interface in model.interfaces() {
        let binary = folder.join(model.host_binary(&interface.identifier).unwrap_or_default());
        let kind = interface.kind;
        let done = load(&binary, &mut findings).and_then(|library| {
            let mut probe = Probe { findings: &mut findings, model, kind, library, instance: null_mut() };
            if model.is_fmi3() { probe.all_arrays(folder) } else { probe.all(folder) }
        });
        if let Err(problem) = done {
            let said = SAID.lock().map(|mut said| std::mem::take(&mut *said)).unwrap_or_default();
            let said = if said.is_empty() { said } else { format!("; it says: {said}") };
            let of_kind = if kind == Kind::ModelExchange { "in model exchange: " } else { "" };
            findings.tell("problem", &format!("{of_kind}{problem}{said}"));
        }
    }
    Ok(())
}

/// `fmi2CallbackFunctions` of the standard.
#[repr(C)]
pub(crate) struct Callbacks {
    pub(crate) logger: *const c_void,
    pub(crate) allocate_memory: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    pub(crate) free_memory: unsafe extern "C" fn(*mut c_void),
    pub(crate) step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    pub(crate) environment: *mut c_void,
}

/// `fmi2CoSimulation` and `fmi2ModelExchange` of the standard.
pub(crate) const CO_SIMULATION: c_int = 1;
const MODEL_EXCHANGE: c_int = 0;

pub(crate) type Instance = *mut c_void;
pub(crate) type Instantiate = unsafe extern "C" fn(
    *const c_char,
    c_int,
    *const c_char,
    *const c_char,
    *const Callbacks,
    c_int,
    c_int,
) -> Instance;
type Values<T> = unsafe extern "C" fn(Instance, *const u32, usize, *mut T) -> c_int;

/// The last text that the binary logged as an error.
pub(crate) static SAID: Mutex<String> = Mutex::new(String::new());

pub(crate) unsafe extern "C" fn log(
    _: *mut c_void,
    _: *const c_char,
    status: c_int,
    _: *const c_char,
    text: *const c_char,
) {
    // From fmi2Discard on. The text is a format whose arguments are out of reach for Rust.
    if status >= 2 && !text.is_null() {
        // SAFETY: the binary promises a text closed by a null byte.
        let text = unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned();
        if let Ok(mut said) = SAID.lock() {
            *said = text;
        }
    }
}

/// The file that the findings are left in.
pub(super) struct Findings(File);

impl Findings {
    pub(super) fn tell(&mut self, kind: &str, text: &str) {
        // If the disk is full, the parent reports what it finds.
        let _ = writeln!(self.0, "{kind}: {}", text.replace(['\n', '\r'], " "));
    }
}

fn load(path: &Path, findings: &mut Findings) -> Result<Library, String> {
    findings.tell("call", "loading");
    // SAFETY: none; that it may do anything is why this is another process.
    unsafe { Library::new(path) }.map_err(|error| {
        let reason = std::error::Error::source(&error).map_or_else(|| error.to_string(), ToString::to_string);
        format!("cannot be loaded: {reason}")
    })
}

pub(super) struct Probe<'a> {
    pub(super) findings: &'a mut Findings,
    pub(super) model: &'a Model,
    kind: Kind,
    library: Library,
    pub(super) instance: Instance,
}

impl<'a> Probe<'a> {
    /// A host's way through the functions, to the first that fails.
    fn all(&mut self, folder: &Path) -> Result<(), String> {
        self.constant("fmi2GetTypesPlatform", "default")?;
        self.constant("fmi2GetVersion", "2.0")?;
        let callbacks = Callbacks {
            // The same arguments up to the format; what follows it is not looked at.
            logger: log as *const c_void,
            allocate_memory: libc::calloc,
            free_memory: libc::free,
            step_finished: None,
            environment: null_mut(),
        };
        let location = location(&folder.join("resources"));
        self.instantiate("{00000000-0000-0000-0000-000000000000}", &location, &callbacks)?;
        if !self.instance.is_null() {
            self.findings.tell("remark", "fmi2Instantiate accepts a GUID that is not that of the description");
            self.free()?;
        }
        if let Ok(mut said) = SAID.lock() {
            said.clear();
        }
        self.instantiate(&self.model.guid, &location, &callbacks)?;
        if self.instance.is_null() {
            return Err("fmi2Instantiate refuses the description's GUID or the resources".to_owned());
        }
        let done = self.step();
        self.free()?;
        done
    }

    /// Initialization, one step, and every value before and after.
    fn step(&mut self) -> Result<(), String> {
        let experiment = &self.model.experiment;
        let start = experiment.start.unwrap_or(0.0);
        let step = experiment.step.unwrap_or_else(|| (experiment.stop.unwrap_or(start + 1.0) - start) / 500.0);
        type Setup = unsafe extern "C" fn(Instance, c_int, f64, f64, c_int, f64) -> c_int;
        type Step = unsafe extern "C" fn(Instance, f64, f64, c_int) -> c_int;
        let set_up = self.function::<Setup>("fmi2SetupExperiment")?;
        // SAFETY: the arguments of the standard, here and below.
        self.status("fmi2SetupExperiment", unsafe { set_up(self.instance, 0, 0.0, start, 0, 0.0) })?;
        self.plain("fmi2EnterInitializationMode")?;
        self.values(true)?;
        self.plain("fmi2ExitInitializationMode")?;
        self.values(false)?;
        if self.kind == Kind::ModelExchange {
            self.integrate(start, step)?;
            return self.plain("fmi2Terminate");
        }
        let do_step = self.function::<Step>("fmi2DoStep")?;
        self.status("fmi2DoStep", unsafe { do_step(self.instance, start, step, 1) })?;
        self.values(false)?;
        self.plain("fmi2Terminate")
    }

    pub(super) fn kind(&self) -> Kind {
        self.kind
    }

    /// How many continuous states and event indicators there are.
    pub(super) fn continuous(&self) -> (usize, usize) {
        (self.model.structure.derivatives.as_ref().map_or(0, Vec::len), self.model.event_indicators)
    }

    pub(super) fn function<T: Copy>(&mut self, name: &str) -> Result<T, String> {
        self.findings.tell("call", name);
        // SAFETY: the caller names the type that the standard gives the function, and does not keep it.
        let function = unsafe { self.library.get::<T>(name.as_bytes()) };
        function.map(|function| *function).map_err(|_| format!("{name} is not exported"))
    }

    pub(super) fn status(&mut self, function: &str, status: c_int) -> Result<(), String> {
        let name = match status {
            0 => return Ok(()),
            1 => {
                let version = function.get(..4).unwrap_or_default();
                self.findings.tell("remark", &format!("{function} answers {version}Warning, at which some hosts stop"));
                return Ok(());
            }
            2 => "Discard",
            3 => "Error",
            4 => "Fatal",
            5 => "Pending",
            _ => return Err(format!("{function} answers an unknown status")),
        };
        Err(format!("{function} answers {}{name}", function.get(..4).unwrap_or_default()))
    }

    pub(super) fn plain(&mut self, name: &str) -> Result<(), String> {
        let function = self.function::<unsafe extern "C" fn(Instance) -> c_int>(name)?;
        self.status(name, unsafe { function(self.instance) })
    }

    pub(super) fn free(&mut self) -> Result<(), String> {
        let name = if self.model.is_fmi3() { "fmi3FreeInstance" } else { "fmi2FreeInstance" };
        let function = self.function::<unsafe extern "C" fn(Instance)>(name)?;
        unsafe { function(self.instance) };
        Ok(())
    }

    pub(super) fn constant(&mut self, name: &str, wanted: &str) -> Result<(), String> {
        let function = self.function::<unsafe extern "C" fn() -> *const c_char>(name)?;
        let text = unsafe { function() };
        // SAFETY: not NULL here, and the binary promises a text closed by a null byte.
        let text = if text.is_null() { "NULL".into() } else { unsafe { CStr::from_ptr(text) }.to_string_lossy() };
        if text == wanted { Ok(()) } else { Err(format!("{name} answers \"{text}\"; allowed: \"{wanted}\"")) }
    }

    fn instantiate(&mut self, guid: &str, location: &str, callbacks: &Callbacks) -> Result<(), String> {
        let function = self.function::<Instantiate>("fmi2Instantiate")?;
        let text = |text: &str| CString::new(text).map_err(|_| format!("\"{text}\" holds a null byte"));
        let kind = if self.kind == Kind::CoSimulation { CO_SIMULATION } else { MODEL_EXCHANGE };
        let (name, guid, location) = (text("check")?, text(guid)?, text(location)?);
        self.instance = unsafe { function(name.as_ptr(), kind, guid.as_ptr(), location.as_ptr(), callbacks, 0, 0) };
        Ok(())
    }

    /// Reads every variable; compares start values with those of the description if nothing else was set yet.
    pub(super) fn values(&mut self, compare: bool) -> Result<(), String> {
        let reals = self.read("fmi2GetReal", 0.0_f64, |kind| kind == Type::Real)?;
        let of_integers = |kind| matches!(kind, Type::Integer | Type::Enumeration);
        let integers = self.read("fmi2GetInteger", 0, of_integers)?;
        let booleans = self.read("fmi2GetBoolean", 0, |kind| kind == Type::Boolean)?;
        self.read("fmi2GetString", null::<c_char>(), |kind| kind == Type::String)?;
        for (variable, value) in &reals {
            if !value.is_finite() {
                self.findings.tell("remark", &format!("{} = {value}", variable.name));
            }
        }
        if compare {
            let number = |text: &str| text.trim().parse::<f64>().ok();
            let truth = |text: &str| Some(f64::from(u8::from(matches!(text, "true" | "1"))));
            let integer = |(variable, value): (_, c_int)| (variable, f64::from(value));
            self.compare(reals, number);
            self.compare(integers.into_iter().map(integer).collect(), number);
            self.compare(booleans.into_iter().map(integer).collect(), truth);
        }
        Ok(())
    }

    fn compare(&mut self, values: Vec<(&Variable, f64)>, parse: impl Fn(&str) -> Option<f64>) {
        for (variable, value) in values {
            let given = matches!(variable.causality, Causality::Parameter | Causality::Input);
            if let Some(start) = variable.attributes.start.as_deref().filter(|_| given)
                && parse(start).is_some_and(|start| start != value)
            {
                self.findings.tell("problem", &format!("{} is {value}; the description has {start}", variable.name));
            }
        }
    }

    fn read<T: Copy>(
        &mut self,
        name: &str,
        nothing: T,
        wanted: impl Fn(Type) -> bool,
    ) -> Result<Vec<(&'a Variable, T)>, String> {
        let of_type = |variable: &&Variable| wanted(variable.attributes.data_type);
        let variables: Vec<&Variable> = self.model.variables.iter().filter(of_type).collect();
        let references: Vec<u32> = variables.iter().map(|variable| variable.reference).collect();
        let mut values = vec![nothing; variables.len()];
        if !variables.is_empty() {
            let get = self.function::<Values<T>>(name)?;
            let status = unsafe { get(self.instance, references.as_ptr(), references.len(), values.as_mut_ptr()) };
            self.status(name, status)?;
        }
        Ok(variables.into_iter().zip(values).collect())
    }
}

/// The location of a folder as hosts give it.
pub(crate) fn location(folder: &Path) -> String {
    let path = folder.to_string_lossy().replace('\\', "/");
    let encode = |c: char| match c {
        ' ' => "%20".to_owned(),
        '%' => "%25".to_owned(),
        c => c.to_string(),
    };
    let encoded: String = path.chars().map(encode).collect();
    if encoded.starts_with('/') { format!("file://{encoded}") } else { format!("file:///{encoded}") }
}
