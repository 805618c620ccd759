//! The exported functions, in the groups of the standard. Each translates its arguments and calls the instance through
//! the guard in `ffi`.

macro_rules! export {
    ($($functions:tt)*) => {
        crate::ffi::export_by! { (crate::fmi2::Fmi2, c: fmi2Component => fmi2Status) $($functions)* }
    };
}

mod common;
mod cosimulation;
mod exchange;
mod values;

pub use common::*;
pub use cosimulation::*;
pub use exchange::*;
pub use values::*;
