//! Getting and setting values.

use std::mem::MaybeUninit;

use crate::fmi2::boundary::{array, array_mut, call};
use crate::fmi2::types::{
    fmi2Boolean, fmi2Component, fmi2Integer, fmi2Real, fmi2Status, fmi2String, fmi2ValueReference,
};
use crate::instance::{Call, Instance, Refusal};
use crate::variables::Type;

/// Fills `value` with what `get` finds for each of `vr`.
///
/// # Safety
/// See the [module](crate::fmi2).
#[inline]
unsafe fn get<T>(
    c: fmi2Component,
    function: &'static str,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut T,
    get: impl Fn(&mut Instance, fmi2ValueReference) -> Result<T, Refusal>,
) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe {
        call(c, function, Call::Get, |instance| {
            let (references, values) = (array("vr", vr, nvr)?, array_mut("value", value, nvr)?);
            for (reference, value) in references.iter().zip(values) {
                MaybeUninit::write(value, get(instance, *reference)?);
            }
            Ok(())
        })
    }
}

/// Hands `vr` and `value` to `set`, which applies all of them or none.
///
/// # Safety
/// See the [module](crate::fmi2).
unsafe fn set<T>(
    c: fmi2Component,
    function: &'static str,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const T,
    set: impl Fn(&mut Instance, &[fmi2ValueReference], &[T]) -> Result<(), Refusal>,
) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe {
        call(c, function, Call::Set, |instance| set(instance, array("vr", vr, nvr)?, array("value", value, nvr)?))
    }
}

/// Reads real variables.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe { get(c, "fmi2GetReal", vr, nvr, value, Instance::real) }
}

/// Reads integers and enumerations.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Integer,
) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe { get(c, "fmi2GetInteger", vr, nvr, value, Instance::integer) }
}

/// Reads booleans.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    let read = |instance: &mut Instance, reference| instance.boolean(reference).map(fmi2Boolean::from);
    // SAFETY: the host's promises, see the module.
    unsafe { get(c, "fmi2GetBoolean", vr, nvr, value, read) }
}

/// There are no strings: an error unless nothing is asked for.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetString(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2String,
) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe { get(c, "fmi2GetString", vr, nvr, value, |instance, reference| Err(instance.refuse_string(reference))) }
}

/// Sets real parameters and inputs: all of them, or none if any is refused.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Real,
) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe { set(c, "fmi2SetReal", vr, nvr, value, Instance::set_reals) }
}

/// Sets enumerations: all of them, or none if any is refused.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Integer,
) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe { set(c, "fmi2SetInteger", vr, nvr, value, Instance::set_integers) }
}

/// No boolean can be set: an error unless nothing is set.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Boolean,
) -> fmi2Status {
    let refuse = |instance: &mut Instance, references: &[_], _: &[_]| instance.refuse_to_set(references, Type::Boolean);
    // SAFETY: the host's promises, see the module.
    unsafe { set(c, "fmi2SetBoolean", vr, nvr, value, refuse) }
}

/// There are no strings: an error unless nothing is set.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetString(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2String,
) -> fmi2Status {
    let refuse = |instance: &mut Instance, references: &[_], _: &[_]| instance.refuse_to_set(references, Type::String);
    // SAFETY: the host's promises, see the module.
    unsafe { set(c, "fmi2SetString", vr, nvr, value, refuse) }
}
