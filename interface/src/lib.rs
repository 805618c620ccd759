//! What the Newton's cradle FMU and its producer share: the parameters, the variables, and what a run shows.
//!
//! It knows no run, so that the producer is built without the engine.
//!
//! | module | what it says |
//! |---|---|
//! | [`fmi2`] | the C types of FMI 2.0 |
//! | [`parameters`] | the parameters and inputs of a cradle, in SI units |
//! | [`results`] | what a run shows at its current time, and derivatives of that |
//! | [`variables`] | the interface as one table: names, types, units, ranges, description, access |

#![forbid(unsafe_code)]
#![deny(clippy::print_stderr, clippy::print_stdout)]

pub mod fmi2;
pub mod parameters;
pub mod results;
pub mod variables;
