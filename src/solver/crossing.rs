//! First crossings and maxima of truncated power series.

use super::root::{self, Smooth, search_within};
use super::series::{
    NUMBERS, bound, bound_of_change_of_derivative, derivative_by_lanes, sample_derivative, sum_by_lanes,
    value_and_derivatives, value_by_lanes,
};

/// Number of equidistant places at which a series is sampled at once.
const SAMPLES: usize = 8;

/// Rounding error of a value, relative.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Most evaluations of one search, far more than usual: a series that almost touches 0 for so long has no crossing.
const EVALUATIONS: u32 = 1000;

/// The place on `[from, to]` where the value is largest, and that value.
///
/// The derivative is scanned in eighths of the interval; each change of its sign is refined to a maximum. Within its
/// range of fast convergence a series does not turn more often.
pub fn maximum(c: &[f64], from: f64, to: f64) -> (f64, f64) {
    let higher = |best: (f64, f64), t: f64| {
        let value = value_by_lanes(c, t);
        if value > best.1 { (t, value) } else { best }
    };
    let at_start = if from == 0.0 { c[0] } else { value_by_lanes(c, from) };
    let mut best = higher((from, at_start), to);
    if c.len() > 1 && c[1].abs() > bound_of_change_of_derivative(c, to) {
        return best;
    }
    let places = eighths(from, to);
    let slope_at_start = if from == 0.0 && c.len() > 1 { c[1] } else { derivative_by_lanes(c, from) };
    let (mut left, mut slope_left) = (from, slope_at_start);
    for (right, slope_right) in places.into_iter().zip(sample_derivative(c, &places)) {
        if slope_left > 0.0 && slope_right <= 0.0 {
            // Newton's method: half the digits of the place give all digits of the maximum.
            let falling = |t: f64| {
                let [_, slope, curvature] = value_and_derivatives(c, t);
                [-slope, -curvature, 0.0]
            };
            let top = root::rising_zero(falling, (left, -slope_left), (right, -slope_right));
            let value = value_by_lanes(c, top);
            // Up to rounding, an end of the interval beside it may be as high.
            let rounding = if best.0 == left || best.0 == right { ROUNDING * best.1.abs() } else { 0.0 };
            if value > best.1 - rounding {
                best = (top, value.max(best.1));
            }
        }
        (left, slope_left) = (right, slope_right);
    }
    best
}

fn eighths(from: f64, to: f64) -> [f64; SAMPLES] {
    std::array::from_fn(|p| from + (to - from) * (p + 1) as f64 / SAMPLES as f64)
}

/// The first `t` in `[0, until]` after which `sign` (1 or -1) times the series minus `level` is positive, by
/// [`search_within`]. NaN for a series that leaves the range of doubles, so that it is noticed where that time is used.
///
/// At 0 it should not be positive; if it is, only a rise above that value counts.
#[inline]
pub fn first_positive(c: &[f64], sign: f64, level: f64, until: f64) -> Option<f64> {
    let (value, slope) = (sign * (c[0] - level), sign * c[1]);
    let (chord, deviation) = (value + until * slope, until * until * bound(&c[2..], until));
    // A cheap bound: most searches find nothing.
    if value < -deviation && chord < -deviation {
        return None;
    }
    // Nothing is known of numbers beyond the range of doubles.
    if !(chord + deviation).is_finite() {
        return Some(f64::NAN);
    }
    Above { c, sign, level }.first_positive(until)
}

/// `sign (c - level)` for a series c.
struct Above<'a> {
    c: &'a [f64],
    sign: f64,
    level: f64,
}

impl Above<'_> {
    fn first_positive(&self, until: f64) -> Option<f64> {
        let &Self { c, sign, level } = self;
        // If value, slope and curvature vanish at the start, the first coefficient that is not zero decides.
        if sign * (c[0] - level) >= 0.0 && [c[1], c[2]] == [0.0; 2] {
            let lead = c[3..].iter().position(|&c| c != 0.0).map(|more| 3 + more)?;
            if sign * c[lead] > 0.0 {
                return Some(0.0);
            }
            // Up to `half / rest` the leading term dominates.
            let (half, rest) = (0.5 * c[lead].abs(), bound(&c[lead + 1..], until));
            if rest * until <= half {
                return None;
            }
            return Self { level: c[0], ..*self }.search(half / rest, until);
        }
        self.search(0.0, until)
    }

    fn search(&self, from: f64, until: f64) -> Option<f64> {
        let mut allowed = EVALUATIONS;
        search_within(self, from, until, &mut allowed).found()
    }
}

