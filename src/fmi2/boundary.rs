//! From C to Rust: components, arrays, and the guard that every call passes.

use std::cell::{Cell, UnsafeCell};
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::types::{fmi2Component, fmi2Status};
use crate::instance::{Call, Instance, Refusal};

/// Marks memory as a component of ours; "cradleF2" in ASCII.
const MAGIC: u64 = 0x6372_6164_6c65_4632;

/// What `fmi2Component` points to.
pub(super) struct Component {
    magic: Cell<u64>,
    /// A call is being made: one that comes in meanwhile can only come from the host's logger, and is refused.
    busy: Cell<bool>,
    /// A panic was caught; the instance can only be freed.
    poisoned: Cell<bool>,
    instance: UnsafeCell<Instance>,
}

impl Component {
    /// Hands an instance over to the host.
    pub(super) fn into_raw(instance: Instance) -> fmi2Component {
        let component = Self {
            magic: Cell::new(MAGIC),
            busy: Cell::new(false),
            poisoned: Cell::new(false),
            instance: UnsafeCell::new(instance),
        };
        Box::into_raw(Box::new(component)).cast()
    }

    /// The component behind a pointer; nothing for null and, as far as it can be told, for what is no component.
    ///
    /// # Safety
    /// `c` is null or points to readable memory of at least the size of a component that lives for `'a`.
    #[inline]
    unsafe fn from_raw<'a>(c: fmi2Component) -> Option<&'a Self> {
        let component: *const Self = c.cast();
        if component.is_null() || !component.is_aligned() {
            return None;
        }
        // SAFETY: not null, aligned, and alive as the caller promises.
        let component = unsafe { &*component };
        (component.magic.get() == MAGIC).then_some(component)
    }

    /// Frees a component; null, and a component in the middle of a call, are left alone.
    ///
    /// # Safety
    /// As for [`Component::from_raw`], and nobody uses `c` afterwards.
    pub(super) unsafe fn free(c: fmi2Component) {
        // SAFETY: as the caller promises.
        let component = unsafe { Self::from_raw(c) };
        if let Some(component) = component.filter(|component| !component.busy.get()) {
            component.magic.set(0);
            // SAFETY: it came out of `into_raw`, as the magic number says, and no reference to it is left.
            let owned = unsafe { Box::from_raw(c.cast::<Self>()) };
            let _ = catch_unwind(AssertUnwindSafe(|| drop(owned)));
        }
    }
}

/// Makes one call of the host: checks the component, asks whether the call is legal now, runs `body`, logs why it was
/// refused, and catches a panic.
///
/// # Safety
/// As for [`Component::from_raw`].
#[inline]
pub(super) unsafe fn call(
    c: fmi2Component,
    function: &'static str,
    call: Call,
    body: impl FnOnce(&mut Instance) -> Result<(), Refusal>,
) -> fmi2Status {
    // SAFETY: as the caller promises.
    let Some(component) = (unsafe { Component::from_raw(c) }) else { return fmi2Status::fmi2Error };
    if component.poisoned.get() {
        return fmi2Status::fmi2Fatal;
    }
    if component.busy.replace(true) {
        return fmi2Status::fmi2Error;
    }
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: `busy` makes this the only reference while the call lasts.
        let instance = unsafe { &mut *component.instance.get() };
        let outcome = instance.require(call).and_then(|()| body(instance));
        outcome.inspect_err(|refusal| instance.log.error(format_args!("{function}: {refusal}"))).is_ok()
    }));
    let status = match outcome {
        Ok(true) => fmi2Status::fmi2OK,
        Ok(false) => fmi2Status::fmi2Error,
        Err(panic) => poison(component, function, panic.as_ref()),
    };
    component.busy.set(false);
    status
}

/// After a panic the instance may be in any state: it is given up.
#[cold]
fn poison(component: &Component, function: &str, panic: &(dyn std::any::Any + Send)) -> fmi2Status {
    component.poisoned.set(true);
    let reason = panic
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("unknown reason");
    let _ = catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: `busy` is still set, so that this is the only reference; the log is never changed in the middle of
        // something that panics.
        let instance = unsafe { &*component.instance.get() };
        instance.log.fatal(format_args!("{function}: internal error, the instance can only be freed: {reason}"));
    }));
    fmi2Status::fmi2Fatal
}

