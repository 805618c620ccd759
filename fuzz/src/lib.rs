//! What the fuzz targets share: the host of the tests, the interface as the description tells it, and a model of what is legal.

pub mod interface;
pub mod model;
pub mod operation;
