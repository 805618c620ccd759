#![deny(unsafe_code)]

pub mod engine;
pub mod fmi2;
pub mod instance;
pub mod model;
pub mod solver;
pub mod variables;
