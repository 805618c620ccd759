//! Getting and setting values, and their derivatives.

use crate::ffi::{array, array_mut, write};
use crate::fmi2::types::*;
use crate::variables::Type;

export! {
    /// Reads real variables.
    fn fmi2GetReal(vr: *const fmi2ValueReference, nvr: usize, value: *mut f64) as GET |instance| {
        instance.get(Type::Real, array("vr", vr, nvr)?, array_mut("value", value, nvr)?, |value| value)
    };
    /// Reads integers and enumerations; counts that do not fit are the largest integer.
    fn fmi2GetInteger(vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2Integer) as GET |instance| {
        let places = array_mut("value", value, nvr)?;
        instance.get(Type::Integer, array("vr", vr, nvr)?, places, |value| value as fmi2Integer)
    };
    /// Reads booleans.
    fn fmi2GetBoolean(vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2Boolean) as GET |instance| {
        let places = array_mut("value", value, nvr)?;
        instance.get(Type::Boolean, array("vr", vr, nvr)?, places, |value| value as fmi2Boolean)
    };
    /// There are no strings: legal for an empty list only.
    fn fmi2GetString(vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2String) as GET |instance| {
        instance.get(Type::String, array("vr", vr, nvr)?, array_mut("value", value, nvr)?, |_| std::ptr::null())
    };
    /// Sets real parameters and inputs: all, or none if any is refused.
    fn fmi2SetReal(vr: *const fmi2ValueReference, nvr: usize, value: *const f64) as SET |instance| {
        instance.set(Type::Real, array("vr", vr, nvr)?, array("value", value, nvr)?, |value| value)
    };
    /// Sets enumerations: all, or none if any is refused.
    fn fmi2SetInteger(vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2Integer) as SET_DISCRETE |instance| {
        instance.set(Type::Integer, array("vr", vr, nvr)?, array("value", value, nvr)?, f64::from)
    };
    /// No boolean can be set: legal for an empty list only.
    fn fmi2SetBoolean(vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2Boolean) as SET_DISCRETE |instance| {
        instance.set(Type::Boolean, array("vr", vr, nvr)?, array("value", value, nvr)?, f64::from)
    };
    /// There are no strings: legal for an empty list only.
    fn fmi2SetString(vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2String) as SET_DISCRETE |instance| {
        instance.set(Type::String, array("vr", vr, nvr)?, array("value", value, nvr)?, |_| f64::NAN)
    };
    /// Sets time derivatives of real inputs, of order 1 to 3, for the next fmi2DoStep: all, or none if any is refused.
    /// After that step the inputs keep the values they reached.
    fn fmi2SetRealInputDerivatives(
        vr: *const fmi2ValueReference, nvr: usize, order: *const fmi2Integer, value: *const f64
    ) as SET_INPUT_DERIVATIVES |instance| {
        let (references, orders) = (array("vr", vr, nvr)?, array("order", order, nvr)?);
        instance.set_input_derivatives(references, orders, array("value", value, nvr)?)
    };
    /// Time derivatives of real outputs, of order 1 to 3; 0 for variables that change only at events and communication
    /// points.
    fn fmi2GetRealOutputDerivatives(
        vr: *const fmi2ValueReference, nvr: usize, order: *const fmi2Integer, value: *mut f64
    ) as GET_OUTPUT_DERIVATIVES |instance| {
        let (references, orders) = (array("vr", vr, nvr)?, array("order", order, nvr)?);
        write("value", value, ("nvr", nvr), instance.output_derivatives(references, orders)?)
    };
    /// Derivatives of the unknowns along the direction in which the knowns change by `dvKnown`. In Initialization Mode
    /// the unknowns are real outputs and calculated parameters, the knowns real parameters and inputs; later, the real
    /// outputs at the end of the last step, and the inputs that were held over it; in model exchange the real outputs
    /// and the derivatives of the states, and states and inputs.
    fn fmi2GetDirectionalDerivative(
        vUnknown_ref: *const fmi2ValueReference, nUnknown: usize, vKnown_ref: *const fmi2ValueReference, nKnown: usize,
        dvKnown: *const f64, dvUnknown: *mut f64
    ) as DIRECTIONAL_DERIVATIVE |instance| {
        let unknowns = array("vUnknown_ref", vUnknown_ref, nUnknown)?;
        let (knowns, direction) = (array("vKnown_ref", vKnown_ref, nKnown)?, array("dvKnown", dvKnown, nKnown)?);
        let found = instance.directional(unknowns, knowns, direction)?;
        write("dvUnknown", dvUnknown, ("nUnknown", nUnknown), found)
    };
}
