//! Two neighbours in flight on arcs: the series of G, of which the overlap is `2 G / (1 + q)` with
//! `q = sqrt(1 - 2 G / D_c)`, and whether they keep their sides. See "Arcs" in docs/theory.md.

use serde::{Deserialize, Serialize};

use super::path::{FEW, Path, TERMS, Terms, dot};
use crate::model::{ContactLaw, overlap_of_approach};
use crate::solver::DoubleDouble;
use crate::solver::crossing::first_positive;
use crate::solver::series::{bound, value, value_and_derivatives};

/// G of two neighbours in flight: a series, with so many `terms`, in the time since a common start over `unit` (s).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Approach {
    terms: usize,
    unit: f64,
    /// How long the series holds, s, backwards and forwards.
    pub before: f64,
    pub length: f64,
    /// Distance of the centres at first contact, `D_c`, m.
    touch: f64,
    g: Terms,
    /// When the centre of one ball crosses the string of the other, if that is while the series holds, s.
    pub crossing: Option<f64>,
}

impl Approach {
    /// From the lengths of the two pendulums (m), their paths, their overlap (m) at the start and its law.
    pub fn new([l, r]: [f64; 2], [left, right]: [&Path; 2], overlap: f64, law: &ContactLaw) -> Self {
        // The shorter unit: no power of the ratio of the units leaves the range of doubles.
        let (unit, touch) = (left.unit.min(right.unit), law.pivots - law.clearance);
        let terms = left.terms.min(right.terms);
        let (mut width, mut height, mut factors) = ([0.0; TERMS], [0.0; TERMS], [1.0; 2]);
        for k in 0..terms {
            let [l, r] = [l * factors[0], r * factors[1]];
            width[k] = r * right.sin[k] - l * left.sin[k];
            height[k] = l * left.cos[k] - r * right.cos[k];
            factors = [factors[0] * (unit / left.unit), factors[1] * (unit / right.unit)];
        }
        width[0] += law.pivots;
        height[0] += r - l;
        let back = |c: &Terms| -> Terms { std::array::from_fn(|k| c[TERMS - 1 - k]) };
        let (width_back, height_back, factor) = (back(&width), back(&height), -0.5 / touch);
        let mut g = [0.0; TERMS];
        for (k, c) in g[..terms].iter_mut().enumerate() {
            let back = TERMS - 1 - k..;
            *c = (dot(&width[..=k], &width_back[back.clone()]) + dot(&height[..=k], &height_back[back])) * factor;
        }
        g[0] = overlap * (1.0 - 0.5 * overlap / touch);
        let (before, length) = (left.before.min(right.before), left.length.min(right.length));
        let sides = Sides {
            unit,
            lengths: [l, r],
            paths: [left, right],
            distances: [&width[..terms], &height[..terms]],
            g: &g[..terms],
            pivots: law.pivots,
            touch,
            until: length / unit,
        };
        let crossing = [sides.crossing(0), sides.crossing(1)].into_iter().flatten().reduce(f64::min);
        Self { terms, unit, before, length, touch, g, crossing: crossing.map(|time| time * unit) }
    }

    pub fn is_sound(&self) -> bool {
        let scales = [self.unit, self.before, self.length, self.touch];
        (FEW..=TERMS).contains(&self.terms)
            && scales.iter().all(|scale| *scale > 0.0)
            && scales.iter().chain(&self.g).chain(&self.crossing).all(|value| value.is_finite())
    }

    /// Whether the overlap does not change.
    pub fn is_constant(&self) -> bool {
        self.g[1..].iter().all(|c| *c == 0.0)
    }

    /// Overlap (m), its rate (m/s) and acceleration (m/s2) at `tau` (s), while the series holds.
    pub fn at(&self, tau: f64) -> [f64; 3] {
        let [g, slope, curvature] = value_and_derivatives(&self.g[..self.terms], tau / self.unit);
        overlap_of_approach([g, slope / self.unit, curvature / (self.unit * self.unit)], self.touch)
    }

