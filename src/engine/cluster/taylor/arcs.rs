//! The geometry of balls on arcs as power series: sines and cosines of the angles, and the lines of the centres.
//!
//! A closed contact's overlap follows from the distance of the centres, whose coefficients are computed without
//! cancellation. An open contact has the coefficients of G (see "Arcs" in docs/theory.md) in the row of its overlap.

use crate::engine::cluster::window::Window;
use crate::model::{Mode, overlap_of_approach};
use crate::solver::series::{product_term, sine_and_cosine_term};

/// Rows of coefficients with the stride of a [`Series`](super::series::Series); empty where balls move on lines.
#[derive(Clone, Debug, Default)]
pub(crate) struct ArcSeries {
    stride: usize,
    /// For each ball: its length, m; the angle, each coefficient times its index; sine and cosine of the angle.
    lengths: Vec<f64>,
    angles: Vec<f64>,
    pub(super) sin: Vec<f64>,
    pub(super) cos: Vec<f64>,
    /// For each contact: horizontal, vertical and full distance of the centres, m; its direction; and the components of
    /// the direction along the paths of the left and the right ball.
    width: Vec<f64>,
    height: Vec<f64>,
    distance: Vec<f64>,
    pub(super) direction: [Vec<f64>; 2],
    pub(super) along: [Vec<f64>; 2],
    /// For an open contact, whose row of overlaps holds G: the distance at which it closes, m.
    touch: Vec<Option<f64>>,
}

impl ArcSeries {
    /// Whether the row of overlaps of contact `j` holds G.
    pub(super) fn is_open(&self, j: usize) -> bool {
        self.touch.get(j).is_some_and(Option::is_some)
    }

    /// The largest coefficient `k` of the deflections, times `k`; it limits how long the velocities converge, too.
    pub(super) fn term(&self, k: usize) -> f64 {
        let rows = self.sin.chunks_exact(self.stride).zip(self.cos.chunks_exact(self.stride)).zip(&self.lengths);
        let term = |((sin, cos), length): ((&[f64], &[f64]), &f64)| {
            k as f64 * (*length * sin[k]).abs().max((*length * cos[k]).abs())
        };
        rows.map(term).fold(0.0, f64::max)
    }

    /// Overlap (m) of contact `j` and its rate, from value and rate of the series in its row.
    pub(super) fn overlap(&self, j: usize, value: f64, rate: f64) -> (f64, f64) {
        let Some(touch) = self.touch.get(j).copied().flatten() else { return (value, rate) };
        let [overlap, rate, _] = overlap_of_approach([value, rate, 0.0], touch);
        (overlap, rate)
    }

    /// The reverse of [`Self::overlap`]: the rate of the series in the row.
    pub(super) fn rate_of_row(&self, j: usize, overlap: f64, rate: f64) -> f64 {
        self.touch.get(j).copied().flatten().map_or(rate, |touch| rate - rate * overlap / touch)
    }

    /// Takes the state at the start.
    pub(super) fn begin(&mut self, window: &Window<'_>, stride: usize, displacements: &[f64], overlaps: &mut [f64]) {
        let (n, on_arcs) = (window.models.len(), window.models[0].on_arc);
        self.stride = stride;
        let of_balls = [&mut self.angles, &mut self.sin, &mut self.cos];
        let of_contacts = [&mut self.width, &mut self.height, &mut self.distance];
        let rows = of_balls.into_iter().chain(of_contacts);
        for rows in rows.chain(&mut self.direction).chain(&mut self.along) {
            rows.clear();
            rows.resize(if on_arcs { n * stride } else { 0 }, 0.0);
        }
        self.lengths.clear();
        self.touch.clear();
        if !on_arcs {
            return;
        }
        let open = |j: usize| {
            (window.contacts[j].mode == Mode::Open).then(|| window.laws[j].pivots - window.laws[j].clearance)
        };
        self.lengths.extend((0..n).map(|i| window.models[i].length));
        self.touch.extend((0..n - 1).map(open));
        for i in 0..n {
            let place = window.models[i].place(window.flights[i].x);
            (self.sin[i * stride], self.cos[i * stride]) = (place.sin, place.cos);
        }
        for k in 0..2 {
            self.expand(window, k, displacements, overlaps, &|_| true);
        }
    }

