//! Getting and setting values: all elements of the arrays asked for, one after the other.

use crate::ffi::{array, array_mut};
use crate::fmi3::types::*;
use crate::instance::{Instance, Refusal, Value};
use crate::variables::ArrayType;

/// Fills the `count` places of `values` with the elements of the variables, all of this type.
///
/// # Safety
/// As for [`array()`] and [`array_mut()`].
unsafe fn get<T>(
    instance: &mut Instance,
    asked: ArrayType,
    references: (*const fmi3ValueReference, usize),
    values: (*mut T, usize),
    convert: fn(Value) -> T,
) -> Result<(), Refusal> {
    // SAFETY: as the caller promises.
    let (references, places) =
        unsafe { (array("valueReferences", references.0, references.1)?, array_mut("values", values.0, values.1)?) };
    instance.recompute()?;
    let mut found = 0;
    for reference in references {
        let array = instance.readable(*reference, asked)?;
        for index in 0..array.len(instance.balls()) {
            let value = instance.element(array, index)?;
            if let Some(place) = places.get_mut(found) {
                place.write(convert(value));
            }
            found += 1;
        }
    }
    if found == places.len() { Ok(()) } else { Err(wrong_count("nValues", places.len(), found)) }
}

fn float(value: Value) -> f64 {
    if let Value::Float(value) = value { value } else { 0.0 }
}

fn count(value: Value) -> u64 {
    if let Value::Count(value) = value { value } else { 0 }
}

fn item(value: Value) -> i64 {
    if let Value::Item(value) = value { value } else { 0 }
}

fn flag(value: Value) -> u8 {
    (value == Value::Flag(true)).into()
}

/// Says that there is room for another number of elements than there are.
#[cold]
pub(super) fn wrong_count(name: &'static str, given: usize, wanted: usize) -> Refusal {
    let allowed = format!("{wanted}, the elements of the variables");
    Refusal::Argument { name, value: given.to_string(), allowed }
}

/// Hands variables and values to `set`, which applies all of them or none.
///
/// # Safety
/// As for [`array()`].
unsafe fn set<T>(
    references: (*const fmi3ValueReference, usize),
    values: (*const T, usize),
    set: impl FnOnce(&[u32], &[T]) -> Result<(), Refusal>,
) -> Result<(), Refusal> {
    // SAFETY: as the caller promises.
    let references = unsafe { array("valueReferences", references.0, references.1)? };
    set(references, unsafe { array("values", values.0, values.1)? })
}

/// Says that there are no variables of this type, if any is asked for.
fn refuse_type(asked: usize) -> Result<(), Refusal> {
    if asked == 0 { Ok(()) } else { Err(Refusal::Unsupported("no variable is of this type")) }
}

export! {
    /// Reads real variables.
    fn fmi3GetFloat64(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Float64, nValues: usize,
    ) as GetArrays |instance| get(instance, ArrayType::Float64, (valueReferences, nValueReferences), (values, nValues), float);
    /// Reads counts, and `n`.
    fn fmi3GetUInt64(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3UInt64, nValues: usize,
    ) as GetArrays |instance| get(instance, ArrayType::UInt64, (valueReferences, nValueReferences), (values, nValues), count);
    /// Reads enumerations.
    fn fmi3GetInt64(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Int64, nValues: usize,
    ) as GetArrays |instance| get(instance, ArrayType::Enumeration, (valueReferences, nValueReferences), (values, nValues), item);
    /// Reads truth values.
    fn fmi3GetBoolean(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Boolean, nValues: usize,
    ) as GetArrays |instance| get(instance, ArrayType::Boolean, (valueReferences, nValueReferences), (values, nValues), flag);
    /// Reads whether clocks are active.
    fn fmi3GetClock(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *mut fmi3Clock,
    ) as GetArrays |instance| {
        get(instance, ArrayType::Clock, (valueReferences, nValueReferences), (values, nValueReferences), flag)
    };
    /// Sets real parameters, inputs and slopes: all of them, or none if any is refused.
    fn fmi3SetFloat64(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Float64, nValues: usize,
    ) as Set |instance| {
        set((valueReferences, nValueReferences), (values, nValues), |references, values| instance.set_floats(references, values))
    };
    /// Sets `n`, in Configuration Mode.
    fn fmi3SetUInt64(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3UInt64, nValues: usize,
    ) as SetCounts |instance| {
        set((valueReferences, nValueReferences), (values, nValues), |references, values| instance.set_counts(references, values))
    };
    /// Sets enumerations: all of them, or none if any is refused.
    fn fmi3SetInt64(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Int64, nValues: usize,
    ) as SetDiscrete |instance| {
        set((valueReferences, nValueReferences), (values, nValues), |references, values| instance.set_items(references, values))
    };
    /// No truth value can be set.
    fn fmi3SetBoolean(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Boolean, nValues: usize,
    ) as SetDiscrete |instance| {
        set((valueReferences, nValueReferences), (values, nValues), |references, _| {
            instance.refuse_to_set_arrays(references, ArrayType::Boolean)
        })
    };
    /// No clock can be set: those that there are tick by themselves.
    fn fmi3SetClock(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, values: *const fmi3Clock,
    ) as SetDiscrete |instance| {
        set((valueReferences, nValueReferences), (values, nValueReferences), |references, _| {
            instance.refuse_to_set_arrays(references, ArrayType::Clock)
        })
    };
    /// Reads `log.pulses`. The bytes stay where they are until the next call.
    fn fmi3GetBinary(
        valueReferences: *const fmi3ValueReference, nValueReferences: usize, valueSizes: *mut usize, values: *mut fmi3Binary,
        nValues: usize,
    ) as GetArrays |instance| {
        let references = array("valueReferences", valueReferences, nValueReferences)?;
        let (sizes, places) = (array_mut("valueSizes", valueSizes, nValues)?, array_mut("values", values, nValues)?);
        if nValues != references.len() {
            return Err(wrong_count("nValues", nValues, references.len()));
        }
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
        _values: *const fmi3Binary, _nValues: usize,
    ) as SetDiscrete |instance| {
        instance.refuse_to_set_arrays(array("valueReferences", valueReferences, nValueReferences)?, ArrayType::Binary)
    };
}

/// Exports getter and setter of a type that no variable has.
macro_rules! no_such_type {
    ($($get:ident $set:ident $type:ty;)*) => {
        export! {$(
            /// There are no variables of this type.
            fn $get(
                _valueReferences: *const fmi3ValueReference, nValueReferences: usize, _values: *mut $type, _nValues: usize,
            ) as GetArrays |_| refuse_type(nValueReferences);
            /// There are no variables of this type.
            fn $set(
                _valueReferences: *const fmi3ValueReference, nValueReferences: usize, _values: *const $type, _nValues: usize,
            ) as SetDiscrete |_| refuse_type(nValueReferences);
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
