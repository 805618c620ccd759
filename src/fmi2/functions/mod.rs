//! The exported functions, in the groups of the standard. Each takes its arguments apart and hands the rest to the instance, by
//! [`boundary::call`](super::boundary::call).

mod common;
mod cosimulation;
mod derivatives;
mod instantiate;
mod states;
mod values;

pub use common::*;
pub use cosimulation::*;
pub use derivatives::*;
pub use instantiate::*;
pub use states::*;
pub use values::*;
