//! What the fuzz targets share: the host of the tests, the interface as the description tells it, and a model of what
//! is legal.

pub mod forgery;
pub mod hybrid;
pub mod inspection;
pub mod interface;
pub mod values;
