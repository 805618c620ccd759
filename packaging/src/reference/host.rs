//! A minimal host for the FMU's own binary. It runs in a process of its own, which ends with the run.
#![allow(unsafe_code)]

use std::ffi::{CString, c_char, c_int, c_void};
use std::path::Path;
use std::ptr::null;

use libloading::{Library, Symbol};
use newtons_cradle::variables::Variable;

use super::cases::Case;

/// `fmi2CallbackFunctions` of the standard: five pointers.
type Callbacks = [*const c_void; 5];

/// `fmi2CoSimulation` of the standard.
const CO_SIMULATION: c_int = 1;

type Instance = *mut c_void;
type Text = *const c_char;
type Instantiate = unsafe extern "C" fn(Text, c_int, Text, Text, *const Callbacks, c_int, c_int) -> Instance;
type Plain = unsafe extern "C" fn(Instance) -> c_int;
type Setup = unsafe extern "C" fn(Instance, c_int, f64, f64, c_int, f64) -> c_int;
type Step = unsafe extern "C" fn(Instance, f64, f64, c_int) -> c_int;
type Get = unsafe extern "C" fn(Instance, *const u32, usize, *mut f64) -> c_int;
type Set<T> = unsafe extern "C" fn(Instance, *const u32, usize, *const T) -> c_int;

/// The logger for the binary: it reads none of its arguments, so variadic arguments do no harm.
unsafe extern "C" fn ignore() {}

/// A cradle with parameters set.
pub struct Run {
    library: Library,
    instance: Instance,
}

impl Run {
    /// Loads a binary of this product and starts a run at 0 s.
    pub fn start(binary: &Path, resources: &Path, guid: &str, case: &Case) -> Result<Self, String> {
        // SAFETY: none; that it may do anything is why this is another process.
        let library = unsafe { Library::new(binary) }.map_err(|error| {
            let reason = std::error::Error::source(&error).map_or_else(|| error.to_string(), ToString::to_string);
            format!("it cannot be loaded: {reason}")
        })?;
        let mut run = Self { library, instance: std::ptr::null_mut() };
        let instantiate = *run.function::<Instantiate>("fmi2Instantiate")?;
        let text = |text: &str| CString::new(text).map_err(|_| format!("\"{text}\" holds a null byte"));
        let (name, guid, place) = (text("reference")?, text(guid)?, text(&location(resources))?);
        let (allocate, free) = (libc::calloc as *const c_void, libc::free as *const c_void);
        // They must not move.
        let callbacks = Box::leak(Box::new([ignore as *const c_void, allocate, free, null(), null()]));
        // SAFETY: the arguments of the standard, here and below.
        run.instance =
            unsafe { instantiate(name.as_ptr(), CO_SIMULATION, guid.as_ptr(), place.as_ptr(), callbacks, 0, 0) };
        if run.instance.is_null() {
            return Err("fmi2Instantiate refuses the GUID or the resources".to_owned());
        }
        for variable in &case.parameters {
            if let Some(value) = variable.real(&case.settings) {
                run.set("fmi2SetReal", variable, &value)?;
            } else if let Some(item) = variable.item(&case.settings) {
                run.set("fmi2SetInteger", variable, &item)?;
            }
        }
        run.call("fmi2SetupExperiment", |set_up: Setup| unsafe { set_up(run.instance, 0, 0.0, 0.0, 0, 0.0) })?;
        for name in ["fmi2EnterInitializationMode", "fmi2ExitInitializationMode"] {
            run.call(name, |function: Plain| unsafe { function(run.instance) })?;
        }
        Ok(run)
    }

    fn set<T>(&self, name: &str, variable: &Variable, value: &T) -> Result<(), String> {
        self.call(name, |set: Set<T>| unsafe { set(self.instance, &variable.reference(), 1, value) })
    }

    /// Steps from `time` to another one, s.
    pub fn step(&self, time: f64, next: f64) -> Result<(), String> {
        self.call("fmi2DoStep", |step: Step| unsafe { step(self.instance, time, next - time, 1) })
    }

    /// The value of a real variable.
    pub fn get(&self, variable: &Variable) -> Result<f64, String> {
        let mut value = 0.0;
        let call = |get: Get| unsafe { get(self.instance, &variable.reference(), 1, &mut value) };
        self.call("fmi2GetReal", call).map(|()| value)
    }

    /// A function of the library; the caller names its type in the standard.
    fn function<T>(&self, name: &str) -> Result<Symbol<'_, T>, String> {
        // SAFETY: see above.
        unsafe { self.library.get(name.as_bytes()) }.map_err(|_| format!("{name} is not exported"))
    }

    /// Calls a function, which must answer with `fmi2OK` or `fmi2Warning`.
    fn call<T: Copy>(&self, name: &str, call: impl FnOnce(T) -> c_int) -> Result<(), String> {
        match call(*self.function::<T>(name)?) {
            0 | 1 => Ok(()),
            status => Err(format!("{name} answers with status {status}")),
        }
    }
}

/// The location of a folder as hosts give it.
fn location(folder: &Path) -> String {
    let path = folder.to_string_lossy().replace('\\', "/").replace('%', "%25").replace(' ', "%20");
    if path.starts_with('/') { format!("file://{path}") } else { format!("file:///{path}") }
}
