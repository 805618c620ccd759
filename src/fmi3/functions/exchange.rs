//! Functions of model exchange. Events are those of co-simulation with event mode.

use crate::ffi::{answer, array, write};
use crate::fmi3::types::*;
use crate::instance::Phase;
use crate::variables::Refusal;

export! {
    /// Enters Continuous-Time Mode.
    fn fmi3EnterContinuousTimeMode() as ENTER_CONTINUOUS_TIME_MODE |instance| instance.enter(Phase::ContinuousTimeMode);
    /// Ends a step of the host's solver; asks for Event Mode where an indicator has changed its sign. Never ends a run.
    fn fmi3CompletedIntegratorStep(
        _noSetFMUStatePriorToCurrentPoint: fmi3Boolean, enterEventMode: *mut fmi3Boolean,
        terminateSimulation: *mut fmi3Boolean,
    ) as COMPLETED_INTEGRATOR_STEP |instance| {
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
        write("derivatives", derivatives, ("nContinuousStates", nContinuousStates), instance.state_derivatives()?)
    };
    /// The event indicators: the elements of `z.contact` and `z.clip`.
    fn fmi3GetEventIndicators(eventIndicators: *mut f64, nEventIndicators: usize) as GET_CONTINUOUS |instance| {
        write("eventIndicators", eventIndicators, ("nEventIndicators", nEventIndicators), instance.event_indicators()?)
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
