//! The C ABI of FMI 3.0 for co-simulation, with event mode, and model exchange, with clocks and arrays.
//!
//! Every exported function goes through the guard in `ffi`. A refused call ends the run, as FMI 3.0 requires; values
//! out of range return fmi3Discard and change nothing. Functions of scheduled execution exist, because hosts look for
//! them, and refuse.
//!
//! # Safety
//! The exported functions are called from C. Pointers are checked for null and alignment; beyond that the standard's
//! rules are relied on: arrays as long as their count, null-terminated texts, an instance not yet freed, one thread at
//! a time per instance.
#![allow(unsafe_code, non_camel_case_types, non_upper_case_globals, non_snake_case)]

mod functions;
mod instantiate;
mod types;

pub use functions::*;
pub use instantiate::*;
pub use types::*;

use crate::ffi::Version;
use crate::instance::{Instance, Severity};
use crate::variables::{LogCategory, Refusal, RefusalCause};

/// FMI 3.0, and the callbacks of the host.
struct Fmi3 {
    environment: fmi3InstanceEnvironment,
    update: fmi3IntermediateUpdateCallback,
    /// Whether the host may end a step where it is called.
    may_end_early: bool,
}

impl Fmi3 {
    /// Calls the host within a step, at `time` (s). Returns the time at which it wants the step to end early, which it
    /// may have set to NaN.
    ///
    /// # Safety
    /// The host's callback may be called with its environment.
    unsafe fn update(&self, time: f64) -> Option<f64> {
        let (mut requested, mut end) = (fmi3False, time);
        let may_end = self.may_end_early.into();
        // SAFETY: as the caller promises; the places live until it returns.
        unsafe {
            self.update?(self.environment, time, fmi3True, fmi3True, fmi3True, may_end, &mut requested, &mut end)
        };
        (self.may_end_early && requested != fmi3False).then_some(end)
    }
}

impl Version for Fmi3 {
    // "cradleF3" in ASCII.
    const MAGIC: u64 = 0x6372_6164_6c65_4633;
    type Status = fmi3Status;
    const STATUSES: [fmi3Status; 5] = {
        use fmi3Status::*;
        [fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal]
    };

    /// A value that is out of range or does not exist changes nothing; everything else ends the run.
    fn refused(instance: &mut Instance, function: &str, refusal: &Refusal) -> fmi3Status {
        if refusal.cause != RefusalCause::Call {
            instance.log.write(Severity::Discard, LogCategory::Discard, format_args!("{function}: {refusal}"));
            return fmi3Status::fmi3Discard;
        }
        instance.log.error(format_args!("{function}: {refusal}"));
        instance.give_up(function);
        fmi3Status::fmi3Error
    }
}
