//! Functions of clocks with intervals, of which there are none, and of scheduled execution.

use crate::fmi3::types::*;

refuse! {
    "the clocks have no intervals: they tick when contacts close and open":
    /// There are no clocks with intervals.
    fn fmi3GetIntervalDecimal(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, intervals: *mut fmi3Float64,
        qualifiers: *mut fmi3IntervalQualifier,
    );
    /// There are no clocks with intervals.
    fn fmi3GetIntervalFraction(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *mut fmi3UInt64,
        resolutions: *mut fmi3UInt64, qualifiers: *mut fmi3IntervalQualifier,
    );
    /// There are no clocks with intervals.
    fn fmi3GetShiftDecimal(valueReferences: *const fmi3ValueReference, nValueReferences: usize, shifts: *mut fmi3Float64);
    /// There are no clocks with intervals.
    fn fmi3GetShiftFraction(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *mut fmi3UInt64,
        resolutions: *mut fmi3UInt64,
    );
    /// There are no clocks with intervals.
    fn fmi3SetIntervalDecimal(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, intervals: *const fmi3Float64,
    );
    /// There are no clocks with intervals.
    fn fmi3SetIntervalFraction(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *const fmi3UInt64,
        resolutions: *const fmi3UInt64,
    );
    /// There are no clocks with intervals.
    fn fmi3SetShiftDecimal(valueReferences: *const fmi3ValueReference, nValueReferences: usize, shifts: *const fmi3Float64);
    /// There are no clocks with intervals.
    fn fmi3SetShiftFraction(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *const fmi3UInt64,
        resolutions: *const fmi3UInt64,
    );
}

refuse! {
    "scheduled execution is not offered; allowed: co-simulation or model exchange":
    /// Not offered.
    fn fmi3ActivateModelPartition(clockReference: fmi3ValueReference, activationTime: fmi3Float64);
}

refuse! {
    "the discrete states are up to date whenever they are read":
    /// Not offered.
    fn fmi3EvaluateDiscreteStates();
}
