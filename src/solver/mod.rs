//! Numerical methods. Knows no cradle.

pub mod double_double;
pub mod dual;
pub mod oscillator;
pub mod quadrature;
pub mod queue;
pub mod root;
pub mod series;
