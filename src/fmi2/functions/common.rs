//! Functions common to all kinds of FMUs: versions, creating and freeing components, logging, phases, saved states.

use std::ffi::{CStr, c_char};
use std::ptr::null_mut;

use crate::ffi::{self, Component, Version, array, log_line, text};
use crate::fmi2::Fmi2;
use crate::fmi2::types::*;
use crate::instance::{Experiment, Kind, Log, Phase, Purpose, Sink};
use crate::variables::Refusal;

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

/// Creates an instance. Returns NULL and logs why if the GUID does not match this binary and the FMU's resources, the
/// resources are damaged, or the type is unknown.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    instanceName: fmi2String,
    fmuType: fmi2Type,
    fmuGUID: fmi2String,
    fmuResourceLocation: fmi2String,
    functions: *const fmi2CallbackFunctions,
    _visible: fmi2Boolean,
    loggingOn: fmi2Boolean,
) -> fmi2Component {
    if functions.is_null() || !functions.is_aligned() {
        return null_mut(); // No callbacks, so no logger.
    }
    // SAFETY: checked above, and the host promises that it points to its functions.
    let functions = unsafe { *functions };
    // SAFETY: the host promises null-terminated texts, or NULL.
    let [name, guid, location] = [instanceName, fmuGUID, fmuResourceLocation].map(|given| unsafe { text(given) });
    let log = Log::new(sink(functions, name), loggingOn != fmi2False);
    let start = |_: &Log| {
        if name.is_empty() {
            return Err(Refusal::new("instanceName is missing or empty; allowed: any other text"));
        }
        let kind = match fmuType {
            fmi2ModelExchange => Kind::ModelExchange,
            fmi2CoSimulation => Kind::CoSimulation,
            other => {
                let allowed = "fmi2ModelExchange (0), fmi2CoSimulation (1)";
                return Err(Refusal::argument("fmuType", other, allowed));
            }
        };
        ffi::start(Purpose::fmi2(kind), ffi::at_location(location.to_bytes()), ("fmuGUID", guid))
    };
    ffi::create("fmi2Instantiate", log, Fmi2, start)
}

/// A sink for the host's logger, if it has one. The name is copied, because the host may free its own.
fn sink(functions: fmi2CallbackFunctions, name: &CStr) -> Option<Sink> {
    let (logger, environment, name) = (functions.logger?, functions.componentEnvironment, name.to_owned());
    Some(Box::new(move |severity, category, text| {
        let [category, message] = log_line(category, text, true);
        // SAFETY: the host promises that its logger can be called with its environment while the instance lives. The
        // message is a format without conversions, so that no further argument is read.
        unsafe { logger(environment, name.as_ptr(), Fmi2::status(severity), category.as_ptr(), message.as_ptr()) }
    }))
}

/// Frees a component in any phase; NULL is ignored.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: fmi2Component) {
    // SAFETY: the host promises that `c` is NULL or a component it does not use again.
    unsafe { Component::<Fmi2>::free(c) }
}

export! {
    /// Switches logging on for the categories listed only, for all if none is listed, or off. An unknown category is an
    /// error and changes nothing.
    fn fmi2SetDebugLogging(loggingOn: fmi2Boolean, nCategories: usize, categories: *const fmi2String)
    as SET_DEBUG_LOGGING |instance| {
        let categories = ffi::categories(array("categories", categories, nCategories)?)?;
        instance.log.switch(false, &[]);
        instance.log.switch(loggingOn != fmi2False, &categories);
        Ok(())
    };
    /// Sets start time, stop time and tolerance. A tolerance can only tighten `solver.tolerance`; non-positive and
    /// non-finite values are ignored.
    fn fmi2SetupExperiment(
        toleranceDefined: fmi2Boolean, tolerance: f64, startTime: f64, stopTimeDefined: fmi2Boolean, stopTime: f64
    ) as SETUP_EXPERIMENT |instance| {
        let stop = (stopTimeDefined != fmi2False).then_some(stopTime);
        let tolerance = (toleranceDefined != fmi2False).then_some(tolerance);
        instance.set_up(Experiment { start: startTime, stop, tolerance })
    };
    /// Enters Initialization Mode; fmi2SetupExperiment comes first.
    fn fmi2EnterInitializationMode() as ENTER_INITIALIZATION_MODE |instance| instance.enter_initialization();
    /// Starts the run.
    fn fmi2ExitInitializationMode() as EXIT_INITIALIZATION_MODE |instance| instance.exit_initialization();
    /// Ends the run; its last values can still be read.
    fn fmi2Terminate() as TERMINATE |instance| instance.enter(Phase::Terminated);
    /// Returns to the state after fmi2Instantiate.
    fn fmi2Reset() as RESET |instance| { instance.reset(); Ok(()) };
}

ffi::export_states! {
    fmi2FMUstate, c_char:
    fmi2GetFMUstate fmi2SetFMUstate fmi2FreeFMUstate
    fmi2SerializedFMUstateSize fmi2SerializeFMUstate fmi2DeSerializeFMUstate
}
