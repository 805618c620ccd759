//! The common part of the C functions of all versions of the standard.
//!
//! Every exported function goes through [`call`]: null and foreign components are refused, calls that are illegal in
//! the current phase are refused and logged, panics are caught, and arithmetic is in the default floating-point
//! environment, whatever the host's is. Pointers are checked for null and alignment; beyond that the standard's rules
//! are relied on.
#![allow(unsafe_code)]

/// Exports functions of a component: `fn name(arguments) as Call |instance| body` is the function `name` of the
/// standard, legal where [`Call`](crate::instance::Call) says so, run by [`call`]. `body` relies on the host's
/// promises, see the module of its version. The block after `or` is executed first: it writes the answers of a refused
/// call, with which even a host that ignores the status comes to an end.
macro_rules! export_by {
    (
        ($version:ty, $component:ident: $handle:ty => $status:ty)
        $(
            $(#[$doc:meta])* fn $name:ident($($argument:ident: $type:ty),* $(,)?)
            as $call:ident $(or $refused:block)? |$instance:pat_param| $body:expr;
        )*
    ) => {$(
        $(#[$doc])*
        ///
        /// # Safety
        /// See the module of this version of the standard.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name($component: $handle, $($argument: $type),*) -> $status {
            // SAFETY: the host's promises, see the module.
            unsafe {
                $($refused)?
                let mut body =
                    |$instance: &mut crate::instance::Instance| -> Result<(), crate::variables::Refusal> { $body };
                let call = crate::instance::Call::$call;
                crate::ffi::call::<$version>($component, stringify!($name), call, &mut body)
            }
        }
    )*};
}
pub(crate) use export_by;

mod arrays;
mod component;
mod fenv;
mod resources;
mod states;

pub(crate) use arrays::{answer, array, array_mut, categories, fill, log_line, text, write};
pub(crate) use component::{Component, Version, call, create};
pub(crate) use fenv::HostFenv;
pub(crate) use resources::{at_location, at_path, start};
pub(crate) use states::{export_states, free, saved, store};
