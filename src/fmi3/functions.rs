//! The exported functions, in groups. Each translates its arguments and calls the instance through the guard in `ffi`.

use crate::ffi::{self, Component, answer, array, array_mut, call, write};
use crate::fmi3::Fmi3;
use crate::fmi3::instantiate::no_scheduled_execution;
use crate::fmi3::types::*;
use crate::instance::{Call, Experiment, Handled, Instance, Phase, StepEnd};
use crate::variables::{Refusal, Type, ensure};

macro_rules! export {
    ($($functions:tt)*) => {
        ffi::export_by! { (Fmi3, instance: fmi3Instance => fmi3Status) $($functions)* }
    };
}

// Logging and phases.
export! {
    /// Switches logging on or off for the categories listed; for all if none is listed.
    fn fmi3SetDebugLogging(loggingOn: fmi3Boolean, nCategories: usize, categories: *const fmi3String)
    as SET_DEBUG_LOGGING |instance| {
        let categories = ffi::categories(array("categories", categories, nCategories)?)?;
        instance.log.switch(loggingOn != fmi3False, &categories);
        Ok(())
    };
    /// Enters Configuration Mode, in which the number of balls can be set.
    fn fmi3EnterConfigurationMode() as ENTER_CONFIGURATION_MODE |instance| instance.enter(Phase::ConfigurationMode);
    /// Leaves Configuration Mode.
    fn fmi3ExitConfigurationMode() as EXIT_CONFIGURATION_MODE |instance| instance.enter(Phase::Instantiated);
    /// Enters Initialization Mode. A tolerance can only tighten `solver.tolerance`; non-positive and non-finite values
    /// are ignored.
    fn fmi3EnterInitializationMode(
        toleranceDefined: fmi3Boolean, tolerance: f64, startTime: f64, stopTimeDefined: fmi3Boolean, stopTime: f64,
    ) as ENTER_INITIALIZATION_MODE |instance| {
        let stop = (stopTimeDefined != fmi3False).then_some(stopTime);
        let tolerance = (toleranceDefined != fmi3False).then_some(tolerance);
        instance.set_up(Experiment { start: startTime, stop, tolerance })?;
        instance.enter_initialization()
    };
    /// Starts the run, in Event Mode or, without event mode, in Step Mode.
    fn fmi3ExitInitializationMode() as EXIT_INITIALIZATION_MODE |instance| instance.exit_initialization();
    /// Enters Event Mode and activates the clocks of the first pending event.
    fn fmi3EnterEventMode() as ENTER_EVENTS |instance| instance.enter_event_mode();
    /// Ends the event of the active clocks. If another one is pending, its clocks are active now, and
    /// `discreteStatesNeedUpdate` asks the host to call again.
    fn fmi3UpdateDiscreteStates(
        discreteStatesNeedUpdate: *mut fmi3Boolean, terminateSimulation: *mut fmi3Boolean,
        nominalsOfContinuousStatesChanged: *mut fmi3Boolean, valuesOfContinuousStatesChanged: *mut fmi3Boolean,
        nextEventTimeDefined: *mut fmi3Boolean, nextEventTime: *mut f64,
    ) as NEXT_EVENT or {
        let changed = [nominalsOfContinuousStatesChanged, valuesOfContinuousStatesChanged];
        for flag in changed.into_iter().chain([discreteStatesNeedUpdate, nextEventTimeDefined]) {
            _ = answer("a flag", flag, fmi3False);
        }
        _ = answer("terminateSimulation", terminateSimulation, fmi3True);
        _ = answer("nextEventTime", nextEventTime, 0.0);
    } |instance| {
        let Handled { again, changed, next } = instance.update_discrete_states()?;
        answer("discreteStatesNeedUpdate", discreteStatesNeedUpdate, again.into())?;
        answer("terminateSimulation", terminateSimulation, fmi3False)?;
        answer("nominalsOfContinuousStatesChanged", nominalsOfContinuousStatesChanged, fmi3False)?;
        answer("valuesOfContinuousStatesChanged", valuesOfContinuousStatesChanged, changed.into())?;
        answer("nextEventTimeDefined", nextEventTimeDefined, next.is_some().into())?;
        answer("nextEventTime", nextEventTime, next.unwrap_or_default())
    };
    /// Ends the run; its last values can still be read.
    fn fmi3Terminate() as TERMINATE |instance| instance.enter(Phase::Terminated);
    /// Returns to the state after instantiation.
    fn fmi3Reset() as RESET |instance| { instance.reset(); Ok(()) };
}