/// The array of `count` values at `pointer`.
///
/// # Safety
/// `pointer` is null, misaligned, or points to `count` values that live for `'a`.
pub(super) unsafe fn array<'a, T>(name: &'static str, pointer: *const T, count: usize) -> Result<&'a [T], Refusal> {
    if count == 0 {
        return Ok(&[]);
    }
    check(name, pointer, count)?;
    // SAFETY: checked as far as it can be; the rest is the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// The array at `pointer` that `count` values are to be written to; what it holds need not be initialized.
///
/// # Safety
/// As for [`array()`], and nobody else uses it for `'a`.
pub(super) unsafe fn array_mut<'a, T>(
    name: &'static str,
    pointer: *mut T,
    count: usize,
) -> Result<&'a mut [MaybeUninit<T>], Refusal> {
    if count == 0 {
        return Ok(&mut []);
    }
    check(name, pointer, count)?;
    // SAFETY: as above.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer.cast(), count) })
}

fn check<T>(name: &'static str, pointer: *const T, count: usize) -> Result<(), Refusal> {
    let fits = count.checked_mul(size_of::<T>()).is_some_and(|bytes| isize::try_from(bytes).is_ok());
    if !pointer.is_null() && pointer.is_aligned() && fits { Ok(()) } else { Err(no_array(name, pointer.cast(), count)) }
}

#[cold]
fn no_array(name: &'static str, pointer: *const (), count: usize) -> Refusal {
    let value = if pointer.is_null() { "NULL".to_owned() } else { format!("{pointer:p}") };
    Refusal::Argument { name, value, allowed: format!("an array of {count}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instance::{Kind, Log, Severity};
    use crate::variables::Settings;
    use std::cell::RefCell;
    use std::rc::Rc;

    type Lines = Rc<RefCell<Vec<(Severity, String)>>>;

    fn component() -> (fmi2Component, Lines) {
        let lines = Lines::default();
        let kept = lines.clone();
        let sink = move |severity, _, text: &str| kept.borrow_mut().push((severity, text.to_owned()));
        let log = Log::new(Some(Box::new(sink)), false);
        (Component::into_raw(Instance::new(Kind::CoSimulation, Settings::default_for(5), String::new(), log)), lines)
    }

    /// Resets the component, and makes of that call whatever `body` does.
    fn reset(c: fmi2Component, body: impl FnOnce(&mut Instance)) -> fmi2Status {
        unsafe {
            call(c, "fmi2Reset", Call::Reset, |instance| {
                body(instance);
                instance.reset()
            })
        }
    }

    #[test]
    fn a_panic_is_fatal_and_the_instance_can_only_be_freed() {
        let (c, lines) = component();
        assert_eq!(reset(c, |_| panic!("by test")), fmi2Status::fmi2Fatal);
        let (severity, text) = lines.borrow()[0].clone();
        assert!(severity == Severity::Fatal && text.contains("fmi2Reset: internal error") && text.contains("by test"));
        assert_eq!(reset(c, |_| {}), fmi2Status::fmi2Fatal);
        unsafe { Component::free(c) };
    }

    #[test]
    fn a_call_from_within_a_call_is_refused() {
        let (c, _) = component();
        let mut inner = fmi2Status::fmi2OK;
        let outer = reset(c, |_| {
            inner = reset(c, |_| {});
            unsafe { Component::free(c) }; // Left alone.
        });
        assert_eq!((outer, inner), (fmi2Status::fmi2OK, fmi2Status::fmi2Error));
        assert_eq!(reset(c, |_| {}), fmi2Status::fmi2OK);
        unsafe { Component::free(c) };
    }

    #[test]
    fn arrays_are_checked() {
        let values = [1.0, 2.0];
        unsafe {
            assert_eq!(array("value", values.as_ptr(), 2).unwrap(), &values);
            assert!(array::<f64>("value", std::ptr::null(), 0).unwrap().is_empty());
            assert!(array::<f64>("value", std::ptr::null(), 1).is_err());
            assert!(array::<f64>("value", 9 as *const f64, 1).is_err());
            assert!(array("value", values.as_ptr(), usize::MAX / 2).is_err());
        }
    }
}
