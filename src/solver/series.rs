//! Truncated power series: slices of coefficients `c[k]` of `t^k`.

use super::dual::Scalar;
use super::root::{self, Smooth};

/// Sums that are taken side by side where that pays.
pub const LANES: usize = 4;

/// Value at `t`.
pub fn value<S: Scalar>(c: &[S], t: S) -> S {
    c.iter().rev().fold(S::default(), |sum, &c| sum * t + c)
}

/// First derivative at `t` less that at 0.
pub fn change_of_derivative(c: &[f64], t: f64) -> f64 {
    t * c.iter().enumerate().skip(2).rev().fold(0.0, |sum, (k, &c)| sum * t + k as f64 * c)
}

/// First derivative at `t`.
pub fn derivative<S: Scalar>(c: &[S], t: S) -> S {
    c.iter().enumerate().skip(1).rev().fold(S::default(), |sum, (k, &c)| sum * t + S::from(k as f64) * c)
}

/// Integral from 0 to `t`.
pub fn integral<S: Scalar>(c: &[S], t: S) -> S {
    t * c.iter().enumerate().rev().fold(S::default(), |sum, (k, &c)| sum * t + c / S::from((k + 1) as f64))
}

/// The first coefficients of the same function about `t`.
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

/// Value and first two derivatives at `t`.
pub fn value_and_derivatives(c: &[f64], t: f64) -> [f64; 3] {
    let (mut value, mut slope, mut half_curvature) = (0.0, 0.0, 0.0);
    for &c in c.iter().rev() {
        half_curvature = half_curvature * t + slope;
        slope = slope * t + value;
        value = value * t + c;
    }
    [value, slope, 2.0 * half_curvature]
}

/// Coefficient `k` of the product of two series, from their first `k + 1` coefficients.
pub fn product_term<S: Scalar>(a: &[S], b: &[S], k: usize) -> S {
    a[..=k].iter().zip(b[..=k].iter().rev()).map(|(a, b)| *a * *b).sum()
}

/// Coefficient `k >= 1` of `c^p` for real `p` and `c[0] > 0`, from the coefficients `power[..k]` before it.
///
/// The recursion follows from `c q' = p c' q` for `q = c^p` (J. C. P. Miller; Knuth, The Art of Computer Programming 2,
/// 4.7, equation 9).
pub fn power_term<S: Scalar>(c: &[S], power: &[S], p: S, k: usize) -> S {
    let factor = |j: usize| (p + S::from(1.0)) * S::from(j as f64) - S::from(k as f64);
    let sum: S = (1..=k).map(|j| factor(j) * c[j] * power[k - j]).sum();
    sum / (S::from(k as f64) * c[0])
}

/// Product of two series integrated from 0 to `t`, exactly for the truncated series.
pub fn product_integral(a: &[f64], b: &[f64], t: f64) -> f64 {
    let mut product = vec![0.0; a.len() + b.len()];
    for (i, a) in a.iter().enumerate() {
        for (j, b) in b.iter().enumerate() {
            product[i + j] += a * b;
        }
    }
    integral(&product, t)
}

