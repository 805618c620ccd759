//! Saving and restoring the state of a component.

use super::derivatives::fill;
use crate::fmi2::boundary::{array, array_mut};
use crate::fmi2::types::*;
use crate::instance::{Refusal, SavedState};

/// Marks memory as a state of ours; "cradleFS" in ASCII.
const MAGIC: u64 = 0x6372_6164_6c65_4653;

/// What `fmi2FMUstate` points to.
struct Saved {
    magic: u64,
    state: SavedState,
}

impl Saved {
    /// The state behind a pointer; refused are null and, as far as it can be told, what is no state.
    ///
    /// # Safety
    /// `pointer` is null or points to readable memory of at least the size of a state, which nobody else uses for `'a`.
    unsafe fn from_raw<'a>(pointer: fmi2FMUstate) -> Result<&'a mut Self, Refusal> {
        let saved: *mut Self = pointer.cast();
        if !saved.is_null() && saved.is_aligned() {
            // SAFETY: not null, aligned, and alive as the caller promises.
            let saved = unsafe { &mut *saved };
            if saved.magic == MAGIC {
                return Ok(saved);
            }
        }
        let value = if saved.is_null() { "NULL".to_owned() } else { format!("{saved:p}") };
        Err(Refusal::Argument { name: "FMUstate", value, allowed: "a state of this FMU".to_owned() })
    }
}

/// Stores `state` where the host wants it: in the memory of the state that is there already, or in new memory.
///
/// # Safety
/// `place` is null, misaligned, or points to NULL or a state.
unsafe fn store(place: *mut fmi2FMUstate, state: impl FnOnce() -> Result<SavedState, Refusal>) -> Result<(), Refusal> {
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

export! {
    /// Saves the state. Where `*FMUstate` is not NULL it is a state saved before, whose memory is used again.
    fn fmi2GetFMUstate(FMUstate: *mut fmi2FMUstate) as State |instance| store(FMUstate, || Ok(instance.state()));
    /// Goes back to a state saved by a component of the same FMU. The state stays as it is and can be set again.
    fn fmi2SetFMUstate(FMUstate: fmi2FMUstate) as State |instance| instance.set_state(&Saved::from_raw(FMUstate)?.state);
    /// Frees a state and sets the host's pointer to NULL; no state is ignored.
    fn fmi2FreeFMUstate(FMUstate: *mut fmi2FMUstate) as State |_| {
        if FMUstate.is_null() {
            return Ok(());
        }
        array("FMUstate", FMUstate.cast_const(), 1)?;
        if !(*FMUstate).is_null() {
            let saved: *mut Saved = Saved::from_raw(*FMUstate)?;
            (*saved).magic = 0;
            drop(Box::from_raw(saved));
            *FMUstate = std::ptr::null_mut();
        }
        Ok(())
    };
    /// Number of bytes that [`fmi2SerializeFMUstate`] writes for this state.
    fn fmi2SerializedFMUstateSize(FMUstate: fmi2FMUstate, size: *mut usize) as State |_| {
        for place in array_mut("size", size, 1)? {
            place.write(Saved::from_raw(FMUstate)?.state.to_bytes()?.len());
        }
        Ok(())
    };
    /// Writes a state as bytes that any process with this FMU can read. `size` must be what [`fmi2SerializedFMUstateSize`]
    /// answered.
    fn fmi2SerializeFMUstate(FMUstate: fmi2FMUstate, serializedState: *mut fmi2Byte, size: usize) as State |_| {
        let bytes = Saved::from_raw(FMUstate)?.state.to_bytes()?;
        if size != bytes.len() {
            let allowed = format!("{}, as fmi2SerializedFMUstateSize says", bytes.len());
            return Err(Refusal::Argument { name: "size", value: size.to_string(), allowed });
        }
        fill(array_mut("serializedState", serializedState.cast::<u8>(), size)?, bytes);
        Ok(())
    };
    /// Makes a state of the bytes that [`fmi2SerializeFMUstate`] wrote, also in another process. Damaged, foreign and newer bytes
    /// are refused, and `*FMUstate` is left as it is; where it is not NULL its memory is used again.
    fn fmi2DeSerializeFMUstate(serializedState: *const fmi2Byte, size: usize, FMUstate: *mut fmi2FMUstate) as State |instance| {
        let bytes = array("serializedState", serializedState.cast::<u8>(), size)?;
        store(FMUstate, || instance.read_state(bytes))
    };
}