    /// Time after the start at which the overlap rises through 0, by more than `rounding` (m), while the series holds.
    /// A rate (m/s) and an acceleration (m/s2) of these sizes count as none.
    pub fn onset(&self, rounding: f64, [rate, acceleration]: [f64; 2]) -> Option<DoubleDouble> {
        let (mut g, unit, until) = (self.g, self.unit, self.length / self.unit);
        let g = &mut g[..self.terms];
        g[1] -= rate * unit;
        g[2] -= 0.5 * acceleration * unit * unit;
        let onset = first_positive(g, 1.0, 0.0, until)? * unit;
        if value(g, until) <= rounding && first_positive(g, 1.0, rounding, until).is_none() {
            return None;
        }
        let [overlap, rate, _] = self.at(onset);
        let later = if rate > 0.0 && overlap.abs() <= 1e-6 * onset * rate { -overlap / rate } else { 0.0 };
        Some(DoubleDouble::from(onset) + later)
    }
}

/// Two neighbours in flight on arcs, which may go over each other: see "Arcs" in docs/theory.md. Times are multiples of
/// `unit`.
struct Sides<'a> {
    /// Unit of time, s.
    unit: f64,
    /// Lengths of the pendulums, m.
    lengths: [f64; 2],
    paths: [&'a Path; 2],
    /// Series of the horizontal and the vertical distance of the centres, m, and of G.
    distances: [&'a [f64]; 2],
    g: &'a [f64],
    /// Distance of the pivots, and of the centres at first contact, m.
    pivots: f64,
    touch: f64,
    /// How long the series hold.
    until: f64,
}

impl Sides<'_> {
    /// When a centre first crosses the string of the left (0) or the right (1) ball, `k`.
    #[inline]
    fn crossing(&self, k: usize) -> Option<f64> {
        let (own, other, angle) = (self.lengths[k], self.lengths[1 - k], self.paths[k].reach / self.lengths[k]);
        let (sin, less) = (angle.min(1.0), 0.5 * angle * angle);
        let aside = self.pivots + (own - other).abs() * sin;
        // Centres at a crossing are at most
        // D_0 sin + max(L - L_c, 0) (1 - cos) + (D_0 + |L - L_c| sin)^2 / L_c
        // apart, with the distance D_0 of the pivots, the lengths L of the string and L_c of the other, and the largest
        // angle.
        let near = self.pivots * sin + (own - other).max(0.0) * less.min(1.0) + aside * aside / other;
        if near < self.touch { None } else { self.crossing_within(near, [sin, less], k) }
    }

    /// When the other centre crosses the string of ball `k`, with the centres no farther apart than `near` (m), which
    /// is rare. The sine of the angle of the string is at most the first of the two numbers, its cosine at least 1 less
    /// the second. If the centre gets beyond the line of the string outside of its ends, a later crossing shows once
    /// the series are renewed.
    #[inline(never)]
    fn crossing_within(&self, near: f64, [largest_sine, less]: [f64; 2], k: usize) -> Option<f64> {
        let &Self { paths, distances: [width, height], g, touch, until, .. } = self;
        let [narrower, higher] = [width, height].map(|c| until * bound(&c[1..], until));
        let stays_beside = (width[0] - narrower) * (1.0 - less).max(0.0) > (height[0].abs() + higher) * largest_sine;
        let level = 0.5 * (touch - near * (near / touch));
        let comes_near = || g[0] >= level || first_positive(g, 1.0, level, until).is_some();
        if stays_beside || !comes_near() {
            return None;
        }
        // Backwards, as `dot` needs them.
        let pace = self.unit / paths[k].unit;
        let ([mut sin, mut cos], mut factor) = ([[0.0; TERMS]; 2], 1.0);
        for i in 0..g.len() {
            (sin[TERMS - 1 - i], cos[TERMS - 1 - i]) = (factor * paths[k].sin[i], factor * paths[k].cos[i]);
            factor *= pace;
        }
        // Distance of the other centre beyond the line of the string.
        let mut beyond = [0.0; TERMS];
        for (i, c) in beyond[..g.len()].iter_mut().enumerate() {
            *c = -(dot(&width[..=i], &cos[TERMS - 1 - i..]) + dot(&height[..=i], &sin[TERMS - 1 - i..]));
        }
        let beyond = &beyond[..g.len()];
        let time = if beyond[0] >= 0.0 { 0.0 } else { first_positive(beyond, 1.0, 0.0, until)? };
        // Place of the crossing up the string from its ball.
        let [width, height] = [width, height].map(|c| value(c, time));
        let [sin, cos] = [&paths[k].sin, &paths[k].cos].map(|c| value(c, pace * time));
        let up = if k == 0 { height * cos - width * sin } else { width * sin - height * cos };
        (0.0..self.lengths[k]).contains(&up).then_some(time)
    }
}
