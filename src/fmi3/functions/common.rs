//! Logging, phases and saved states.

use crate::ffi::{self, answer, array, categories as known_categories};
use crate::fmi3::types::*;
use crate::instance::{Experiment, Handled, Phase};

export! {
    /// Switches logging on or off for the categories listed, for all if none is listed.
    fn fmi3SetDebugLogging(loggingOn: fmi3Boolean, nCategories: usize, categories: *const fmi3String)
    as SET_DEBUG_LOGGING |instance| {
        let categories = known_categories(array("categories", categories, nCategories)?)?;
        instance.log.switch(loggingOn != fmi3False, &categories);
        Ok(())
    };
    /// Enters Configuration Mode, in which the number of balls can be set.
    fn fmi3EnterConfigurationMode() as ENTER_CONFIGURATION_MODE |instance| instance.enter(Phase::ConfigurationMode);
    /// Leaves it.
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
    ) as NEXT_EVENT |instance| {
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
