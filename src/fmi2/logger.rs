//! From our log to the host's logger.

use std::ffi::{CStr, CString};

use super::types::{fmi2CallbackFunctions, fmi2Status};
use crate::instance::{Severity, Sink};

/// A way to the host's logger, if it has one. The name is copied: the host may free its own.
pub(super) fn sink(functions: &fmi2CallbackFunctions, instance_name: &CStr) -> Option<Sink> {
    let logger = functions.logger?;
    let environment = functions.componentEnvironment;
    let name = instance_name.to_owned();
    Some(Box::new(move |severity, category, text| {
        let (category, message) = (CString::new(category.name()).unwrap_or_default(), message(text));
        // SAFETY: the host promises that its logger can be called with its environment while the instance lives. The
        // message is a format without conversions, so that no further argument is read.
        unsafe { logger(environment, name.as_ptr(), status(severity), category.as_ptr(), message.as_ptr()) }
    }))
}

fn status(severity: Severity) -> fmi2Status {
    match severity {
        Severity::Ok => fmi2Status::fmi2OK,
        Severity::Warning => fmi2Status::fmi2Warning,
        Severity::Discard => fmi2Status::fmi2Discard,
        Severity::Error => fmi2Status::fmi2Error,
        Severity::Fatal => fmi2Status::fmi2Fatal,
    }
}

/// A message is a printf format, and some hosts expand `#r123#` to a variable's name: both signs are doubled.
fn message(text: &str) -> CString {
    CString::new(text.replace('\0', "").replace('%', "%%").replace('#', "##")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_in_a_message_is_expanded() {
        assert_eq!(message("100 %s of #r1#\0!").as_c_str(), c"100 %%s of ##r1##!");
    }
}
