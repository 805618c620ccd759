//! Functions of co-simulation: stepping, and asking about the last step.

use crate::fmi2::boundary::{array_mut, call};
use crate::fmi2::types::*;
use crate::instance::{Call, Instance, Refusal};

/// Steps from `currentCommunicationPoint` by `communicationStepSize` > 0, in s. Never answers fmi2Discard or
/// fmi2Warning, at which hosts loop or stop.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    c: fmi2Component,
    currentCommunicationPoint: fmi2Real,
    communicationStepSize: fmi2Real,
    _noSetFMUStatePriorToCurrentPoint: fmi2Boolean,
) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe {
        call(c, "fmi2DoStep", Call::DoStep, |instance| instance.step(currentCommunicationPoint, communicationStepSize))
    }
}

/// Steps are synchronous: there is never one to cancel.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(c: fmi2Component) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe { call(c, "fmi2CancelStep", Call::CancelStep, |_| Ok(())) }
}

/// Answers the question about the last step that is `allowed`, given with its name in the standard, if `kind` asks it.
///
/// # Safety
/// See the [module](crate::fmi2).
unsafe fn status<T>(
    c: fmi2Component,
    function: &'static str,
    allowed: (fmi2StatusKind, &str),
    kind: fmi2StatusKind,
    value: *mut T,
    answer: impl Fn(&Instance) -> T,
) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe {
        call(c, function, Call::Status, |instance| {
            if kind != allowed.0 {
                let allowed = format!("{} ({})", allowed.1, allowed.0);
                return Err(Refusal::Argument { name: "fmi2StatusKind", value: kind.to_string(), allowed });
            }
            for place in array_mut("value", value, 1)? {
                place.write(answer(instance));
            }
            Ok(())
        })
    }
}

/// fmi2DoStepStatus: steps are synchronous, and a failed one leaves the error state in which this cannot be asked.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2Status) -> fmi2Status {
    let allowed = (fmi2DoStepStatus, "fmi2DoStepStatus");
    // SAFETY: the host's promises, see the module.
    unsafe { status(c, "fmi2GetStatus", allowed, s, value, |_| fmi2Status::fmi2OK) }
}

/// fmi2LastSuccessfulTime: the time that the last step reached, s.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2Real) -> fmi2Status {
    let allowed = (fmi2LastSuccessfulTime, "fmi2LastSuccessfulTime");
    // SAFETY: the host's promises, see the module.
    unsafe { status(c, "fmi2GetRealStatus", allowed, s, value, Instance::time) }
}

/// The standard defines no status that is an integer.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(
    c: fmi2Component,
    _s: fmi2StatusKind,
    _value: *mut fmi2Integer,
) -> fmi2Status {
    let none = "no status is an integer";
    // SAFETY: the host's promises, see the module.
    unsafe { call(c, "fmi2GetIntegerStatus", Call::Status, |_| Err(Refusal::Unsupported(none))) }
}

/// fmi2Terminated: the FMU never ends a run by itself.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(
    c: fmi2Component,
    s: fmi2StatusKind,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    let allowed = (fmi2Terminated, "fmi2Terminated");
    // SAFETY: the host's promises, see the module.
    unsafe { status(c, "fmi2GetBooleanStatus", allowed, s, value, |_| fmi2False) }
}

/// fmi2PendingStatus: nothing is ever pending.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(
    c: fmi2Component,
    s: fmi2StatusKind,
    value: *mut fmi2String,
) -> fmi2Status {
    let allowed = (fmi2PendingStatus, "fmi2PendingStatus");
    // SAFETY: the host's promises, see the module.
    unsafe { status(c, "fmi2GetStringStatus", allowed, s, value, |_| c"".as_ptr()) }
}
