//! Symmetric, positive definite, tridiagonal systems.

/// The factors `L D L'` of a matrix, which need no pivoting here (Golub and Van Loan, Matrix Computations, section
/// 4.3.6).
pub(super) struct Tridiagonal {
    diagonal: Vec<f64>,
    beside: Vec<f64>,
}

impl Tridiagonal {
    /// Of the matrix with this diagonal and these elements beside it, one less.
    pub fn new(mut diagonal: Vec<f64>, mut beside: Vec<f64>) -> Self {
        for i in 0..beside.len() {
            let factor = beside[i] / diagonal[i];
            diagonal[i + 1] -= factor * beside[i];
            beside[i] = factor;
        }
        Self { diagonal, beside }
    }

    /// Replaces `b` by the solution of `matrix * solution = b`.
    pub fn solve(&self, b: &mut [f64]) {
        for i in 0..self.beside.len() {
            b[i + 1] -= self.beside[i] * b[i];
        }
        b.iter_mut().zip(&self.diagonal).for_each(|(b, d)| *b /= d);
        for i in (0..self.beside.len()).rev() {
            b[i] -= self.beside[i] * b[i + 1];
        }
    }
}
