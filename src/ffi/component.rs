//! Components, and the guard that every call passes.

use std::cell::{Cell, UnsafeCell};
use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::fenv::HostFenv;
use crate::instance::{Call, Instance, Log, Severity, Start};
use crate::variables::{LogCategory, Refusal};

pub(crate) trait Version {
    /// Marks memory as a component of this version.
    const MAGIC: u64;
    type Status: Copy + 'static;
    /// The status for each [`Severity`], in its order.
    const STATUSES: [Self::Status; 5];

    fn status(of: Severity) -> Self::Status {
        Self::STATUSES[of as usize]
    }

    /// Handles the refusal of a call of `function`: logs the reason, changes the instance, returns the status.
    fn refused(instance: &mut Instance, function: &str, refusal: &Refusal) -> Self::Status;
}

/// What the host's pointer points to. The magic number comes first, whatever the version.
#[repr(C)]
pub(crate) struct Component<V> {
    magic: Cell<u64>,
    /// The host's callbacks beside its logger.
    callbacks: V,
    fenv: HostFenv,
    /// Whether a call is in progress: another one can only come from the host's logger, and is refused.
    busy: Cell<bool>,
    /// Whether a panic was caught: the instance can only be freed.
    poisoned: Cell<bool>,
    /// Whether the host is being called within a step: it may make calls, but not free the instance.
    calling_host: Cell<bool>,
    instance: UnsafeCell<Instance>,
}

/// The pointer to a new component for the host; `log` calls the host in its own `fenv`. NULL if `make` panics, or if it
/// refuses: then the log says why `function` failed.
pub(crate) fn create<V: Version>(
    function: &str,
    (fenv, log): (HostFenv, Log),
    callbacks: V,
    make: impl FnOnce(&Log) -> Result<Start, Refusal>,
) -> *mut c_void {
    let _inside = fenv.enter();
    let made = catch_unwind(AssertUnwindSafe(|| {
        let start = make(&log).map_err(|reason| log.error(format_args!("{function}: {reason}"))).ok()?;
        Some(Component::into_raw(Instance::new(start, log), callbacks, fenv.clone()))
    }));
    made.ok().flatten().unwrap_or(std::ptr::null_mut())
}

impl<V: Version> Component<V> {
    pub(crate) fn into_raw(instance: Instance, callbacks: V, fenv: HostFenv) -> *mut c_void {
        let component = Self {
            magic: Cell::new(V::MAGIC),
            callbacks,
            fenv,
            busy: Cell::new(false),
            poisoned: Cell::new(false),
            calling_host: Cell::new(false),
            instance: UnsafeCell::new(instance),
        };
        Box::into_raw(Box::new(component)).cast()
    }

    /// The component behind a pointer, if it is one of this version.
    ///
    /// # Safety
    /// As for [`marked`], of a component that lives for `'a`.
    #[inline]
    unsafe fn from_raw<'a>(c: *mut c_void) -> Option<&'a Self> {
        // SAFETY: as the caller promises.
        unsafe { marked::<Self>(c, V::MAGIC).map(|component| &*component) }
    }

    /// Frees a component; null and a component within a call are left alone.
    ///
    /// # Safety
    /// As for [`Component::from_raw`], and nobody uses `c` afterwards.
    pub(crate) unsafe fn free(c: *mut c_void) {
        // SAFETY: as the caller promises.
        let component = unsafe { Self::from_raw(c) };
        if let Some(component) = component.filter(|component| !component.busy.get() && !component.calling_host.get()) {
            let fenv = component.fenv.clone();
            let _inside = fenv.enter();
            component.magic.set(0);
            // SAFETY: it came out of `into_raw`, as the magic number says, and no reference to it is left.
            let owned = unsafe { Box::from_raw(c.cast::<Self>()) };
            let _ = catch_unwind(AssertUnwindSafe(|| drop(owned)));
        }
    }

    /// Calls the host between two parts of a step, in its own floating-point environment; `None` if there is no
    /// component.
    ///
    /// # Safety
    /// As for [`Component::from_raw`].
    pub(crate) unsafe fn call_host<T>(c: *mut c_void, host: impl FnOnce(&V) -> T) -> Option<T> {
        // SAFETY: as the caller promises.
        let component = unsafe { Self::from_raw(c) }?;
        // Meanwhile the host may try another step. It is refused, but also passes here: the flag must stay set.
        let before = component.calling_host.replace(true);
        let done = host(&component.callbacks);
        component.calling_host.set(before);
        Some(done)
    }
}

/// What a pointer of the host points to, if that begins with the number `magic`; `None` for null and, as far as can be
/// detected, for foreign pointers.
///
/// # Safety
/// `pointer` is null or points to readable memory of at least the size of a `T`, which begins with a number.
#[inline]
pub(super) unsafe fn marked<T>(pointer: *mut c_void, magic: u64) -> Option<*mut T> {
    let place: *mut T = pointer.cast();
    // SAFETY: not null, aligned, and readable as the caller promises.
    let known = !place.is_null() && place.is_aligned() && unsafe { place.cast::<u64>().read() } == magic;
    known.then_some(place)
}

/// Executes one call of the host: checks the component and the legality of the call, runs `body` in the default
/// floating-point environment, logs a refusal, and catches a panic.
///
/// # Safety
/// As for [`Component::from_raw`].
pub(crate) unsafe fn call<V: Version>(
    c: *mut c_void,
    function: &'static str,
    call: Call,
    body: &mut dyn FnMut(&mut Instance) -> Result<(), Refusal>,
) -> V::Status {
    // SAFETY: as the caller promises.
    let Some(component) = (unsafe { Component::<V>::from_raw(c) }) else { return V::status(Severity::Error) };
    if component.poisoned.get() {
        return V::status(Severity::Fatal);
    }
    if component.busy.replace(true) {
        return V::status(Severity::Error);
    }
    let _inside = component.fenv.enter();
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: `busy` makes this the only reference while the call lasts.
        let instance = unsafe { &mut *component.instance.get() };
        match instance.require(call).and_then(|()| body(instance)) {
            Ok(()) => V::status(Severity::Ok),
            Err(refusal) => V::refused(instance, function, &refusal),
        }
    }));
    let status = outcome.unwrap_or_else(|panic| {
        poison(component, function, panic.as_ref());
        V::status(Severity::Fatal)
    });
    component.busy.set(false);
    status
}

/// After a panic the instance may be in any state: it is given up.
#[cold]
fn poison<V>(component: &Component<V>, function: &str, panic: &(dyn std::any::Any + Send)) {
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
        let text = format_args!("{function}: internal error, the instance can only be freed: {reason}");
        instance.log.write(Severity::Fatal, LogCategory::Error, text);
    }));
}
