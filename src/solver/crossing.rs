//! Where truncated power series cross a level for the first time, and where they are largest.

use super::root::{self, Smooth};
use super::series::{
    NUMBERS, SAMPLES, bound, bound_of_change_of_derivative, derivative_by_lanes, sample, sample_derivative,
    sample_terms, shifted, sum_by_lanes, value_and_derivatives, value_by_lanes,
};

/// How often the distance of two places is halved where a series comes near 0: some times suffice unless it almost
/// touches.
const HALVINGS: usize = 4;

/// The largest value on `[from, to]`.
pub fn maximum(c: &[f64], from: f64, to: f64) -> f64 {
    place_and_maximum(c, from, to).1
}

/// Where on `[from, to]` the value is largest.
pub fn place_of_maximum(c: &[f64], from: f64, to: f64) -> f64 {
    place_and_maximum(c, from, to).0
}

/// Both.
///
/// The interval is scanned in eighths for changes of sign of the derivative, each refined to a maximum; a series that a
/// step controller has cut to its range of fast convergence does not turn more often.
fn place_and_maximum(c: &[f64], from: f64, to: f64) -> (f64, f64) {
    let higher = |best: (f64, f64), t: f64| {
        let value = value_by_lanes(c, t);
        if value > best.1 { (t, value) } else { best }
    };
    let at_start = if from == 0.0 { c[0] } else { value_by_lanes(c, from) };
    let mut best = higher((from, at_start), to);
    if c.len() > 1 && c[1].abs() > bound_of_change_of_derivative(c, to) {
        return best;
    }
    let places: [f64; SAMPLES] = std::array::from_fn(|p| from + (to - from) * (p + 1) as f64 / SAMPLES as f64);
    let sampled = sample_derivative(c, &places);
    let slope_at_start = if from == 0.0 && c.len() > 1 { c[1] } else { derivative_by_lanes(c, from) };
    let (mut left, mut slope_left) = (from, slope_at_start);
    for (right, slope_right) in places.into_iter().zip(sampled) {
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

/// The first `t` in `[0, until]` from which on `sign` (1 or -1) times the series less `level` is positive; see
/// [`root::first_positive`].
pub fn first_positive(c: &[f64], sign: f64, level: f64, until: f64) -> Option<f64> {
    // Most searches find nothing and need not be made.
    let linear = (sign * (c[0] - level)).max(sign * (c[0] - level + until * c[1]));
    if linear < -until * until * bound(&c[2..], until) {
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
    let g = Above { c, sign, level };
    let found = if from == 0.0 { scan(&g, until) } else { Err(from) };
    found.unwrap_or_else(|clear| match clear {
        0.0 => root::first_positive(&g, 0.0, until),
        // About a later place the coefficients tell more of what comes behind it.
        _ => {
            let about = shifted(c, clear);
            let g = Above { c: &about[..c.len()], sign, level };
            root::first_positive(&g, 0.0, until - clear).map(|t| clear + t)
        }
    })
}

/// The answer of [`first_positive`], if it can be had from values at some places: between two of them a function is
/// above its chord by no more than its curvature allows. Else, how far it is surely not positive.
fn scan(g: &Above, until: f64) -> Result<Option<f64>, f64> {
    let Above { c, sign, level } = *g;
    let places: [f64; SAMPLES] = std::array::from_fn(|p| until * (p + 1) as f64 / SAMPLES as f64);
    let values = sample(c, &places).map(|value| sign * (value - level));
    // Of two intervals at a time.
    let curvatures: [f64; SAMPLES / 2] = std::array::from_fn(|p| places[2 * p + 1]);
    let bend = |c: f64, k: f64| k * (k - 1.0) * c.abs();
    let curvatures = sample_terms(&c[2.min(c.len())..], &NUMBERS[2..], &curvatures, bend).map(|c| (1.0 + 1e-9) * c);
    let mut from = (0.0, sign * (c[0] - level));
    for (p, to) in places.into_iter().zip(values).enumerate() {
        // Most are far below.
        if highest(from, to, curvatures[p / 2]) < 0.0 {
            from = to;
            continue;
        }
        match g.between(from, to, curvatures[p / 2], HALVINGS) {
            Ok(None) => from = to,
            found => return found,
        }
    }
    Ok(None)
}

/// The most that a function may be between two places, each with the value there, where nothing bends more than by
/// `curvature`.
fn highest(from: (f64, f64), to: (f64, f64), curvature: f64) -> f64 {
    let distance = to.0 - from.0;
    from.1.max(to.1) + 0.125 * distance * distance * curvature
}

/// `sign (c - level)` for a series c.
struct Above<'a> {
    c: &'a [f64],
    sign: f64,
    level: f64,
}

impl Above<'_> {
    /// The answer of [`scan`] between two places, each with the value there, where nothing bends more than by
    /// `curvature`.
    fn between(&self, from: (f64, f64), to: (f64, f64), curvature: f64, halvings: usize) -> Result<Option<f64>, f64> {
        let bend = (to.0 - from.0) * curvature;
        // Where it starts from 0, or so near that it counts as 0, the slope leads away from there.
        let falls = || from.0 == 0.0 && self.sign * self.c[1] + 0.5 * bend < 0.0;
        if highest(from, to, curvature) < 0.0 || falls() {
            return Ok(None);
        }
        // No slope differs from that of the chord by more than half of what it bends.
        if from.1 < 0.0 && to.1 > 0.0 && to.1 - from.1 > 0.5 * (to.0 - from.0) * bend {
            return Ok(Some(root::rising_zero(|t| self.at(t), from, to)));
        }
        if halvings == 0 {
            return Err(from.0);
        }
        let middle = 0.5 * (from.0 + to.0);
        let middle = (middle, self.sign * (value_by_lanes(self.c, middle) - self.level));
        match self.between(from, middle, curvature, halvings - 1) {
            Ok(None) => self.between(middle, to, curvature, halvings - 1),
            found => found,
        }
    }
}

impl Smooth for Above<'_> {
    fn at(&self, t: f64) -> [f64; 3] {
        let [value, slope, curvature] = value_and_derivatives(self.c, t);
        [value - self.level, slope, curvature].map(|d| self.sign * d)
    }

    fn third_derivative_bound(&self, t: f64, span: f64) -> f64 {
        let start = 3.min(self.c.len());
        sum_by_lanes(&self.c[start..], &NUMBERS[3..], t + span, |c, k| k * (k - 1.0) * (k - 2.0) * c.abs())
    }

    fn bound_depends_on_span(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
                // It rises through the level where the phase is that of its arc sine, after the start.
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

    #[test]
    fn a_start_from_zero_is_no_crossing() {
        // Down from 0 and up again, with decays that make the bounds of a series coarse.
        let decay: Vec<f64> = (0..40)
            .scan(1.0, |term, k| {
                *term *= if k == 0 { 1.0 } else { -6.0 / k as f64 };
                Some(*term)
            })
            .collect();
        let mut c = decay;
        (c[0], c[1]) = (c[0] - 1.0, c[1] + 1.5);
        let t = first_positive(&c, 1.0, 0.0, 1.0).unwrap();
        assert!((libm::exp(-6.0 * t) - 1.0 + 1.5 * t).abs() < 1e-13 && t > 0.5, "{t}");
        assert_eq!(first_positive(&c, 1.0, 0.0, 0.5), None);
    }
}
