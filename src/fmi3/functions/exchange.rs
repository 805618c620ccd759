//! Functions of model exchange, which the FMU does not offer in FMI 3.0.

use crate::fmi3::types::*;

refuse! {
    "model exchange is not offered in FMI 3.0; allowed: co-simulation":
    /// Not offered.
    fn fmi3EnterContinuousTimeMode();
    /// Not offered.
    fn fmi3CompletedIntegratorStep(
        noSetFMUStatePriorToCurrentPoint: fmi3Boolean, enterEventMode: *mut fmi3Boolean, terminateSimulation: *mut fmi3Boolean,
    );
    /// Not offered.
    fn fmi3SetTime(time: fmi3Float64);
    /// Not offered.
    fn fmi3SetContinuousStates(continuousStates: *const fmi3Float64, nContinuousStates: usize);
    /// Not offered.
    fn fmi3GetContinuousStateDerivatives(derivatives: *mut fmi3Float64, nContinuousStates: usize);
    /// Not offered.
    fn fmi3GetEventIndicators(eventIndicators: *mut fmi3Float64, nEventIndicators: usize);
    /// Not offered.
    fn fmi3GetContinuousStates(continuousStates: *mut fmi3Float64, nContinuousStates: usize);
    /// Not offered.
    fn fmi3GetNominalsOfContinuousStates(nominals: *mut fmi3Float64, nContinuousStates: usize);
    /// Not offered.
    fn fmi3GetNumberOfEventIndicators(nEventIndicators: *mut usize);
    /// Not offered.
    fn fmi3GetNumberOfContinuousStates(nContinuousStates: *mut usize);
}
