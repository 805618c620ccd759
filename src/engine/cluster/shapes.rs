//! The natural modes of a chain of balls of masses `m_i` joined by springs `k_j`, with free ends, in units of the first
//! mass and the first stiffness.
//!
//! The coordinate of mode j is `q_j = sum_i m_i phi_j(i) x_i`; the shapes are orthogonal: `sum_i m_i phi_a(i) phi_b(i)
//! = 0` for a other than b, 1 for a = b. Mode 0 is the motion of the centre of mass.
//!
//! They come from the eigenvectors u of a matrix with one row for each contact (Meirovitch, Fundamentals of Vibrations,
//! 2001, chapter 7),
//!
//! ```text
//! T = K^(1/2) D M^-1 D' K^(1/2),    T u = lambda u,    phi = M^-1 D' K^(1/2) u / sqrt(lambda),
//! D phi = sqrt(lambda) K^(-1/2) u
//! ```
//!
//! with `D x` the differences of neighbours. T is tridiagonal and, unlike the matrix of the balls, has no eigenvalue 0
//! whose rounding would spoil the slowest modes.

use nalgebra::{DMatrix, SymmetricEigen};

/// Allowed relative difference between `T u` and `lambda u`; modes beyond it are spoiled by rounding.
const TOLERANCE: f64 = 1e-12;

#[derive(Clone, Debug)]
pub(super) struct Shapes {
    /// `lambda_j`.
    pub lambda: Vec<f64>,
    /// For each mode: `phi_j(i)` for each ball, the displacement for a unit of its coordinate.
    pub balls: Vec<f64>,
    /// For each mode: `phi_j(i) - phi_j(i + 1)` for each contact, the same of the overlap.
    pub contacts: Vec<f64>,
}

impl Shapes {
    /// For these `masses` and, one less, `stiffnesses`; `None` if they are too far apart.
    pub fn new(masses: &[f64], stiffnesses: &[f64]) -> Option<Self> {
        let (size, contacts) = (masses.len(), stiffnesses.len());
        let roots: Vec<f64> = stiffnesses.iter().map(|k| k.sqrt()).collect();
        let matrix = DMatrix::from_fn(contacts, contacts, |r, c| match r.abs_diff(c) {
            0 => stiffnesses[r] * (1.0 / masses[r] + 1.0 / masses[r + 1]),
            1 => -roots[r] * roots[c] / masses[r.max(c)],
            _ => 0.0,
        });
        if !matrix.iter().all(|entry| entry.is_finite()) {
            return None;
        }
        let mut shapes = Self { lambda: Vec::new(), balls: Vec::new(), contacts: Vec::new() };
        let total: f64 = masses.iter().sum();
        shapes.lambda.push(0.0);
        shapes.balls.extend(masses.iter().map(|_| 1.0 / total.sqrt()));
        shapes.contacts.extend(stiffnesses.iter().map(|_| 0.0));
        if contacts == 0 {
            return Some(shapes);
        }
        // It takes about two iterations per eigenvalue.
        let vectors = SymmetricEigen::try_new(matrix, f64::EPSILON, 30 * size)?.eigenvectors;
        for u in vectors.column_iter() {
            let force = |i: usize| roots.get(i).map_or(0.0, |root| root * u[i]);
            let pushed = |i: usize| (force(i) - force(i.wrapping_sub(1))) / masses[i];
            // From the vector, the eigenvalue has twice its digits (Rayleigh's quotient).
            let lambda: f64 = (0..size).map(|i| masses[i] * pushed(i) * pushed(i)).sum();
            let root = lambda.sqrt();
            let good = |i: usize| (roots[i] * (pushed(i) - pushed(i + 1)) - lambda * u[i]).abs() <= TOLERANCE * lambda;
            if !(0..contacts).all(good) {
                return None;
            }
            shapes.lambda.push(lambda);
            shapes.balls.extend((0..size).map(|i| pushed(i) / root));
            shapes.contacts.extend((0..contacts).map(|i| root * u[i] / roots[i]));
        }
        Some(shapes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_unequal_has_no_modes_here() {
        assert!(Shapes::new(&[1.0, 1e-300, 2.0], &[1.0, 1.5]).is_none());
        assert!(Shapes::new(&[1.0, 1e-30, 1.0], &[1.0, 1e300]).is_none());
        assert!(Shapes::new(&[1.0, 1e-2, 2.0], &[1.0, 1.5]).is_some());
    }
}
