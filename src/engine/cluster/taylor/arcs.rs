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
        let (stride, two, arcs) = (self.stride, 2.0, self);
        for i in 0..window.models.len() {
            let (row, length) = (i * stride..(i + 1) * stride, window.models[i].length);
            if k > 0 {
                arcs.angles[row.start + k] = k as f64 * displacements[row.start + k] / length;
                let rows = [&arcs.angles, &arcs.sin, &arcs.cos].map(|rows| &rows[row.clone()]);
                let (sin, cos) = sine_and_cosine_term(rows[0], rows[1], rows[2], k);
                (arcs.sin[row.start + k], arcs.cos[row.start + k]) = (sin, cos);
            }
            let Some(j) = i.checked_sub(1) else { continue };
            let (l, r, left) = (j * stride, i * stride, window.models[j].length);
            let at = l + k;
            arcs.width[at] = length * arcs.sin[r + k] - left * arcs.sin[l + k];
            arcs.height[at] = left * arcs.cos[l + k] - length * arcs.cos[r + k];
            if k == 0 {
                [arcs.width[at], arcs.height[at]] = window.pair(j).distances([j, i].map(|i| window.flights[i].x));
            }
            let part = |rows: &[f64]| product_term(&rows[l..l + stride], &rows[l..l + stride], k);
            let square = part(&arcs.width) + part(&arcs.height);
            if let Some(touch) = arcs.touch[j] {
                overlaps[at] = if k == 0 {
                    let overlap = window.contacts[j].overlap;
                    overlap - overlap * overlap / (two * touch)
                } else {
                    -square / (two * touch)
                };
                continue;
            }
            arcs.distance[at] = if k == 0 {
                square.sqrt()
            } else {
                let known: f64 = (1..k).map(|i| arcs.distance[l + i] * arcs.distance[l + k - i]).sum();
                (square - known) / (two * arcs.distance[l])
            };
            if k > 0 && !given(j) {
                overlaps[at] = -arcs.distance[at];
            }
            for (rows, of) in arcs.direction.iter_mut().zip([&arcs.width, &arcs.height]) {
                let known: f64 = (1..=k).map(|i| arcs.distance[l + i] * rows[l + k - i]).sum();
                rows[at] = (of[at] - known) / arcs.distance[l];
            }
            for (rows, ball) in arcs.along.iter_mut().zip([l, r]) {
                let part = |n: &[f64], to: &[f64]| product_term(&n[l..l + stride], &to[ball..ball + stride], k);
                rows[at] = part(&arcs.direction[0], &arcs.cos) + part(&arcs.direction[1], &arcs.sin);
            }
        }
    }
}
