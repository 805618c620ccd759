//! Arrays and texts of the host.

use std::ffi::{CStr, CString, c_char};
use std::mem::MaybeUninit;

use crate::variables::{LogCategory, Refusal, ensure};

/// The array of `count` values at `pointer`.
///
/// # Safety
/// `pointer` is null, misaligned, or points to `count` values that live for `'a`.
pub(crate) unsafe fn array<'a, T>(name: &'static str, pointer: *const T, count: usize) -> Result<&'a [T], Refusal> {
    if count == 0 {
        return Ok(&[]);
    }
    check(name, pointer, count)?;
    // SAFETY: checked as far as it can be; the rest is the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// The array at `pointer` for `count` values to be written; it need not be initialized.
///
/// # Safety
/// As for [`array()`], and nobody else uses it for `'a`.
pub(crate) unsafe fn array_mut<'a, T>(
    name: &'static str,
    pointer: *mut T,
    count: usize,
) -> Result<&'a mut [MaybeUninit<T>], Refusal> {
    if count == 0 {
        return Ok(&mut []);
    }
    check(name, pointer, count)?;
    // SAFETY: as in `array`.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer.cast(), count) })
}

fn check<T>(name: &'static str, pointer: *const T, count: usize) -> Result<(), Refusal> {
    let fits = count.checked_mul(size_of::<T>()).is_some_and(|bytes| isize::try_from(bytes).is_ok());
    ensure(!pointer.is_null() && pointer.is_aligned() && fits, || no_array(name, pointer.cast(), count))
}

#[cold]
fn no_array(name: &str, pointer: *const (), count: usize) -> Refusal {
    Refusal::argument(name, shown(pointer), format_args!("an array of {count}"))
}

/// A pointer for messages.
pub(super) fn shown(pointer: *const ()) -> String {
    if pointer.is_null() { "NULL".to_owned() } else { format!("{pointer:p}") }
}

pub(crate) fn fill<T>(places: &mut [MaybeUninit<T>], values: impl IntoIterator<Item = T>) {
    places.iter_mut().zip(values).for_each(|(place, value)| *place = MaybeUninit::new(value));
}

/// Writes `values` to `places`; refuses if their number is not `given`, the host's argument `count`.
///
/// # Safety
/// As for [`array_mut()`].
pub(crate) unsafe fn write<T>(
    name: &'static str,
    places: *mut T,
    (count, given): (&str, usize),
    values: Vec<T>,
) -> Result<(), Refusal> {
    Refusal::unless_count(count, given, values.len())?;
    // SAFETY: as the caller promises.
    fill(unsafe { array_mut(name, places, given) }?, values);
    Ok(())
}

/// Writes an answer to the place that the host has for it.
///
/// # Safety
/// As for [`array_mut()`].
pub(crate) unsafe fn answer<T>(name: &'static str, place: *mut T, value: T) -> Result<(), Refusal> {
    // SAFETY: as the caller promises.
    fill(unsafe { array_mut(name, place, 1) }?, [value]);
    Ok(())
}

/// A text of the host; NULL is an empty one.
///
/// # Safety
/// `text` is NULL or null-terminated, and lives for `'a`.
pub(crate) unsafe fn text<'a>(text: *const c_char) -> &'a CStr {
    // SAFETY: not NULL here, the rest is the caller's promise.
    if text.is_null() { c"" } else { unsafe { CStr::from_ptr(text) } }
}

/// Category and message of a log line for the host. Some hosts expand `#r123#` to a variable's name, so `#` is doubled;
/// so is `%`, where the message is a `format` of printf.
pub(crate) fn log_line(category: LogCategory, text: &str, format: bool) -> [CString; 2] {
    let text = text.replace('\0', "").replace('#', "##");
    let text = if format { text.replace('%', "%%") } else { text };
    [LogCategory::ITEMS[category as usize].name, &text].map(|text| CString::new(text).unwrap_or_default())
}

/// The log categories of these names.
///
/// # Safety
/// As for [`text()`].
pub(crate) unsafe fn categories(names: &[*const c_char]) -> Result<Vec<LogCategory>, Refusal> {
    let category = |name: &*const c_char| {
        // SAFETY: as the caller promises.
        let name = if name.is_null() { c"NULL" } else { unsafe { text(*name) } }.to_string_lossy();
        let known = LogCategory::ITEMS.iter().find(|item| item.name == name);
        let known = known.and_then(|item| LogCategory::numbered(item.value));
        let allowed = || LogCategory::ITEMS.iter().map(|item| item.name).collect::<Vec<_>>().join(", ");
        known.ok_or_else(|| Refusal::argument("category", &name, allowed()))
    };
    names.iter().map(category).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_with_percent_signs_is_not_expanded() {
        let message = |format| log_line(LogCategory::Error, "100 %s of #r1#\0!", format)[1].clone();
        assert_eq!(
            (message(true).as_c_str(), message(false).as_c_str()),
            (c"100 %%s of ##r1##!", c"100 %s of ##r1##!")
        );
    }
}
