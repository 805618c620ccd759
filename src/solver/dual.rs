//! Dual numbers: a value and its derivative along one direction, carried through every operation.
//!
//! Results have exact derivatives, except for rounding (forward mode of automatic differentiation: Griewank and
//! Walther, Evaluating Derivatives, 2008, chapter 3). One formula serves doubles and dual numbers by [`Scalar`].

use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// A number for formulas: a double or a [`Dual`].
pub trait Scalar:
    Copy
    + PartialEq
    + std::fmt::Debug
    + Default
    + From<f64>
    + Sum
    + Neg<Output = Self>
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// A number with this value and derivative; doubles drop the latter.
    fn with_tangent(value: f64, tangent: f64) -> Self;
    fn value(self) -> f64;
    /// Its derivative; 0 for doubles.
    fn tangent(self) -> f64 {
        0.0
    }
    fn sqrt(self) -> Self;
    /// Its power with a real exponent, for a value of 0 or more.
    fn pow(self, exponent: Self) -> Self;
    /// Its sine and cosine.
    fn sin_cos(self) -> (Self, Self);
}

impl Scalar for f64 {
    fn with_tangent(value: f64, _tangent: f64) -> Self {
        value
    }

    fn value(self) -> f64 {
        self
    }

    fn sqrt(self) -> Self {
        self.sqrt()
    }

    fn pow(self, exponent: Self) -> Self {
        libm::pow(self, exponent)
    }

    fn sin_cos(self) -> (Self, Self) {
        libm::sincos(self)
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dual {
    value: f64,
    tangent: f64,
}

impl Scalar for Dual {
    fn with_tangent(value: f64, tangent: f64) -> Self {
        Self { value, tangent }
    }

    fn value(self) -> f64 {
        self.value
    }

    fn tangent(self) -> f64 {
        self.tangent
    }

    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        let tangent = if self.tangent == 0.0 { 0.0 } else { 0.5 * self.tangent / root };
        Self { value: root, tangent }
    }

    fn pow(self, exponent: Self) -> Self {
        let value = libm::pow(self.value, exponent.value);
        let of_base = match (self.tangent, self.value) {
            (0.0, _) => 0.0,
            _ if exponent.value == 0.0 => 0.0,
            (tangent, 0.0) => exponent.value * tangent * libm::pow(0.0, exponent.value - 1.0),
            (tangent, base) => value * (exponent.value * tangent / base),
        };
        let grows = exponent.tangent != 0.0 && value != 0.0;
        let of_exponent = if grows { value * (exponent.tangent * libm::log(self.value)) } else { 0.0 };
        Self { value, tangent: of_base + of_exponent }
    }

    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = libm::sincos(self.value);
        (Self { value: s, tangent: c * self.tangent }, Self { value: c, tangent: -s * self.tangent })
    }
}

impl From<f64> for Dual {
    fn from(value: f64) -> Self {
        Self { value, tangent: 0.0 }
    }
}

operators! {
    Dual: -a = Self { value: -a.value, tangent: -a.tangent };
    Add.add(a, b: Self) = Self { value: a.value + b.value, tangent: a.tangent + b.tangent };
    Mul.mul(a, b: Self) = Self { value: a.value * b.value, tangent: a.tangent * b.value + a.value * b.tangent };
    Div.div(a, b: Self) = {
        let value = a.value / b.value;
        Self { value, tangent: (a.tangent - value * b.tangent) / b.value }
    };
}

impl Sum for Dual {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Self::default(), Add::add)
    }
}