/// Sum of `factor(i) backward[i]` for `i` from 0 to `k`, and on to where a group of terms is full.
#[inline]
pub fn sum_of_products(k: usize, factor: impl Fn(usize) -> f64, backward: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    for (group, backward) in backward.chunks_exact(LANES).take(k / LANES + 1).enumerate() {
        for (lane, (sum, c)) in sums.iter_mut().zip(backward).enumerate() {
            *sum += factor(LANES * group + lane) * c;
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// The same over `t` for the first `order` terms of the product, summed as [`sum_of_products`] does.
pub fn product_integral_by_lanes(a: &[f64], b: &[f64], order: usize, t: f64) -> f64 {
    let mut forward = vec![0.0; order + LANES];
    let mut backward = vec![0.0; order + LANES];
    forward.iter_mut().zip(a).take(order).for_each(|(forward, a)| *forward = *a);
    b.iter().take(order).enumerate().for_each(|(k, b)| backward[order - k] = *b);
    let term = |k: usize| sum_of_products(k, |i| forward[i], &backward[order - k..]) * (1.0 / (k + 1) as f64);
    (0..order).rev().fold(0.0, |sum, k| sum * t + term(k))
}

/// Sum of `weight(k, c[k]) t^k`, in four sums side by side: not the same bits as by Horner's rule, in less time.
pub fn sum_by_lanes(c: &[f64], t: f64, weight: impl Fn(usize, f64) -> f64) -> f64 {
    let (square, groups) = (t * t, c.chunks_exact(LANES));
    let (mut sums, fourth) = ([0.0; LANES], square * square);
    let rest = c.len() - groups.remainder().len();
    for (lane, c) in groups.remainder().iter().enumerate() {
        sums[lane] = weight(rest + lane, *c);
    }
    for (group, c) in groups.enumerate().rev() {
        for (lane, sum) in sums.iter_mut().enumerate() {
            *sum = *sum * fourth + weight(LANES * group + lane, c[lane]);
        }
    }
    (sums[0] + sums[1] * t) + (sums[2] + sums[3] * t) * square
}

/// A bound of the absolute value on `[0, t]`, by more than rounding.
pub fn bound(c: &[f64], t: f64) -> f64 {
    (1.0 + 1e-9) * sum_by_lanes(c, t, |_, c| c.abs())
}

/// The same for the derivative less that at 0.
pub fn bound_of_change_of_derivative(c: &[f64], t: f64) -> f64 {
    (1.0 + 1e-9) * t * sum_by_lanes(&c[2.min(c.len())..], t, |k, c| (k + 2) as f64 * c.abs())
}

/// The largest value on `[from, to]`.
pub fn maximum(c: &[f64], from: f64, to: f64) -> f64 {
    value(c, place_of_maximum(c, from, to))
}

/// Where on `[from, to]` the value is largest.
///
/// The interval is scanned in eighths for changes of sign of the derivative, each refined to a maximum; a series that a
/// step controller has cut to its range of fast convergence does not turn more often.
pub fn place_of_maximum(c: &[f64], from: f64, to: f64) -> f64 {
    const PARTS: usize = 8;
    let higher = |a: f64, b: f64| if value(c, b) > value(c, a) { b } else { a };
    let mut best = higher(from, to);
    if c.len() > 1 && c[1].abs() > bound_of_change_of_derivative(c, to) {
        return best;
    }
    let mut left = from;
    let mut slope_left = derivative(c, left);
    for part in 1..=PARTS {
        let right = from + (to - from) * part as f64 / PARTS as f64;
        let slope_right = derivative(c, right);
        if slope_left > 0.0 && slope_right <= 0.0 {
            best = higher(best, root::falling_zero(|t| derivative(c, t), left, right));
        }
        (left, slope_left) = (right, slope_right);
    }
    best
}

/// The first `t` in `[0, until]` from which on `sign` (1 or -1) times the series less `level` is positive; see
/// [`root::first_positive`].
pub fn first_positive(c: &[f64], sign: f64, level: f64, until: f64) -> Option<f64> {
    // Most searches find nothing and need not be made.
    if sign * (c[0] - level) < -until * bound(&c[1..], until) {
        return None;
    }
    let mut from = 0.0;
    // At a start with vanishing value, slope and curvature the first coefficient that is not zero decides.
    if c[0] == level && c[1] == 0.0 && c[2] == 0.0 {
        let lead = 3 + c.iter().skip(3).position(|&c| c != 0.0)?;
        if sign * c[lead] > 0.0 {
            return Some(0.0);
        }
        let rest: f64 = c[lead + 1..].iter().rev().fold(0.0, |sum, c| sum * until + c.abs());
        // On this stretch the leading term outweighs all others.
        let half = 0.5 * c[lead].abs();
        from = if rest * until <= half { until } else { half / rest };
    }
    first_positive_after(c, sign, level, from, until)
}

/// The same in `[from, until]`, for a start where the value, the slope or the curvature tells how it goes on.
pub fn first_positive_after(c: &[f64], sign: f64, level: f64, from: f64, until: f64) -> Option<f64> {
    root::first_positive(&Above { c, sign, level }, from, until)
}

/// `sign (c - level)` for a series c.
struct Above<'a> {
    c: &'a [f64],
    sign: f64,
    level: f64,
}

impl Smooth for Above<'_> {
    fn at(&self, t: f64) -> [f64; 3] {
        let [value, slope, curvature] = value_and_derivatives(self.c, t);
        [value - self.level, slope, curvature].map(|d| self.sign * d)
    }

    fn third_derivative_bound(&self, t: f64, span: f64) -> f64 {
        let end = t + span;
        self.c.iter().enumerate().skip(3).rev().fold(0.0, |sum, (k, c)| {
            let k = k as f64;
            sum * end + k * (k - 1.0) * (k - 2.0) * c.abs()
        })
    }

    fn bound_depends_on_span(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn power_recursion_matches_the_binomial_series() {
        let c = [2.0, 1.0, 0.0, 0.0, 0.0, 0.0];
        let mut power = vec![libm::pow(2.0, 1.5)];
        for k in 1..6 {
            let term = power_term(&c, &power, 1.5, k);
            power.push(term);
        }
        assert!((value(&power, 0.01) - libm::pow(2.01, 1.5)).abs() < 1e-15);
    }

    #[test]
    fn a_polynomial_about_another_place() {
        // (1 + s)^3 about s = 1 is (2 + s)^3.
        assert_eq!(about(&[1.0, 3.0, 3.0, 1.0], 1.0), [8.0, 12.0, 6.0]);
        assert_eq!(about(&[1.0, 3.0, 3.0, 1.0], 1.0), [8.0, 12.0, 6.0, 1.0, 0.0]);
    }

    #[test]
    fn maximum_of_a_hump() {
        // t (1 - t) peaks at 1/4; on [0.6, 1] the left end is the largest.
        let c = [0.0, 1.0, -1.0];
        assert!((maximum(&c, 0.0, 1.0) - 0.25).abs() < 1e-15);
        assert!((maximum(&c, 0.6, 1.0) - 0.24).abs() < 1e-15);
    }

    #[test]
    fn crossing_decided_by_the_leading_term() {
        assert_eq!(first_positive(&[0.0, 0.0, 0.0, 0.0, 1e-30], 1.0, 0.0, 1.0), Some(0.0));
        assert_eq!(first_positive(&[0.0; 6], 1.0, 0.0, 1.0), None);
        let t = first_positive(&[0.0, 0.0, 0.0, 1.0, -2.0], -1.0, 0.0, 1.0).unwrap();
        assert!((t - 0.5).abs() < 1e-15);
    }

    #[test]
    fn integrals_of_products() {
        // (1 + t) (1 - t) integrated to 1 is 2/3.
        assert!((product_integral(&[1.0, 1.0], &[1.0, -1.0], 1.0) - 2.0 / 3.0).abs() < 1e-15);
        assert!((integral(&[1.0, 2.0, 3.0], 2.0) - 14.0).abs() < 1e-15);
    }
}
