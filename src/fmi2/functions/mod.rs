//! The exported functions, in the groups of the standard. Each takes its arguments apart and hands the rest to the
//! instance, by the guard in `ffi`.

/// Exports functions of a component: `fn name(arguments) as Call |instance| body` is the function `name` of the
/// standard, which is legal where [`Call`](crate::instance::Call) says so and answers what becomes of `body`. What
/// `body` takes for granted are the host's promises, see the [module](crate::fmi2).
macro_rules! export {
    ($(
        $(#[$doc:meta])* fn $name:ident($($argument:ident: $type:ty),*)
        as $call:ident |$instance:pat_param| $body:expr;
    )*) => {$(
        $(#[$doc])*
        ///
        /// # Safety
        /// See the [module](crate::fmi2).
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(c: fmi2Component, $($argument: $type),*) -> fmi2Status {
            // SAFETY: the host's promises, see the module.
            unsafe {
                crate::ffi::call::<crate::fmi2::Fmi2>(
                    c, stringify!($name), crate::instance::Call::$call, |$instance| $body
                )
            }
        }
    )*};
}

mod common;
mod cosimulation;
mod exchange;
mod values;

pub use common::*;
pub use cosimulation::*;
pub use exchange::*;
pub use values::*;
