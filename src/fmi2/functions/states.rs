//! Saving and restoring the state of a component.

use crate::ffi;
use crate::fmi2::types::*;

export! {
    /// Saves the state. Where `*FMUstate` is not NULL it is a state saved before, whose memory is used again.
    fn fmi2GetFMUstate(FMUstate: *mut fmi2FMUstate) as State |instance| ffi::get(instance, FMUstate);
    /// Goes back to a state saved by a component of the same FMU. The state stays as it is and can be set again.
    fn fmi2SetFMUstate(FMUstate: fmi2FMUstate) as State |instance| ffi::set(instance, FMUstate);
    /// Frees a state and sets the host's pointer to NULL; no state is ignored.
    fn fmi2FreeFMUstate(FMUstate: *mut fmi2FMUstate) as State |_| ffi::free(FMUstate);
    /// Number of bytes that [`fmi2SerializeFMUstate`] writes for this state.
    fn fmi2SerializedFMUstateSize(FMUstate: fmi2FMUstate, size: *mut usize) as State |_| {
        ffi::serialized_size(FMUstate, size)
    };
    /// Writes a state as bytes that any process with this FMU can read. `size` must be what
    /// [`fmi2SerializedFMUstateSize`] answered.
    fn fmi2SerializeFMUstate(FMUstate: fmi2FMUstate, serializedState: *mut fmi2Byte, size: usize) as State |_| {
        ffi::serialize(FMUstate, serializedState.cast(), size, "fmi2SerializedFMUstateSize")
    };
    /// Makes a state of the bytes that [`fmi2SerializeFMUstate`] wrote, also in another process. Damaged, foreign and
    /// newer bytes are refused, and `*FMUstate` is left as it is; where it is not NULL its memory is used again.
    fn fmi2DeSerializeFMUstate(
        serializedState: *const fmi2Byte, size: usize, FMUstate: *mut fmi2FMUstate
    ) as State |instance| {
        ffi::deserialize(instance, serializedState.cast(), size, FMUstate)
    };
}
