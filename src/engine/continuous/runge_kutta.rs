//! The classical Runge-Kutta formula.

use super::trajectory::{Trajectory, resolved};
use crate::engine::EngineError;

impl Trajectory {
    /// Makes a step of the classical method of order 4. Within it the solution is the cubic polynomial with the states
    /// and rates at both ends (Hermite's).
    pub(super) fn runge_kutta(&mut self) -> Result<(), EngineError> {
        let h = self.fixed_step;
        let (from, to) = (self.path.end, self.path.end + h);
        if !resolved(from, h) {
            return Err(EngineError::StepTooSmall { time: from.value(), step: h });
        }
        // Rates times the step: at the last stage, and the weighted sum over all stages.
        self.kept.copy_from_slice(self.path.column(1));
        self.correction.copy_from_slice(self.path.column(1));
        for (share, weight) in [(0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
            let y = self.path.last().iter().zip(&self.kept);
            self.state.iter_mut().zip(y).for_each(|(state, (y, k))| *state = y + share * k);
            self.evaluate(from + share * h);
            self.kept.iter_mut().zip(&self.rates).for_each(|(k, rate)| *k = h * rate);
            self.correction.iter_mut().zip(&self.kept).for_each(|(sum, k)| *sum += weight * k);
        }
        let y = self.path.last().iter().zip(&self.correction);
        self.state.iter_mut().zip(y).for_each(|(state, (y, sum))| *state = y + sum / 6.0);
        self.evaluate(to);
        for i in 0..self.state.len() {
            let (y0, y1, r0, r1) = (self.path.last()[i], self.state[i], self.path.column(1)[i], h * self.rates[i]);
            let (a, b) = (y0 - y1 + r1, r0 - r1);
            for (j, c) in [y1, r1, 3.0 * a + b, 2.0 * a + b].into_iter().enumerate() {
                self.path.column_mut(j)[i] = c;
            }
        }
        (self.path.end, self.path.degree) = (to, 3);
        Ok(())
    }
}
