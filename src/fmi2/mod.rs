//! The C ABI of FMI 2.0 for co-simulation and model exchange, and the only unsafe code of the FMU.
//!
//! Every exported function goes through `boundary::call`: null and foreign components are refused, calls that are not
//! legal in the current phase are refused and logged, and a panic is caught before it reaches the host.
//!
//! # Safety
//! The exported functions are called from C. Pointers are checked for null and alignment; beyond that they must be
//! what the standard says: arrays as long as their count, texts closed by a null byte, a component that
//! `fmi2Instantiate` returned and `fmi2FreeInstance` has not freed, one thread at a time per component.
#![allow(unsafe_code, non_camel_case_types, non_upper_case_globals, non_snake_case)]

mod boundary;
mod functions;
mod logger;
mod resources;
mod types;

pub use functions::*;
pub use types::*;
