//! Getting and setting values: all elements of the arrays asked for, one after the other.

use crate::ffi::{array, array_mut};
use crate::fmi3::types::*;
use crate::variables::{Refusal, Type};

/// Error for a type that no variable has, if any is asked for.
fn refuse_type(asked: usize) -> Result<(), Refusal> {
    if asked == 0 { Ok(()) } else { Err(Refusal::new("no variable is of this type")) }
}

/// Exports getter and setter of a type that variables have.
macro_rules! values {
    ($(
        $(#[$got:meta])* $get:ident
        $(#[$is_set:meta])* $set:ident($type:ty = $asked:ident) as $call:ident;
    )*) => {
        export! {$(
            $(#[$got])*
            fn $get(
                valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut $type, nValues: usize,
            ) as GET_ARRAYS |instance| {
                let references = array("valueReferences", valueReferences, nValueReferences)?;
                instance.get(Type::$asked, references, array_mut("values", values, nValues)?, |value| value as $type)
            };
            $(#[$is_set])*
            fn $set(
                valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const $type,
                nValues: usize,
            ) as $call |instance| {
                let references = array("valueReferences", valueReferences, nValueReferences)?;
                instance.set(Type::$asked, references, array("values", values, nValues)?, |value| value as f64)
            };
        )*}
    };
}

values! {
    /// Reads real variables.
    fmi3GetFloat64
    /// Sets real parameters, inputs and slopes: all, or none if any is refused.
    fmi3SetFloat64(f64 = Real) as SET;
    /// Reads counts, and `n`.
    fmi3GetUInt64
    /// Sets `n`, in Configuration Mode.
    fmi3SetUInt64(u64 = Integer) as SET_COUNTS;
    /// Reads enumerations.
    fmi3GetInt64
    /// Sets enumerations: all, or none if any is refused.
    fmi3SetInt64(i64 = Enumeration) as SET_DISCRETE;
    /// Reads truth values.
    fmi3GetBoolean
    /// No truth value can be set.
    fmi3SetBoolean(fmi3Boolean = Boolean) as SET_DISCRETE;
}

export! {
    /// Reads whether clocks are active.
    fn fmi3GetClock(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Clock,
    ) as GET_ARRAYS |instance| {
        let references = array("valueReferences", valueReferences, nValueReferences)?;
        let places = array_mut("values", values, nValueReferences)?;
        instance.get(Type::Clock, references, places, |value| value as fmi3Clock)
    };
    /// No clock can be set: all are outputs.
    fn fmi3SetClock(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Clock,
    ) as SET_DISCRETE |instance| {
        let references = array("valueReferences", valueReferences, nValueReferences)?;
        instance.set(Type::Clock, references, array("values", values, nValueReferences)?, f64::from)
    };
    /// Reads `log.pulses`. The bytes stay valid until the next call.
    fn fmi3GetBinary(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, valueSizes: *mut usize,
        values: *mut fmi3Binary, nValues: usize,
    ) as GET_ARRAYS |instance| {
        let references = array("valueReferences", valueReferences, nValueReferences)?;
        let (sizes, places) = (array_mut("valueSizes", valueSizes, nValues)?, array_mut("values", values, nValues)?);
        Refusal::unless_count("nValues", nValues, references.len())?;
        let bytes = instance.binary(references)?.as_bytes();
        for (size, place) in sizes.iter_mut().zip(places) {
            size.write(bytes.len());
            place.write(bytes.as_ptr());
        }
        Ok(())
    };
    /// No bytes can be set.
    fn fmi3SetBinary(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, _valueSizes: *const usize,
        values: *const fmi3Binary, nValues: usize,
    ) as SET_DISCRETE |instance| {
        let references = array("valueReferences", valueReferences, nValueReferences)?;
        instance.set(Type::Binary, references, array("values", values, nValues)?, |_| f64::NAN)
    };
}

/// Exports getter and setter of a type that no variable has.
macro_rules! no_such_type {
    ($($get:ident $set:ident $type:ty;)*) => {
        export! {$(
            /// There are no variables of this type.
            fn $get(
                _valueReferences: *const fmi3ValueReference, nValueReferences: usize, _values: *mut $type,
                _nValues: usize,
            ) as GET_ARRAYS |_| refuse_type(nValueReferences);
            /// There are no variables of this type.
            fn $set(
                _valueReferences: *const fmi3ValueReference, nValueReferences: usize, _values: *const $type,
                _nValues: usize,
            ) as SET_DISCRETE |_| refuse_type(nValueReferences);
        )*}
    };
}

no_such_type! {
    fmi3GetFloat32 fmi3SetFloat32 f32;
    fmi3GetInt8 fmi3SetInt8 i8;
    fmi3GetUInt8 fmi3SetUInt8 u8;
    fmi3GetInt16 fmi3SetInt16 i16;
    fmi3GetUInt16 fmi3SetUInt16 u16;
    fmi3GetInt32 fmi3SetInt32 i32;
    fmi3GetUInt32 fmi3SetUInt32 u32;
    fmi3GetString fmi3SetString fmi3String;
}
