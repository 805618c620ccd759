//! A minimal host for the FMU's own binary. It runs in a process of its own, which ends after the run.
#![allow(unsafe_code)]

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::Path;
use std::ptr::{from_ref, null};

use libloading::{Library, Symbol};
use newtons_cradle::variables::{Type, Variable};

use super::cases::Case;

/// `fmi2CoSimulation` of the standard.
const CO_SIMULATION: c_int = 1;

type Instance = *mut c_void;
type Text = *const c_char;
/// `fmi2Instantiate`; its callbacks are five pointers.
type Instantiate = unsafe extern "C" fn(Text, c_int, Text, Text, *const [*const c_void; 5], c_int, c_int) -> Instance;

/// `fmi2Error`.
const ERROR: c_int = 3;

/// The logger for the binary. It keeps the last error in its environment, the [`RefCell`] of [`run`]. It reads no
/// variadic arguments, because the messages of this product need none.
unsafe extern "C" fn keep(said: *const RefCell<String>, _name: Text, status: c_int, _category: Text, message: Text) {
    if status >= ERROR && !said.is_null() && !message.is_null() {
        // SAFETY: the cell that `run` has passed, and a text of the binary.
        let (said, message) = unsafe { (&*said, CStr::from_ptr(message)) };
        // `%` is doubled for printf, and `#` for hosts that expand references to variables.
        said.replace(message.to_string_lossy().replace("%%", "%").replace("##", "#"));
    }
}

/// Whether programs and libraries may be loaded from this folder's file system.
pub fn may_execute(folder: &Path) -> bool {
    #[cfg(target_os = "linux")]
    if let Ok(path) = CString::new(folder.as_os_str().as_encoded_bytes()) {
        // SAFETY: it consists of numbers, for which 0 is valid; statvfs fills it.
        let mut system: libc::statvfs = unsafe { std::mem::zeroed() };
        let known = unsafe { libc::statvfs(path.as_ptr(), &raw mut system) } == 0;
        return !known || system.f_flag & libc::ST_NOEXEC == 0;
    }
    let _ = folder;
    true
}

/// Loads a binary of this product, runs a case from 0 s on, and returns the values of real variables at these times, s.
pub fn run(
    binary: &Path,
    resources: &Path,
    guid: &str,
    case: &Case,
    times: &[f64],
    variables: &[Variable],
) -> Result<Vec<Vec<f64>>, String> {
    // SAFETY: none. The binary may do anything, which is why this is a process of its own.
    let library = unsafe { Library::new(binary) }.map_err(|error| {
        let reason = std::error::Error::source(&error).map_or_else(|| error.to_string(), ToString::to_string);
        format!("it cannot be loaded: {reason}")
    })?;
    let instantiate = function::<Instantiate>(&library, "fmi2Instantiate")?;
    let text = |text: &str| CString::new(text).map_err(|_| format!("\"{text}\" holds a null byte"));
    let (name, guid, place) = (text("reference")?, text(guid)?, text(&location(resources))?);
    let (allocate, free) = (libc::calloc as *const c_void, libc::free as *const c_void);
    let said = RefCell::new(String::new());
    let callbacks = [keep as *const c_void, allocate, free, null(), from_ref(&said).cast()];
    // SAFETY: here and below, arguments as the standard prescribes, which point to what lives as long as it is used.
    let instance =
        unsafe { instantiate(name.as_ptr(), CO_SIMULATION, guid.as_ptr(), place.as_ptr(), &callbacks, 0, 0) };
    if instance.is_null() {
        return Err(reason(&said, "fmi2Instantiate refuses the GUID or the resources"));
    }
    // Calls a function for the instance, with more arguments of these types. Any status but `fmi2OK` and `fmi2Warning`
    // is returned as an error from the function or closure around it.
    macro_rules! call {
        ($name:literal $(, $argument:expr => $type:ty)*) => {{
            type Function = unsafe extern "C" fn(Instance $(, $type)*) -> c_int;
            match unsafe { function::<Function>(&library, $name)?(instance $(, $argument)*) } {
                0 | 1 => {}
                status => return Err(reason(&said, &format!("{} answers with status {status}", $name))),
            }
        }};
    }
    for variable in &case.parameters {
        let reference = variable.reference();
        let value = variable.value(&case.settings).unwrap_or_default();
        if variable.row.access.data_type() == Type::Real {
            call!("fmi2SetReal", &reference => *const u32, 1 => usize, &value => *const f64);
        } else {
            call!("fmi2SetInteger", &reference => *const u32, 1 => usize, &(value as i32) => *const i32);
        }
    }
    call!("fmi2SetupExperiment", 0 => c_int, 0.0 => f64, 0.0 => f64, 0 => c_int, 0.0 => f64);
    call!("fmi2EnterInitializationMode");
    call!("fmi2ExitInitializationMode");
    let references: Vec<u32> = variables.iter().map(Variable::reference).collect();
    let mut before = 0.0;
    let sample = |time: &f64| {
        if *time > before {
            call!("fmi2DoStep", before => f64, time - before => f64, 1 => c_int);
        }
        before = *time;
        let mut values = vec![0.0; references.len()];
        let (from, to) = (references.as_ptr(), values.as_mut_ptr());
        call!("fmi2GetReal", from => *const u32, references.len() => usize, to => *mut f64);
        Ok(values)
    };
    times.iter().map(sample).collect()
}

/// The error that the binary has logged, else what it `did`.
fn reason(said: &RefCell<String>, did: &str) -> String {
    let said = said.borrow();
    if said.is_empty() { did.to_owned() } else { said.clone() }
}

/// Ends this process at once, whatever the binary is doing, without running its exit handlers.
pub fn end() -> ! {
    // SAFETY: it takes a number and does not return.
    unsafe { libc::_exit(0) }
}

/// A function of the library; the caller must name its type in the standard.
fn function<'a, T>(library: &'a Library, name: &str) -> Result<Symbol<'a, T>, String> {
    // SAFETY: see `run`: the binary may do anything.
    unsafe { library.get(name.as_bytes()) }.map_err(|_| format!("{name} is not exported"))
}

/// The location of a folder as a URI, as hosts pass it.
fn location(folder: &Path) -> String {
    let path = folder.to_string_lossy().replace('\\', "/").replace('%', "%25").replace(' ', "%20");
    if path.starts_with('/') { format!("file://{path}") } else { format!("file:///{path}") }
}
