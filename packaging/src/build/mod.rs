//! Building an FMU: from what the user chooses to the files that go into the zip file.
//!
//! [`Choice`] collects what the user asks for and makes a checked recipe of it, [`Workspace`] compiles a binary,
//! [`Ready`] takes those of another FMU, and [`entries`] puts description, documentation and binaries together.

mod choice;
mod compile;
mod contents;
mod date;
mod names;
mod page;
mod preset;
mod source;
mod standard;

pub use choice::{Choice, in_words};
pub use compile::Workspace;
pub use contents::{Binary, entries};
pub use names::did_you_mean;
pub use preset::{PRESETS, Preset};
pub use source::{Ready, checkout, replaced};
pub use standard::Standard;
