//! The exported functions, in groups. Each takes its arguments apart and hands the rest to the instance, by the guard
//! in `ffi`.

/// Exports functions of an instance: `fn name(arguments) as Call |instance| body` is the function `name` of the
/// standard, which is legal where [`Call`](crate::instance::Call) says so and answers what becomes of `body`. What
/// `body` takes for granted are the host's promises, see the [module](crate::fmi3).
macro_rules! export {
    ($(
        $(#[$doc:meta])* fn $name:ident($($argument:ident: $type:ty),* $(,)?)
        as $call:ident |$instance:pat_param| $body:expr;
    )*) => {$(
        $(#[$doc])*
        ///
        /// # Safety
        /// See the [module](crate::fmi3).
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(instance: fmi3Instance, $($argument: $type),*) -> fmi3Status {
            // SAFETY: the host's promises, see the module.
            unsafe {
                crate::ffi::call_small::<crate::fmi3::Fmi3>(
                    instance, stringify!($name), crate::instance::Call::$call, &mut |$instance| $body
                )
            }
        }
    )*};
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