    /// Computes coefficient `k` of the geometry from those of the displacements, and of the overlaps that are not
    /// `given`.
    pub(super) fn expand(
        &mut self,
        window: &Window<'_>,
        k: usize,
        displacements: &[f64],
        overlaps: &mut [f64],
        given: &dyn Fn(usize) -> bool,
    ) {
        for i in 0..window.models.len() {
            self.expand_ball(i, k, displacements, window.models[i].length);
            let Some(j) = i.checked_sub(1) else { continue };
            let square = self.expand_distances(window, j, k);
            let at = j * self.stride + k;
            match self.touch[j] {
                None => self.expand_closed(j, k, square, (!given(j)).then_some(&mut overlaps[at])),
                Some(touch) if k == 0 => {
                    let overlap = window.contacts[j].overlap;
                    overlaps[at] = overlap - overlap * overlap / (2.0 * touch);
                }
                Some(touch) => overlaps[at] = -square / (2.0 * touch),
            }
        }
    }

    /// Coefficient `k` of sine and cosine of the angle of ball `i`; that at the start is known.
    #[inline(always)]
    fn expand_ball(&mut self, i: usize, k: usize, displacements: &[f64], length: f64) {
        if k == 0 {
            return;
        }
        let row = i * self.stride..(i + 1) * self.stride;
        self.angles[row.start + k] = k as f64 * displacements[row.start + k] / length;
        let rows = [&self.angles, &self.sin, &self.cos].map(|rows| &rows[row.clone()]);
        let (sin, cos) = sine_and_cosine_term(rows[0], rows[1], rows[2], k);
        (self.sin[row.start + k], self.cos[row.start + k]) = (sin, cos);
    }

    /// Coefficient `k` of the horizontal and the vertical distance of the balls of contact `j`; returns that of the
    /// square of their distance.
    #[inline(always)]
    fn expand_distances(&mut self, window: &Window<'_>, j: usize, k: usize) -> f64 {
        let (stride, [left, right]) = (self.stride, [j, j + 1].map(|i| window.models[i].length));
        let (l, r) = (j * stride, (j + 1) * stride);
        if k == 0 {
            [self.width[l], self.height[l]] = window.pair(j).distances([j, j + 1].map(|i| window.flights[i].x));
        } else {
            self.width[l + k] = right * self.sin[r + k] - left * self.sin[l + k];
            self.height[l + k] = left * self.cos[l + k] - right * self.cos[r + k];
        }
        let part = |rows: &[f64]| product_term(&rows[l..l + stride], &rows[l..l + stride], k);
        part(&self.width) + part(&self.height)
    }

    /// Coefficient `k` of distance and direction of the closed contact `j`, from that of the `square` of the distance;
    /// and of its `overlap`, if that is to be computed after the start.
    #[inline(always)]
    fn expand_closed(&mut self, j: usize, k: usize, square: f64, overlap: Option<&mut f64>) {
        let (stride, l) = (self.stride, j * self.stride);
        let at = l + k;
        self.distance[at] = if k == 0 {
            square.sqrt()
        } else {
            let known: f64 = (1..k).map(|i| self.distance[l + i] * self.distance[l + k - i]).sum();
            (square - known) / (2.0 * self.distance[l])
        };
        if k > 0
            && let Some(overlap) = overlap
        {
            *overlap = -self.distance[at];
        }
        for (rows, of) in self.direction.iter_mut().zip([&self.width, &self.height]) {
            let known: f64 = (1..=k).map(|i| self.distance[l + i] * rows[l + k - i]).sum();
            rows[at] = (of[at] - known) / self.distance[l];
        }
        for (rows, ball) in self.along.iter_mut().zip([l, l + stride]) {
            let part = |n: &[f64], to: &[f64]| product_term(&n[l..l + stride], &to[ball..ball + stride], k);
            rows[at] = part(&self.direction[0], &self.cos) + part(&self.direction[1], &self.sin);
        }
    }
}
