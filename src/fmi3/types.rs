//! The types of `fmi3PlatformTypes.h` and `fmi3FunctionTypes.h`, under the names of the standard where they are not
//! Rust's own: `fmi3Float64` is `f64`.

use std::ffi::{c_char, c_int, c_uint, c_void};

/// An instance, opaque to the host.
pub type fmi3Instance = *mut c_void;
/// Data of the host, handed back to its callbacks.
pub type fmi3InstanceEnvironment = *mut c_void;
/// A saved state, opaque to the host.
pub type fmi3FMUState = *mut c_void;
/// Identifies a variable.
pub type fmi3ValueReference = c_uint;
/// A C `bool`, as the byte that it is: a host may pass any.
pub type fmi3Boolean = u8;
/// Whether a clock is active: a byte like [`fmi3Boolean`].
pub type fmi3Clock = u8;
/// A null-terminated text in UTF-8.
pub type fmi3String = *const c_char;
/// Bytes; another argument is their number.
pub type fmi3Binary = *const u8;
/// How a variable depends on another one. A plain integer, since a host may pass any.
pub type fmi3DependencyKind = c_int;
/// What is known of the interval of a clock. A plain integer, since a host may pass any.
pub type fmi3IntervalQualifier = c_int;

/// False.
pub const fmi3False: fmi3Boolean = 0;
/// True.
pub const fmi3True: fmi3Boolean = 1;

/// Return value of a function. Hosts never pass one to us, so an enumeration is safe.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum fmi3Status {
    /// Success.
    fmi3OK,
    /// Success, with a warning in the log.
    fmi3Warning,
    /// The value is unavailable; the instance is unchanged.
    fmi3Discard,
    /// The call was refused or failed, and the run is over.
    fmi3Error,
    /// The instance is lost.
    fmi3Fatal,
}

/// The host's logger: `(environment, status, category, message)`.
pub type fmi3LogMessageCallback =
    Option<unsafe extern "C" fn(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String)>;
/// What the host does in the middle of a step:
/// `(environment, time, set requested, get allowed, step finished, can return early, early return requested, early
/// return time)`.
pub type fmi3IntermediateUpdateCallback = Option<
    unsafe extern "C" fn(
        fmi3InstanceEnvironment,
        f64,
        fmi3Boolean,
        fmi3Boolean,
        fmi3Boolean,
        fmi3Boolean,
        *mut fmi3Boolean,
        *mut f64,
    ),
>;
