//! Systems of linear equations whose matrix is block-tridiagonal, by Gaussian elimination (Golub and Van Loan, Matrix
//! Computations, 2013, sections 3.4 and 4.5.1).
//!
//! Our own code for so small blocks: linear algebra packages choose their kernels by the processor, and a run must give
//! the same bits on all of them.

use super::radau::{Matrix, STAGES, Stages};

/// The rows of a block-tridiagonal matrix with their right-hand sides.
#[derive(Clone, Debug, Default)]
pub struct BlockTridiagonal {
    rows: Vec<Row>,
}

#[derive(Clone, Debug)]
struct Row {
    lower: Matrix,
    diagonal: Matrix,
    /// The block above the diagonal and, in the last column, the right-hand side.
    right: [[f64; STAGES + 1]; STAGES],
}

impl BlockTridiagonal {
    /// Makes it empty.
    pub fn clear(&mut self) {
        self.rows.clear();
    }

    /// Adds a block row with its right-hand side. The first one's `lower` and the last one's `upper` have no meaning.
    pub fn push(&mut self, lower: Matrix, diagonal: Matrix, upper: &Matrix, known: &Stages) {
        let mut right = [[0.0; STAGES + 1]; STAGES];
        for ((right, upper), known) in right.iter_mut().zip(upper).zip(known) {
            right[..STAGES].copy_from_slice(upper);
            right[STAGES] = *known;
        }
        self.rows.push(Row { lower, diagonal, right });
    }

    /// The solution, a block a row; pivots are sought within the blocks. The rows are used up.
    pub fn solve(&mut self) -> impl Iterator<Item = Stages> {
        for i in 0..self.rows.len() {
            let (before, rest) = self.rows.split_at_mut(i);
            let row = &mut rest[0];
            if let Some(before) = before.last() {
                for (r, lower) in row.lower.iter().enumerate() {
                    for (factor, above) in lower.iter().zip(&before.right) {
                        row.diagonal[r].iter_mut().zip(above).for_each(|(d, a)| *d -= factor * a);
                        row.right[r][STAGES] -= factor * above[STAGES];
                    }
                }
            }
            solve_dense(&mut row.diagonal, &mut row.right);
        }
        for i in (1..self.rows.len()).rev() {
            let (before, after) = self.rows.split_at_mut(i);
            for right in &mut before[i - 1].right {
                let known: f64 = right[..STAGES].iter().zip(&after[0].right).map(|(u, next)| u * next[STAGES]).sum();
                right[STAGES] -= known;
            }
        }
        self.rows.iter().map(|row| row.right.map(|right| right[STAGES]))
    }
}

/// Solves `matrix X = right` in the place of `right`, by Gaussian elimination with partial pivoting.
pub fn solve_dense<const COLUMNS: usize>(matrix: &mut Matrix, right: &mut [[f64; COLUMNS]; STAGES]) {
    for column in 0..STAGES {
        let size = |&row: &usize| matrix[row][column].abs();
        let pivot = (column..STAGES).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(column);
        matrix.swap(column, pivot);
        right.swap(column, pivot);
        for row in column + 1..STAGES {
            let factor = matrix[row][column] / matrix[column][column];
            subtract(matrix, factor, column, row);
            subtract(right, factor, column, row);
        }
    }
    for row in (0..STAGES).rev() {
        for (below, factor) in matrix[row].iter().enumerate().skip(row + 1) {
            subtract(right, *factor, below, row);
        }
        let inverse = 1.0 / matrix[row][row];
        right[row].iter_mut().for_each(|r| *r *= inverse);
    }
}

/// Takes `factor` times row `of` from row `from`.
fn subtract<const COLUMNS: usize>(rows: &mut [[f64; COLUMNS]; STAGES], factor: f64, of: usize, from: usize) {
    let taken = rows[of];
    rows[from].iter_mut().zip(taken).for_each(|(r, t)| *r -= factor * t);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::radau::times;

    #[test]
    fn solves_what_it_was_multiplied_from() {
        let mut state = 1u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let mut matrix = || -> Matrix { std::array::from_fn(|_| std::array::from_fn(|_| random())) };
        let blocks: Vec<[Matrix; 3]> = (0..4).map(|_| [matrix(), matrix(), matrix()]).collect();
        let wanted: Vec<Stages> = (0..4).map(|i| std::array::from_fn(|k| (i * STAGES + k) as f64)).collect();
        let mut system = BlockTridiagonal::default();
        for (i, [lower, diagonal, upper]) in blocks.iter().enumerate() {
            let mut right = times(diagonal, &wanted[i]);
            let mut add = |more: Stages| right.iter_mut().zip(more).for_each(|(r, m)| *r += m);
            if i > 0 {
                add(times(lower, &wanted[i - 1]));
            }
            if i < 3 {
                add(times(upper, &wanted[i + 1]));
            }
            system.push(*lower, *diagonal, upper, &right);
        }
        for (found, wanted) in system.solve().zip(&wanted) {
            for (f, w) in found.iter().zip(wanted) {
                assert!((f - w).abs() < 1e-10, "{f} {w}");
            }
        }
    }
}
