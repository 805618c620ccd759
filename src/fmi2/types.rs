//! The types of `fmi2TypesPlatform.h` and `fmi2FunctionTypes.h`, under the names of the standard where they are not
//! Rust's own: `fmi2Real` is `f64`.

use std::ffi::{c_char, c_int, c_uint, c_void};

/// An instance, opaque to the host.
pub type fmi2Component = *mut c_void;
/// Data of the host, handed back to its callbacks.
pub type fmi2ComponentEnvironment = *mut c_void;
/// A saved state, opaque to the host.
pub type fmi2FMUstate = *mut c_void;
/// Identifies a variable.
pub type fmi2ValueReference = c_uint;
/// An integer, or the value of an enumeration.
pub type fmi2Integer = c_int;
/// [`fmi2True`] or [`fmi2False`]; a plain integer, since a host may pass any.
pub type fmi2Boolean = c_int;
/// A null-terminated text in UTF-8.
pub type fmi2String = *const c_char;

/// False.
pub const fmi2False: fmi2Boolean = 0;
/// True.
pub const fmi2True: fmi2Boolean = 1;

/// Return value of a function. Hosts never pass one to us, so an enumeration is safe.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum fmi2Status {
    /// Success.
    fmi2OK,
    /// Success, with a warning in the log.
    fmi2Warning,
    /// The step or the value is unavailable; the instance is unchanged.
    fmi2Discard,
    /// The call was refused or failed.
    fmi2Error,
    /// All instances are lost.
    fmi2Fatal,
    /// The step is asynchronous; never returned here.
    fmi2Pending,
}

/// Kind of FMU a host asks for. A plain integer, since a host may pass any.
pub type fmi2Type = c_int;
/// The host integrates.
pub const fmi2ModelExchange: fmi2Type = 0;
/// The FMU integrates.
pub const fmi2CoSimulation: fmi2Type = 1;

/// What a host asks about the last step. A plain integer, since a host may pass any.
pub type fmi2StatusKind = c_int;
/// How the step ended.
pub const fmi2DoStepStatus: fmi2StatusKind = 0;
/// Status of a pending step; there are none.
pub const fmi2PendingStatus: fmi2StatusKind = 1;
/// Time reached by the last step, s.
pub const fmi2LastSuccessfulTime: fmi2StatusKind = 2;
/// Whether the instance wants to end the run.
pub const fmi2Terminated: fmi2StatusKind = 3;

/// The host's logger: `(environment, instance name, status, category, format, ...)`.
pub type fmi2CallbackLogger =
    Option<unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...)>;

/// Result of handling an event.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct fmi2EventInfo {
    /// Never: one call handles all that is due.
    pub newDiscreteStatesNeeded: fmi2Boolean,
    /// Never.
    pub terminateSimulation: fmi2Boolean,
    /// Never: they are constant.
    pub nominalsOfContinuousStatesChanged: fmi2Boolean,
    /// Whether a contact has opened or closed, or a state has jumped.
    pub valuesOfContinuousStatesChanged: fmi2Boolean,
    /// Whether the next event is known.
    pub nextEventTimeDefined: fmi2Boolean,
    /// When it is due, s, later than now.
    pub nextEventTime: f64,
}

/// The callbacks of the host. The FMU manages its own memory (`canNotUseMemoryManagementFunctions`) and steps are
/// synchronous, so only the logger and its environment are used.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct fmi2CallbackFunctions {
    /// Takes the messages.
    pub logger: fmi2CallbackLogger,
    /// Not used.
    pub allocateMemory: Option<unsafe extern "C" fn()>,
    /// Not used.
    pub freeMemory: Option<unsafe extern "C" fn()>,
    /// Not used.
    pub stepFinished: Option<unsafe extern "C" fn()>,
    /// First argument of the logger.
    pub componentEnvironment: fmi2ComponentEnvironment,
}
