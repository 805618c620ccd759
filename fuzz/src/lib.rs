//! What the fuzz targets share: the host of the tests, the interface as the description tells it, and a model of what
//! is legal.

pub mod forgery;
pub mod hybrid;
pub mod inspection;
pub mod instance3;
pub mod interface;
pub mod model;
pub mod operation;
