//! modelDescription.xml: [`Model`] is what it says, as far as the checks need it, and the other modules check that.

pub(super) mod arrays;
pub(super) mod attributes;
pub(super) mod model;
mod reader;
pub(super) mod structure;
pub(super) mod variables;

pub use model::Model;
