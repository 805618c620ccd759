//! Functions of co-simulation: stepping, and asking about the last step.

use crate::ffi;
use crate::fmi2::types::*;
use crate::variables::Refusal;

export! {
    /// Steps from `currentCommunicationPoint` by `communicationStepSize` > 0, in s. Never answers fmi2Discard or
    /// fmi2Warning, at which hosts loop or stop.
    fn fmi2DoStep(
        currentCommunicationPoint: fmi2Real, communicationStepSize: fmi2Real,
        _noSetFMUStatePriorToCurrentPoint: fmi2Boolean
    ) as DoStep |instance| {
        instance.step(currentCommunicationPoint, communicationStepSize, false).map(|_| ())
    };
    /// Steps are synchronous: there is never one to cancel.
    fn fmi2CancelStep() as CancelStep |_| Ok(());
    /// fmi2DoStepStatus: steps are synchronous, and a failed one leaves the error state in which this cannot be asked.
    fn fmi2GetStatus(s: fmi2StatusKind, value: *mut fmi2Status) as Status |_| {
        answer((fmi2DoStepStatus, "fmi2DoStepStatus"), s, value, fmi2Status::fmi2OK)
    };
    /// fmi2LastSuccessfulTime: the time that the last step reached, s.
    fn fmi2GetRealStatus(s: fmi2StatusKind, value: *mut fmi2Real) as Status |instance| {
        answer((fmi2LastSuccessfulTime, "fmi2LastSuccessfulTime"), s, value, instance.time())
    };
    /// The standard defines no status that is an integer.
    fn fmi2GetIntegerStatus(_s: fmi2StatusKind, _value: *mut fmi2Integer) as Status |_| {
        Err(Refusal::new("no status is an integer"))
    };
    /// fmi2Terminated: the FMU never ends a run by itself.
    fn fmi2GetBooleanStatus(s: fmi2StatusKind, value: *mut fmi2Boolean) as Status |_| {
        answer((fmi2Terminated, "fmi2Terminated"), s, value, fmi2False)
    };
    /// fmi2PendingStatus: nothing is ever pending.
    fn fmi2GetStringStatus(s: fmi2StatusKind, value: *mut fmi2String) as Status |_| {
        answer((fmi2PendingStatus, "fmi2PendingStatus"), s, value, c"".as_ptr())
    };
}

/// Answers the `allowed` question about the last step, given with its name in the standard, if `kind` is that one.
///
/// # Safety
/// As for [`ffi::answer()`].
unsafe fn answer<T>(
    allowed: (fmi2StatusKind, &str),
    kind: fmi2StatusKind,
    place: *mut T,
    value: T,
) -> Result<(), Refusal> {
    if kind != allowed.0 {
        return Err(Refusal::argument("fmi2StatusKind", kind, format_args!("{} ({})", allowed.1, allowed.0)));
    }
    // SAFETY: as the caller promises.
    unsafe { ffi::answer("value", place, value) }
}
