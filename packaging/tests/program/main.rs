//! The tests of the program, as one program: linking is most of what each costs.

#![expect(clippy::unwrap_used, reason = "what goes wrong fails the test")]

mod command;
mod damage;
mod installed;
mod restitution;
mod support;
