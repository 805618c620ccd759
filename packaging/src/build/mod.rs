//! Building an FMU: from what the user chooses to the files that go into the zip file.
//!
//! [`Choice`] collects what the user asks for and makes a checked recipe of it, [`Workspace`] compiles a binary, and [`entries`]
//! puts description, documentation and binaries together.

mod choice;
mod compile;
mod contents;
mod date;
mod page;

pub use choice::{Choice, PRESETS, Preset, in_words};
pub use compile::Workspace;
pub use contents::{Binary, entries};
