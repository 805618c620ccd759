//! Symmetric, positive definite, tridiagonal systems.

/// The matrix; solving replaces it by its factors.
#[derive(Clone, Debug, Default)]
pub struct Tridiagonal {
    pub diagonal: Vec<f64>,
    /// Beside the diagonal, one element less.
    pub beside: Vec<f64>,
    factored: bool,
}

impl Tridiagonal {
    pub fn new(diagonal: Vec<f64>, beside: Vec<f64>) -> Self {
        Self { diagonal, beside, factored: false }
    }

    /// Replaces `b` by the solution of `matrix * solution = b`: the factors `L D L'`, which need no pivoting here
    /// (Golub and Van Loan, Matrix Computations, section 4.3.6).
    pub fn solve(&mut self, b: &mut [f64]) {
        if !std::mem::replace(&mut self.factored, true) {
            for i in 0..self.beside.len() {
                let factor = self.beside[i] / self.diagonal[i];
                self.diagonal[i + 1] -= factor * self.beside[i];
                self.beside[i] = factor;
            }
        }
        for i in 0..self.beside.len() {
            b[i + 1] -= self.beside[i] * b[i];
        }
        b.iter_mut().zip(&self.diagonal).for_each(|(b, d)| *b /= d);
        for i in (0..self.beside.len()).rev() {
            b[i] -= self.beside[i] * b[i + 1];
        }
    }
}
