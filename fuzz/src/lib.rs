//! What the fuzz targets share: the host of the tests, the interface as the description tells it, and a picture
//! of what is legal in FMI 3.0.

pub mod forgery;
pub mod hybrid;
pub mod inspection;
pub mod interface;
pub mod values;
