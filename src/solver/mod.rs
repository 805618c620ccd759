//! Numerical methods. Knows no cradle.

pub mod block_tridiagonal;
mod corrector;
pub mod course;
pub mod double_double;
pub mod dual;
pub mod multistep;
pub mod ode;
pub mod oscillator;
pub mod quadrature;
pub mod queue;
pub mod radau;
pub mod root;
pub mod runge_kutta;
pub mod series;
pub mod steady;
pub mod tridiagonal;
pub mod trigonometry;
