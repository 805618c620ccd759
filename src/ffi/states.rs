//! Saved states of the host: saving, restoring, freeing, writing as bytes. What each function does, the functions of
//! the standard say.

use std::ffi::c_void;

use super::arrays::{answer, array, array_mut, fill};
use crate::instance::{Instance, SavedState};
use crate::variables::Refusal;

/// Marks memory as a state of ours; "cradleFS" in ASCII.
const MAGIC: u64 = 0x6372_6164_6c65_4653;

struct Saved {
    magic: u64,
    state: SavedState,
}

impl Saved {
    /// The state behind a pointer; refuses null and, as far as can be detected, foreign pointers.
    ///
    /// # Safety
    /// `pointer` is null or points to readable memory of at least the size of a state, which nobody else uses for `'a`.
    unsafe fn from_raw<'a>(pointer: *mut c_void) -> Result<&'a mut Self, Refusal> {
        let saved: *mut Self = pointer.cast();
        if !saved.is_null() && saved.is_aligned() {
            // SAFETY: not null, aligned, and alive as the caller promises.
            let saved = unsafe { &mut *saved };
            if saved.magic == MAGIC {
                return Ok(saved);
            }
        }
        let value = if saved.is_null() { "NULL".to_owned() } else { format!("{saved:p}") };
        Err(Refusal::argument("FMUstate", value, "a state of this FMU"))
    }
}

/// Stores `state` at `place`: in the memory of the state there, or in new memory.
///
/// # Safety
/// `place` is null, misaligned, or points to NULL or a state.
unsafe fn store(place: *mut *mut c_void, state: impl FnOnce() -> Result<SavedState, Refusal>) -> Result<(), Refusal> {
    // SAFETY: null and misaligned are refused, the rest is the caller's promise.
    unsafe {
        array("FMUstate", place.cast_const(), 1)?;
        if (*place).is_null() {
            *place = Box::into_raw(Box::new(Saved { magic: MAGIC, state: state()? })).cast();
        } else {
            Saved::from_raw(*place)?.state = state()?;
        }
    }
    Ok(())
}

/// # Safety
/// As for [`store`].
pub(crate) unsafe fn get(instance: &Instance, place: *mut *mut c_void) -> Result<(), Refusal> {
    // SAFETY: as the caller promises.
    unsafe { store(place, || Ok(instance.state())) }
}

/// # Safety
/// As for [`Saved::from_raw`].
pub(crate) unsafe fn set(instance: &mut Instance, state: *mut c_void) -> Result<(), Refusal> {
    // SAFETY: as the caller promises.
    instance.set_state(&unsafe { Saved::from_raw(state) }?.state)
}

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
            let saved: *mut Saved = Saved::from_raw(*place)?;
            (*saved).magic = 0;
            drop(Box::from_raw(saved));
            *place = std::ptr::null_mut();
        }
    }
    Ok(())
}

/// # Safety
/// As for [`Saved::from_raw`] and [`answer`].
pub(crate) unsafe fn serialized_size(state: *mut c_void, size: *mut usize) -> Result<(), Refusal> {
    // SAFETY: as the caller promises.
    unsafe {
        array("size", size.cast_const(), 1)?;
        answer("size", size, Saved::from_raw(state)?.state.to_bytes()?.len())
    }
}

/// `size` must be that returned by the function named `sized`.
///
/// # Safety
/// As for [`Saved::from_raw`] and [`array_mut`].
pub(crate) unsafe fn serialize(
    state: *mut c_void,
    bytes: *mut u8,
    size: usize,
    sized: &'static str,
) -> Result<(), Refusal> {
    // SAFETY: as the caller promises.
    let (state, places) = unsafe { (&Saved::from_raw(state)?.state, || array_mut("serializedState", bytes, size)) };
    let written = state.to_bytes()?;
    if size != written.len() {
        return Err(Refusal::argument("size", size, format_args!("{}, as {sized} says", written.len())));
    }
    fill(places()?, written);
    Ok(())
}

/// # Safety
/// As for [`array()`] and [`store`].
pub(crate) unsafe fn deserialize(
    instance: &Instance,
    bytes: *const u8,
    size: usize,
    place: *mut *mut c_void,
) -> Result<(), Refusal> {
    // SAFETY: as the caller promises.
    unsafe {
        let bytes = array("serializedState", bytes, size)?;
        store(place, || instance.read_state(bytes))
    }
}
