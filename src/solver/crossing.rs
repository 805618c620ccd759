//! First crossings and maxima of truncated power series.

use super::root;
use super::series::{
    MOST, NUMBERS, about, bound, bound_of_change_of_derivative, derivative_by_lanes, sample, sample_derivative,
    sample_terms, value_and_derivatives, value_by_lanes,
};

/// Number of equidistant places at which a series is sampled at once.
const SAMPLES: usize = 8;

/// Halvings of an interval where a series comes near 0 before it is expanded there, and the number of such expansions:
/// a few suffice unless it almost touches.
const HALVINGS: usize = 4;
const EXPANSIONS: usize = 50;

/// Rounding below which a series is noise.
const NOISE: f64 = 4.0 * f64::EPSILON;

/// Where on `[from, to]` the value is largest, and that value.
///
/// The interval is scanned in eighths for changes of sign of the derivative, each refined to a maximum; within its
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
            // Newton's steps: half the digits of the place give all digits of the maximum.
            let falling = |t: f64| {
                let [_, slope, curvature] = value_and_derivatives(c, t);
                [-slope, -curvature, 0.0]
            };
            best = higher(best, root::rising_zero(falling, (left, -slope_left), (right, -slope_right)));
        }
        (left, slope_left) = (right, slope_right);
    }
    best
}

fn eighths(from: f64, to: f64) -> [f64; SAMPLES] {
    std::array::from_fn(|p| from + (to - from) * (p + 1) as f64 / SAMPLES as f64)
}

/// The first `t` in `[0, until]` from which on `sign` (1 or -1) times the series minus `level` is positive.
///
/// At 0 it should not be positive; a value that is counts as 0. If it is 0 there, the derivatives decide: rising, the
/// result is 0; falling, the search continues after it. A maximum that touches 0 within rounding is not a crossing.
/// None is missed: between two places a function exceeds its chord by no more than its curvature allows.
pub fn first_positive(c: &[f64], sign: f64, level: f64, until: f64) -> Option<f64> {
    first_within(c, sign, level, until, EXPANSIONS)
}

/// The same, with a limited number of expansions about later places.
fn first_within(c: &[f64], sign: f64, level: f64, until: f64, expansions: usize) -> Option<f64> {
    let (value, slope, curvature) = (sign * (c[0] - level), sign * c[1], sign * c[2]);
    // A cheap bound: most searches would find nothing.
    if value.max(value + until * slope) < -until * until * bound(&c[2..], until) {
        return None;
    }
    if value >= 0.0 && (slope > 0.0 || (slope == 0.0 && curvature > 0.0)) {
        return Some(0.0);
    }
    let level = if value > 0.0 { c[0] } else { level };
    // Coefficients about a later place give tighter bounds after it.
    let beyond = |clear: f64| {
        let about: [f64; MOST] = about(c, clear);
        let found = first_within(&about[..c.len()], sign, level, until - clear, expansions.checked_sub(1)?);
        found.map(|t| clear + t)
    };
    // At a start with vanishing value, slope and curvature the first coefficient that is not zero decides.
    if [value, slope, curvature] == [0.0; 3] {
        let lead = 3 + c[3..].iter().position(|&c| c != 0.0)?;
        if sign * c[lead] > 0.0 {
            return Some(0.0);
        }
        // On this stretch the leading term dominates.
        let (half, rest) = (0.5 * c[lead].abs(), bound(&c[lead + 1..], until));
        return if rest * until <= half { None } else { beyond(half / rest) };
    }
    let places = eighths(0.0, until);
    let values = sample(c, &places).map(|value| sign * (value - level));
    // Of two intervals at a time.
    let curvatures = largest_curvatures(c, &std::array::from_fn::<_, { SAMPLES / 2 }, _>(|p| places[2 * p + 1]));
    let search = Search { c, sign, level };
    let mut left = (0.0, value.min(0.0));
    for (p, right) in places.into_iter().zip(values).enumerate() {
        match search.between(left, right, curvatures[p / 2], HALVINGS) {
            Ok(None) => left = right,
            Ok(found) => return found,
            Err(clear) => return beyond(clear),
        }
    }
    None
}

/// Bounds of the absolute second derivative from 0 to each place.
fn largest_curvatures<const PLACES: usize>(c: &[f64], places: &[f64; PLACES]) -> [f64; PLACES] {
    let bend = |c: f64, k: f64| k * (k - 1.0) * c.abs();
    sample_terms(&c[2..], &NUMBERS[2..], places, bend).map(|c| (1.0 + 1e-9) * c)
}

/// The search for where `sign (c - level)` becomes positive for a series c.
struct Search<'a> {
    c: &'a [f64],
    sign: f64,
    level: f64,
}

impl Search<'_> {
    /// The crossing between two places with their values, where the curvature is at most `curvature`; or, if halving
    /// does not decide, up to where there is none.
    fn between(&self, from: (f64, f64), to: (f64, f64), curvature: f64, halvings: usize) -> Result<Option<f64>, f64> {
        let &Self { c, sign, level } = self;
        let distance = to.0 - from.0;
        let bend = distance * curvature;
        let highest = from.1.max(to.1) + 0.125 * distance * bend;
        // From 0, or from a value that counts as 0, the slope leads away.
        let falls = || from.0 == 0.0 && sign * c[1] + 0.5 * bend < 0.0;
        let rounding = || NOISE * (level.abs() + c[0].abs() + to.0 * (c[1].abs() + 0.5 * to.0 * curvature));
        if to.1 <= 0.0 && (highest < 0.0 || falls() || highest <= rounding()) {
            return Ok(None);
        }
        // No slope differs from that of the chord by more than half the change of slope.
        if from.1 < 0.0 && to.1 > 0.0 && to.1 - from.1 > 0.5 * distance * bend {
            let g = |t: f64| {
                let [value, slope, curvature] = value_and_derivatives(c, t);
                [sign * (value - level), sign * slope, sign * curvature]
            };
            return Ok(Some(root::rising_zero(g, from, to)));
        }
        if halvings == 0 && from.0 > 0.0 {
            return Err(from.0);
        }
        let middle = 0.5 * (from.0 + to.0);
        if middle <= from.0 || middle >= to.0 {
            return Ok((to.1 > 0.0).then_some(to.0));
        }
        let [of_left] = largest_curvatures(c, &[middle]);
        let middle = (middle, sign * (value_by_lanes(c, middle) - level));
        match self.between(from, middle, of_left, halvings.saturating_sub(1)) {
            Ok(None) => self.between(middle, to, curvature, halvings.saturating_sub(1)),
            found => found,
        }
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

    #[test]
    fn the_first_crossing_of_many_waves() {
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
