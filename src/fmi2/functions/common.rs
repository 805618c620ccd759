//! Functions common to all kinds of FMUs: versions, logging, and the way through the phases.

use std::ffi::CStr;

use crate::fmi2::boundary::{array, call};
use crate::fmi2::types::*;
use crate::instance::{Call, Experiment, Refusal};
use crate::variables::{LOG_CATEGORIES, LogCategory};

/// Platform of the types: `default`.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> fmi2String {
    c"default".as_ptr()
}

/// Version of the standard: `2.0`.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> fmi2String {
    c"2.0".as_ptr()
}

/// Switches logging on for the categories listed only, for all if none is listed, or off. An unknown category is an
/// error and changes nothing.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    c: fmi2Component,
    loggingOn: fmi2Boolean,
    nCategories: usize,
    categories: *const fmi2String,
) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe {
        call(c, "fmi2SetDebugLogging", Call::SetDebugLogging, |instance| {
            let names = array("categories", categories, nCategories)?;
            let categories: Vec<LogCategory> = names.iter().map(|name| category(*name)).collect::<Result<_, _>>()?;
            instance.log.switch(loggingOn != fmi2False, &categories);
            Ok(())
        })
    }
}

/// # Safety
/// `name` is NULL or a text closed by a null byte.
unsafe fn category(name: fmi2String) -> Result<LogCategory, Refusal> {
    // SAFETY: not NULL here, the rest is the caller's promise.
    let name = if name.is_null() { c"NULL" } else { unsafe { CStr::from_ptr(name) } }.to_string_lossy();
    LOG_CATEGORIES.into_iter().find(|category| category.name() == name).ok_or_else(|| Refusal::Argument {
        name: "category",
        value: name.into_owned(),
        allowed: LOG_CATEGORIES.map(LogCategory::name).join(", "),
    })
}

/// Takes start time, stop time and tolerance. A tolerance can only tighten `solver.tolerance`; nonsense is ignored.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    c: fmi2Component,
    toleranceDefined: fmi2Boolean,
    tolerance: fmi2Real,
    startTime: fmi2Real,
    stopTimeDefined: fmi2Boolean,
    stopTime: fmi2Real,
) -> fmi2Status {
    let experiment = Experiment {
        start: startTime,
        stop: (stopTimeDefined != fmi2False).then_some(stopTime),
        tolerance: (toleranceDefined != fmi2False).then_some(tolerance),
    };
    // SAFETY: the host's promises, see the module.
    unsafe { call(c, "fmi2SetupExperiment", Call::SetupExperiment, |instance| instance.set_up(experiment)) }
}

/// Enters Initialization Mode; fmi2SetupExperiment comes first.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: fmi2Component) -> fmi2Status {
    let function = "fmi2EnterInitializationMode";
    // SAFETY: the host's promises, see the module.
    unsafe { call(c, function, Call::EnterInitializationMode, |instance| instance.enter_initialization()) }
}

/// Starts the run.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: fmi2Component) -> fmi2Status {
    let function = "fmi2ExitInitializationMode";
    // SAFETY: the host's promises, see the module.
    unsafe { call(c, function, Call::ExitInitializationMode, |instance| instance.exit_initialization()) }
}

/// Ends the run; its last values can still be read.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(c: fmi2Component) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe { call(c, "fmi2Terminate", Call::Terminate, |instance| instance.terminate()) }
}

/// Back to where fmi2Instantiate left it.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: fmi2Component) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe { call(c, "fmi2Reset", Call::Reset, |instance| instance.reset()) }
}
