//! Functions of clocks with intervals, of which there are none, and of scheduled execution.

use crate::fmi3::types::*;

refuse! {
    "the clocks have no intervals: they tick when contacts close and open":
    /// There are no clocks with intervals.
    fn fmi3GetIntervalDecimal as Intervals(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, intervals: *mut fmi3Float64,
        qualifiers: *mut fmi3IntervalQualifier,
    ) if nValueReferences > 0;
    /// There are no clocks with intervals.
    fn fmi3GetIntervalFraction as Intervals(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *mut fmi3UInt64,
        resolutions: *mut fmi3UInt64, qualifiers: *mut fmi3IntervalQualifier,
    ) if nValueReferences > 0;
    /// There are no clocks with intervals.
    fn fmi3GetShiftDecimal as Intervals(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, shifts: *mut fmi3Float64,
    ) if nValueReferences > 0;
    /// There are no clocks with intervals.
    fn fmi3GetShiftFraction as Intervals(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *mut fmi3UInt64,
        resolutions: *mut fmi3UInt64,
    ) if nValueReferences > 0;
    /// There are no clocks with intervals.
    fn fmi3SetIntervalDecimal as Intervals(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, intervals: *const fmi3Float64,
    ) if nValueReferences > 0;
    /// There are no clocks with intervals.
    fn fmi3SetIntervalFraction as Intervals(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *const fmi3UInt64,
        resolutions: *const fmi3UInt64,
    ) if nValueReferences > 0;
    /// There are no clocks with intervals.
    fn fmi3SetShiftDecimal as Intervals(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, shifts: *const fmi3Float64,
    ) if nValueReferences > 0;
    /// There are no clocks with intervals.
    fn fmi3SetShiftFraction as Intervals(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, counters: *const fmi3UInt64,
        resolutions: *const fmi3UInt64,
    ) if nValueReferences > 0;
}

refuse! {
    "scheduled execution is not offered; allowed: co-simulation or model exchange":
    /// Not offered.
    fn fmi3ActivateModelPartition as SetDebugLogging(
        clockReference: fmi3ValueReference, activationTime: fmi3Float64,
    ) if true;
}

export! {
    /// Ignored, as the standard has it where `providesEvaluateDiscreteStates` is false.
    fn fmi3EvaluateDiscreteStates() as NextEvent |_| Ok(());
}
