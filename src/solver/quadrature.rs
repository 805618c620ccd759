//! Integrals of smooth functions, by the rule of Gauss and Legendre.

use super::gauss::{Nodes, Stretching, weighted};

/// Integral from 0 to `t` of a function given at all places at a time: exact up to degree 31, and to rounding where it
/// varies by no more than about a wave.
pub fn of_samples(t: f64, f: impl Fn(&Nodes) -> Nodes) -> f64 {
    let table = Stretching::None.table();
    t * weighted(&table.of_rate, &f(&table.times.map(|part| t * part)))
}

/// Integral of `f` over `[a, b]`, the interval split into `panels` equal parts (at least 1).
pub fn gauss_legendre(f: impl Fn(f64) -> f64, a: f64, b: f64, panels: usize) -> f64 {
    let width = (b - a) / panels as f64;
    let panel = |p: usize| of_samples(width, |places| places.map(|t| f(a + p as f64 * width + t)));
    (0..panels).map(panel).sum()
}
