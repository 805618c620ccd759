//! What the C functions of all versions of the standard share.
//!
//! Every exported function goes through [`call`]: null and foreign components are refused, calls that are not legal in
//! the current phase are refused and logged, and a panic is caught before it reaches the host. Pointers are checked for
//! null and alignment; beyond that they must be what the standard says.
#![allow(unsafe_code)]

mod arrays;
mod component;
mod resources;
mod states;

pub(crate) use arrays::{answer, array, array_mut, categories, fill, log_line, text, write};
pub(crate) use component::{Component, Version, call, call_small, create};
pub(crate) use resources::{at_location, at_path, start_values};
pub(crate) use states::{deserialize, free, get, serialize, serialized_size, set};
