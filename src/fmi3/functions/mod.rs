//! The exported functions, in groups. Each translates its arguments and calls the instance through the guard in `ffi`.

macro_rules! export {
    ($($functions:tt)*) => {
        crate::ffi::export_by! { (crate::fmi3::Fmi3, instance: fmi3Instance => fmi3Status) $($functions)* }
    };
}

mod clocks;
mod common;
mod cosimulation;
mod derivatives;
mod exchange;
mod instantiate;
mod values;

pub use clocks::*;
pub use common::*;
pub use cosimulation::*;
pub use derivatives::*;
pub use exchange::*;
pub use instantiate::*;
pub use values::*;
