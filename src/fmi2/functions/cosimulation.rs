//! Functions of co-simulation: stepping, and asking about the last step.

use crate::ffi::answer;
use crate::fmi2::types::*;
use crate::variables::Refusal;

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
    fn fmi2GetStatus(s: fmi2StatusKind, value: *mut fmi2Status) as STATUS |_| {
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
    fn fmi2GetBooleanStatus(s: fmi2StatusKind, value: *mut fmi2Boolean) as STATUS |_| {
        check(s, fmi2Terminated, "fmi2Terminated")?;
        answer("value", value, fmi2False)
    };
    /// fmi2PendingStatus: nothing is ever pending.
    fn fmi2GetStringStatus(s: fmi2StatusKind, value: *mut fmi2String) as STATUS |_| {
        check(s, fmi2PendingStatus, "fmi2PendingStatus")?;
        answer("value", value, c"".as_ptr())
    };
}

/// Refuses any other question about the last step than the `allowed` one, of this name in the standard.
fn check(asked: fmi2StatusKind, allowed: fmi2StatusKind, name: &str) -> Result<(), Refusal> {
    if asked == allowed {
        return Ok(());
    }
    Err(Refusal::argument("fmi2StatusKind", asked, format_args!("{name} ({allowed})")))
}
