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

    /// Rate of its overlap, m/s.
    fn overlap_rate(&self, j: usize) -> S {
        self.velocity(j) - self.velocity(j + 1)
    }

    /// Reduced mass of its balls, kg.
    fn reduced_mass(&self, j: usize) -> f64 {
        let [left, right] = [j, j + 1].map(|i| self.ball(i).mass.value());
        left * right / (left + right)
    }

    /// Whether its force by the law matters: it presses, or only the force tells when it will press again.
    fn needs_force(&self, j: usize) -> bool {
        match self.mode(j) {
            Mode::Open => false,
            Mode::Pressing => true,
            Mode::Clipped => self.law(j).sign_of_force().is_none(),
        }
    }
}
