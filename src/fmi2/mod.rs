//! The C ABI of FMI 2.0 for co-simulation and model exchange.
//!
//! Every exported function goes through the guard in `ffi`.
//!
//! # Safety
//! The exported functions are called from C. Pointers are checked for null and alignment; beyond that they must be
//! what the standard says: arrays as long as their count, texts closed by a null byte, a component that
//! `fmi2Instantiate` returned and `fmi2FreeInstance` has not freed, one thread at a time per component.
#![allow(unsafe_code, non_camel_case_types, non_upper_case_globals, non_snake_case)]

mod functions;
mod logger;
mod types;

pub use functions::*;
pub use types::*;

use crate::ffi::Version;
use crate::instance::Instance;
use crate::variables::Refusal;

/// FMI 2.0, as far as `ffi` must know it.
struct Fmi2;

impl Version for Fmi2 {
    // "cradleF2" in ASCII.
    const MAGIC: u64 = 0x6372_6164_6c65_4632;
    type Status = fmi2Status;
    const OK: fmi2Status = fmi2Status::fmi2OK;
    const ERROR: fmi2Status = fmi2Status::fmi2Error;
    const FATAL: fmi2Status = fmi2Status::fmi2Fatal;

    /// The instance goes on as it was.
    fn refused(instance: &mut Instance, function: &str, refusal: &Refusal) -> fmi2Status {
        instance.log.error(format_args!("{function}: {refusal}"));
        Self::ERROR
    }
}
