//! Creating and freeing instances.

use std::ffi::CString;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::null_mut;

use crate::ffi::{self, Component, array, text};
use crate::fmi3::Fmi3;
use crate::fmi3::types::*;
use crate::instance::{Instance, Kind, Log, Severity, Sink};
use crate::variables::{Array, Description, LogCategory, Settings};

/// Version of the standard: `3.0`.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> fmi3String {
    c"3.0".as_ptr()
}

/// Creates an instance for co-simulation. NULL, with a line in the log if it is on, if the token is not that of the
/// description that belongs to this binary and the FMU's resources, or if the resources are damaged.
///
/// # Safety
/// See the [module](crate::fmi3).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    instanceName: fmi3String,
    instantiationToken: fmi3String,
    resourcePath: fmi3String,
    _visible: fmi3Boolean,
    loggingOn: fmi3Boolean,
    eventModeUsed: fmi3Boolean,
    earlyReturnAllowed: fmi3Boolean,
    requiredIntermediateVariables: *const fmi3ValueReference,
    nRequiredIntermediateVariables: usize,
    instanceEnvironment: fmi3InstanceEnvironment,
    logMessage: fmi3LogMessageCallback,
    intermediateUpdate: fmi3IntermediateUpdateCallback,
) -> fmi3Instance {
    let created = catch_unwind(AssertUnwindSafe(|| {
        let log = Log::on_demand(sink(logMessage, instanceEnvironment), loggingOn != fmi3False);
        // SAFETY: the host promises texts closed by a null byte, or NULL.
        let settings = unsafe { settings(instanceName, instantiationToken, resourcePath) };
        let Some((settings, token)) = told("fmi3InstantiateCoSimulation", &log, settings) else { return null_mut() };
        // SAFETY: the host promises as many references as it says.
        let wanted = unsafe {
            array("requiredIntermediateVariables", requiredIntermediateVariables, nRequiredIntermediateVariables)
        };
        for reference in wanted.unwrap_or_default() {
            if !Array::at(*reference).is_some_and(Array::is_intermediate) {
                log.solver(format_args!(
                    "the variable with the value reference {reference} is not there within a step"
                ));
            }
        }
        let (events, early) = (eventModeUsed != fmi3False, earlyReturnAllowed != fmi3False);
        let callbacks = Fmi3 { environment: instanceEnvironment, update: intermediateUpdate, may_end_early: early };
        let instance = Instance::with_arrays(Kind::CoSimulation, settings, token, log, events, early);
        Component::into_raw(instance, callbacks)
    }));
    created.unwrap_or(null_mut())
}

/// Creates an instance for model exchange, with clocks. NULL as for co-simulation.
///
/// # Safety
/// See the [module](crate::fmi3).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    instanceName: fmi3String,
    instantiationToken: fmi3String,
    resourcePath: fmi3String,
    _visible: fmi3Boolean,
    loggingOn: fmi3Boolean,
    instanceEnvironment: fmi3InstanceEnvironment,
    logMessage: fmi3LogMessageCallback,
) -> fmi3Instance {
    let created = catch_unwind(AssertUnwindSafe(|| {
        let log = Log::on_demand(sink(logMessage, instanceEnvironment), loggingOn != fmi3False);
        // SAFETY: the host promises texts closed by a null byte, or NULL.
        let settings = unsafe { settings(instanceName, instantiationToken, resourcePath) };
        let Some((settings, token)) = told("fmi3InstantiateModelExchange", &log, settings) else { return null_mut() };
        let callbacks = Fmi3 { environment: instanceEnvironment, update: None, may_end_early: false };
        Component::into_raw(Instance::with_arrays(Kind::ModelExchange, settings, token, log, true, false), callbacks)
    }));
    created.unwrap_or(null_mut())
}

/// The FMU is not for scheduled execution: NULL, with a line in the log if it is on.
///
/// # Safety
/// See the [module](crate::fmi3).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    _instanceName: fmi3String,
    _instantiationToken: fmi3String,
    _resourcePath: fmi3String,
    _visible: fmi3Boolean,
    loggingOn: fmi3Boolean,
    instanceEnvironment: fmi3InstanceEnvironment,
    logMessage: fmi3LogMessageCallback,
    _clockUpdate: fmi3ClockUpdateCallback,
    _lockPreemption: fmi3LockPreemptionCallback,
    _unlockPreemption: fmi3UnlockPreemptionCallback,
) -> fmi3Instance {
    let _ = catch_unwind(AssertUnwindSafe(|| {
        let log = Log::on_demand(sink(logMessage, instanceEnvironment), loggingOn != fmi3False);
        log.error(format_args!("scheduled execution is not offered; allowed: co-simulation or model exchange"));
    }));
    null_mut()
}

/// Frees an instance in any phase; NULL is ignored, and so is an instance in the middle of a step.
///
/// # Safety
/// See the [module](crate::fmi3).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: fmi3Instance) {
    // SAFETY: the host promises that it is NULL or an instance it does not use again.
    unsafe { Component::<Fmi3>::free(instance) }
}

/// What `function` needs, or a line in the log that says why it is not available.
fn told<T>(function: &str, log: &Log, needed: Result<T, String>) -> Option<T> {
    needed.map_err(|reason| log.error(format_args!("{function}: {reason}"))).ok()
}

/// A way to the host's logger, if it has one.
fn sink(logger: fmi3LogMessageCallback, environment: fmi3InstanceEnvironment) -> Option<Sink> {
    let logger = logger?;
    Some(Box::new(move |severity: Severity, category: LogCategory, text: &str| {
        let category = CString::new(category.name()).unwrap_or_default();
        let message = CString::new(text.replace('\0', "").replace('#', "##")).unwrap_or_default();
        let status = match severity {
            Severity::Ok => fmi3Status::fmi3OK,
            Severity::Warning => fmi3Status::fmi3Warning,
            Severity::Discard => fmi3Status::fmi3Discard,
            Severity::Error => fmi3Status::fmi3Error,
            Severity::Fatal => fmi3Status::fmi3Fatal,
        };
        // SAFETY: the host promises that its logger can be called with its environment while the instance lives.
        unsafe { logger(environment, status, category.as_ptr(), message.as_ptr()) }
    }))
}

/// The start values of the FMU whose description has this token, and the token; or why there are none.
///
/// # Safety
/// As for [`text()`].
unsafe fn settings(name: fmi3String, token: fmi3String, path: fmi3String) -> Result<(Settings, String), String> {
    // SAFETY: as the caller promises.
    let [name, token, path] = [name, token, path].map(|given| unsafe { text(given) });
    if name.to_string_lossy().trim().is_empty() {
        return Err("instanceName is missing or blank; allowed: any other text".to_owned());
    }
    let recipe = ffi::at_path(path.to_bytes())?;
    let settings = recipe.settings().map_err(|error| format!("resources: {error}"))?;
    let given = token.to_string_lossy();
    if Description::of_token(&settings, &given).is_none() {
        let own = Description::fmi3(&settings).guid();
        return Err(format!(
            "instantiationToken = {given} is refused; allowed: {own}, that of the description that belongs to this binary and \
             resources"
        ));
    }
    Ok((settings, given.into_owned()))
}
