//! First crossings and maxima of truncated power series.

use super::root;
use super::series::{
    self, MOST, NUMBERS, bound, bound_of_change_of_derivative, derivative_by_lanes, sample, sample_derivative,
    sample_terms, value_and_derivatives, value_by_lanes,
};

/// Number of equidistant places at which a series is sampled at once.
const SAMPLES: usize = 8;

/// Halvings of an interval where a series comes near 0 before it is expanded there, and the number of such expansions:
/// a few suffice unless it almost touches.
const HALVINGS: usize = 4;
const EXPANSIONS: usize = 50;

/// Halvings of an interval that begins at 0, where an expansion would change nothing: down to 5e-20 of its length, far
/// below what the series resolves.
const HALVINGS_FROM_0: usize = 64;

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

/// The first `t` in `[0, until]` from which on `sign` (1 or -1) times the series minus `level` is positive; NaN for a
/// series that leaves the range of doubles, so that it is noticed where that time is used.
///
/// At 0 it should not be positive; a value that is counts as 0. If it is 0 there, the derivatives decide: rising, the
/// result is 0; falling, the search continues after it. A maximum that touches 0 within rounding is not a crossing.
/// None is missed: between two places a function exceeds its chord by no more than its curvature allows.
#[inline]
pub fn first_positive(c: &[f64], sign: f64, level: f64, until: f64) -> Option<f64> {
    match first_near(c, sign, level, until) {
        Ok(found) => found,
        Err(undecided) => first_beyond(c, sign, until, undecided),
    }
}

/// A place up to which there is no crossing, and the level after it.
type Undecided = (f64, f64);

/// Goes on from place to place, with coefficients about each, which give tighter bounds after it.
fn first_beyond(c: &[f64], sign: f64, mut until: f64, (mut clear, mut level): Undecided) -> Option<f64> {
    let (mut about, mut places) = ([0.0; MOST], [0.0; EXPANSIONS]);
    about[..c.len()].copy_from_slice(c);
    for expansion in 0..EXPANSIONS {
        places[expansion] = clear;
        until -= clear;
        about = series::about(&about[..c.len()], clear);
        match first_near(&about[..c.len()], sign, level, until) {
            Ok(found) => return found.map(|t| places[..=expansion].iter().rev().fold(t, |t, place| place + t)),
            Err(undecided) => (clear, level) = undecided,
        }
    }
    None
}

