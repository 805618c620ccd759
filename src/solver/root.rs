//! The first time at which a function becomes positive: see "Separation and first crossings" in docs/theory.md.

use super::hypotenuse;
use crate::forecast::Forecast;

/// A function whose first crossing is searched for: a closed form or a power series.
pub trait Smooth {
    /// Whether bounds on shorter spans are so much lower that they are worth their cost: true for polynomials, false
    /// for oscillators.
    const TIGHTENS: bool = false;
    /// Value and first two derivatives at `t`.
    fn at(&self, t: f64) -> [f64; 3];
    /// An upper bound, 0 or more, of the third derivative on `[t, t + span]`.
    fn third_derivative_bound(&self, t: f64, span: f64) -> f64;
    /// A time within which it may change a lot.
    fn time_scale(&self) -> f64 {
        f64::INFINITY
    }
}

/// Largest ratio of the next step to the last one. Trying too long a step costs little, unless bounds tighten.
const GROWTH: f64 = 1000.0;
const GROWTH_OF_TIGHT: f64 = 8.0;

/// The first `t` in `[from, until]` after which `g` is positive, with at most `allowed` evaluations, which are counted
/// down.
///
/// `g(from)` should not be positive; if it is, only a rise above that value counts. If `g(from)` is 0, the derivatives
/// decide: rising, the result is `from`; falling, the search continues after it. A maximum that touches 0 within
/// rounding is no crossing. Where `g` is NaN, the result is the time NaN, which the caller notices.
pub fn search_within<G: Smooth>(g: &G, from: f64, until: f64, allowed: &mut u32) -> Forecast {
    let mut t = from;
    let mut window = (until - from).min(g.time_scale());
    // Where g is 0 within rounding no bound helps: steps double from a tiny one (of the window or the unit of time).
    let least = 1e-17 * window.min(1.0);
    let (mut blind, mut excess) = (least, None);
    while *allowed > 0 {
        *allowed -= 1;
        let [value, slope, curvature] = g.at(t);
        let value = value - *excess.get_or_insert(value.max(0.0));
        if value.is_nan() {
            return Forecast::At(value);
        }
        if value >= 0.0 && (slope > 0.0 || (slope == 0.0 && curvature > 0.0)) {
            return Forecast::At(t);
        }
        let rest = until - t;
        if rest <= 0.0 {
            return Forecast::Never;
        }
        let step = safe_step(g, t, [value.min(0.0), slope, curvature], window.min(rest));
        if step >= rest {
            return Forecast::Never;
        }
        let resolution = least.max(f64::EPSILON * t);
        if slope > 0.0 && -value <= 4.0 * slope * resolution {
            // The crossing is nearer than the resolution of t.
            return Forecast::At(if step > least { t + step } else { t });
        }
        if step > resolution || (slope > 0.0 && t + step > t) {
            t += step;
            window = if G::TIGHTENS { GROWTH_OF_TIGHT } else { GROWTH } * step;
            blind = least;
        } else {
            t = t.next_up().max(t + blind);
            blind *= 2.0;
        }
    }
    Forecast::NotBefore(t)
}

/// A step from `t`, at most `window`, on which `g` provably does not become positive: the longest of a few tries.
pub fn safe_step<G: Smooth>(g: &G, t: f64, [value, slope, curvature]: [f64; 3], window: f64) -> f64 {
    // No step can be longer than if the third derivative were zero.
    let mut span = window.min(first_root_of_parabola(value, slope, curvature));
    let mut best = 0.0_f64;
    let mut bound = g.third_derivative_bound(t, span);
    for _ in 0..8 {
        // On the span, g <= value + slope s + (curvature + bound span / 3) s^2 / 2.
        let bent = curvature + bound * span / 3.0;
        let reach = first_root_of_parabola(value, slope, bent).min(span);
        best = best.max(reach);
        if reach >= 0.3 * span {
            break;
        }
        span = (3.0 * best).max(0.05 * span);
        if G::TIGHTENS {
            bound = g.third_derivative_bound(t, span);
        }
    }
    best
}

/// The first `s > 0` with `value + slope s + bent s^2 / 2 >= 0`, for `value <= 0`; infinite if there is none.
pub fn first_root_of_parabola(value: f64, slope: f64, bent: f64) -> f64 {
    if value == 0.0 {
        return if slope < 0.0 && bent > 0.0 {
            -2.0 * slope / bent
        } else if slope > 0.0 || bent > 0.0 {
            0.0
        } else {
            f64::INFINITY
        };
    }
    if bent == f64::INFINITY {
        return 0.0;
    }
    let discriminant = slope * slope - 2.0 * bent * value;
    if discriminant < 0.0 {
        return f64::INFINITY;
    }
    // The form of the root without cancellation.
    if slope >= 0.0 {
        let denominator = slope + discriminant.sqrt();
        if denominator > 0.0 { -2.0 * value / denominator } else { f64::INFINITY }
    } else if bent > 0.0 {
        (hypotenuse(discriminant, slope, (-2.0 * bent * value).sqrt()) - slope) / bent
    } else {
        f64::INFINITY
    }
}

/// Zero of a derivative between `low`, where it is positive, and `high`, where it is not: the place of a maximum.
/// Secant steps kept inside the bracket (the Illinois variant of regula falsi, Dowell and Jarratt 1971).
pub fn falling_zero(slope: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let (mut at_low, mut at_high) = (slope(low), slope(high));
    for _ in 0..60 {
        let middle = low + (high - low) * (at_low / (at_low - at_high));
        let at_middle = slope(middle);
        // A maximum is flat: half the digits of its place give all digits of its value.
        if at_middle == 0.0 || (high - low) <= 1e-9 * (high.abs() + low.abs()) {
            return middle;
        }
        if at_middle > 0.0 {
            (low, at_low, at_high) = (middle, at_middle, 0.5 * at_high);
        } else {
            (high, at_high, at_low) = (middle, at_middle, 0.5 * at_low);
        }
    }
    0.5 * (low + high)
}

/// A zero between `low`, where a function is not positive, and `high`, where it is not negative, with the values there.
/// From the zero of the chord, third-order steps go to roots of parabolas and stay inside the bracket.
pub fn rising_zero(g: impl Fn(f64) -> [f64; 3], (mut low, at_low): (f64, f64), (mut high, at_high): (f64, f64)) -> f64 {
    let width = high - low;
    let mut t = low + width * (at_low / (at_low - at_high));
    for _ in 0..60 {
        let [value, slope, curvature] = g(t);
        if value > 0.0 {
            high = t;
        } else {
            low = t;
        }
        let discriminant = slope * slope - 2.0 * curvature * value;
        let next = t - 2.0 * value / (slope + discriminant.max(0.0).sqrt());
        let inside = next >= low && next <= high;
        if inside && (next - t).abs() <= 1e-6 * width {
            return next;
        }
        t = if inside { next } else { 0.5 * (low + high) };
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line with a decay of 1e-18 s before it.
    struct Decaying;

    impl Smooth for Decaying {
        fn at(&self, t: f64) -> [f64; 3] {
            let decay = 1e-3 * libm::exp(-1e18 * t);
            [0.5 * t - 1.0 - decay, 0.5 + 1e18 * decay, -1e36 * decay]
        }
        fn third_derivative_bound(&self, t: f64, _: f64) -> f64 {
            1e51 * libm::exp(-1e18 * t)
        }
    }

    #[test]
    fn root_finder_takes_no_short_step_for_a_crossing() {
        let t = search_within(&Decaying, 0.0, 10.0, &mut 1000).found().unwrap();
        assert!((t - 2.0).abs() < 1e-15, "{t}");
    }
}
