//! Derivatives of inputs and outputs.

use super::border::{array, call};
use super::types::{fmi2Component, fmi2Integer, fmi2Real, fmi2Status, fmi2ValueReference};
use crate::instance::Call;

/// Gives derivatives of real inputs by time, of order 1 to 3, for the next fmi2DoStep: all of them, or none if any is
/// refused. After that step the inputs keep the values they reached.
///
/// # Safety
/// See the [module](super).
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