/// The same as [`first_positive`] by these coefficients alone.
fn first_near(c: &[f64], sign: f64, level: f64, until: f64) -> Result<Option<f64>, Undecided> {
    let (value, slope, curvature) = (sign * (c[0] - level), sign * c[1], sign * c[2]);
    let (chord, bend) = (value + until * slope, until * until * bound(&c[2..], until));
    // A cheap bound: most searches would find nothing.
    if value < -bend && chord < -bend {
        return Ok(None);
    }
    // Of numbers beyond the range of doubles nothing is known.
    if !(chord + bend).is_finite() {
        return Ok(Some(f64::NAN));
    }
    if value >= 0.0 && (slope > 0.0 || (slope == 0.0 && curvature > 0.0)) {
        return Ok(Some(0.0));
    }
    let level = if value > 0.0 { c[0] } else { level };
    // At a start with vanishing value, slope and curvature the first coefficient that is not zero decides.
    if [value, slope, curvature] == [0.0; 3] {
        let Some(lead) = c[3..].iter().position(|&c| c != 0.0).map(|more| 3 + more) else { return Ok(None) };
        if sign * c[lead] > 0.0 {
            return Ok(Some(0.0));
        }
        // On this stretch the leading term dominates.
        let (half, rest) = (0.5 * c[lead].abs(), bound(&c[lead + 1..], until));
        return if rest * until <= half { Ok(None) } else { Err((half / rest, level)) };
    }
    let places = eighths(0.0, until);
    let values = sample(c, &places).map(|value| sign * (value - level));
    // Of two intervals at a time.
    let curvatures = largest_curvatures(c, &std::array::from_fn::<_, { SAMPLES / 2 }, _>(|p| places[2 * p + 1]));
    let search = Search { c, sign, level };
    let mut left = (0.0, value.min(0.0));
    for (p, right) in places.into_iter().zip(values).enumerate() {
        let found = match p {
            0 => search.search_from_0(left.1, right, curvatures[0]),
            _ => search.between(left, right, curvatures[p / 2], HALVINGS),
        };
        match found {
            Ok(None) => left = right,
            Ok(found) => return Ok(found),
            Err(clear) => return Err((clear, level)),
        }
    }
    Ok(None)
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

/// A place and the value there, with its sign and above the level.
type Point = (f64, f64);

impl Search<'_> {
    /// The crossing between two places where the curvature is at most `curvature`; `Err` if the bounds do not decide.
    #[inline]
    fn decide(&self, from: Point, to: Point, curvature: f64) -> Result<Option<f64>, ()> {
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
        Err(())
    }

    /// The place half way between two, unless doubles do not resolve it.
    fn middle(&self, from: f64, to: f64) -> Option<Point> {
        let middle = 0.5 * (from + to);
        let value = || self.sign * (value_by_lanes(self.c, middle) - self.level);
        (from < middle && middle < to).then(|| (middle, value()))
    }

    /// A bound of the absolute second derivative from 0 to `place`.
    fn curvature_up_to(&self, place: f64) -> f64 {
        let [curvature] = largest_curvatures(self.c, &[place]);
        curvature
    }

    /// The crossing between two places, the first one above 0, where the curvature is at most `curvature`; or, if so
    /// many `halvings` do not decide, up to where there is none.
    fn between(&self, from: Point, to: Point, curvature: f64, halvings: usize) -> Result<Option<f64>, f64> {
        if let Ok(decided) = self.decide(from, to, curvature) {
            return Ok(decided);
        }
        let Some(halvings) = halvings.checked_sub(1) else { return Err(from.0) };
        let Some(middle) = self.middle(from.0, to.0) else { return Ok((to.1 > 0.0).then_some(to.0)) };
        match self.between(from, middle, self.curvature_up_to(middle.0), halvings)? {
            None => self.between(middle, to, curvature, halvings),
            found => Ok(found),
        }
    }

    /// The same from 0, where the value is `at_0`.
    fn search_from_0(&self, at_0: f64, to: Point, curvature: f64) -> Result<Option<f64>, f64> {
        self.decide((0.0, at_0), to, curvature).or_else(|()| self.towards_0(at_0, to, curvature))
    }

    /// In ever shorter intervals from 0, then back through those left out.
    #[cold]
    fn towards_0(&self, at_0: f64, mut to: Point, mut curvature: f64) -> Result<Option<f64>, f64> {
        let (mut later, mut count) = ([((0.0, 0.0), 0.0); HALVINGS_FROM_0], 0);
        loop {
            let Some(middle) = self.middle(0.0, to.0).filter(|_| count < HALVINGS_FROM_0) else {
                if to.1 > 0.0 {
                    return Ok(Some(to.0));
                }
                break;
            };
            later[count] = (to, curvature);
            count += 1;
            (to, curvature) = (middle, self.curvature_up_to(middle.0));
            match self.decide((0.0, at_0), to, curvature) {
                Ok(None) => break,
                Ok(found) => return Ok(found),
                Err(()) => {}
            }
        }
        for (count, &(next, curvature)) in later[..count].iter().enumerate().rev() {
            match self.between(to, next, curvature, HALVINGS.saturating_sub(count + 1))? {
                None => to = next,
                found => return Ok(found),
            }
        }
        Ok(None)
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

    /// Of a series with one coefficient that is none nothing is known, and the search ends.
    #[test]
    fn what_is_no_number_gives_none() {
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
        // Also where nothing bends and the value alone is below 0.
        assert!(first_positive(&[-1.0, f64::NAN, 0.0], 1.0, 0.0, 1.0).is_some_and(f64::is_nan));
        assert!(first_positive(&wave(0.0, 1.0, 0.0), 1.0, f64::NAN, 1.0).is_some_and(f64::is_nan));
        assert!(first_positive(&wave(0.0, 1.0, 0.0), 1.0, 1.0, f64::NAN).is_some_and(f64::is_nan));
    }

    /// Near 0, where no expansion helps, the intervals become ever shorter; from a touch at 0 down to the shortest.
    #[test]
    fn crossings_right_after_the_start() {
        for exponent in [-1, -10, -30, -100, -300] {
            let gap = libm::exp10(f64::from(exponent));
            // t^2 - gap, and t^3 - gap, which turns only after the crossing.
            for (k, place) in [(2, gap.sqrt()), (3, gap.cbrt())] {
                let mut c = [0.0; 12];
                (c[0], c[k]) = (-gap, 1.0);
                let t = first_positive(&c, 1.0, 0.0, 1.0).unwrap();
                assert!((t - place).abs() <= 1e-9 * place + 1e-19, "{t}, not {place}");
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
