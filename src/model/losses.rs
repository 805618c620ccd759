//! Damping from a coefficient of restitution, for the impact of two free balls at a given speed.
//!
//! In units of the impact the reduced mass, the speed of approach and the elastic force at the overlap 1 are 1, so that
//! the overlap x has `x'' = -x^p - D x^s x'`. An impact turns the point (u, z) about the origin, from (1, 0): `u = x'`,
//! and `z = h^-1 x^((p+1)/2)` with `h = sqrt((p+1)/2)`, so that `(u^2 + z^2)/2` is the energy. In polar coordinates
//!
//! ```text
//! d ln(r) / d angle = -q cos^2 / (1 + q sin cos),   q = D / h (h r sin)^w,   w = (2 s - p + 1) / (p + 1)
//! ```
//!
//! A law that does not pull ends where `x^(p-s) = D e` and `u = -e`, another one at the angle pi. Since e determines
//! the end, D is the root of one function: the error of r there.

use std::f64::consts::{FRAC_PI_2, PI};

use super::contact::ContactLaw;

/// Steps of the coarsest integration.
const STEPS: i32 = 60;
/// Number of integrations, each with twice as many steps as the one before, for extrapolation.
const LEVELS: u32 = 5;
/// The variable of integration runs from minus to plus this; beyond, not even the last digit changes, for p up to 10.
const ENDS: f64 = 4.9;

impl ContactLaw {
    /// The damping factor C, N.s/m, with which two free balls of the reduced mass `m` (kg) that close at `rate` (m/s,
    /// positive) part with this `restitution`, above 0 and at most 1; to about 1e-10 of the restitution.
    pub fn damping_for(&self, restitution: f64, m: f64, rate: f64) -> f64 {
        let impact =
            DimensionlessImpact::new(self.exponent, self.damping_exponent(), self.damping.clipped, restitution);
        self.unit_of_damping(m, rate) * if restitution < 1.0 { impact.damping() } else { 0.0 }
    }

    /// The damping factor C, N.s/m, for D = 1 in the units of such an impact.
    pub fn unit_of_damping(&self, m: f64, rate: f64) -> f64 {
        let ratio = (m / self.stiffness).sqrt() * (rate / self.overlap_ref);
        // Unit of length over reference overlap.
        let length = libm::pow(ratio, 2.0 / (self.exponent + 1.0));
        m * rate / (length * self.overlap_ref) / libm::pow(length, self.damping_exponent())
    }
}

/// An impact in units in which its mass, its speed and its stiffness are 1; see above.
struct DimensionlessImpact {
    p: f64,
    s: f64,
    /// Whether the law does not pull.
    clipped: bool,
    restitution: f64,
    h: f64,
    w: f64,
}

impl DimensionlessImpact {
    fn new(p: f64, s: f64, clipped: bool, restitution: f64) -> Self {
        Self { p, s, clipped, restitution, h: (0.5 * (p + 1.0)).sqrt(), w: (2.0 * s - p + 1.0) / (p + 1.0) }
    }

    /// The factor D for the coefficient of restitution, by regula falsi.
    fn damping(&self) -> f64 {
        // Right in the limit of small losses, for a linear contact.
        let guess = 2.0 / PI * (1.0 - self.restitution);
        let (mut low, mut high) = (guess, guess);
        let mut at_low = self.excess(guess);
        let mut at_high = at_low;
        while at_low <= 0.0 {
            (high, at_high, low) = (low, at_low, 0.5 * low);
            at_low = self.excess(low);
        }
        while at_high > 0.0 {
            (low, at_low, high) = (high, at_high, 2.0 * high);
            at_high = self.excess(high);
        }
        for _ in 0..100 {
            if high - low <= 1e-14 * high {
                break;
            }
            let part = if (at_low - at_high).is_finite() { at_low / (at_low - at_high) } else { 0.5 };
            let middle = low + (high - low) * part;
            let value = self.excess(middle);
            if value == 0.0 || !(low < middle && middle < high) {
                return middle;
            }
            // Halving the value at the end that stays makes that end move next time (Illinois).
            if value > 0.0 {
                (low, at_low, at_high) = (middle, value, 0.5 * at_high);
            } else {
                (high, at_high, at_low) = (middle, value, 0.5 * at_low);
            }
        }
        0.5 * (low + high)
    }

