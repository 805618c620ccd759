//! Functions of optional capabilities that the description declares as absent. They exist because hosts look them up
//! whether they use them or not, and answer fmi2Error.

use super::border::call;
use super::types::{fmi2Component, fmi2Integer, fmi2Real, fmi2Status, fmi2ValueReference};
use crate::instance::{Call, Refusal};

/// # Safety
/// See the [module](super).
unsafe fn refuse(c: fmi2Component, function: &'static str, kind: Call, capability: &'static str) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe { call(c, function, kind, |_| Err(Refusal::Unsupported(capability))) }
}

/// Not supported.
///
/// # Safety
/// See the [module](super).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: fmi2Component,
    _vUnknown_ref: *const fmi2ValueReference,
    _nUnknown: usize,
    _vKnown_ref: *const fmi2ValueReference,
    _nKnown: usize,
    _dvKnown: *const fmi2Real,
    _dvUnknown: *mut fmi2Real,
) -> fmi2Status {
    let capability = "not supported: providesDirectionalDerivative is false";
    // SAFETY: the host's promises, see the module.
    unsafe { refuse(c, "fmi2GetDirectionalDerivative", Call::DirectionalDerivative, capability) }
}

/// Not supported.
///
/// # Safety
/// See the [module](super).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    c: fmi2Component,
    _vr: *const fmi2ValueReference,
    _nvr: usize,
    _order: *const fmi2Integer,
    _value: *mut fmi2Real,
) -> fmi2Status {
    let capability = "not supported: maxOutputDerivativeOrder is 0";
    // SAFETY: the host's promises, see the module.
    unsafe { refuse(c, "fmi2GetRealOutputDerivatives", Call::GetOutputDerivatives, capability) }
}
