//! The exported functions, in the groups of the standard. Each translates its arguments and calls the instance through
//! the guard in `ffi`.

use std::ffi::{CStr, c_char};
use std::ptr::null_mut;

use crate::ffi::{self, Component, HostFenv, Version, answer, array, array_mut, fill, log_line, text, write};
use crate::fmi2::Fmi2;
use crate::fmi2::types::*;
use crate::instance::{Experiment, Handled, Kind, Log, LogSink, Phase, Purpose};
use crate::variables::{Refusal, Type, ensure};

macro_rules! export {
    ($($functions:tt)*) => {
        ffi::export_by! { (Fmi2, c: fmi2Component => fmi2Status) $($functions)* }
    };
}

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
    let fenv = HostFenv::default();
    let log = Log::new(sink(functions, name, fenv.clone()), loggingOn != fmi2False, true);
    let start = |_: &Log| {
        ensure(!name.is_empty(), || Refusal::new("instanceName is missing or empty; allowed: any other text"))?;
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
    ffi::create("fmi2Instantiate", (fenv, log), Fmi2, start)
}

/// A sink for the host's logger, if it has one. The name is copied, because the host may free its own.
fn sink(functions: fmi2CallbackFunctions, name: &CStr, fenv: HostFenv) -> Option<LogSink> {
    let (logger, environment, name) = (functions.logger?, functions.componentEnvironment, name.to_owned());
    Some(Box::new(move |severity, category, text| {
        let [category, message] = log_line(category, text, true);
        // SAFETY: the host promises that its logger can be called with its environment while the instance lives. The
        // message is a format without conversions, so that no further argument is read.
        fenv.outside(|| unsafe {
            logger(environment, name.as_ptr(), Fmi2::status(severity), category.as_ptr(), message.as_ptr());
        });
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

// Logging and phases.
export! {
    /// Switches logging on for the categories listed and off for all others; for all if none is listed. An unknown
    /// category is an error and changes nothing.
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

// Values and their derivatives.
export! {
    /// Reads real variables.
    fn fmi2GetReal(vr: *const fmi2ValueReference, nvr: usize, value: *mut f64) as GET |instance| {
        instance.get(Type::Real, array("vr", vr, nvr)?, array_mut("value", value, nvr)?, |value| value)
    };
    /// Reads integers and enumerations; counts that do not fit are the largest integer.
    fn fmi2GetInteger(vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2Integer) as GET |instance| {
        let places = array_mut("value", value, nvr)?;
        instance.get(Type::Integer, array("vr", vr, nvr)?, places, |value| value as fmi2Integer)
    };
    /// Reads booleans.
    fn fmi2GetBoolean(vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2Boolean) as GET |instance| {
        let places = array_mut("value", value, nvr)?;
        instance.get(Type::Boolean, array("vr", vr, nvr)?, places, |value| value as fmi2Boolean)
    };
    /// There are no strings: legal for an empty list only.
    fn fmi2GetString(vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2String) as GET |instance| {
        instance.get(Type::String, array("vr", vr, nvr)?, array_mut("value", value, nvr)?, |_| std::ptr::null())
    };
    /// Sets real parameters and inputs: all, or none if any is refused.
    fn fmi2SetReal(vr: *const fmi2ValueReference, nvr: usize, value: *const f64) as SET |instance| {
        instance.set(Type::Real, array("vr", vr, nvr)?, array("value", value, nvr)?, |value| value)
    };
    /// Sets enumerations: all, or none if any is refused.
    fn fmi2SetInteger(vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2Integer) as SET_DISCRETE |instance| {
        instance.set(Type::Integer, array("vr", vr, nvr)?, array("value", value, nvr)?, f64::from)
    };
    /// No boolean can be set: legal for an empty list only.
    fn fmi2SetBoolean(vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2Boolean) as SET_DISCRETE |instance| {
        instance.set(Type::Boolean, array("vr", vr, nvr)?, array("value", value, nvr)?, f64::from)
    };
    /// There are no strings: legal for an empty list only.
    fn fmi2SetString(vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2String) as SET_DISCRETE |instance| {
        instance.set(Type::String, array("vr", vr, nvr)?, array("value", value, nvr)?, |_| f64::NAN)
    };
    /// Sets time derivatives of real inputs, of order 1 to 3, for the next fmi2DoStep: all, or none if any is refused.
    /// After that step the inputs keep the values they reached.
    fn fmi2SetRealInputDerivatives(
        vr: *const fmi2ValueReference, nvr: usize, order: *const fmi2Integer, value: *const f64
    ) as SET_INPUT_DERIVATIVES |instance| {
        let (references, orders) = (array("vr", vr, nvr)?, array("order", order, nvr)?);
        instance.set_input_derivatives(references, orders, array("value", value, nvr)?)
    };
    /// Time derivatives of real outputs, of order 1 to 3; 0 for variables that change only at events and communication
    /// points.
    fn fmi2GetRealOutputDerivatives(
        vr: *const fmi2ValueReference, nvr: usize, order: *const fmi2Integer, value: *mut f64
    ) as GET_OUTPUT_DERIVATIVES |instance| {
        let (references, orders) = (array("vr", vr, nvr)?, array("order", order, nvr)?);
        write("value", value, ("nvr", nvr), instance.output_derivatives(references, orders)?)
    };
    /// Derivatives of the unknowns along the direction in which the knowns change by `dvKnown`. In Initialization Mode
    /// the unknowns are real outputs and calculated parameters, the knowns real parameters and inputs. Later, the
    /// unknowns are real outputs at the end of the last step, the knowns the inputs held over it. In model exchange the
    /// unknowns are real outputs and derivatives of states, the knowns states and inputs.
    fn fmi2GetDirectionalDerivative(
        vUnknown_ref: *const fmi2ValueReference, nUnknown: usize, vKnown_ref: *const fmi2ValueReference, nKnown: usize,
        dvKnown: *const f64, dvUnknown: *mut f64
    ) as DIRECTIONAL_DERIVATIVE |instance| {
        let unknowns = array("vUnknown_ref", vUnknown_ref, nUnknown)?;
        let (knowns, direction) = (array("vKnown_ref", vKnown_ref, nKnown)?, array("dvKnown", dvKnown, nKnown)?);
        let found = instance.directional(unknowns, knowns, direction)?;
        write("dvUnknown", dvUnknown, ("nUnknown", nUnknown), found)
    };
}

// Steps of co-simulation, and questions about the last one.
export! {
    /// Steps from `currentCommunicationPoint` by `communicationStepSize` > 0, in s. Never answers fmi2Discard or
    /// fmi2Warning, at which hosts loop or stop.
    fn fmi2DoStep(
        currentCommunicationPoint: f64, communicationStepSize: f64, _noSetFMUStatePriorToCurrentPoint: fmi2Boolean
    ) as DO_STEP |instance| {
        instance.step(currentCommunicationPoint, communicationStepSize, false).map(|_| ())
    };
    /// Steps are synchronous: there is never one to cancel.
    fn fmi2CancelStep() as CANCEL_STEP |_| Ok(());
    /// fmi2DoStepStatus: steps are synchronous, and a failed one leaves the error state in which this cannot be asked.
    fn fmi2GetStatus(s: fmi2StatusKind, value: *mut fmi2Status) as STATUS or {
        _ = answer("value", value, fmi2Status::fmi2Error);
    } |_| {
        check(s, fmi2DoStepStatus, "fmi2DoStepStatus")?;
        answer("value", value, fmi2Status::fmi2OK)
    };
    /// fmi2LastSuccessfulTime: the time that the last step reached, s.
    fn fmi2GetRealStatus(s: fmi2StatusKind, value: *mut f64) as STATUS |instance| {
        check(s, fmi2LastSuccessfulTime, "fmi2LastSuccessfulTime")?;
        answer("value", value, instance.time())
    };
    /// The standard defines no status that is an integer.
    fn fmi2GetIntegerStatus(_s: fmi2StatusKind, _value: *mut fmi2Integer) as STATUS |_| {
        Err(Refusal::new("no status is an integer"))
    };
    /// fmi2Terminated: the FMU never ends a run by itself.
    fn fmi2GetBooleanStatus(s: fmi2StatusKind, value: *mut fmi2Boolean) as STATUS or {
        _ = answer("value", value, fmi2True);
    } |_| {
        check(s, fmi2Terminated, "fmi2Terminated")?;
        answer("value", value, fmi2False)
    };
    /// fmi2PendingStatus: nothing is ever pending.
    fn fmi2GetStringStatus(s: fmi2StatusKind, value: *mut fmi2String) as STATUS |_| {
        check(s, fmi2PendingStatus, "fmi2PendingStatus")?;
        answer("value", value, c"".as_ptr())
    };
}

/// Refuses a question about the last step other than the `allowed` one, which the standard calls `name`.
fn check(asked: fmi2StatusKind, allowed: fmi2StatusKind, name: &str) -> Result<(), Refusal> {
    ensure(asked == allowed, || Refusal::argument("fmi2StatusKind", asked, format_args!("{name} ({allowed})")))
}

// Model exchange: events, and what a host needs to integrate.
export! {
    /// Enters Event Mode.
    fn fmi2EnterEventMode() as ENTER_EVENT_MODE |instance| instance.enter_event_mode();
    /// Handles all that is due: contacts close, open, or are followed to their end, as `exchange.contacts` selects.
    fn fmi2NewDiscreteStates(eventInfo: *mut fmi2EventInfo) as NEW_DISCRETE_STATES or {
        _ = answer("eventInfo", eventInfo, fmi2EventInfo {
            newDiscreteStatesNeeded: fmi2False,
            terminateSimulation: fmi2True,
            nominalsOfContinuousStatesChanged: fmi2False,
            valuesOfContinuousStatesChanged: fmi2False,
            nextEventTimeDefined: fmi2False,
            nextEventTime: 0.0,
        });
    } |instance| {
        let places = array_mut("eventInfo", eventInfo, 1)?;
        let Handled { again, changed, next } = instance.update_discrete_states()?;
        fill(places, [fmi2EventInfo {
            newDiscreteStatesNeeded: again.into(),
            terminateSimulation: fmi2False,
            nominalsOfContinuousStatesChanged: fmi2False,
            valuesOfContinuousStatesChanged: changed.into(),
            nextEventTimeDefined: next.is_some().into(),
            nextEventTime: next.unwrap_or_default(),
        }]);
        Ok(())
    };
    /// Enters Continuous-Time Mode.
    fn fmi2EnterContinuousTimeMode() as ENTER_CONTINUOUS_TIME_MODE |instance| instance.enter(Phase::ContinuousTimeMode);
    /// Ends a step of the host's solver; asks for Event Mode where an indicator has changed its sign. Never ends a run.
    fn fmi2CompletedIntegratorStep(
        _noSetFMUStatePriorToCurrentPoint: fmi2Boolean, enterEventMode: *mut fmi2Boolean,
        terminateSimulation: *mut fmi2Boolean
    ) as COMPLETED_INTEGRATOR_STEP or {
        _ = answer("enterEventMode", enterEventMode, fmi2False);
        _ = answer("terminateSimulation", terminateSimulation, fmi2True);
    } |instance| {
        let enter = array_mut("enterEventMode", enterEventMode, 1)?;
        let ends = array_mut("terminateSimulation", terminateSimulation, 1)?;
        fill(enter, [instance.completed_integrator_step()?.into()]);
        fill(ends, [fmi2False]);
        Ok(())
    };
    /// Sets the time, s.
    fn fmi2SetTime(time: f64) as SET_TIME |instance| instance.set_time(time);
    /// Sets the continuous states, all of them finite.
    fn fmi2SetContinuousStates(x: *const f64, nx: usize) as SET_CONTINUOUS_STATES |instance| {
        Refusal::unless_count("nx", nx, instance.count_states())?;
        instance.set_continuous_states(array("x", x, nx)?)
    };
    /// Derivatives of the continuous states by time.
    fn fmi2GetDerivatives(derivatives: *mut f64, nx: usize) as GET_CONTINUOUS |instance| {
        let (found, exist) = instance.state_derivatives()?;
        write("derivatives", derivatives, ("nx", nx), found)?;
        exist
    };
    /// The event indicators.
    fn fmi2GetEventIndicators(eventIndicators: *mut f64, ni: usize) as GET_CONTINUOUS |instance| {
        let (found, exist) = instance.event_indicators()?;
        write("eventIndicators", eventIndicators, ("ni", ni), found)?;
        exist
    };
    /// The continuous states.
    fn fmi2GetContinuousStates(x: *mut f64, nx: usize) as GET_CONTINUOUS |instance| {
        write("x", x, ("nx", nx), instance.continuous_states()?)
    };
    /// Orders of magnitude of the continuous states, positive and constant from initialization on.
    fn fmi2GetNominalsOfContinuousStates(x_nominal: *mut f64, nx: usize) as GET_NOMINALS |instance| {
        write("x_nominal", x_nominal, ("nx", nx), instance.nominals()?)
    };
}
