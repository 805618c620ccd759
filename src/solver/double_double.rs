//! Unevaluated sums of two doubles: about 32 digits for times and for running sums.
//!
//! A contact lasts 1e-7 s, and at t = 600 s a double resolves 1e-13 s: a millionth of a contact. Times of events,
//! phases of pendulums and sums over thousands of pulses therefore carry a second double with the rest.

use serde::{Deserialize, Serialize};

/// `hi + lo` with `|lo|` at most half a unit in the last place of `hi`.
///
/// The order is lexicographic, which for normalised pairs is the order of the values.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd, Serialize, Deserialize)]
pub struct DoubleDouble {
    hi: f64,
    lo: f64,
}

/// Sum and its rounding error (Knuth, The Art of Computer Programming 2, 4.2.2, theorem B).
fn two_sum(a: f64, b: f64) -> DoubleDouble {
    let hi = a + b;
    let b_seen = hi - a;
    DoubleDouble { hi, lo: (a - (hi - b_seen)) + (b - b_seen) }
}

/// Sum and its rounding error for `|a| >= |b|` (Dekker 1971).
fn quick_two_sum(a: f64, b: f64) -> DoubleDouble {
    let hi = a + b;
    DoubleDouble { hi, lo: b - (hi - a) }
}

impl DoubleDouble {
    pub const ZERO: Self = Self { hi: 0.0, lo: 0.0 };

    pub fn value(self) -> f64 {
        self.hi
    }

    /// The part beyond the rounded value.
    pub fn rest(self) -> f64 {
        self.lo
    }

    /// Whether it is finite and normalised.
    pub fn is_sound(self) -> bool {
        self.hi.is_finite() && self.hi + self.lo == self.hi
    }

    /// The smallest double that is not below the value.
    pub fn value_up(self) -> f64 {
        if self.lo > 0.0 { self.hi.next_up() } else { self.hi }
    }

    /// The largest double that is not above the value.
    pub fn value_down(self) -> f64 {
        if self.lo < 0.0 { self.hi.next_down() } else { self.hi }
    }

    /// The exact product of two doubles (Dekker 1971), without a fused multiply-add, which not every target has.
    pub fn product(a: f64, b: f64) -> Self {
        let split = |x: f64| {
            let t = 134_217_729.0 * x; // 2^27 + 1
            let high = t - (t - x);
            (high, x - high)
        };
        let hi = a * b;
        let ((a1, a2), (b1, b2)) = (split(a), split(b));
        Self { hi, lo: ((a1 * b1 - hi) + a1 * b2 + a2 * b1) + a2 * b2 }
    }

    /// The square root of a value >= 0: one Newton correction of the rounded root.
    pub fn sqrt(self) -> Self {
        let root = self.hi.sqrt();
        if root == 0.0 {
            return Self::default();
        }
        let square = Self::product(root, root);
        quick_two_sum(root, ((self.hi - square.hi) + (self.lo - square.lo)) / (2.0 * root))
    }
}

impl From<f64> for DoubleDouble {
    fn from(hi: f64) -> Self {
        Self { hi, lo: 0.0 }
    }
}

operators! {
    DoubleDouble: -a = Self { hi: -a.hi, lo: -a.lo };
    Add.add(a, b: f64) = {
        let sum = two_sum(a.hi, b);
        quick_two_sum(sum.hi, sum.lo + a.lo)
    };
    Add.add(a, b: Self) = {
        let sum = two_sum(a.hi, b.hi);
        quick_two_sum(sum.hi, sum.lo + (a.lo + b.lo))
    };
    Mul.mul(a, b: f64) = {
        let product = Self::product(a.hi, b);
        quick_two_sum(product.hi, product.lo + a.lo * b)
    };
    Mul.mul(a, b: Self) = {
        let product = Self::product(a.hi, b.hi);
        quick_two_sum(product.hi, product.lo + (a.hi * b.lo + a.lo * b.hi))
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn double_double_root_has_the_digits_of_two_doubles() {
        let (root, two) = (DoubleDouble::from(2.0).sqrt(), DoubleDouble::from(2.0));
        for off in [root * root - two, root * 3.0 - (root + root + root)] {
            assert!(off.value().abs() < 1e-31, "{off:?}");
        }
        assert_eq!([root.value_down(), root.value_up()], [2.0_f64.sqrt().next_down(), 2.0_f64.sqrt()]);
        assert_eq!((-root).value_up(), -root.value_down());
    }
}
