//! Functions common to all kinds of FMUs: versions, logging, and the way through the phases.

use std::ffi::CStr;

use crate::fmi2::boundary::array;
use crate::fmi2::types::*;
use crate::instance::{Experiment, Refusal};
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

export! {
    /// Switches logging on for the categories listed only, for all if none is listed, or off. An unknown category is an
    /// error and changes nothing.
    fn fmi2SetDebugLogging(loggingOn: fmi2Boolean, nCategories: usize, categories: *const fmi2String)
    as SetDebugLogging |instance| {
        let names = array("categories", categories, nCategories)?;
        let categories: Vec<LogCategory> = names.iter().map(|name| category(*name)).collect::<Result<_, _>>()?;
        instance.log.switch(loggingOn != fmi2False, &categories);
        Ok(())
    };
    /// Takes start time, stop time and tolerance. A tolerance can only tighten `solver.tolerance`; nonsense is ignored.
    fn fmi2SetupExperiment(
        toleranceDefined: fmi2Boolean, tolerance: fmi2Real, startTime: fmi2Real, stopTimeDefined: fmi2Boolean, stopTime: fmi2Real
    ) as SetupExperiment |instance| {
        let stop = (stopTimeDefined != fmi2False).then_some(stopTime);
        let tolerance = (toleranceDefined != fmi2False).then_some(tolerance);
        instance.set_up(Experiment { start: startTime, stop, tolerance })
    };
    /// Enters Initialization Mode; fmi2SetupExperiment comes first.
    fn fmi2EnterInitializationMode() as EnterInitializationMode |instance| instance.enter_initialization();
    /// Starts the run.
    fn fmi2ExitInitializationMode() as ExitInitializationMode |instance| instance.exit_initialization();
    /// Ends the run; its last values can still be read.
    fn fmi2Terminate() as Terminate |instance| instance.terminate();
    /// Back to where fmi2Instantiate left it.
    fn fmi2Reset() as Reset |instance| instance.reset();
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
