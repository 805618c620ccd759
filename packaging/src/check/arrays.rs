//! What the binary answers in FMI 3.0: a host's way through co-simulation, without event mode, or up to what it integrates.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::Path;
use std::ptr::{null, null_mut};

use super::description::model::{Array, Kind};
use super::probe::{Instance, Probe, SAID};

type Log = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);
/// Name, token, path of the resources, visible, loggingOn; what only co-simulation has; the host's environment and functions.
type ForCoSimulation = unsafe extern "C" fn(
    *const c_char,
    *const c_char,
    *const c_char,
    bool,
    bool,
    bool,
    bool,
    *const u32,
    usize,
    *mut c_void,
    Log,
    *const c_void,
) -> Instance;
type ForModelExchange =
    unsafe extern "C" fn(*const c_char, *const c_char, *const c_char, bool, bool, *mut c_void, Log) -> Instance;
type Get<T> = unsafe extern "C" fn(Instance, *const u32, usize, *mut T, usize) -> c_int;
type Step = unsafe extern "C" fn(Instance, f64, f64, bool, *mut bool, *mut bool, *mut bool, *mut f64) -> c_int;

unsafe extern "C" fn log(_: *mut c_void, status: c_int, _: *const c_char, text: *const c_char) {
    if status >= 2 && !text.is_null() {
        // SAFETY: the binary promises a text closed by a null byte.
        let text = unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned();
        if let Ok(mut said) = SAID.lock() {
            *said = text;
        }
    }
}

impl Probe<'_> {
    /// A host's way through the functions, to the first that fails.
    pub(super) fn all_arrays(&mut self, folder: &Path) -> Result<(), String> {
        self.constant("fmi3GetVersion", &self.model.fmi_version.clone())?;
        let resources = folder.join("resources/").to_string_lossy().into_owned();
        self.create("{00000000-0000-0000-0000-000000000000}", &resources)?;
        if !self.instance.is_null() {
            let text = format!("{} accepts a token that is not that of the description", self.instantiates());
            self.findings.tell("remark", &text);
            self.free()?;
        }
        if let Ok(mut said) = SAID.lock() {
            said.clear();
        }
        self.create(&self.model.guid.clone(), &resources)?;
        if self.instance.is_null() {
            return Err(format!("{} refuses the description's token or the resources", self.instantiates()));
        }
        let done = self.run_arrays();
        self.free()?;
        done
    }

    /// Name of the function that makes an instance of this kind.
    fn instantiates(&self) -> &'static str {
        match self.kind() {
            Kind::CoSimulation => "fmi3InstantiateCoSimulation",
            Kind::ModelExchange => "fmi3InstantiateModelExchange",
        }
    }

    fn create(&mut self, token: &str, resources: &str) -> Result<(), String> {
        let text = |text: &str| CString::new(text).map_err(|_| format!("\"{text}\" holds a null byte"));
        let texts = [text("check")?, text(token)?, text(resources)?];
        let [name, token, path] = texts.each_ref().map(|text| text.as_ptr());
        let (function, none) = (self.instantiates(), null_mut());
        // SAFETY: the arguments of the standard, here and below.
        self.instance = match self.kind() {
            Kind::CoSimulation => {
                let instantiate = self.function::<ForCoSimulation>(function)?;
                unsafe { instantiate(name, token, path, false, true, false, false, null(), 0, none, log, null()) }
            }
            Kind::ModelExchange => {
                let instantiate = self.function::<ForModelExchange>(function)?;
                unsafe { instantiate(name, token, path, false, true, none, log) }
            }
        };
        Ok(())
    }

    /// Initialization, one step, and every value before and after.
    fn run_arrays(&mut self) -> Result<(), String> {
        let experiment = &self.model.experiment;
        let start = experiment.start.unwrap_or(0.0);
        let step = experiment.step.unwrap_or_else(|| (experiment.stop.unwrap_or(start + 1.0) - start) / 500.0);
        type Enter = unsafe extern "C" fn(Instance, bool, f64, f64, bool, f64) -> c_int;
        let enter = self.function::<Enter>("fmi3EnterInitializationMode")?;
        self.status("fmi3EnterInitializationMode", unsafe { enter(self.instance, false, 0.0, start, false, 0.0) })?;
        self.elements(true)?;
        self.plain("fmi3ExitInitializationMode")?;
        self.elements(false)?;
        if self.kind() == Kind::ModelExchange {
            self.integrate_arrays(start, step)?;
            return self.plain("fmi3Terminate");
        }
        let do_step = self.function::<Step>("fmi3DoStep")?;
        let (mut events, mut terminate, mut early, mut reached) = (false, false, false, start);
        let status =
            unsafe { do_step(self.instance, start, step, true, &mut events, &mut terminate, &mut early, &mut reached) };
        self.status("fmi3DoStep", status)?;
        if early || reached != start + step {
            return Err(format!("fmi3DoStep returns early, at {reached} s, though that is not allowed"));
        }
        self.elements(false)?;
        self.plain("fmi3Terminate")
    }

    /// Reads every variable; compares start values with those of the description if nothing else was set yet.
    pub(super) fn elements(&mut self, compare: bool) -> Result<(), String> {
        for array in &self.model.arrays {
            let values = match array.element.as_str() {
                "Float64" => self.array::<f64>(array, "fmi3GetFloat64", |value| value)?,
                "UInt64" => self.array::<u64>(array, "fmi3GetUInt64", |value| value as f64)?,
                "Int64" | "Enumeration" => self.array::<i64>(array, "fmi3GetInt64", |value| value as f64)?,
                "Int32" => self.array::<i32>(array, "fmi3GetInt32", f64::from)?,
                "Boolean" => self.array::<bool>(array, "fmi3GetBoolean", |value| f64::from(u8::from(value)))?,
                _ => continue,
            };
            if values.iter().any(|value| !value.is_finite()) {
                self.findings.tell("remark", &format!("{} is not finite", array.name));
            }
            let set = matches!(array.causality.as_str(), "parameter" | "structuralParameter" | "input");
            let start =
                array.start.as_deref().filter(|_| set && compare && array.element != "Boolean").unwrap_or_default();
            let start: Vec<f64> = start.split_whitespace().filter_map(|text| text.parse().ok()).collect();
            if !start.is_empty() && start != values {
                let text = format!("{} is {values:?}; the description has {start:?}", array.name);
                self.findings.tell("problem", &text);
            }
        }
        Ok(())
    }

    fn array<T: Copy + Default>(
        &mut self,
        array: &Array,
        name: &str,
        as_f64: fn(T) -> f64,
    ) -> Result<Vec<f64>, String> {
        let mut values = vec![T::default(); self.model.elements(array)];
        let get = self.function::<Get<T>>(name)?;
        let status = unsafe { get(self.instance, &array.reference, 1, values.as_mut_ptr(), values.len()) };
        self.status(&format!("{name} of {}", array.name), status)?;
        Ok(values.into_iter().map(as_f64).collect())
    }
}
