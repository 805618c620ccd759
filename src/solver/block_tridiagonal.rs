//! Linear equations with a block tridiagonal matrix, by Gaussian elimination (Golub and Van Loan, Matrix Computations,
//! 2013, section 4.5.1).

use super::radau::{Matrix, Stages};

/// A block row of the matrix with its right-hand side; `lower` of the first row and `upper` of the last are ignored.
#[derive(Clone, Debug)]
pub struct Row {
    pub lower: Matrix,
    pub diagonal: Matrix,
    pub upper: Matrix,
    pub known: Stages,
}

/// The solution, one block per row, with pivoting within the blocks; `None` if there is no pivot. Consumes the rows.
pub fn solve(rows: &mut [Row]) -> Option<impl Iterator<Item = Stages>> {
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
