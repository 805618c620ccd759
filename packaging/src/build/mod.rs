//! Building an FMU: from the user's choice to the files in the zip file.
//!
//! [`Choice`] makes a checked recipe from the user's arguments, [`Workspace`] compiles a binary, [`Ready`] takes
//! binaries from another FMU, and [`entries`] puts description, documentation and binaries together.

mod choice;
mod compile;
mod contents;
mod names;
mod page;
mod restitution;
mod source;

pub use choice::{Choice, PRESETS, Preset};
pub use compile::Workspace;
pub use contents::{Binary, entries};
pub use restitution::Restitution;
pub use source::{Ready, replaced};
