//! Functions of clocks with intervals and of scheduled execution, of which the FMU has neither.

use crate::fmi3::types::*;
use crate::variables::Refusal;

/// Exports functions of clocks with intervals, legal for an empty list only.
macro_rules! intervals {
    ($(fn $name:ident($($argument:ident: $type:ty),*);)*) => {
        export! {$(
            /// There are no clocks with intervals.
            fn $name(
                _valueReferences: *const fmi3ValueReference, nValueReferences: usize, $($argument: $type),*
            ) as INTERVALS |_| match nValueReferences {
                0 => Ok(()),
                _ => Err(Refusal::new("no clock has an interval: they tick when contacts close and open")),
            };
        )*}
    };
}

intervals! {
    fn fmi3GetIntervalDecimal(_intervals: *mut f64, _qualifiers: *mut fmi3IntervalQualifier);
    fn fmi3GetIntervalFraction(
        _counters: *mut u64, _resolutions: *mut u64, _qualifiers: *mut fmi3IntervalQualifier
    );
    fn fmi3GetShiftDecimal(_shifts: *mut f64);
    fn fmi3GetShiftFraction(_counters: *mut u64, _resolutions: *mut u64);
    fn fmi3SetIntervalDecimal(_intervals: *const f64);
    fn fmi3SetIntervalFraction(_counters: *const u64, _resolutions: *const u64);
    fn fmi3SetShiftDecimal(_shifts: *const f64);
    fn fmi3SetShiftFraction(_counters: *const u64, _resolutions: *const u64);
}

export! {
    /// Not offered.
    fn fmi3ActivateModelPartition(_clockReference: fmi3ValueReference, _activationTime: f64)
    as NOT_OFFERED |_| Err(no_scheduled_execution());
    /// Does nothing, as the standard requires where `providesEvaluateDiscreteStates` is false.
    fn fmi3EvaluateDiscreteStates() as NEXT_EVENT |_| Ok(());
}

pub(super) fn no_scheduled_execution() -> Refusal {
    Refusal::new("scheduled execution is not offered; allowed: co-simulation or model exchange")
}