    /// `ln(r)` at the end less its value for the coefficient of restitution: positive where D is too small.
    fn excess(&self, damping: f64) -> f64 {
        let Self { p, s, clipped, restitution: e, h, w } = *self;
        if s == p {
            // Hunt and Crossley's law has an integral for every exponent: ln((1 + D)/(1 - D e)) = D (1 + e).
            return if damping * e < 1.0 {
                beyond_linear(-damping * e) - beyond_linear(damping)
            } else {
                f64::NEG_INFINITY
            };
        }
        let z = if clipped { libm::pow(damping * e, 0.5 * (p + 1.0) / (p - s)) / h } else { 0.0 };
        let beyond = libm::atan2(z, e);
        let end = PI - beyond;
        let slope = |t: f64, ln_r: f64| {
            // Double exponential substitution: the ends, with their fractional powers, lie at infinite t.
            let tail = libm::exp(-PI * libm::sinh(t.abs()));
            let (near, far) = (end * tail / (1.0 + tail), end / (1.0 + tail));
            let (angle, rest) = if t < 0.0 { (near, far) } else { (far, near) };
            let rate = near * PI * libm::cosh(t) / (1.0 + tail);
            let (sin, cos) = if angle < FRAC_PI_2 {
                (libm::sin(angle), libm::cos(angle))
            } else {
                (libm::sin(rest + beyond), -libm::cos(rest + beyond))
            };
            let power = libm::pow(h * libm::exp(ln_r) * sin, w.abs());
            let (over, under) = if w < 0.0 { (damping / h, power) } else { (damping / h * power, 1.0) };
            let divisor = under + over * sin * cos;
            (divisor > 0.0).then(|| -over * cos * cos / divisor * rate)
        };
        // The integration fails where balls stick unless the law clips. With w > 0 that means that D is too small: the
        // balls part before the end that belongs to e and would stick only later. Otherwise D is too large.
        let stuck = if w > 0.0 { f64::INFINITY } else { f64::NEG_INFINITY };
        extrapolated(slope).map_or(stuck, |ln_r| ln_r - libm::log(libm::hypot(e, z)))
    }
}

/// `log(1 + x) - x`, for x above -1.
fn beyond_linear(x: f64) -> f64 {
    if x.abs() > 0.3 {
        return libm::log1p(x) - x;
    }
    // By the series of log(1 + x) = 2 artanh(y), whose first term 2 y is x - x y.
    let y = x / (2.0 + x);
    let series = (1..12).rev().fold(0.0, |sum, k| y * y * (sum + 1.0 / f64::from(2 * k + 1)));
    2.0 * y * series - x * y
}

/// End value of a solution that starts at 0, by the classical Runge-Kutta method with ever smaller steps, extrapolated;
/// `None` if `slope` gives it anywhere.
fn extrapolated(slope: impl Fn(f64, f64) -> Option<f64>) -> Option<f64> {
    let mut rows: Vec<f64> = Vec::new();
    for level in 0..LEVELS {
        let count = STEPS << level;
        let (step, mut y) = (2.0 * ENDS / f64::from(count), 0.0);
        for k in 0..count {
            let t = -ENDS + f64::from(k) * step;
            let k1 = slope(t, y)?;
            let k2 = slope(t + 0.5 * step, y + 0.5 * step * k1)?;
            let k3 = slope(t + 0.5 * step, y + 0.5 * step * k2)?;
            y += step / 6.0 * (k1 + 2.0 * (k2 + k3) + slope(t + step, y + step * k3)?);
        }
        // The leading error is of order 4.
        let (mut row, mut weight) = (vec![y], 16.0);
        for coarser in rows {
            let finer = row[row.len() - 1];
            row.push(finer + (finer - coarser) / (weight - 1.0));
            weight *= 2.0;
        }
        rows = row;
    }
    rows.last().copied()
}
