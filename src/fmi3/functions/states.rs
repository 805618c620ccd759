//! Saving and restoring the state of an instance.

use crate::ffi;
use crate::fmi3::types::*;

export! {
    /// Saves the state. Where `*FMUState` is not NULL it is a state saved before, whose memory is used again.
    fn fmi3GetFMUState(FMUState: *mut fmi3FMUState) as State |instance| ffi::get(instance, FMUState);
    /// Goes back to a state saved by an instance of the same FMU. The state stays as it is and can be set again.
    fn fmi3SetFMUState(FMUState: fmi3FMUState) as State |instance| ffi::set(instance, FMUState);
    /// Frees a state and sets the host's pointer to NULL; no state is ignored.
    fn fmi3FreeFMUState(FMUState: *mut fmi3FMUState) as State |_| ffi::free(FMUState);
    /// Number of bytes that [`fmi3SerializeFMUState`] writes for this state.
    fn fmi3SerializedFMUStateSize(FMUState: fmi3FMUState, size: *mut usize) as State |_| {
        ffi::serialized_size(FMUState, size)
    };
    /// Writes a state as bytes that any process with this FMU can read.
    fn fmi3SerializeFMUState(FMUState: fmi3FMUState, serializedState: *mut fmi3Byte, size: usize) as State |_| {
        ffi::serialize(FMUState, serializedState, size, "fmi3SerializedFMUStateSize")
    };
    /// Makes a state of the bytes that [`fmi3SerializeFMUState`] wrote, also in another process.
    fn fmi3DeserializeFMUState(
        serializedState: *const fmi3Byte, size: usize, FMUState: *mut fmi3FMUState,
    ) as State |instance| {
        ffi::deserialize(instance, serializedState, size, FMUState)
    };
}
