//! The Radau IIA collocation method with nine stages, of order 17 and L-stable.
//!
//! On a step of length h from y_0 the collocation polynomial satisfies the equations at the times `c_i h`, the last of
//! which is the end of the step: `Y_i = y_0 + h sum_j a_ij f(Y_j)` with the `a_ij` the integrals of the Lagrange
//! polynomials of the nodes (Hairer and Wanner, Solving Ordinary Differential Equations II, 1996, section IV.5).

use std::sync::LazyLock;

use nalgebra::{SMatrix, SVector};

use super::quadrature::gauss_legendre;

pub const STAGES: usize = 9;

/// One value per stage.
pub type Stages = SVector<f64, STAGES>;

/// A linear map of stage values.
pub type Matrix = SMatrix<f64, STAGES, STAGES>;

/// The zeros of `P_s(2 c - 1) - P_(s-1)(2 c - 1)`, P the Legendre polynomials.
const NODES: [f64; STAGES] = [
    0.017_779_915_147_363_434,
    0.091_323_607_899_793_93,
    0.214_308_479_395_630_75,
    0.371_932_164_583_272_3,
    0.545_186_684_803_426_7,
    0.713_175_242_855_569_5,
    0.855_633_742_957_854_4,
    0.955_366_044_710_030_2,
    1.0,
];

#[derive(Debug)]
pub struct Radau {
    /// The nodes `c_i`, in (0, 1].
    pub nodes: Stages,
    /// The `a_ij`: integrals from 0 to the nodes.
    pub integral: Matrix,
    /// The inverse of `integral`: differentiates polynomials that are 0 at 0.
    pub derivative: Matrix,
}

pub static RADAU: LazyLock<Radau> = LazyLock::new(Radau::new);

impl Radau {
    fn new() -> Self {
        let nodes = Stages::from(NODES);
        let lagrange = |j: usize, x: f64| {
            let others = (0..STAGES).filter(|&k| k != j);
            others.map(|k| (x - nodes[k]) / (nodes[j] - nodes[k])).product::<f64>()
        };
        let entry = |i: usize, j: usize| gauss_legendre(&|x| lagrange(j, x), 0.0, nodes[i], 1);
        let integral = Matrix::from_fn(entry);
        let derivative = inverse(&integral);
        Self { nodes, integral, derivative }
    }

    /// Coefficients of the powers of the polynomial through `start` at 0 and the stage values at the nodes.
    pub fn polynomial_from(&self, start: f64, values: &Stages) -> [f64; STAGES + 1] {
        let mut nodes = [0.0; STAGES + 1];
        let mut differences = [start; STAGES + 1];
        nodes[1..].copy_from_slice(self.nodes.as_slice());
        differences[1..].copy_from_slice(values.as_slice());
        powers(&nodes, differences)
    }

    /// Coefficients of the powers of the polynomial through the stage values at the nodes.
    pub fn polynomial(&self, values: &Stages) -> [f64; STAGES] {
        powers(&self.nodes.into(), (*values).into())
    }
}

/// Newton's divided differences of the values at `nodes`, turned into coefficients of powers. For smooth functions
/// nothing cancels, as it would with the inverse of a Vandermonde matrix.
fn powers<const N: usize>(nodes: &[f64; N], values: [f64; N]) -> [f64; N] {
    let mut c = values;
    for level in 1..N {
        for i in (level..N).rev() {
            c[i] = (c[i] - c[i - 1]) / (nodes[i] - nodes[i - level]);
        }
    }
    for level in (0..N - 1).rev() {
        for i in level..N - 1 {
            c[i] -= nodes[level] * c[i + 1];
        }
    }
    c
}

/// Inverse of a matrix; not finite if there is none.
pub fn inverse(matrix: &Matrix) -> Matrix {
    matrix.lu().try_inverse().unwrap_or_else(|| Matrix::repeat(f64::NAN))
}

/// A block row of a block tridiagonal matrix, with its right-hand side `known`. The first `lower` and the last `upper`
/// are ignored.
#[derive(Clone, Debug)]
pub struct BlockRow {
    pub lower: Matrix,
    pub diagonal: Matrix,
    pub upper: Matrix,
    pub known: Stages,
}

/// The solution, one block per row, by Gaussian elimination with pivoting within the blocks (Golub and Van Loan, Matrix
/// Computations, 2013, section 4.5.1); `None` if a block is singular. Overwrites the rows.
pub fn solve(rows: &mut [BlockRow]) -> Option<impl Iterator<Item = Stages>> {
    let last = rows.len().saturating_sub(1);
    for i in 0..rows.len() {
        let (before, rest) = rows.split_at_mut(i);
        let row = &mut rest[0];
        if let Some(before) = before.last() {
            row.diagonal -= row.lower * before.upper;
            row.known -= row.lower * before.known;
        }
        let factors = row.diagonal.lu();
        if !factors.solve_mut(&mut row.known) || i < last && !factors.solve_mut(&mut row.upper) {
            return None;
        }
    }
    for i in (1..rows.len()).rev() {
        let later = rows[i].known;
        let row = &mut rows[i - 1];
        row.known -= row.upper * later;
    }
    Some(rows.iter().map(|row| row.known))
}
