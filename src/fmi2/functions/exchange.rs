//! Functions of model exchange: events, and what a host needs to integrate.

use crate::engine::Update;
use crate::ffi::{array, array_mut, fill};
use crate::fmi2::types::*;
use crate::instance::Refusal;

export! {
    /// Enters Event Mode.
    fn fmi2EnterEventMode() as EnterEventMode |instance| instance.enter_event_mode();
    /// Handles all that is due: contacts close and open, and are followed to their end, as `exchange.contacts` says. An
    /// event with nothing due changes nothing.
    fn fmi2NewDiscreteStates(eventInfo: *mut fmi2EventInfo) as NewDiscreteStates |instance| {
        let [place] = array_mut("eventInfo", eventInfo, 1)? else { return Ok(()) };
        let Update { changed, next } = instance.new_discrete_states()?;
        place.write(fmi2EventInfo {
            newDiscreteStatesNeeded: fmi2False,
            terminateSimulation: fmi2False,
            nominalsOfContinuousStatesChanged: fmi2False,
            valuesOfContinuousStatesChanged: changed.into(),
            nextEventTimeDefined: next.is_some().into(),
            nextEventTime: next.unwrap_or_default(),
        });
        Ok(())
    };
    /// Enters Continuous-Time Mode.
    fn fmi2EnterContinuousTimeMode() as EnterContinuousTimeMode |instance| instance.enter_continuous_time_mode();
    /// The end of a step of the host's solver; asks for Event Mode where an indicator has changed its sign. Never ends
    /// a run.
    fn fmi2CompletedIntegratorStep(
        _noSetFMUStatePriorToCurrentPoint: fmi2Boolean, enterEventMode: *mut fmi2Boolean, terminateSimulation: *mut fmi2Boolean
    ) as CompletedIntegratorStep |instance| {
        let (enter, terminate) = (answer("enterEventMode", enterEventMode)?, answer("terminateSimulation", terminateSimulation)?);
        *enter = instance.completed_integrator_step()?.into();
        *terminate = fmi2False;
        Ok(())
    };
    /// Sets the time, s.
    fn fmi2SetTime(time: fmi2Real) as SetTime |instance| instance.set_time(time);
    /// Sets the continuous states, all of them finite.
    fn fmi2SetContinuousStates(x: *const fmi2Real, nx: usize) as SetContinuousStates |instance| {
        instance.set_continuous_states(array("x", x, nx)?)
    };
    /// Derivatives of the continuous states by time.
    fn fmi2GetDerivatives(derivatives: *mut fmi2Real, nx: usize) as GetContinuous |instance| {
        let places = array_mut("derivatives", derivatives, nx)?;
        fill(places, instance.state_derivatives(nx)?);
        Ok(())
    };
    /// The event indicators.
    fn fmi2GetEventIndicators(eventIndicators: *mut fmi2Real, ni: usize) as GetContinuous |instance| {
        let places = array_mut("eventIndicators", eventIndicators, ni)?;
        fill(places, instance.event_indicators(ni)?);
        Ok(())
    };
    /// The continuous states.
    fn fmi2GetContinuousStates(x: *mut fmi2Real, nx: usize) as GetContinuous |instance| {
        let places = array_mut("x", x, nx)?;
        fill(places, instance.continuous_states(nx)?);
        Ok(())
    };
    /// Orders of magnitude of the continuous states, positive and constant from initialization on.
    fn fmi2GetNominalsOfContinuousStates(x_nominal: *mut fmi2Real, nx: usize) as GetNominals |instance| {
        let places = array_mut("x_nominal", x_nominal, nx)?;
        fill(places, instance.nominals(nx)?);
        Ok(())
    };
}

/// The place of one answer.
///
/// # Safety
/// As for [`array_mut()`].
unsafe fn answer<'a>(name: &'static str, place: *mut fmi2Boolean) -> Result<&'a mut fmi2Boolean, Refusal> {
    // SAFETY: as the caller promises; nothing is read before it is written.
    match unsafe { array_mut(name, place, 1) }? {
        [place] => Ok(place.write(fmi2False)),
        _ => Err(Refusal::Missing("there is no place for the answer")),
    }
}
