//! Getting and setting values.

use std::mem::MaybeUninit;

use crate::fmi2::boundary::{array, array_mut, call};
use crate::fmi2::types::*;
use crate::instance::{Call, Instance, Refusal};
use crate::variables::Type;

/// Fills `value` with what `get` finds for each of `vr`.
///
/// # Safety
/// See the [module](crate::fmi2).
#[inline]
unsafe fn get<T>(
    c: fmi2Component,
    function: &'static str,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut T,
    get: impl Fn(&mut Instance, fmi2ValueReference) -> Result<T, Refusal>,
) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe {
        call(c, function, Call::Get, |instance| {
            let (references, values) = (array("vr", vr, nvr)?, array_mut("value", value, nvr)?);
            for (reference, value) in references.iter().zip(values) {
                MaybeUninit::write(value, get(instance, *reference)?);
            }
            Ok(())
        })
    }
}

/// Hands `vr` and `value` to `set`, which applies all of them or none.
///
/// # Safety
/// See the [module](crate::fmi2).
unsafe fn set<T>(
    c: fmi2Component,
    function: &'static str,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const T,
    set: impl Fn(&mut Instance, &[fmi2ValueReference], &[T]) -> Result<(), Refusal>,
) -> fmi2Status {
    // SAFETY: the host's promises, see the module.
    unsafe {
        call(c, function, Call::Set, |instance| set(instance, array("vr", vr, nvr)?, array("value", value, nvr)?))
    }
}

/// Exports getters and setters of a type of values.
macro_rules! export {
    ($($(#[$doc:meta])* $name:ident($values:ty) = $access:ident($function:expr);)*) => {$(
        $(#[$doc])*
        ///
        /// # Safety
        /// See the [module](crate::fmi2).
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            c: fmi2Component,
            vr: *const fmi2ValueReference,
            nvr: usize,
            value: $values,
        ) -> fmi2Status {
            // SAFETY: the host's promises, see the module.
            unsafe { $access(c, stringify!($name), vr, nvr, value, $function) }
        }
    )*};
}

export! {
    /// Reads real variables.
    fmi2GetReal(*mut fmi2Real) = get(Instance::real);
    /// Reads integers and enumerations.
    fmi2GetInteger(*mut fmi2Integer) = get(Instance::integer);
    /// Reads booleans.
    fmi2GetBoolean(*mut fmi2Boolean) = get(|instance, reference| instance.boolean(reference).map(fmi2Boolean::from));
    /// There are no strings: an error unless nothing is asked for.
    fmi2GetString(*mut fmi2String) = get(|instance, reference| Err(instance.refuse_string(reference)));
    /// Sets real parameters and inputs: all of them, or none if any is refused.
    fmi2SetReal(*const fmi2Real) = set(Instance::set_reals);
    /// Sets enumerations: all of them, or none if any is refused.
    fmi2SetInteger(*const fmi2Integer) = set(Instance::set_integers);
    /// No boolean can be set: an error unless nothing is set.
    fmi2SetBoolean(*const fmi2Boolean) = set(|instance, references, _| instance.refuse_to_set(references, Type::Boolean));
    /// There are no strings: an error unless nothing is set.
    fmi2SetString(*const fmi2String) = set(|instance, references, _| instance.refuse_to_set(references, Type::String));
}
