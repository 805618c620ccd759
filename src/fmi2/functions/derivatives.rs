//! Derivatives of inputs and outputs by time, and directional derivatives.

use std::mem::MaybeUninit;

use crate::fmi2::boundary::{array, array_mut, call};
use crate::fmi2::types::*;
use crate::instance::Call;

/// Gives derivatives of real inputs by time, of order 1 to 3, for the next fmi2DoStep: all of them, or none if any is
/// refused. After that step the inputs keep the values they reached.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    order: *const fmi2Integer,
    value: *const fmi2Real,
) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe {
        call(c, "fmi2SetRealInputDerivatives", Call::SetInputDerivatives, |instance| {
            let (references, orders) = (array("vr", vr, nvr)?, array("order", order, nvr)?);
            instance.set_input_derivatives(references, orders, array("value", value, nvr)?)
        })
    }
}

/// Derivatives of real outputs by time, of order 1 to 3: 0 for what changes only at events and communication points.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    order: *const fmi2Integer,
    value: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe {
        call(c, "fmi2GetRealOutputDerivatives", Call::GetOutputDerivatives, |instance| {
            let (references, orders) = (array("vr", vr, nvr)?, array("order", order, nvr)?);
            let places = array_mut("value", value, nvr)?;
            fill(places, instance.output_derivatives(references, orders)?);
            Ok(())
        })
    }
}

/// Derivatives of the unknowns along the direction in which the knowns change by `dvKnown`. In Initialization Mode the unknowns are
/// real outputs and calculated parameters, the knowns real parameters and inputs; later, the real outputs at the end of the last
/// step, and the inputs that were held over it.
///
/// # Safety
/// See the [module](crate::fmi2).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: fmi2Component,
    vUnknown_ref: *const fmi2ValueReference,
    nUnknown: usize,
    vKnown_ref: *const fmi2ValueReference,
    nKnown: usize,
    dvKnown: *const fmi2Real,
    dvUnknown: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe {
        call(c, "fmi2GetDirectionalDerivative", Call::DirectionalDerivative, |instance| {
            let unknowns = array("vUnknown_ref", vUnknown_ref, nUnknown)?;
            let (knowns, direction) = (array("vKnown_ref", vKnown_ref, nKnown)?, array("dvKnown", dvKnown, nKnown)?);
            let places = array_mut("dvUnknown", dvUnknown, nUnknown)?;
            fill(places, instance.directional_derivatives(unknowns, knowns, direction)?);
            Ok(())
        })
    }
}

fn fill(places: &mut [MaybeUninit<fmi2Real>], values: Vec<f64>) {
    places.iter_mut().zip(values).for_each(|(place, value)| *place = MaybeUninit::new(value));
}
