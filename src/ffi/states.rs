//! Saved states of the host: saving, restoring, freeing, writing as bytes.

use std::ffi::c_void;

use super::arrays::{array, shown};
use super::component::marked;
use crate::instance::SavedState;
use crate::variables::Refusal;

/// Marks memory as a saved state of this FMU; "cradleFS" in ASCII.
const MAGIC: u64 = 0x6372_6164_6c65_4653;

#[repr(C)]
struct Saved {
    magic: u64,
    state: SavedState,
}

/// The memory behind a pointer; refuses null and, as far as can be detected, foreign pointers.
///
/// # Safety
/// As for [`marked`], of a state.
unsafe fn memory(pointer: *mut c_void) -> Result<*mut Saved, Refusal> {
    let foreign = || Refusal::argument("FMUstate", shown(pointer.cast()), "a state of this FMU");
    // SAFETY: as the caller promises.
    unsafe { marked(pointer, MAGIC) }.ok_or_else(foreign)
}

/// The state behind a pointer.
///
/// # Safety
/// As for [`memory`], and nobody changes it for `'a`.
pub(crate) unsafe fn saved<'a>(pointer: *mut c_void) -> Result<&'a SavedState, Refusal> {
    // SAFETY: a state, alive as the caller promises.
    unsafe { memory(pointer).map(|saved| &(*saved).state) }
}

/// Stores `state` at `place`: in the memory of the state there, or in new memory.
///
/// # Safety
/// `place` is null, misaligned, or points to NULL or a state.
pub(crate) unsafe fn store(
    place: *mut *mut c_void,
    state: impl FnOnce() -> Result<SavedState, Refusal>,
) -> Result<(), Refusal> {
    // SAFETY: null and misaligned are refused, the rest is the caller's promise.
    unsafe {
        array("FMUstate", place.cast_const(), 1)?;
        if (*place).is_null() {
            *place = Box::into_raw(Box::new(Saved { magic: MAGIC, state: state()? })).cast();
        } else {
            (*memory(*place)?).state = state()?;
        }
    }
    Ok(())
}

/// Frees the state at `place`, if there is one.
///
/// # Safety
/// As for [`store`], and nobody uses the state afterwards.
pub(crate) unsafe fn free(place: *mut *mut c_void) -> Result<(), Refusal> {
    if place.is_null() {
        return Ok(());
    }
    // SAFETY: as the caller promises.
    unsafe {
        array("FMUstate", place.cast_const(), 1)?;
        if !(*place).is_null() {
            let saved = memory(*place)?;
            (*saved).magic = 0;
            drop(Box::from_raw(saved));
            *place = std::ptr::null_mut();
        }
    }
    Ok(())
}

/// Exports the functions of saved states, under the names of a version of the standard, by `export!` of the module that
/// calls this.
macro_rules! export_states {
    (
        $state:ty, $byte:ty:
        $get:ident $set:ident $free:ident $serialized_size:ident $serialize:ident $deserialize:ident
    ) => {
        export! {
            /// Saves the state. If `*FMUstate` is not NULL, it must be a saved state, whose memory is reused.
            fn $get(FMUstate: *mut $state) as STATE |instance| crate::ffi::store(FMUstate, || Ok(instance.state()));
            /// Restores a state saved by an instance of the same FMU. The state can be restored again.
            fn $set(FMUstate: $state) as STATE |instance| instance.set_state(crate::ffi::saved(FMUstate)?);
            /// Frees a state and sets the host's pointer to NULL; NULL is ignored.
            fn $free(FMUstate: *mut $state) as STATE |_| crate::ffi::free(FMUstate);
            #[doc = concat!("Number of bytes that [`", stringify!($serialize), "`] writes for this state.")]
            fn $serialized_size(FMUstate: $state, size: *mut usize) as STATE |_| {
                crate::ffi::answer("size", size, crate::ffi::saved(FMUstate)?.to_bytes()?.len())
            };
            /// Writes a state as bytes that any process with this FMU can read. `size` must be that of
            #[doc = concat!("[`", stringify!($serialized_size), "`].")]
            fn $serialize(FMUstate: $state, serializedState: *mut $byte, size: usize) as STATE |_| {
                let bytes = crate::ffi::saved(FMUstate)?.to_bytes()?;
                let allowed = format_args!("{}, as {} says", bytes.len(), stringify!($serialized_size));
                let refusal = || crate::variables::Refusal::argument("size", size, allowed);
                crate::variables::ensure(size == bytes.len(), refusal)?;
                crate::ffi::fill(crate::ffi::array_mut("serializedState", serializedState.cast(), size)?, bytes);
                Ok(())
            };
            #[doc = concat!("Makes a state of the bytes that [`", stringify!($serialize), "`] wrote, also in another")]
            /// process. Damaged, foreign and newer bytes are refused, and `*FMUstate` is unchanged; if it is not NULL,
            /// its memory is reused.
            fn $deserialize(serializedState: *const $byte, size: usize, FMUstate: *mut $state) as STATE |instance| {
                let bytes = crate::ffi::array("serializedState", serializedState.cast(), size)?;
                crate::ffi::store(FMUstate, || instance.read_state(bytes))
            };
        }
    };
}
pub(crate) use export_states;
