//! General-purpose solvers of ordinary differential equations: BDF and Adams-Moulton formulas of variable order and
//! step, the classical Runge-Kutta formula of fixed step ([`Method`]).
//!
//! A [`Solver`] solves a [`System`], which has its own measure of errors and linear algebra ([`Tridiagonal`] where that
//! fits), and provides each step as a polynomial ([`Path`]).

mod corrector;
mod multistep;
mod solver;
mod system;
mod tridiagonal;

pub use solver::{Method, Solver};
pub use system::{Path, StepCounters, Stuck, System};
pub use tridiagonal::Tridiagonal;
