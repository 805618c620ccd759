//! The solution over one step as polynomials.

use serde::{Deserialize, Serialize};

use crate::solver::DoubleDouble;

/// The solution over the last step: each component is a polynomial of `s = (t - end) / step` on `[-1, 0]`.
///
/// Its coefficients are scaled derivatives at the end of the step, `step^j y^(j) / j!`: Nordsieck's array (1962).
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct NordsieckStep {
    pub end: DoubleDouble,
    /// Length, s; 0 before the first step.
    pub step: f64,
    pub degree: usize,
    size: usize,
    /// Coefficients 0 of all components, then coefficients 1, and so on.
    columns: Vec<f64>,
}

impl NordsieckStep {
    /// A path of no length at `y`, with room for polynomials up to `degree`.
    pub fn resting(t: DoubleDouble, y: &[f64], degree: usize) -> Self {
        let mut columns = y.to_vec();
        columns.resize(y.len() * (degree + 1), 0.0);
        Self { end: t, step: 0.0, degree: 0, size: y.len(), columns }
    }

    /// Whether it has `size` components, room for polynomials up to `room` and, unless `broken`, finite values.
    pub fn is_sound(&self, size: usize, room: usize, broken: bool) -> bool {
        let fits = self.size == size && self.columns.len() == size * (room + 1) && self.degree <= room;
        let finite = |path: &Self| path.columns[..size * (path.degree + 1)].iter().all(|c| c.is_finite());
        fits && (broken || self.end.is_sound() && self.step >= 0.0 && self.step.is_finite() && finite(self))
    }

    /// Coefficients `j` of all components.
    #[inline]
    pub fn column(&self, j: usize) -> &[f64] {
        &self.columns[j * self.size..(j + 1) * self.size]
    }

    #[inline]
    pub fn column_mut(&mut self, j: usize) -> &mut [f64] {
        &mut self.columns[j * self.size..(j + 1) * self.size]
    }

    pub fn last(&self) -> &[f64] {
        self.column(0)
    }

    pub fn start(&self) -> DoubleDouble {
        self.end + -self.step
    }

    /// The argument `s` at the time `t` on the step.
    pub fn place(&self, t: DoubleDouble) -> f64 {
        if self.step == 0.0 { 0.0 } else { ((t - self.end).value() / self.step).clamp(-1.0, 0.0) }
    }

    pub fn time(&self, s: f64) -> DoubleDouble {
        self.end + s * self.step
    }

    pub fn value(&self, i: usize, s: f64) -> f64 {
        let coefficient = |j: usize| self.columns[j * self.size + i];
        (0..self.degree).rev().fold(coefficient(self.degree), |sum, j| sum * s + coefficient(j))
    }

    /// Derivative of component `i` by time at `s`.
    pub fn rate(&self, i: usize, s: f64) -> f64 {
        let term = |j: usize| j as f64 * self.columns[j * self.size + i];
        let by_s = (1..=self.degree).rev().fold(0.0, |sum, j| sum * s + term(j));
        if self.step == 0.0 { 0.0 } else { by_s / self.step }
    }

    pub fn state(&self, s: f64) -> Vec<f64> {
        (0..self.size).map(|i| self.value(i, s)).collect()
    }

    /// Copies `other` without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        (self.end, self.step, self.degree) = (other.end, other.step, other.degree);
        let used = (other.degree + 1) * self.size;
        self.columns[..used].copy_from_slice(&other.columns[..used]);
    }

    /// Rescales the same polynomials to steps `ratio` times as long.
    pub fn rescale(&mut self, ratio: f64) {
        if ratio == 1.0 {
            return;
        }
        let mut power = 1.0;
        for j in 1..=self.degree {
            power *= ratio;
            self.column_mut(j).iter_mut().for_each(|c| *c *= power);
        }
        self.step *= ratio;
    }

    /// Moves the end of the step on by one step along the same polynomials: Pascal's triangle.
    pub fn extrapolate(&mut self) {
        for k in 1..=self.degree {
            for j in (k..=self.degree).rev() {
                let (lower, upper) = self.columns.split_at_mut(j * self.size);
                lower[(j - 1) * self.size..].iter_mut().zip(upper).for_each(|(a, b)| *a += *b);
            }
        }
        self.end += self.step;
    }

    pub fn add(&mut self, j: usize, factor: f64, e: &[f64]) {
        self.column_mut(j).iter_mut().zip(e).for_each(|(c, e)| *c += factor * e);
    }
}
