//! The producer of the Newton's cradle FMU: chooses a cradle, compiles or takes binaries, writes the .fmu, and checks any FMU.
//!
//! | module | what it does |
//! |---|---|
//! | [`choice`] | a cradle from presets, parameter files and single start values |
//! | [`compile`] | the shared library, with Cargo |
//! | [`platform`] | folders of the standard, target triples, and what a binary is made for |
//! | [`contents`], [`archive`] | the files of an FMU, and the zip file, the same bytes for the same contents |
//! | [`check`], [`info`] | what is wrong with an FMU, whoever wrote it, and what is in it |
//! | [`animation`] | a run as a page for the browser, by the Python package |

#![deny(unsafe_code)]

pub mod animation;
pub mod archive;
pub mod check;
pub mod choice;
pub mod compile;
pub mod contents;
pub mod date;
pub mod info;
pub mod page;
pub mod platform;

/// What went wrong, in words for the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// The arguments ask for something that does not exist or is not allowed.
    Usage(String),
    /// Something did not work: a file, a program, a device.
    Failure(String),
}

impl std::fmt::Display for Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Usage(text) | Self::Failure(text) => f.write_str(text),
        }
    }
}

impl std::error::Error for Error {}
