//! Truncated power series: slices of coefficients `c[k]` of `t^k`.

use super::power::power;

/// Number of sums computed side by side where that pays.
pub const LANES: usize = 4;

pub fn value(c: &[f64], t: f64) -> f64 {
    c.iter().rev().fold(0.0, |sum, &c| sum * t + c)
}

pub fn derivative(c: &[f64], t: f64) -> f64 {
    c.iter().enumerate().skip(1).rev().fold(0.0, |sum, (k, &c)| sum * t + k as f64 * c)
}

pub fn integral(c: &[f64], t: f64) -> f64 {
    t * c.iter().enumerate().rev().fold(0.0, |sum, (k, &c)| sum * t + c / (k + 1) as f64)
}

/// The coefficients of the series with these derivatives at 0.
pub fn of_derivatives<const N: usize>(mut derivatives: [f64; N]) -> [f64; N] {
    let mut factorial = 1.0;
    for (k, c) in derivatives.iter_mut().enumerate() {
        factorial *= k.max(1) as f64;
        *c /= factorial;
    }
    derivatives
}

/// The first coefficients of the series expanded about `t`.
pub fn about<const N: usize>(c: &[f64], t: f64) -> [f64; N] {
    let mut about = [0.0; N];
    for &c in c.iter().rev() {
        for k in (1..N).rev() {
            about[k] = about[k] * t + about[k - 1];
        }
        about[0] = about[0] * t + c;
    }
    about
}

/// Value and first two derivatives at `t`, in [`LANES`] side by side.
pub fn value_and_derivatives(c: &[f64], t: f64) -> [f64; 3] {
    let (first, groups) = c.as_rchunks::<LANES>();
    // A polynomial of the fourth power of `t` in each lane: its value, derivative and half its second derivative.
    let (mut values, mut slopes, mut curvatures) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    let square = t * t;
    let fourth = square * square;
    for c in groups.iter().rev() {
        for lane in 0..LANES {
            curvatures[lane] = curvatures[lane] * fourth + slopes[lane];
            slopes[lane] = slopes[lane] * fourth + values[lane];
            values[lane] = values[lane] * fourth + c[lane];
        }
    }
    // The lanes, each times its power of `t`, their sum and its derivatives.
    let sum = |l: &[f64; LANES]| (l[0] + l[2] * square) + (l[1] + l[3] * square) * t;
    let slope = |l: &[f64; LANES]| 2.0 * t * l[2] + (l[1] + 3.0 * square * l[3]);
    let rise = 4.0 * square * t;
    let mut value = sum(&values);
    let mut derivative = slope(&values) + rise * sum(&slopes);
    let mut curvature = (values[2] + 3.0 * values[3] * t)
        + rise * slope(&slopes)
        + 6.0 * square * sum(&slopes)
        + rise * rise * sum(&curvatures);
    for c in first.iter().rev() {
        curvature = curvature * t + derivative;
        derivative = derivative * t + value;
        value = value * t + c;
    }
    [value, derivative, 2.0 * curvature]
}

/// Coefficient `k` of the product of two series, from their first `k + 1` coefficients.
pub fn product_term(a: &[f64], b: &[f64], k: usize) -> f64 {
    a[..=k].iter().zip(b[..=k].iter().rev()).map(|(a, b)| *a * *b).sum()
}

/// Coefficients `k >= 1` of sine and cosine of an angle, from the ones before. `angle` has the coefficients of the
/// angle, each times its index.
pub fn sine_and_cosine_term(angle: &[f64], sin: &[f64], cos: &[f64], k: usize) -> (f64, f64) {
    let inverse = 1.0 / k as f64;
    (product_term(&angle[1..], cos, k - 1) * inverse, -product_term(&angle[1..], sin, k - 1) * inverse)
}

/// Coefficient `k >= 1` of `c^p` for real `p` and `c[0] > 0`, from the coefficients `power[..k]` before it.
///
/// The recursion follows from `c q' = p c' q` for `q = c^p` (J. C. P. Miller; Knuth, The Art of Computer Programming 2,
/// 4.7, equation 9).
pub fn power_term(c: &[f64], power: &[f64], p: f64, k: usize) -> f64 {
    let factor = |j: usize| (p + 1.0) * j as f64 - k as f64;
    let sum: f64 = (1..=k).map(|j| factor(j) * c[j] * power[k - j]).sum();
    sum / (k as f64 * c[0])
}

/// The series of `(c scale)^exponent` for a series c, term by term. If c begins with 0, a fractional power has no
/// series; its terms are then 0.
pub struct PowerSeries {
    exponent: f64,
    scale: f64,
    /// The coefficients; for a whole exponent, row by row, also those of the lower powers.
    rows: Vec<f64>,
}

impl PowerSeries {
    /// For an exponent of 0 or more.
    pub fn new(exponent: f64, scale: f64) -> Self {
        Self { exponent, scale, rows: Vec::new() }
    }

    /// Coefficient `k`, from the first `k + 1` of `c`, after the coefficients before it. Every call has the same length
    /// of `c`.
    pub fn term(&mut self, c: &[f64], k: usize) -> f64 {
        if self.exponent == 1.0 {
            return c[k] * self.scale;
        }
        let (stride, whole) = (c.len(), self.exponent as usize);
        if whole as f64 != self.exponent {
            self.rows.resize(stride, 0.0);
            self.rows[k] = if c[0] <= 0.0 {
                0.0
            } else if k == 0 {
                power(c[0] * self.scale, self.exponent)
            } else {
                power_term(c, &self.rows, self.exponent, k)
            };
            return self.rows[k];
        }
        if whole == 0 {
            return if k == 0 { 1.0 } else { 0.0 };
        }
        self.rows.resize(whole * stride, 0.0);
        self.rows[k] = c[k] * self.scale;
        for q in 1..whole {
            let (base, lower) = (&self.rows[..stride], &self.rows[(q - 1) * stride..q * stride]);
            self.rows[q * stride + k] = product_term(base, lower, k);
        }
        self.rows[(whole - 1) * stride + k]
    }
}

