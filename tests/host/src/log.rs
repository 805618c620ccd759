//! The log of the host for FMI 2.0.

use std::cell::RefCell;
use std::ffi::{CStr, c_char, c_void};
use std::mem;

use newtons_cradle::fmi2::*;

/// A line of the log.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Name of the instance.
    pub instance: String,
    /// The severity.
    pub status: fmi2Status,
    /// One of the log categories of the description.
    pub category: String,
    /// The message, with its percent signs as printed.
    pub text: String,
}

/// The log; it is the component environment, to which the logger writes.
pub type Lines = RefCell<Vec<Line>>;

unsafe extern "C" fn logger(
    environment: fmi2ComponentEnvironment,
    instance: fmi2String,
    status: fmi2Status,
    category: fmi2String,
    message: fmi2String,
) {
    let text = |text: *const c_char| unsafe { CStr::from_ptr(text) }.to_str().unwrap().to_owned();
    // What printf makes of a format without conversions.
    let message = text(message).replace("%%", "%");
    let line = Line { instance: text(instance), status, category: text(category), text: message };
    unsafe { &*environment.cast::<Lines>() }.borrow_mut().push(line);
}

/// The callbacks of a host that logs to `lines`.
pub fn callbacks(lines: &Lines) -> fmi2CallbackFunctions {
    type Fixed = unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String);
    type Variadic = unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
    let fixed: Fixed = logger;
    fmi2CallbackFunctions {
        // Stable Rust cannot define variadic functions. The FMU passes no variable arguments, and on the platforms that
        // the tests run on, fixed arguments are passed in the same way.
        logger: Some(unsafe { mem::transmute::<Fixed, Variadic>(fixed) }),
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: (lines as *const Lines).cast_mut().cast::<c_void>(),
    }
}
