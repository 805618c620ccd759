//! What is wrong with an FMU: its entries, its description, its binaries, and what the binary answers. Damage of any kind is
//! reported, whoever wrote the FMU.
//!
//! [`file()`] and [`bytes()`] check a whole FMU and hand out a [`Report`]. What they read on the way is here, too, for those who
//! only want to look: the entries by [`unpack()`], the description as `Model`, a binary as `Library`.

mod arrays;
mod binary;
mod description;
mod exchange;
mod exchange3;
mod fmu;
mod folder;
mod own;
pub mod probe;
mod report;
mod unpack;

pub(crate) use binary::Library;
pub(crate) use description::Model;
pub use fmu::{MAX_BYTES, bytes, file, read};
pub use report::Report;
pub use unpack::unpack;
