//! Numerical methods. Knows no cradle.
//!
//! Dense linear algebra is nalgebra's, without its `std`: that would bring kernels chosen by the processor, and other
//! bits on each. What is here is what no crate has as it is needed:
//!
//! - first crossings (`root`, `crossing`): a search that misses none needs bounds of the derivatives, which the motion
//!   knows;
//! - dual numbers (`dual`): with every function by libm, as it is for doubles;
//! - double-double (`double_double`): the few operations that times and sums over pulses take;
//! - powers of many numbers at once (`power`);
//! - the event queue (`queue`): entries that move by their key, ties in the order of the keys;
//! - BDF and Adams-Moulton formulas: why none of the crates serves stands in `ode`.

pub mod block_tridiagonal;
pub mod crossing;
pub mod double_double;
pub mod dual;
pub mod gauss;
pub mod ode;
pub mod oscillator;
pub mod power;
pub mod quadrature;
pub mod queue;
pub mod radau;
pub mod root;
pub mod series;
