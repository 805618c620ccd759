//! The C ABI of FMI 2.0 for co-simulation and model exchange.
//!
//! Every exported function goes through the guard in `ffi`.
//!
//! # Safety
//! The exported functions are called from C. Pointers are checked for null and alignment; beyond that the standard's
//! rules are relied on: arrays as long as their count, null-terminated texts, a component not yet freed, one thread at
//! a time per component.
#![allow(unsafe_code, non_camel_case_types, non_upper_case_globals, non_snake_case)]

mod functions;
mod types;

pub use functions::*;
pub use types::*;

use crate::ffi::Version;
use crate::instance::{Instance, Severity};
use crate::variables::{LogCategory, Refusal, RefusalCause};

struct Fmi2;

impl Version for Fmi2 {
    // "cradleF2" in ASCII.
    const MAGIC: u64 = 0x6372_6164_6c65_4632;
    type Status = fmi2Status;
    const STATUSES: [fmi2Status; 5] = {
        use fmi2Status::*;
        [fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal]
    };

    /// The instance is unchanged.
    fn refused(instance: &mut Instance, function: &str, refusal: &Refusal) -> fmi2Status {
        if refusal.cause == RefusalCause::State {
            instance.log.write(Severity::Discard, LogCategory::Discard, format_args!("{function}: {refusal}"));
            return fmi2Status::fmi2Discard;
        }
        instance.log.error(format_args!("{function}: {refusal}"));
        fmi2Status::fmi2Error
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ffi::{Component, HostFenv, call};
    use crate::instance::{Call, Kind, Log, Purpose, Start};
    use crate::variables::Settings;
    use std::cell::RefCell;
    use std::ffi::c_void;
    use std::rc::Rc;

    fn component(log: Log) -> *mut c_void {
        let purpose = Purpose::fmi2(Kind::CoSimulation);
        let start = Start { purpose, settings: Settings::default_for(5), scalars: true, guid: String::new() };
        Component::into_raw(Instance::new(start, log), Fmi2, HostFenv::default())
    }

    /// Resets the component, with `body` as the body of that call.
    fn reset(c: *mut c_void, mut body: impl FnMut(&mut Instance)) -> fmi2Status {
        unsafe {
            call::<Fmi2>(c, "fmi2Reset", Call::RESET, &mut |instance| {
                body(instance);
                instance.reset();
                Ok(())
            })
        }
    }

    #[test]
    fn panic_is_fatal_and_the_instance_can_only_be_freed() {
        let lines = Rc::new(RefCell::new(Vec::new()));
        let kept = lines.clone();
        let sink = move |severity, _, text: &str| kept.borrow_mut().push((severity, text.to_owned()));
        let c = component(Log::new(Some(Box::new(sink)), false, true));
        assert_eq!(reset(c, |_| panic!("by test")), fmi2Status::fmi2Fatal);
        let (severity, text) = lines.borrow()[0].clone();
        assert!(severity == Severity::Fatal && text.contains("fmi2Reset: internal error") && text.contains("by test"));
        assert_eq!(reset(c, |_| {}), fmi2Status::fmi2Fatal);
        unsafe { Component::<Fmi2>::free(c) };
    }

    #[test]
    fn call_from_within_a_call_is_refused() {
        let c = component(Log::new(None, false, true));
        let mut inner = fmi2Status::fmi2OK;
        let outer = reset(c, |_| {
            inner = reset(c, |_| {});
            unsafe { Component::<Fmi2>::free(c) }; // Ignored during a call.
        });
        assert_eq!((outer, inner), (fmi2Status::fmi2OK, fmi2Status::fmi2Error));
        assert_eq!(reset(c, |_| {}), fmi2Status::fmi2OK);
        unsafe { Component::<Fmi2>::free(c) };
    }
}
