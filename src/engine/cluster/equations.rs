//! What the recurrences of power series need of a chain and its state: a window of a run in doubles, or a whole chain
//! in dual numbers.

use crate::engine::flight::Forcing;
use crate::model::{BallModel, ContactLaw, Mode};
use crate::solver::dual::Scalar;

/// A chain in a state. Contact `j` is that of balls `j` and `j + 1`.
pub(crate) trait Equations<S: Scalar> {
    /// Number of balls.
    fn balls(&self) -> usize;
    /// Mass and pendulum of ball `i`.
    fn ball(&self, i: usize) -> BallModel<S>;
    /// Its position, m.
    fn position(&self, i: usize) -> S;
    /// Its velocity, m/s.
    fn velocity(&self, i: usize) -> S;
    /// Its acceleration by the inputs.
    fn forcing(&self, i: usize) -> &Forcing<S>;
    /// Law of contact `j`.
    fn law(&self, j: usize) -> &ContactLaw<S>;
    /// Its overlap, m.
    fn overlap(&self, j: usize) -> S;
    /// Its mode.
    fn mode(&self, j: usize) -> Mode;
}
