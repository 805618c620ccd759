//! Functions of optional capabilities that the description declares as absent. They exist because hosts look them up
//! whether they use them or not, and answer fmi2Error.

use super::border::call;
use super::types::{fmi2Byte, fmi2Component, fmi2FMUstate, fmi2Integer, fmi2Real, fmi2Status, fmi2ValueReference};
use crate::instance::{Call, Refusal};

/// # Safety
/// See the [module](super).
unsafe fn refuse(c: fmi2Component, function: &'static str, kind: Call, capability: &'static str) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe { call(c, function, kind, |_| Err(Refusal::Unsupported(capability))) }
}

const STATE: &str = "not supported: canGetAndSetFMUstate is false";
const SERIALIZE: &str = "not supported: canSerializeFMUstate is false";

/// Not supported.
///
/// # Safety
/// See the [module](super).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: fmi2Component, _FMUstate: *mut fmi2FMUstate) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe { refuse(c, "fmi2GetFMUstate", Call::State, STATE) }
}

/// Not supported.
///
/// # Safety
/// See the [module](super).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: fmi2Component, _FMUstate: fmi2FMUstate) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe { refuse(c, "fmi2SetFMUstate", Call::State, STATE) }
}

/// Nothing to free: fine for no state, as the standard asks, and an error for any other.
///
/// # Safety
/// See the [module](super).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: fmi2Component, FMUstate: *mut fmi2FMUstate) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe {
        call(c, "fmi2FreeFMUstate", Call::State, |_| {
            let none = FMUstate.is_null() || (FMUstate.is_aligned() && (*FMUstate).is_null());
            if none { Ok(()) } else { Err(Refusal::Unsupported(STATE)) }
        })
    }
}

/// Not supported.
///
/// # Safety
/// See the [module](super).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(
    c: fmi2Component,
    _FMUstate: fmi2FMUstate,
    _size: *mut usize,
) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe { refuse(c, "fmi2SerializedFMUstateSize", Call::State, SERIALIZE) }
}

/// Not supported.
///
/// # Safety
/// See the [module](super).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    c: fmi2Component,
    _FMUstate: fmi2FMUstate,
    _serializedState: *mut fmi2Byte,
    _size: usize,
) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe { refuse(c, "fmi2SerializeFMUstate", Call::State, SERIALIZE) }
}

/// Not supported.
///
/// # Safety
/// See the [module](super).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: fmi2Component,
    _serializedState: *const fmi2Byte,
    _size: usize,
    _FMUstate: *mut fmi2FMUstate,
) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe { refuse(c, "fmi2DeSerializeFMUstate", Call::State, SERIALIZE) }
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
