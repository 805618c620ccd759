//! What the fuzz targets share: forged states, values of variables, and a picture of what is legal in FMI 3.0.

pub mod forgery;
pub mod hybrid;
pub mod inspection;
pub mod values;
