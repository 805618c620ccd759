//! Functions of co-simulation: steps, and the return from Event Mode.

use crate::ffi::{Component, answer, call};
use crate::fmi3::Fmi3;
use crate::fmi3::types::*;
use crate::instance::{Call, Instance, Phase, StepEnd};
use crate::variables::Refusal;

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
    let mut end: Option<StepEnd> = None;
    let mut part = |legal: Call, body: &dyn Fn(&mut Instance) -> Result<StepEnd, Refusal>| {
        let end = &mut end;
        // SAFETY: the host's promises, here and below.
        let status = unsafe {
            call::<Fmi3>(instance, "fmi3DoStep", legal, &mut |instance| {
                let reached = body(instance)?;
                *end = Some(reached);
                answer("eventHandlingNeeded", eventHandlingNeeded, reached.events.into())?;
                answer("terminateSimulation", terminateSimulation, fmi3False)?;
                answer("earlyReturn", earlyReturn, reached.early.into())?;
                answer("lastSuccessfulTime", lastSuccessfulTime, reached.time)
            })
        };
        (status, end.filter(|end| end.interrupted))
    };
    let calls = unsafe { Component::call_host(instance, |callbacks: &Fmi3| callbacks.update.is_some()) };
    let calls = calls.unwrap_or(false);
    let (mut status, mut interrupted) =
        part(Call::DO_STEP, &|instance| instance.step(currentCommunicationPoint, communicationStepSize, calls));
    while let (fmi3Status::fmi3OK, Some(StepEnd { time, .. })) = (status, interrupted) {
        let end = unsafe { Component::call_host(instance, |callbacks| update(callbacks, time)) }.flatten();
        (status, interrupted) = part(Call::CONTINUE_STEP, &|instance| instance.continue_step(end));
    }
    status
}

/// Calls the host within a step, at `time` (s). Returns the time at which it wants the step to end early.
///
/// # Safety
/// The host's callback may be called with its environment.
unsafe fn update(callbacks: &Fmi3, time: f64) -> Option<f64> {
    let (mut requested, mut end) = (fmi3False, time);
    let may_end = callbacks.may_end_early.into();
    // SAFETY: as the caller promises; the places live until it returns.
    unsafe {
        callbacks.update?(callbacks.environment, time, fmi3True, fmi3True, fmi3True, may_end, &mut requested, &mut end)
    };
    (callbacks.may_end_early && requested != fmi3False && !end.is_nan()).then_some(end)
}
