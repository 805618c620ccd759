//! Derivatives of inputs and outputs by time, and directional derivatives.

use crate::ffi::{array, write};
use crate::fmi2::types::*;

export! {
    /// Gives derivatives of real inputs by time, of order 1 to 3, for the next fmi2DoStep: all of them, or none if any
    /// is refused. After that step the inputs keep the values they reached.
    fn fmi2SetRealInputDerivatives(
        vr: *const fmi2ValueReference, nvr: usize, order: *const fmi2Integer, value: *const fmi2Real
    ) as SetInputDerivatives |instance| {
        let (references, orders) = (array("vr", vr, nvr)?, array("order", order, nvr)?);
        instance.set_input_derivatives(references, orders, array("value", value, nvr)?)
    };
    /// Derivatives of real outputs by time, of order 1 to 3: 0 for what changes only at events and communication
    /// points.
    fn fmi2GetRealOutputDerivatives(
        vr: *const fmi2ValueReference, nvr: usize, order: *const fmi2Integer, value: *mut fmi2Real
    ) as GetOutputDerivatives |instance| {
        let (references, orders) = (array("vr", vr, nvr)?, array("order", order, nvr)?);
        write("value", value, ("nvr", nvr), instance.output_derivatives(references, orders)?)
    };
    /// Derivatives of the unknowns along the direction in which the knowns change by `dvKnown`. In Initialization Mode
    /// the unknowns are real outputs and calculated parameters, the knowns real parameters and inputs; later, the real
    /// outputs at the end of the last step, and the inputs that were held over it; in model exchange the real outputs
    /// and the derivatives of the states, and states and inputs.
    fn fmi2GetDirectionalDerivative(
        vUnknown_ref: *const fmi2ValueReference, nUnknown: usize, vKnown_ref: *const fmi2ValueReference, nKnown: usize,
        dvKnown: *const fmi2Real, dvUnknown: *mut fmi2Real
    ) as DirectionalDerivative |instance| {
        let unknowns = array("vUnknown_ref", vUnknown_ref, nUnknown)?;
        let (knowns, direction) = (array("vKnown_ref", vKnown_ref, nKnown)?, array("dvKnown", dvKnown, nKnown)?);
        let found = instance.directional_derivatives(unknowns, knowns, direction)?;
        write("dvUnknown", dvUnknown, ("nUnknown", nUnknown), found)
    };
}
