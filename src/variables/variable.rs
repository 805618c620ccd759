//! A variable of the interface: found by name or value reference, and listed in the order of the description.
//!
//! A value reference is the row's position times 16384 plus the zero-based index, so that it does not depend on n and a
//! getter finds its row by one array access.

use super::table::TABLE;
use super::table::row::Row;

/// Smallest number of balls.
pub const MIN_BALLS: usize = 1;
/// Largest number of balls; every index fits into a value reference.
pub const MAX_BALLS: usize = 10_000;
/// Number of balls without resources.
pub const DEFAULT_BALLS: usize = 5;

const INDEX_BITS: u32 = 14;
const INDEX_MASK: u32 = (1 << INDEX_BITS) - 1;
const _: () = assert!(MAX_BALLS <= 1 << INDEX_BITS);

/// One variable: a row and a valid zero-based index.
#[derive(Clone, Copy)]
pub struct Variable {
    /// Its row.
    pub row: &'static Row,
    /// Position of its row in [`TABLE`].
    pub position: usize,
    /// Zero-based ball or contact; 0 for scalars.
    pub index: usize,
}

impl Variable {
    /// The variable behind a value reference in a cradle of `balls` balls.
    #[inline]
    pub fn at(reference: u32, balls: usize) -> Option<Self> {
        let (position, index) = Self::place(reference);
        let row = TABLE.get(position)?;
        (index < row.shape.len(balls)).then_some(Self { row, position, index })
    }

    /// Position of the row and zero-based index in a value reference.
    #[inline]
    pub(super) fn place(reference: u32) -> (usize, usize) {
        ((reference >> INDEX_BITS) as usize, (reference & INDEX_MASK) as usize)
    }

    /// The variable of this name, such as `x[1]` or `ball.mass`, in a cradle of `balls` balls.
    pub fn named(name: &str, balls: usize) -> Option<Self> {
        let index = match name.split(['[', ']']).nth(1) {
            Some(digits) => digits.parse::<usize>().ok()?.checked_sub(1)?,
            None => 0,
        };
        let inner = name.strip_prefix("der(").unwrap_or(name);
        // One that is written differently, such as `x[01]`, is none.
        let is_named = |row: &Row| {
            inner.starts_with(row.rate_of().unwrap_or(row.name))
                && index < row.shape.len(balls)
                && row.name_of(index + 1) == name
        };
        let (position, row) = TABLE.iter().enumerate().find(|(_, row)| is_named(row))?;
        Some(Self { row, position, index })
    }

    /// Value reference, for any number of balls.
    pub fn reference(&self) -> u32 {
        // Both fit: the table is short and n is limited.
        ((self.position as u32) << INDEX_BITS) | self.index as u32
    }
}

/// The name, with the index counted from 1: `x[1]`, `der(overlap[1])`.
impl std::fmt::Display for Variable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.row.name_of(self.index + 1))
    }
}

/// Every variable of a cradle of `balls` balls, in the order of the description.
pub fn variables(balls: usize) -> impl Iterator<Item = Variable> {
    TABLE
        .iter()
        .enumerate()
        .flat_map(move |(position, row)| (0..row.shape.len(balls)).map(move |index| Variable { row, position, index }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_exist_is_not_found() {
        for name in
            ["", "x", "x[0]", "x[6]", "x[01]", "x[+1]", "x[1", "x1]", "F[5]", "gravity[1]", "x[1][1]", "nothing"]
        {
            assert!(Variable::named(name, 5).is_none(), "{name}");
        }
    }
}
