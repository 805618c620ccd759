//! Systems of linear equations whose matrix is block-tridiagonal, by Gaussian elimination (Golub and Van Loan, Matrix
//! Computations, 2013, section 4.5.1).

use super::radau::{Matrix, Stages};

/// The rows of a block-tridiagonal matrix with their right-hand sides.
#[derive(Clone, Debug, Default)]
pub struct BlockTridiagonal {
    rows: Vec<Row>,
}

#[derive(Clone, Debug)]
struct Row {
    lower: Matrix,
    diagonal: Matrix,
    upper: Matrix,
    known: Stages,
}

impl BlockTridiagonal {
    /// Makes it empty.
    pub fn clear(&mut self) {
        self.rows.clear();
    }

    /// Adds a block row with its right-hand side. The first one's `lower` and the last one's `upper` have no meaning.
    pub fn push(&mut self, lower: Matrix, diagonal: Matrix, upper: Matrix, known: Stages) {
        self.rows.push(Row { lower, diagonal, upper, known });
    }

    /// The solution, a block a row; pivots are sought within the blocks. `None` where there is no pivot. The rows are
    /// used up.
    pub fn solve(&mut self) -> Option<impl Iterator<Item = Stages>> {
        let last = self.rows.len().saturating_sub(1);
        for i in 0..self.rows.len() {
            let (before, rest) = self.rows.split_at_mut(i);
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
        for i in (1..self.rows.len()).rev() {
            let later = self.rows[i].known;
            let row = &mut self.rows[i - 1];
            row.known -= row.upper * later;
        }
        Some(self.rows.iter().map(|row| row.known))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::radau::STAGES;

    #[test]
    fn solves_what_it_was_multiplied_from() {
        let mut state = 1u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let mut matrix = || Matrix::from_fn(|_, _| random());
        let blocks: Vec<[Matrix; 3]> = (0..4).map(|_| [matrix(), matrix(), matrix()]).collect();
        let wanted: Vec<Stages> = (0..4).map(|i| Stages::from_fn(|k, _| (i * STAGES + k) as f64)).collect();
        let mut system = BlockTridiagonal::default();
        for (i, &[lower, diagonal, upper]) in blocks.iter().enumerate() {
            let mut right = diagonal * wanted[i];
            if i > 0 {
                right += lower * wanted[i - 1];
            }
            if i < 3 {
                right += upper * wanted[i + 1];
            }
            system.push(lower, diagonal, upper, right);
        }
        for (found, wanted) in system.solve().unwrap().zip(&wanted) {
            assert!((found - wanted).amax() < 1e-10, "{found} {wanted}");
        }
    }
}
