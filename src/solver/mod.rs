//! Numerical methods, independent of the cradle.
//!
//! Dense linear algebra is nalgebra's, without its feature `std`: with it, kernels and so bits would depend on the
//! processor. No crate fits for the modules here:
//!
//! - first crossings (`root`, `crossing`): a search that misses none needs bounds of the derivatives, which the motion
//!   has;
//! - dual numbers (`dual`): with every function by libm, as it is for doubles;
//! - double-double (`double_double`): the few operations for times and sums over pulses;
//! - powers of many numbers at once (`power`);
//! - the event queue (`queue`): entries that move by their key, ties in the order of the keys.

/// Implements the operators of a type of numbers by formulas; differences and assignments follow from them.
macro_rules! operators {
    (
        $type:ident: -$n:ident = $negative:expr;
        $($op:ident.$name:ident($a:ident, $b:ident: $other:ty) = $result:expr;)*
    ) => {
        impl std::ops::Neg for $type {
            type Output = Self;
            fn neg(self) -> Self {
                let $n = self;
                $negative
            }
        }

        impl std::ops::Sub for $type {
            type Output = Self;
            fn sub(self, b: Self) -> Self {
                self + -b
            }
        }

        impl<T> std::ops::AddAssign<T> for $type
        where
            Self: std::ops::Add<T, Output = Self>,
        {
            fn add_assign(&mut self, b: T) {
                *self = *self + b;
            }
        }

        $(impl std::ops::$op<$other> for $type {
            type Output = Self;
            fn $name(self, $b: $other) -> Self {
                let $a = self;
                $result
            }
        })*
    };
}

/// The root of `squares` = `a^2 + b^2`, also where that sum leaves the range of doubles.
#[inline]
pub fn hypotenuse(squares: f64, a: f64, b: f64) -> f64 {
    // Comparisons are cheaper than looking at the bits.
    let in_range = (f64::MIN_POSITIVE..=f64::MAX).contains(&squares);
    if in_range { squares.sqrt() } else { libm::hypot(a, b) }
}

/// Whether all of these are finite. Anything else times 0 is NaN, so no branch is needed.
#[inline(always)]
pub fn all_finite<const N: usize>(values: [f64; N]) -> bool {
    values.into_iter().fold(0.0, |sum, value| sum + 0.0 * value) == 0.0
}

pub mod crossing;
pub mod double_double;
pub mod dual;
pub mod gauss;
// These need nalgebra, which only the engine has.
#[cfg(feature = "engine")]
pub mod oscillator;
pub mod power;
pub mod quadrature;
pub mod queue;
#[cfg(feature = "engine")]
pub mod radau;
pub mod root;
pub mod series;

pub use double_double::DoubleDouble;
pub use dual::{Dual, Scalar};
pub use gauss::{NODES, Nodes, Power, RULE, Stretching, Table, combine, weighted};
#[cfg(feature = "engine")]
pub use oscillator::{BASIS, ForcedOscillator, MAX_FORCE_ORDER, Oscillator, Steady};
pub use queue::EventQueue;
pub use root::Smooth;