ffi::export_states! {
    fmi3FMUState, u8:
    fmi3GetFMUState fmi3SetFMUState fmi3FreeFMUState
    fmi3SerializedFMUStateSize fmi3SerializeFMUState fmi3DeserializeFMUState
}

/// Error for a type that no variable has, if any is asked for.
fn refuse_type(asked: usize) -> Result<(), Refusal> {
    ensure(asked == 0, || Refusal::new("no variable is of this type"))
}

/// Exports getter and setter of a type that variables have: of all elements of the arrays asked for, in their order.
macro_rules! values {
    ($(
        $(#[$got:meta])* $get:ident
        $(#[$is_set:meta])* $set:ident($type:ty = $asked:ident) as $call:ident;
    )*) => {
        export! {$(
            $(#[$got])*
            fn $get(
                valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut $type, nValues: usize,
            ) as GET_ARRAYS |instance| {
                let references = array("valueReferences", valueReferences, nValueReferences)?;
                instance.get(Type::$asked, references, array_mut("values", values, nValues)?, |value| value as $type)
            };
            $(#[$is_set])*
            fn $set(
                valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const $type,
                nValues: usize,
            ) as $call |instance| {
                let references = array("valueReferences", valueReferences, nValueReferences)?;
                instance.set(Type::$asked, references, array("values", values, nValues)?, |value| value as f64)
            };
        )*}
    };
}

values! {
    /// Reads real variables.
    fmi3GetFloat64
    /// Sets real parameters, inputs and slopes: all, or none if any is refused.
    fmi3SetFloat64(f64 = Real) as SET;
    /// Reads counts, and `n`.
    fmi3GetUInt64
    /// Sets `n`, in Configuration Mode.
    fmi3SetUInt64(u64 = Integer) as SET_COUNTS;
    /// Reads enumerations.
    fmi3GetInt64
    /// Sets enumerations: all, or none if any is refused.
    fmi3SetInt64(i64 = Enumeration) as SET_DISCRETE;
    /// Reads truth values.
    fmi3GetBoolean
    /// No truth value can be set.
    fmi3SetBoolean(fmi3Boolean = Boolean) as SET_DISCRETE;
}

export! {
    /// Reads whether clocks are active.
    fn fmi3GetClock(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Clock,
    ) as GET_ARRAYS |instance| {
        let references = array("valueReferences", valueReferences, nValueReferences)?;
        let places = array_mut("values", values, nValueReferences)?;
        instance.get(Type::Clock, references, places, |value| value as fmi3Clock)
    };
    /// No clock can be set: all are outputs.
    fn fmi3SetClock(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Clock,
    ) as SET_DISCRETE |instance| {
        let references = array("valueReferences", valueReferences, nValueReferences)?;
        instance.set(Type::Clock, references, array("values", values, nValueReferences)?, f64::from)
    };
    /// Reads `log.pulses`. The bytes stay valid until the next call.
    fn fmi3GetBinary(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, valueSizes: *mut usize,
        values: *mut fmi3Binary, nValues: usize,
    ) as GET_ARRAYS |instance| {
        let references = array("valueReferences", valueReferences, nValueReferences)?;
        let (sizes, places) = (array_mut("valueSizes", valueSizes, nValues)?, array_mut("values", values, nValues)?);
        Refusal::unless_count("nValues", nValues, references.len())?;
        let bytes = instance.binary(references)?.as_bytes();
        for (size, place) in sizes.iter_mut().zip(places) {
            size.write(bytes.len());
            place.write(bytes.as_ptr());
        }
        Ok(())
    };
    /// No bytes can be set.
    fn fmi3SetBinary(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, _valueSizes: *const usize,
        values: *const fmi3Binary, nValues: usize,
    ) as SET_DISCRETE |instance| {
        let references = array("valueReferences", valueReferences, nValueReferences)?;
        instance.set(Type::Binary, references, array("values", values, nValues)?, |_| f64::NAN)
    };
}

/// Exports getter and setter of a type that no variable has.
macro_rules! no_such_type {
    ($($get:ident $set:ident $type:ty;)*) => {
        export! {$(
            /// There are no variables of this type.
            fn $get(
                _valueReferences: *const fmi3ValueReference, nValueReferences: usize, _values: *mut $type,
                _nValues: usize,
            ) as GET_ARRAYS |_| refuse_type(nValueReferences);
            /// There are no variables of this type.
            fn $set(
                _valueReferences: *const fmi3ValueReference, nValueReferences: usize, _values: *const $type,
                _nValues: usize,
            ) as SET_DISCRETE |_| refuse_type(nValueReferences);
        )*}
    };
}

no_such_type! {
    fmi3GetFloat32 fmi3SetFloat32 f32;
    fmi3GetInt8 fmi3SetInt8 i8;
    fmi3GetUInt8 fmi3SetUInt8 u8;
    fmi3GetInt16 fmi3SetInt16 i16;
    fmi3GetUInt16 fmi3SetUInt16 u16;
    fmi3GetInt32 fmi3SetInt32 i32;
    fmi3GetUInt32 fmi3SetUInt32 u32;
    fmi3GetString fmi3SetString fmi3String;
}

// Derivatives.
export! {
    /// Derivatives of the unknowns along the direction in which the knowns change by `seed`. In Initialization Mode the
    /// unknowns are real outputs and calculated parameters, the knowns real parameters and inputs; later they are
    /// outputs and inputs, as `derivatives.of` says.
    fn fmi3GetDirectionalDerivative(
        unknowns: *const fmi3ValueReference, nUnknowns: usize, knowns: *const fmi3ValueReference, nKnowns: usize,
        seed: *const f64, nSeed: usize, sensitivity: *mut f64, nSensitivity: usize,
    ) as DIRECTIONAL_DERIVATIVE |instance| {
        let (unknowns, knowns) = (array("unknowns", unknowns, nUnknowns)?, array("knowns", knowns, nKnowns)?);
        let found = instance.directional(unknowns, knowns, array("seed", seed, nSeed)?)?;
        write("sensitivity", sensitivity, ("nSensitivity", nSensitivity), found)
    };
    /// The derivatives of fmi3GetDirectionalDerivative, summed over the unknowns with the weights `seed`, for each
    /// known.
    fn fmi3GetAdjointDerivative(
        unknowns: *const fmi3ValueReference, nUnknowns: usize, knowns: *const fmi3ValueReference, nKnowns: usize,
        seed: *const f64, nSeed: usize, sensitivity: *mut f64, nSensitivity: usize,
    ) as DIRECTIONAL_DERIVATIVE |instance| {
        let (unknowns, knowns) = (array("unknowns", unknowns, nUnknowns)?, array("knowns", knowns, nKnowns)?);
        let found = instance.adjoint(unknowns, knowns, array("seed", seed, nSeed)?)?;
        write("sensitivity", sensitivity, ("nSensitivity", nSensitivity), found)
    };
    /// Time derivatives of real outputs, of order 1 to 3; 0 for variables that change only at events and communication
    /// points.
    fn fmi3GetOutputDerivatives(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, orders: *const i32, values: *mut f64,
        nValues: usize,
    ) as GET_OUTPUT_DERIVATIVES |instance| {
        let references = array("valueReferences", valueReferences, nValueReferences)?;
        let found = instance.output_derivatives(references, array("orders", orders, nValueReferences)?)?;
        write("values", values, ("nValues", nValues), found)
    };
    /// Not offered.
    fn fmi3GetNumberOfVariableDependencies(_valueReference: fmi3ValueReference, _nDependencies: *mut usize)
    as NOT_OFFERED |_| no_dependencies();
    /// Not offered.
    fn fmi3GetVariableDependencies(
        _dependent: fmi3ValueReference, _elementIndicesOfDependent: *mut usize, _independents: *mut fmi3ValueReference,
        _elementIndicesOfIndependents: *mut usize, _dependencyKinds: *mut fmi3DependencyKind, _nDependencies: usize,
    ) as NOT_OFFERED |_| no_dependencies();
}

fn no_dependencies() -> Result<(), Refusal> {
    Err(Refusal::new("dependencies of single elements are not offered; those of variables are in the description"))
}

/// Exports functions of clocks with intervals, legal for an empty list only.
macro_rules! intervals {
    ($(fn $name:ident($($argument:ident: $type:ty),*);)*) => {
        export! {$(
            /// There are no clocks with intervals.
            fn $name(
                _valueReferences: *const fmi3ValueReference, nValueReferences: usize, $($argument: $type),*
            ) as INTERVALS |_| match nValueReferences {
                0 => Ok(()),
                _ => Err(Refusal::new("no clock has an interval: they tick when contacts close and open")),
            };
        )*}
    };
}

intervals! {
    fn fmi3GetIntervalDecimal(_intervals: *mut f64, _qualifiers: *mut fmi3IntervalQualifier);
    fn fmi3GetIntervalFraction(
        _counters: *mut u64, _resolutions: *mut u64, _qualifiers: *mut fmi3IntervalQualifier
    );
    fn fmi3GetShiftDecimal(_shifts: *mut f64);
    fn fmi3GetShiftFraction(_counters: *mut u64, _resolutions: *mut u64);
    fn fmi3SetIntervalDecimal(_intervals: *const f64);
    fn fmi3SetIntervalFraction(_counters: *const u64, _resolutions: *const u64);
    fn fmi3SetShiftDecimal(_shifts: *const f64);
    fn fmi3SetShiftFraction(_counters: *const u64, _resolutions: *const u64);
}

export! {
    /// Not offered.
    fn fmi3ActivateModelPartition(_clockReference: fmi3ValueReference, _activationTime: f64)
    as NOT_OFFERED |_| Err(no_scheduled_execution());
    /// Does nothing, as the standard requires where `providesEvaluateDiscreteStates` is false.
    fn fmi3EvaluateDiscreteStates() as NEXT_EVENT |_| Ok(());
}

// Co-simulation.
export! {
    /// Returns from Event Mode to Step Mode.
    fn fmi3EnterStepMode() as ENTER_STEP_MODE |instance| instance.enter(Phase::StepMode);
}

/// Steps from `currentCommunicationPoint` by `communicationStepSize` > 0, in s. With event mode and early return, the
/// step ends at the first onset or release; with `intermediateUpdate`, the host is called at each of them.
///
/// # Safety
/// See the [module](crate::fmi3).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: fmi3Instance,
    currentCommunicationPoint: f64,
    communicationStepSize: f64,
    _noSetFMUStatePriorToCurrentPoint: fmi3Boolean,
    eventHandlingNeeded: *mut fmi3Boolean,
    terminateSimulation: *mut fmi3Boolean,
    earlyReturn: *mut fmi3Boolean,
    lastSuccessfulTime: *mut f64,
) -> fmi3Status {
    let answers = |events: bool, terminate: fmi3Boolean, early: bool, time: f64| {
        // SAFETY: the host's promises, here and below.
        unsafe {
            answer("eventHandlingNeeded", eventHandlingNeeded, events.into())?;
            answer("terminateSimulation", terminateSimulation, terminate)?;
            answer("earlyReturn", earlyReturn, early.into())?;
            answer("lastSuccessfulTime", lastSuccessfulTime, time)
        }
    };
    let mut end: Option<StepEnd> = None;
    let mut part = |legal: Call, body: &dyn Fn(&mut Instance) -> Result<StepEnd, Refusal>| {
        // The answers of a refused call, see `export_by`.
        _ = answers(false, fmi3True, false, end.map_or(currentCommunicationPoint, |end| end.time));
        let status = unsafe {
            call::<Fmi3>(instance, "fmi3DoStep", legal, &mut |instance| {
                _ = answer("lastSuccessfulTime", lastSuccessfulTime, instance.time());
                let StepEnd { time, early, events, .. } = *end.insert(body(instance)?);
                answers(events, fmi3False, early, time)
            })
        };
        (status, end.filter(|end| end.interrupted))
    };
    let calls = unsafe { Component::call_host(instance, |callbacks: &Fmi3| callbacks.update.is_some()) };
    let calls = calls.unwrap_or(false);
    let (mut status, mut interrupted) =
        part(Call::DO_STEP, &|instance| instance.step(currentCommunicationPoint, communicationStepSize, calls));
    while let (fmi3Status::fmi3OK, Some(StepEnd { time, .. })) = (status, interrupted) {
        let end = unsafe { Component::call_host(instance, |callbacks: &Fmi3| callbacks.update(time)) }.flatten();
        (status, interrupted) = part(Call::CONTINUE_STEP, &|instance| instance.continue_step(end));
    }
    status
}

// Model exchange. Its events are handled like those of co-simulation with event mode.
export! {
    /// Enters Continuous-Time Mode.
    fn fmi3EnterContinuousTimeMode() as ENTER_CONTINUOUS_TIME_MODE |instance| instance.enter(Phase::ContinuousTimeMode);
    /// Ends a step of the host's solver; asks for Event Mode where an indicator has changed its sign. Never ends a run.
    fn fmi3CompletedIntegratorStep(
        _noSetFMUStatePriorToCurrentPoint: fmi3Boolean, enterEventMode: *mut fmi3Boolean,
        terminateSimulation: *mut fmi3Boolean,
    ) as COMPLETED_INTEGRATOR_STEP or {
        _ = answer("enterEventMode", enterEventMode, fmi3False);
        _ = answer("terminateSimulation", terminateSimulation, fmi3True);
    } |instance| {
        let enter = instance.completed_integrator_step()?;
        answer("enterEventMode", enterEventMode, enter.into())?;
        answer("terminateSimulation", terminateSimulation, fmi3False)
    };
    /// Sets the time, s, at least that of the last event.
    fn fmi3SetTime(time: f64) as SET_TIME_OF_EXCHANGE |instance| instance.set_time(time);
    /// Sets the continuous states, all of them finite: the elements of `q`, `v`, `impulse`, `E_dissipated` and
    /// `W_external`.
    fn fmi3SetContinuousStates(
        continuousStates: *const f64, nContinuousStates: usize,
    ) as SET_CONTINUOUS_STATES |instance| {
        Refusal::unless_count("nContinuousStates", nContinuousStates, instance.count_states())?;
        instance.set_continuous_states(array("continuousStates", continuousStates, nContinuousStates)?)
    };
    /// Derivatives of the continuous states by time.
    fn fmi3GetContinuousStateDerivatives(derivatives: *mut f64, nContinuousStates: usize) as GET_CONTINUOUS |instance| {
        let (found, exist) = instance.state_derivatives()?;
        write("derivatives", derivatives, ("nContinuousStates", nContinuousStates), found)?;
        exist
    };
    /// The event indicators: the elements of `z.contact` and `z.clip`.
    fn fmi3GetEventIndicators(eventIndicators: *mut f64, nEventIndicators: usize) as GET_CONTINUOUS |instance| {
        let (found, exist) = instance.event_indicators()?;
        write("eventIndicators", eventIndicators, ("nEventIndicators", nEventIndicators), found)?;
        exist
    };
    /// The continuous states.
    fn fmi3GetContinuousStates(continuousStates: *mut f64, nContinuousStates: usize) as GET_CONTINUOUS |instance| {
        let states = instance.continuous_states()?;
        write("continuousStates", continuousStates, ("nContinuousStates", nContinuousStates), states)
    };
    /// Orders of magnitude of the continuous states, positive and constant from initialization on.
    fn fmi3GetNominalsOfContinuousStates(nominals: *mut f64, nContinuousStates: usize) as GET_NOMINALS |instance| {
        write("nominals", nominals, ("nContinuousStates", nContinuousStates), instance.nominals()?)
    };
    /// Number of event indicators, 2 n; 2 n - 2 where variables are scalars.
    fn fmi3GetNumberOfEventIndicators(nEventIndicators: *mut usize) as COUNT_CONTINUOUS |instance| {
        answer("nEventIndicators", nEventIndicators, instance.count_indicators())
    };
    /// Number of continuous states, 3 n + 2; 3 n + 1 where variables are scalars.
    fn fmi3GetNumberOfContinuousStates(nContinuousStates: *mut usize) as COUNT_CONTINUOUS |instance| {
        answer("nContinuousStates", nContinuousStates, instance.count_states())
    };
}
