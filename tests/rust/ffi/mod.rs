//! The C interface: input from outside must do no harm. The package `fuzz` has these tests, too, with AddressSanitizer.

mod bad_input;
mod legality;
mod states;
