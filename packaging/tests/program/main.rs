//! The tests of the program, as one program: linking is most of what each costs.

mod command;
mod damage;
mod licenses;
#[cfg(unix)]
mod page;
mod support;
