//! Functions of model exchange: events, and what a host needs to integrate.

use crate::ffi::{answer, array, array_mut, fill, write};
use crate::fmi2::types::*;
use crate::instance::{Handled, Phase};
use crate::variables::Refusal;

export! {
    /// Enters Event Mode.
    fn fmi2EnterEventMode() as ENTER_EVENT_MODE |instance| instance.enter_event_mode();
    /// Handles all that is due: contacts close, open, or are followed to their end, as `exchange.contacts` selects.
    fn fmi2NewDiscreteStates(eventInfo: *mut fmi2EventInfo) as NEW_DISCRETE_STATES |instance| {
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
    ) as COMPLETED_INTEGRATOR_STEP |instance| {
        let enter = array_mut("enterEventMode", enterEventMode, 1)?;
        answer("terminateSimulation", terminateSimulation, fmi2False)?;
        fill(enter, [instance.completed_integrator_step()?.into()]);
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
        write("derivatives", derivatives, ("nx", nx), instance.state_derivatives()?)
    };
    /// The event indicators.
    fn fmi2GetEventIndicators(eventIndicators: *mut f64, ni: usize) as GET_CONTINUOUS |instance| {
        write("eventIndicators", eventIndicators, ("ni", ni), instance.event_indicators()?)
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