impl Smooth for Above<'_> {
    const TIGHTENS: bool = true;

    fn at(&self, t: f64) -> [f64; 3] {
        let &Self { c, sign, level } = self;
        let [value, slope, curvature] = if t == 0.0 { [c[0], c[1], 2.0 * c[2]] } else { value_and_derivatives(c, t) };
        [sign * (value - level), sign * slope, sign * curvature]
    }

    /// The sum of the rising terms of the third derivative.
    fn third_derivative_bound(&self, t: f64, span: f64) -> f64 {
        let rising = |c: f64| if self.sign * c > 0.0 { self.sign * c } else { 0.0 };
        let third = |c: f64, k: f64| k * (k - 1.0) * (k - 2.0) * rising(c);
        (1.0 + 1e-9) * sum_by_lanes(&self.c[3..], &NUMBERS[3..], t + span, third)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Coefficients of `offset + sin(omega t + phase)`.
    fn wave(offset: f64, omega: f64, phase: f64) -> Vec<f64> {
        let (s, c) = libm::sincos(phase);
        let mut term = 1.0;
        let of = |k: usize| {
            term *= if k == 0 { 1.0 } else { omega / k as f64 };
            [s, c, -s, -c][k % 4] * term + if k == 0 { offset } else { 0.0 }
        };
        (0..40).map(of).collect()
    }

    /// From a start above 0 that falls, only a rise above the start is a crossing.
    #[test]
    fn crossing_exceeds_the_start() {
        for c in [[1e-3, 0.0, 0.0, -1.0, 2.0], [1e-3, 0.0, -1.0, 2.0, 0.0], [0.0, 0.0, 0.0, -1.0, 2.0]] {
            let found = first_positive(&c, 1.0, 0.0, 1.0);
            assert!(found.is_some_and(|t| (t - 0.5).abs() < 1e-9), "{c:?}: {found:?}");
        }
    }

    /// A coefficient that is not a finite number gives no false crossing, and the search ends.
    #[test]
    fn crossing_of_nan_is_none() {
        for (k, strange) in (0..12).flat_map(|k| [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX].map(|c| (k, c)))
        {
            let mut c = wave(0.5, 1.9, -1.4);
            c[k] = strange;
            for (sign, level, until) in [(1.0, 0.0, 1.0), (-1.0, 0.3, 1e-300), (1.0, 0.0, f64::INFINITY)] {
                let found = first_positive(&c, sign, level, until);
                assert!(found.is_none_or(|t| t.is_nan() || (0.0..=until).contains(&t)), "{k} {strange}: {found:?}");
                assert!(maximum(&c, 0.0, until).0 >= 0.0);
            }
            let noticed = first_positive(&c, 1.0, 0.0, 1.0).is_some_and(f64::is_nan);
            assert!(noticed || !strange.is_nan(), "{k} {strange}");
        }
        // A single NaN is noticed in the slope, the level and the end of the interval, too.
        assert!(first_positive(&[-1.0, f64::NAN, 0.0], 1.0, 0.0, 1.0).is_some_and(f64::is_nan));
        assert!(first_positive(&wave(0.0, 1.0, 0.0), 1.0, f64::NAN, 1.0).is_some_and(f64::is_nan));
        assert!(first_positive(&wave(0.0, 1.0, 0.0), 1.0, 1.0, f64::NAN).is_some_and(f64::is_nan));
    }

    /// Near 0 the steps become ever shorter, down to 1e-17 of the interval.
    #[test]
    fn crossing_right_after_the_start_is_found() {
        for exponent in [-1, -10, -30, -100, -300] {
            let gap = libm::exp10(f64::from(exponent));
            // t^2 - gap, and t^3 - gap, which turns only after the crossing.
            for (k, place) in [(2, gap.sqrt()), (3, gap.cbrt())] {
                let mut c = [0.0; 12];
                (c[0], c[k]) = (-gap, 1.0);
                let t = first_positive(&c, 1.0, 0.0, 1.0).unwrap();
                assert!((t - place).abs() <= 1e-9 * place + 1e-17, "{t}, not {place}");
                c[k] = -1.0;
                assert_eq!(first_positive(&c, 1.0, 0.0, 1.0), None);
            }
        }
        // It touches 0 at the start, falls, and comes back.
        let mut c = [0.0; 12];
        (c[2], c[3]) = (-0.25, 1.0);
        let t = first_positive(&c, 1.0, 0.0, 1.0).unwrap();
        assert!((t - 0.25).abs() < 1e-12, "{t}");
    }

    #[test]
    fn crossing_of_many_waves_is_the_first() {
        for (omega, phase) in [(0.7, 0.1), (1.9, -1.4), (3.7, 1.0), (3.7, 3.0), (3.7, -3.0)] {
            for level in [-0.99, -0.3, 0.0, 0.3, 0.9, 0.999_999, 1.000_001] {
                // It rises through the level where the phase is the arc sine, after the start.
                let rise = libm::asin(level) - phase;
                let rise = libm::fmod(rise + 4.0 * std::f64::consts::PI, 2.0 * std::f64::consts::PI) / omega;
                let found = first_positive(&wave(-level, omega, phase), 1.0, 0.0, 1.0);
                if libm::sin(phase) < level && rise < 1.0 {
                    let t = found.unwrap();
                    assert!(libm::sin(omega * t + phase) - level < 1e-13 && (t - rise).abs() < 1e-9, "{t}, not {rise}");
                } else if libm::sin(phase) < level {
                    assert_eq!(found, None, "{omega}, {phase}, {level}");
                }
            }
        }
    }
}
