//! What is wrong with an FMU that this program has written: its entries, its description, its binaries. Damage of any
//! kind is reported, also that of files that are no such FMU.
//!
//! [`bytes()`] checks a whole FMU and hands out a [`Report`]. What it reads on the way is here, too, for those who only
//! want to look: the entries by [`unpack()`], the description as `Model`, a binary as `Library`.

mod binary;
mod fmu;
mod model;
mod own;
mod report;
mod unpack;

pub(crate) use binary::Library;
pub use fmu::{MAX_BYTES, bytes, read};
pub(crate) use model::Model;
pub use report::Report;
pub use unpack::unpack;
