//! A host for the FMU's own binary: parameters, steps, reals. It runs in a process of its own.
#![allow(unsafe_code)]

use std::ffi::{CString, c_char, c_int, c_void};
use std::path::Path;

use libloading::Library;
use newtons_cradle::variables::{Access, Settings, Variable};

/// `fmi2CallbackFunctions` of the standard.
#[repr(C)]
struct Callbacks {
    logger: unsafe extern "C" fn(),
    allocate_memory: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    free_memory: unsafe extern "C" fn(*mut c_void),
    step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    environment: *mut c_void,
}

/// `fmi2CoSimulation` of the standard.
const CO_SIMULATION: c_int = 1;

type Instance = *mut c_void;
type Text = *const c_char;
type Instantiate = unsafe extern "C" fn(Text, c_int, Text, Text, *const Callbacks, c_int, c_int) -> Instance;
type Plain = unsafe extern "C" fn(Instance) -> c_int;
type Setup = unsafe extern "C" fn(Instance, c_int, f64, f64, c_int, f64) -> c_int;
type Step = unsafe extern "C" fn(Instance, f64, f64, c_int) -> c_int;
type Get<T> = unsafe extern "C" fn(Instance, *const u32, usize, *mut T) -> c_int;
type Set<T> = unsafe extern "C" fn(Instance, *const u32, usize, *const T) -> c_int;

/// A cradle with parameters set, at its start time, 0 s.
pub struct Run<'l> {
    library: &'l Library,
    instance: Instance,
    time: f64,
}

/// The binary's log. Its arguments, which are as many as it likes, are the caller's: leaving them alone is safe.
unsafe extern "C" fn ignore() {}

/// Loads a binary of this product.
pub fn load(path: &Path) -> Result<Library, String> {
    // SAFETY: none; that it may do anything is why this is another process.
    unsafe { Library::new(path) }.map_err(|error| {
        let reason = std::error::Error::source(&error).map_or_else(|| error.to_string(), ToString::to_string);
        format!("it cannot be loaded: {reason}")
    })
}

/// A function of the library; the caller names the type that the standard gives it.
fn function<'l, T>(library: &'l Library, name: &str) -> Result<libloading::Symbol<'l, T>, String> {
    // SAFETY: see above.
    unsafe { library.get(name.as_bytes()) }.map_err(|_| format!("{name} is not exported"))
}

fn done(name: &str, status: c_int) -> Result<(), String> {
    // fmi2OK and fmi2Warning.
    if matches!(status, 0 | 1) {
        return Ok(());
    }
    Err(format!("{name} answers with status {status}"))
}

impl<'l> Run<'l> {
    /// Starts a run with the values that `settings` has for `parameters`.
    pub fn start(
        library: &'l Library,
        resources: &Path,
        guid: &str,
        parameters: &[Variable],
        settings: &Settings,
    ) -> Result<Self, String> {
        let callbacks = Callbacks {
            logger: ignore,
            allocate_memory: libc::calloc,
            free_memory: libc::free,
            step_finished: None,
            environment: std::ptr::null_mut(),
        };
        let text = |text: &str| CString::new(text).map_err(|_| format!("\"{text}\" holds a null byte"));
        let (name, guid, place) = (text("reference")?, text(guid)?, text(&location(resources))?);
        let instantiate = function::<Instantiate>(library, "fmi2Instantiate")?;
        // SAFETY: the arguments of the standard, here and below.
        let instance =
            unsafe { instantiate(name.as_ptr(), CO_SIMULATION, guid.as_ptr(), place.as_ptr(), &callbacks, 0, 0) };
        if instance.is_null() {
            return Err("fmi2Instantiate refuses the GUID or the resources".to_owned());
        }
        let run = Self { library, instance, time: 0.0 };
        run.set(parameters, settings)?;
        let set_up = function::<Setup>(library, "fmi2SetupExperiment")?;
        done("fmi2SetupExperiment", unsafe { set_up(instance, 0, 0.0, 0.0, 0, 0.0) })?;
        run.plain("fmi2EnterInitializationMode")?;
        run.plain("fmi2ExitInitializationMode")?;
        Ok(run)
    }

    fn set(&self, parameters: &[Variable], settings: &Settings) -> Result<(), String> {
        let is_item = |variable: &&Variable| matches!(variable.row.access, Access::Enumeration(_));
        let (items, reals): (Vec<&Variable>, Vec<&Variable>) = parameters.iter().partition(is_item);
        let values: Vec<f64> = reals.iter().filter_map(|variable| variable.real(settings)).collect();
        let integers: Vec<c_int> = items.iter().filter_map(|variable| variable.item(settings)).collect();
        self.set_all("fmi2SetReal", &reals, &values)?;
        self.set_all("fmi2SetInteger", &items, &integers)
    }

    fn set_all<T>(&self, name: &str, variables: &[&Variable], values: &[T]) -> Result<(), String> {
        let references: Vec<u32> = variables.iter().map(|variable| variable.reference()).collect();
        let set = function::<Set<T>>(self.library, name)?;
        done(name, unsafe {
            set(self.instance, references.as_ptr(), references.len().min(values.len()), values.as_ptr())
        })
    }

    /// Steps to `time` (s), if it lies ahead.
    pub fn step_to(&mut self, time: f64) -> Result<(), String> {
        if time > self.time {
            let step = function::<Step>(self.library, "fmi2DoStep")?;
            done("fmi2DoStep", unsafe { step(self.instance, self.time, time - self.time, 1) })?;
            self.time = time;
        }
        Ok(())
    }

    /// The values of real variables.
    pub fn get(&self, variables: &[Variable]) -> Result<Vec<f64>, String> {
        let references: Vec<u32> = variables.iter().map(Variable::reference).collect();
        let mut values = vec![0.0; references.len()];
        let get = function::<Get<f64>>(self.library, "fmi2GetReal")?;
        done("fmi2GetReal", unsafe { get(self.instance, references.as_ptr(), references.len(), values.as_mut_ptr()) })?;
        Ok(values)
    }

    fn plain(&self, name: &str) -> Result<(), String> {
        let function = function::<Plain>(self.library, name)?;
        done(name, unsafe { function(self.instance) })
    }
}

impl Drop for Run<'_> {
    fn drop(&mut self) {
        if let Ok(free) = function::<unsafe extern "C" fn(Instance)>(self.library, "fmi2FreeInstance") {
            // SAFETY: the instance is freed once.
            unsafe { free(self.instance) }
        }
    }
}

/// The location of a folder as hosts give it.
fn location(folder: &Path) -> String {
    let path = folder.to_string_lossy().replace('\\', "/").replace('%', "%25").replace(' ', "%20");
    if path.starts_with('/') { format!("file://{path}") } else { format!("file:///{path}") }
}
