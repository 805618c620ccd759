//! Building an FMU: from the user's choice to the files in the zip file.
//!
//! [`Choice`] makes a checked recipe of the user's arguments, [`Workspace`] compiles a binary, [`Ready`] takes those of
//! another FMU, and [`entries`] puts description, documentation and binaries together.

mod choice;
mod compile;
mod contents;
mod names;
mod page;
mod source;

pub use choice::{Choice, PRESETS, Preset, in_words};
pub use compile::Workspace;
pub use contents::{Binary, entries};
pub use source::{Ready, in_checkout, replaced};

/// The version of FMI that an FMU follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standard {
    /// FMI 2.0.
    Fmi2,
    /// FMI 3.0.
    Fmi3 {
        /// Whether it has clocks, which some hosts do not support.
        clocks: bool,
        /// Whether the elements of arrays are scalars, for hosts that do not support arrays.
        scalars: bool,
    },
}

impl Standard {
    /// Whether it has clocks.
    fn has_clocks(self) -> bool {
        matches!(self, Self::Fmi3 { clocks: true, .. })
    }

    /// Whether it has arrays.
    pub fn has_arrays(self) -> bool {
        matches!(self, Self::Fmi3 { scalars: false, .. })
    }
}
