//! Creating and freeing instances.

use crate::ffi::{self, Component, HostFenv, Version, array, log_line, text};
use crate::fmi3::Fmi3;
use crate::fmi3::types::*;
use crate::instance::{Kind, Log, LogSink, Purpose};
use crate::variables::{Refusal, Variable, ensure};

/// Version of the standard: `3.0`.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> fmi3String {
    c"3.0".as_ptr()
}

/// Creates an instance for co-simulation. Returns NULL, and logs why if logging is on, if the token does not match this
/// binary and the FMU's resources or the resources are damaged.
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
    let (events, early_return) = (eventModeUsed != fmi3False, earlyReturnAllowed != fmi3False);
    let purpose = Purpose { kind: Kind::CoSimulation, fmi3: true, events, early_return };
    let callbacks = Fmi3 { environment: instanceEnvironment, update: intermediateUpdate, may_end_early: early_return };
    let names = [instanceName, instantiationToken, resourcePath];
    // SAFETY: the host's promises, here that it gives as many references as it says.
    unsafe {
        let read =
            array("requiredIntermediateVariables", requiredIntermediateVariables, nRequiredIntermediateVariables)
                .unwrap_or_default();
        create("fmi3InstantiateCoSimulation", names, (logMessage, loggingOn), (purpose, callbacks), read)
    }
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
    let purpose = Purpose { kind: Kind::ModelExchange, fmi3: true, events: true, early_return: false };
    let callbacks = Fmi3 { environment: instanceEnvironment, update: None, may_end_early: false };
    let names = [instanceName, instantiationToken, resourcePath];
    // SAFETY: the host's promises.
    unsafe { create("fmi3InstantiateModelExchange", names, (logMessage, loggingOn), (purpose, callbacks), &[]) }
}

/// Creates an instance for this purpose with the FMU's start values, or logs why `function` failed. The host wants to
/// `read` these variables within steps.
///
/// # Safety
/// As for [`text()`].
unsafe fn create(
    function: &str,
    names: [fmi3String; 3],
    (logger, on): (fmi3LogMessageCallback, fmi3Boolean),
    (purpose, callbacks): (Purpose, Fmi3),
    read: &[fmi3ValueReference],
) -> fmi3Instance {
    // SAFETY: as the caller promises.
    let [name, token, path] = names.map(|given| unsafe { text(given) });
    let fenv = HostFenv::default();
    let log = Log::new(sink(logger, callbacks.environment, fenv.clone()), on != fmi3False, false);
    let start = |log: &Log| {
        let is_blank = name.to_string_lossy().trim().is_empty();
        ensure(!is_blank, || Refusal::new("instanceName is missing or blank; allowed: any other text"))?;
        let start = ffi::start(purpose, ffi::at_path(path.to_bytes()), ("instantiationToken", token))?;
        for reference in read {
            let variable = start.variable(*reference, start.settings.balls());
            if !variable.as_ref().is_some_and(Variable::is_intermediate) {
                log.solver(format_args!("the variable with value reference {reference} has no intermediateUpdate"));
            }
        }
        Ok(start)
    };
    ffi::create(function, (fenv, log), callbacks, start)
}

/// Not offered: returns NULL, and logs why if logging is on.
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
    _clockUpdate: Option<unsafe extern "C" fn(fmi3InstanceEnvironment)>,
    _lockPreemption: Option<unsafe extern "C" fn()>,
    _unlockPreemption: Option<unsafe extern "C" fn()>,
) -> fmi3Instance {
    let fenv = HostFenv::default();
    let log = Log::new(sink(logMessage, instanceEnvironment, fenv.clone()), loggingOn != fmi3False, false);
    let callbacks = Fmi3 { environment: instanceEnvironment, update: None, may_end_early: false };
    ffi::create("fmi3InstantiateScheduledExecution", (fenv, log), callbacks, |_| Err(no_scheduled_execution()))
}

/// Frees an instance in any phase; NULL and an instance within a step are ignored.
///
/// # Safety
/// See the [module](crate::fmi3).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: fmi3Instance) {
    // SAFETY: the host promises that it is NULL or an instance it does not use again.
    unsafe { Component::<Fmi3>::free(instance) }
}

/// A sink for the host's logger, if it has one.
fn sink(logger: fmi3LogMessageCallback, environment: fmi3InstanceEnvironment, fenv: HostFenv) -> Option<LogSink> {
    let logger = logger?;
    Some(Box::new(move |severity, category, text| {
        let [category, message] = log_line(category, text, false);
        // SAFETY: the host promises that its logger can be called with its environment while the instance lives.
        fenv.outside(|| unsafe { logger(environment, Fmi3::status(severity), category.as_ptr(), message.as_ptr()) });
    }))
}

pub(super) fn no_scheduled_execution() -> Refusal {
    Refusal::new("scheduled execution is not offered; allowed: co-simulation or model exchange")
}
