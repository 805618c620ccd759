//! Linear equations with a block tridiagonal matrix, by Gaussian elimination (Golub and Van Loan, Matrix Computations,
//! 2013, section 4.5.1).

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
    pub fn clear(&mut self) {
        self.rows.clear();
    }

    /// Adds a block row with its right-hand side; `lower` of the first row and `upper` of the last are ignored.
    pub fn push(&mut self, lower: Matrix, diagonal: Matrix, upper: Matrix, known: Stages) {
        self.rows.push(Row { lower, diagonal, upper, known });
    }

    /// The solution, one block per row, with pivoting within the blocks; `None` if there is no pivot. Consumes the
    /// rows.
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
