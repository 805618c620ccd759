//! Directional, adjoint and output derivatives.

use crate::ffi::{array, write};
use crate::fmi3::types::*;
use crate::variables::Refusal;

export! {
    /// Derivatives of the unknowns along the direction in which the knowns change by `seed`. In Initialization Mode the
    /// unknowns are real outputs and calculated parameters, the knowns real parameters and inputs; later outputs and
    /// inputs, as `derivatives.of` says.
    fn fmi3GetDirectionalDerivative(
        unknowns: *const fmi3ValueReference, nUnknowns: usize, knowns: *const fmi3ValueReference, nKnowns: usize,
        seed: *const f64, nSeed: usize, sensitivity: *mut f64, nSensitivity: usize,
    ) as DIRECTIONAL_DERIVATIVE |instance| {
        let (unknowns, knowns) = (array("unknowns", unknowns, nUnknowns)?, array("knowns", knowns, nKnowns)?);
        let found = instance.directional(unknowns, knowns, array("seed", seed, nSeed)?)?;
        write("sensitivity", sensitivity, ("nSensitivity", nSensitivity), found)
    };
    /// The same derivatives, summed over the unknowns with the weights `seed`, by each known.
    fn fmi3GetAdjointDerivative(
        unknowns: *const fmi3ValueReference, nUnknowns: usize, knowns: *const fmi3ValueReference, nKnowns: usize,
        seed: *const f64, nSeed: usize, sensitivity: *mut f64, nSensitivity: usize,
    ) as DIRECTIONAL_DERIVATIVE |instance| {
        let (unknowns, knowns) = (array("unknowns", unknowns, nUnknowns)?, array("knowns", knowns, nKnowns)?);
        let found = instance.adjoint(unknowns, knowns, array("seed", seed, nSeed)?)?;
        write("sensitivity", sensitivity, ("nSensitivity", nSensitivity), found)
    };
    /// Time derivatives of real outputs, of order 1 to 3; 0 for variables that change only at events and communication
    /// points.
    fn fmi3GetOutputDerivatives(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, orders: *const i32, values: *mut f64,
        nValues: usize,
    ) as GET_OUTPUT_DERIVATIVES |instance| {
        let references = array("valueReferences", valueReferences, nValueReferences)?;
        let found = instance.output_derivatives(references, array("orders", orders, nValueReferences)?)?;
        write("values", values, ("nValues", nValues), found)
    };
    /// Not offered.
    fn fmi3GetNumberOfVariableDependencies(_valueReference: fmi3ValueReference, _nDependencies: *mut usize)
    as NOT_OFFERED |_| no_dependencies();
    /// Not offered.
    fn fmi3GetVariableDependencies(
        _dependent: fmi3ValueReference, _elementIndicesOfDependent: *mut usize, _independents: *mut fmi3ValueReference,
        _elementIndicesOfIndependents: *mut usize, _dependencyKinds: *mut fmi3DependencyKind, _nDependencies: usize,
    ) as NOT_OFFERED |_| no_dependencies();
}

fn no_dependencies() -> Result<(), Refusal> {
    Err(Refusal::new("dependencies of single elements are not offered; those of variables are in the description"))
}
