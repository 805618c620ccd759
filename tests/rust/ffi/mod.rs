//! The C interface: what comes from outside and must do no harm. The package `fuzz` has these tests, too, with
//! AddressSanitizer.

mod bad_input;
mod legality;
mod states;
