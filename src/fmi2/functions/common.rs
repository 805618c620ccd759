//! Functions common to all kinds of FMUs: versions, creating and freeing components, logging, and the way through the
//! phases.

use std::ffi::CStr;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::null_mut;

use crate::ffi::{self, Component, array, text};
use crate::fmi2::types::*;
use crate::fmi2::{Fmi2, logger};
use crate::instance::{Experiment, Instance, Kind, Log};
use crate::variables::{Description, Settings};

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

/// Creates an instance. NULL, with a line in the log, if the GUID is not that of the description that belongs to this
/// binary and the FMU's resources, if the resources are damaged, or if this is to be neither co-simulation nor model
/// exchange.
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
        return null_mut(); // Nobody to tell.
    }
    // SAFETY: checked above, and the host promises that it points to its functions.
    let functions = unsafe { *functions };
    // SAFETY: the host promises texts closed by a null byte, or NULL.
    let [name, guid, location] = [instanceName, fmuGUID, fmuResourceLocation].map(|given| unsafe { text(given) });
    let created = catch_unwind(AssertUnwindSafe(|| {
        let log = Log::new(logger::sink(&functions, name), loggingOn != fmi2False);
        match settings(name, fmuType, guid, location) {
            Ok((kind, settings, guid)) => Component::into_raw(Instance::new(kind, settings, guid, log), Fmi2),
            Err(reason) => {
                log.error(format_args!("fmi2Instantiate: {reason}"));
                null_mut()
            }
        }
    }));
    created.unwrap_or(null_mut())
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
    as SetDebugLogging |instance| {
        let categories = ffi::categories(array("categories", categories, nCategories)?)?;
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

/// The kind of instance asked for, the start values of the FMU whose description has this GUID, and the GUID; or why
/// there are none.
fn settings(name: &CStr, kind: fmi2Type, guid: &CStr, location: &CStr) -> Result<(Kind, Settings, String), String> {
    if name.is_empty() {
        return Err("instanceName is missing or empty; allowed: any other text".to_owned());
    }
    let kind = match kind {
        fmi2ModelExchange => Kind::ModelExchange,
        fmi2CoSimulation => Kind::CoSimulation,
        _ => {
            return Err(format!(
                "fmuType = {kind} is refused; allowed: fmi2ModelExchange ({fmi2ModelExchange}), fmi2CoSimulation ({fmi2CoSimulation})"
            ));
        }
    };
    let recipe = ffi::at_location(location.to_bytes())?;
    let settings = recipe.settings().map_err(|error| format!("resources: {error}"))?;
    let own = Description::of(&settings).guid();
    if guid.to_bytes() != own.as_bytes() {
        let guid = guid.to_string_lossy();
        return Err(format!(
            "fmuGUID = {guid} is refused; allowed: {own}, that of the description that belongs to this binary and resources"
        ));
    }
    Ok((kind, settings, own))
}
