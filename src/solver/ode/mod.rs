//! General-purpose solvers of ordinary differential equations: BDF and Adams-Moulton formulas of variable order and
//! step ([`Multistep`]), the classical Runge-Kutta formula of fixed step ([`RungeKutta`]).
//!
//! They solve a [`System`], which brings its own measure of errors and its own linear algebra ([`Tridiagonal`] where
//! that fits), and hand out each step as a polynomial ([`Path`]).

mod corrector;
mod multistep;
mod runge_kutta;
mod system;
mod tridiagonal;

pub use multistep::{Family, Multistep};
pub use runge_kutta::RungeKutta;
pub use system::{Path, StepCounters, Stuck, System};
pub use tridiagonal::Tridiagonal;