/// Most coefficients of a series that is summed by lanes.
pub const MOST: usize = 64;

/// The numbers from 0 on, or their inverses.
const fn table(inverse: bool) -> [f64; MOST] {
    let (mut table, mut k) = ([0.0; MOST], 0);
    while k < MOST {
        table[k] = if inverse { 1.0 / k as f64 } else { k as f64 };
        k += 1;
    }
    table
}
pub const NUMBERS: [f64; MOST] = table(false);
pub const INVERSES: [f64; MOST] = table(true);

/// Sum of `term(c[k], weights[k]) t^k`, in four sums side by side: faster than Horner's rule, with other last bits.
#[inline]
pub fn sum_by_lanes(c: &[f64], weights: &[f64], t: f64, term: impl Fn(f64, f64) -> f64) -> f64 {
    let [sum] = sums_by_lanes(c, weights, t, [term]);
    sum
}

/// [`sum_by_lanes`] of several terms at a time.
#[inline]
fn sums_by_lanes<const N: usize>(c: &[f64], weights: &[f64], t: f64, terms: [impl Fn(f64, f64) -> f64; N]) -> [f64; N] {
    let weights = &weights[..c.len()];
    let ((first, groups), (first_weights, weights)) = (c.as_rchunks::<LANES>(), weights.as_rchunks::<LANES>());
    let square = t * t;
    let (mut sums, fourth) = ([[0.0; LANES]; N], square * square);
    for (c, weights) in groups.iter().zip(weights).rev() {
        for (sums, term) in sums.iter_mut().zip(&terms) {
            for lane in 0..LANES {
                sums[lane] = sums[lane] * fourth + term(c[lane], weights[lane]);
            }
        }
    }
    std::array::from_fn(|n| {
        let sums = &sums[n];
        let sum = (sums[0] + sums[2] * square) + (sums[1] + sums[3] * square) * t;
        first.iter().zip(first_weights).rev().fold(sum, |sum, (c, weight)| sum * t + terms[n](*c, *weight))
    })
}

pub fn value_by_lanes(c: &[f64], t: f64) -> f64 {
    sum_by_lanes(c, &NUMBERS, t, |c, _| c)
}

pub fn derivative_by_lanes(c: &[f64], t: f64) -> f64 {
    sum_by_lanes(&c[1.min(c.len())..], &NUMBERS[1..], t, |c, k| k * c)
}

/// Value of a series of two or more coefficients at `t`, and the change of its first derivative since 0, by lanes.
pub fn value_and_change_of_derivative(c: &[f64], t: f64) -> (f64, f64) {
    let terms: [fn(f64, f64) -> f64; 2] = [|c, _| c, |c, k| k * c];
    let [rest, change] = sums_by_lanes(&c[2..], &NUMBERS[2..], t, terms);
    (c[0] + (c[1] + rest * t) * t, change * t)
}

pub fn integral_by_lanes(c: &[f64], t: f64) -> f64 {
    t * sum_by_lanes(c, &INVERSES[1..], t, |c, inverse| inverse * c)
}

/// A bound of the absolute value on `[0, t]`, with room for rounding.
pub fn bound(c: &[f64], t: f64) -> f64 {
    (1.0 + 1e-9) * sum_by_lanes(c, &NUMBERS, t, |c, _| c.abs())
}

/// A bound of the absolute change of the derivative since 0, on `[0, t]`, with room for rounding.
pub fn bound_of_change_of_derivative(c: &[f64], t: f64) -> f64 {
    (1.0 + 1e-9) * t * sum_by_lanes(&c[2.min(c.len())..], &NUMBERS[2..], t, |c, k| k * c.abs())
}

pub fn sample<const PLACES: usize>(c: &[f64], places: &[f64; PLACES]) -> [f64; PLACES] {
    sample_terms(c, &NUMBERS, places, |c, _| c)
}

pub fn sample_derivative<const PLACES: usize>(c: &[f64], places: &[f64; PLACES]) -> [f64; PLACES] {
    sample_terms(&c[1.min(c.len())..], &NUMBERS[1..], places, |c, k| k * c)
}

/// Sums of `term(c[k], weights[k]) t^k` at each place t.
#[inline]
pub fn sample_terms<const PLACES: usize>(
    c: &[f64],
    weights: &[f64],
    places: &[f64; PLACES],
    term: impl Fn(f64, f64) -> f64,
) -> [f64; PLACES] {
    c.iter().zip(&weights[..c.len()]).rev().fold([0.0; PLACES], |sums, (c, weight)| {
        let term = term(*c, *weight);
        std::array::from_fn(|p| sums[p] * places[p] + term)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_lanes_sum_as_horner() {
        let c: Vec<f64> = (0..31).map(|k| libm::sin(1.0 + k as f64)).collect();
        for count in 0..c.len() {
            let (c, t) = (&c[..count], 0.8);
            let (about, [.., curvature]) = (about::<3>(c, t), value_and_derivatives(c, t));
            for (by_lanes, by_horner) in [(derivative_by_lanes(c, t), derivative(c, t)), (curvature, 2.0 * about[2])] {
                assert!((by_lanes - by_horner).abs() < 1e-12, "{count} terms: {by_lanes}, not {by_horner}");
            }
        }
    }
}
