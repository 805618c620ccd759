//! modelDescription.xml of FMI 2.0 and 3.0, written from the template, the table and the start values. [`Description`]
//! provides it with its GUID; [`LogCategory`] lists its log categories.

mod elements;
mod log_category;
mod structure;
mod xml;

pub use elements::padding;
pub use log_category::LogCategory;
pub use xml::{Description, MODEL_IDENTIFIER, START_TIME, STEP_SIZE, STOP_TIME};
