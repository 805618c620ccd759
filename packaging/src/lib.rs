//! The producer of the Newton's cradle FMU: chooses a cradle, compiles or takes binaries, writes and checks the .fmu.
//!
//! | module | what it does |
//! |---|---|
//! | [`build`] | the files of an FMU: chosen cradle, description, pages, binary |
//! | [`check`] | what is wrong with an FMU that this program has written |
//! | [`info`] | what is in an FMU |
//! | [`mod@reference`] | parameter sets and reference results, and their check |
//! | [`environment`] | the Python package: its FMU, and commands handed over to it |
//! | [`archive`] | the zip file: the same bytes for the same contents |
//! | [`platform`] | folders of the standard, target triples, and what a binary is made for |
//! | [`universal`] | universal binaries of macOS |
//!
//! Failures that the user sees are [`Error`]s.

// In tests, a panic fails the test.
#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod archive;
pub mod build;
pub mod check;
pub mod environment;
mod error;
pub mod info;
pub mod platform;
pub mod reference;
pub mod universal;

pub use error::Error;
