//! Whether two neighbours in flight on arcs keep their sides.

use super::path::{Path, TERMS, dot};
use crate::solver::crossing::first_positive;
use crate::solver::series::{bound, value};

/// Two neighbours in flight, which may go over each other: see "Arcs" in docs/theory.md. Times are over the left unit.
pub(super) struct Sides<'a> {
    /// Of the pendulums, m.
    pub lengths: [f64; 2],
    pub paths: [&'a Path; 2],
    /// Series of the horizontal and the vertical distance of the centres, m, and of G.
    pub distances: [&'a [f64]; 2],
    pub g: &'a [f64],
    /// Distance of the pivots, and of centres that touch, m.
    pub pivots: f64,
    pub touch: f64,
    /// How long the series hold.
    pub until: f64,
}

impl Sides<'_> {
    /// When a centre first crosses the string of ball `k`, the left or the right one.
    #[inline]
    pub fn crossing(&self, k: usize) -> Option<f64> {
        let (own, other, angle) = (self.lengths[k], self.lengths[1 - k], self.paths[k].reach / self.lengths[k]);
        let (sin, less) = (angle.min(1.0), 0.5 * angle * angle);
        let aside = self.pivots + (own - other).abs() * sin;
        // At most so far apart.
        let near = self.pivots * sin + (own - other).max(0.0) * less.min(1.0) + aside * aside / other;
        if near < self.touch { None } else { self.crossing_within(near, [sin, less], k) }
    }

    /// When it crosses it, no farther apart than `near` (m), which is rare. The angle of the string has a sine up to
    /// the first of the two numbers, and a cosine less than 1 by no more than the second. Where the centre first gets
    /// beyond the line of the string outside of its ends, a later crossing shows once the series are renewed.
    #[inline(never)]
    fn crossing_within(&self, near: f64, [largest_sine, less]: [f64; 2], k: usize) -> Option<f64> {
        let &Self { paths, distances: [width, height], g, touch, until, .. } = self;
        let [narrower, higher] = [width, height].map(|c| until * bound(&c[1..], until));
        let stays_beside = (width[0] - narrower) * (1.0 - less) > (height[0].abs() + higher) * largest_sine;
        let level = 0.5 * (touch - near * (near / touch));
        let comes_near = || g[0] >= level || first_positive(g, 1.0, level, until).is_some();
        if stays_beside || !comes_near() {
            return None;
        }
        // Backwards, as `dot` needs them.
        let pace = paths[0].unit / paths[k].unit;
        let ([mut sin, mut cos], mut factor) = ([[0.0; TERMS]; 2], 1.0);
        for i in 0..g.len() {
            (sin[TERMS - 1 - i], cos[TERMS - 1 - i]) = (factor * paths[k].sin[i], factor * paths[k].cos[i]);
            factor *= pace;
        }
        // How far the other centre is beyond the line of the string.
        let mut beyond = [0.0; TERMS];
        for (i, c) in beyond[..g.len()].iter_mut().enumerate() {
            *c = -(dot(&width[..=i], &cos[TERMS - 1 - i..]) + dot(&height[..=i], &sin[TERMS - 1 - i..]));
        }
        let beyond = &beyond[..g.len()];
        let time = if beyond[0] >= 0.0 { 0.0 } else { first_positive(beyond, 1.0, 0.0, until)? };
        // How far up from the ball that is.
        let [width, height] = [width, height].map(|c| value(c, time));
        let [sin, cos] = [&paths[k].sin, &paths[k].cos].map(|c| value(c, pace * time));
        let up = if k == 0 { height * cos - width * sin } else { width * sin - height * cos };
        (0.0..self.lengths[k]).contains(&up).then_some(time)
    }
}
