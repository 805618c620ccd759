//! Adams-Moulton and backward differentiation formulas of variable order and step.
//!
//! The solution is kept as the polynomial over the last step (Nordsieck's array). A step extrapolates it to `P(s)` and
//! adds `e L(s)` with the corrector polynomial `L` of the family, where `e` follows from `y' = f` at the end of the
//! step. `L` accounts for steps of unequal length (Byrne and Hindmarsh, ACM Trans. Math. Software 1, 1975); for the
//! backward differentiation formulas the leading coefficient is that of equal steps (Jackson and Sacks-Davis, ACM
//! Trans. Math. Software 6, 1980). Errors, orders and steps are controlled as in VODE and CVODE (Brown, Byrne and
//! Hindmarsh, SIAM J. Sci. Stat. Comput. 10, 1989; Cohen and Hindmarsh, Computers in Physics 10, 1996).
//!
//! No crate fits: those with both families have one order only, or a dense Jacobian that is too large for 10,000 balls,
//! or take minutes to build; and none can save and restore its history.

use std::cmp::Ordering;

use super::corrector::{MAX_ORDER, MethodCoefficients, adams, bdf, distances, roots};
use super::trajectory::{LONGEST_STEP, Trajectory, max_degree, resolved};
use crate::engine::EngineError;
use crate::model::SolverMethod;

/// Smallest ratio for which the step is changed, and largest growth of a step.
const WORTH_IT: f64 = 1.5;
const GROWTH: f64 = 10.0;
/// Attempts at one step after which the solver gives up, enough from the longest step to the resolution of doubles; and
/// most iterations in an attempt.
const MAX_ATTEMPTS: usize = 200;
const MAX_ITERATIONS: usize = 3;
/// The iteration ends when its error is below this part of the error allowed in a step.
const ITERATION_ERROR: f64 = 0.1;

/// Ratio of the next step to the last one, whose error was `error` times the allowed one, with a margin `bias`.
fn ratio(bias: f64, error: f64, order: usize) -> f64 {
    1.0 / (libm::pow(bias * error, 1.0 / (order + 1) as f64) + 1e-6)
}

impl Trajectory {
    pub(super) fn multistep(&mut self) -> Result<(), EngineError> {
        // Adapts the path from the order of the last step to that of this one.
        match self.order.cmp(&self.path.degree) {
            Ordering::Less => self.lower_order(),
            Ordering::Greater => self.raise_order(),
            Ordering::Equal => {}
        }
        let change = self.step / self.path.step;
        if change.is_nan() {
            // State or rates allow no first step at all.
            let lost = [0, 1].into_iter().find_map(|j| self.dynamics.beyond_range(self.path.column(j)));
            return Err(self.dynamics.lost(lost.unwrap_or(0), self.path.end));
        }
        self.path.rescale(change);
        let mut failures = 0;
        for _ in 0..MAX_ATTEMPTS {
            if !resolved(self.path.end, self.path.step) {
                break;
            }
            let xi = distances(self.path.step, &self.steps, self.path.step);
            let c = if self.method == SolverMethod::Bdf { bdf(self.order, &xi) } else { adams(self.order, &xi) };
            self.trial.copy_from(&self.path);
            self.trial.extrapolate();
            let Some(error) = self.correct(&c) else {
                self.growth = 1.0;
                self.path.rescale(0.25);
                continue;
            };
            if error.is_nan() || error > 1.0 {
                failures += 1;
                self.after_failure(error, failures);
                continue;
            }
            for j in 0..=self.order {
                self.trial.add(j, c.corrector[j], &self.correction);
            }
            if let Some(fraction) = self.dynamics.overlooked(&self.trial) {
                self.growth = 1.0;
                self.path.rescale(fraction);
                continue;
            }
            self.accept(&c, error);
            return Ok(());
        }
        Err(EngineError::StepTooSmall { time: self.path.end.value(), step: self.path.step })
    }

    /// Finds `e` for the trial step. Returns its error over the allowed one; `None` if the iteration does not converge.
    fn correct(&mut self, c: &MethodCoefficients) -> Option<f64> {
        let (t, step, slope) = (self.trial.end, self.trial.step, c.corrector[1]);
        self.correction.fill(0.0);
        self.state.copy_from_slice(self.trial.last());
        let mut newton = (self.method == SolverMethod::Bdf).then(|| self.dynamics.newton(&self.state, step / slope));
        let (mut before, mut convergence) = (0.0, 1.0_f64);
        for iteration in 0..MAX_ITERATIONS {
            self.evaluate(t);
            // Turns the rates into the change of e.
            let predicted = self.trial.column(1).iter().zip(&self.correction);
            for (rate, (predicted, e)) in self.rates.iter_mut().zip(predicted) {
                *rate = (step * *rate - predicted) / slope - e;
            }
            if let Some(newton) = &mut newton {
                newton(&mut self.rates);
            }
            self.correction.iter_mut().zip(&self.rates).for_each(|(e, change)| *e += change);
            let predicted = self.trial.column(0).iter().zip(&self.correction);
            self.state.iter_mut().zip(predicted).for_each(|(y, (predicted, e))| *y = predicted + e);
            let change = self.dynamics.size(&self.state, &self.rates);
            if iteration > 0 {
                convergence = (0.3 * convergence).max(change / before);
            }
            if change * convergence.min(1.0) * c.error <= ITERATION_ERROR {
                if newton.is_some() {
                    self.correct_sums(c);
                }
                return Some(c.error * self.dynamics.error(&self.state, &self.correction));
            }
            if !change.is_finite() || (iteration > 0 && change > 2.0 * before) {
                return None;
            }
            before = change;
        }
        None
    }

    /// Computes the components that the rates do not depend on, from the rates at the end of the step.
    fn correct_sums(&mut self, c: &MethodCoefficients) {
        self.evaluate(self.trial.end);
        for i in self.dynamics.impulse(0)..self.rates.len() {
            self.correction[i] = (self.trial.step * self.rates[i] - self.trial.column(1)[i]) / c.corrector[1];
        }
    }

    /// Shortens the step; from the fourth failure on also lowers the order, and at order 1 restarts.
    fn after_failure(&mut self, error: f64, failures: usize) {
        self.growth = 1.0;
        let shorter = if failures > 3 {
            if self.order > 1 {
                self.lower_order();
            } else {
                self.state.copy_from_slice(self.path.last());
                self.evaluate(self.path.end);
                self.set_slope(self.path.step);
                self.wait = 10;
            }
            0.1
        } else {
            // A NaN becomes the smallest ratio.
            ratio(6.0, error, self.order).max(0.1).min(if failures > 1 { 0.2 } else { 0.9 })
        };
        self.path.rescale(shorter);
    }

    /// Accepts the trial step, and chooses order and length of the next one.
    fn accept(&mut self, c: &MethodCoefficients, error: f64) {
        std::mem::swap(&mut self.path, &mut self.trial);
        self.steps.rotate_right(1);
        self.steps[0] = self.path.step;
        self.wait -= 1;
        let order = self.order;
        let (mut best, mut next) = (ratio(6.0, error, order), order);
        if self.growth == 1.0 {
            // After a failure the step stays as it is.
            self.wait = self.wait.max(2);
            best = 1.0;
        } else if self.wait == 0 {
            self.wait = 2;
            if order > 1 {
                let lower = ratio(6.0, self.dynamics.error(&self.state, self.path.column(order)) * c.lower, order - 1);
                if lower > best {
                    (best, next) = (lower, order - 1);
                }
            }
            if let Some(spread) = self.kept_spread.take() {
                let same = c.spread / spread * libm::pow(self.steps[0] / self.steps[1], (order + 1) as f64);
                self.kept.iter_mut().zip(&self.correction).for_each(|(kept, e)| *kept = e - same * *kept);
                let higher = ratio(10.0, self.dynamics.error(&self.state, &self.kept) * c.higher, order + 1);
                if higher > best {
                    (best, next) = (higher, order + 1);
                }
            }
        }
        if self.wait == 1 && order < max_degree(self.method) {
            self.kept.copy_from_slice(&self.correction);
            self.kept_spread = Some(c.spread);
        }
        if best < WORTH_IT {
            (best, next) = (1.0, order);
        }
        self.order = next;
        self.step = (self.path.step * best.min(self.growth)).min(LONGEST_STEP);
        self.growth = GROWTH;
    }

    /// Distances of the points before the end of the last step, in steps.
    fn points(&self) -> [f64; MAX_ORDER + 1] {
        distances(self.steps[0], &self.steps[1..], self.path.step)
    }

    /// Removes the highest coefficient from the path, which keeps the points of the lower order.
    fn lower_order(&mut self) {
        let order = self.path.degree;
        let through = roots(&self.points()[..order.saturating_sub(2)]);
        let highest = self.path.column(order).to_vec();
        for j in 2..order {
            let factor = if self.method == SolverMethod::Bdf { 1.0 } else { order as f64 / j as f64 };
            self.path.add(j, -factor * through[j - 2], &highest);
        }
        (self.path.degree, self.order) = (order - 1, order - 1);
        self.wait = order;
    }

    fn raise_order(&mut self) {
        let order = self.path.degree;
        (self.path.degree, self.order) = (order + 1, order + 1);
        self.path.column_mut(order + 1).fill(0.0);
        self.wait = order + 2;
        if self.method == SolverMethod::Bdf {
            // The path passes through one more point. (For Adams that would be a rate, which is not stored.)
            let points = &self.points()[..order];
            let off: f64 = points.iter().enumerate().map(|(j, xi)| 1.0 / (j + 1) as f64 - 1.0 / xi).sum();
            let highest = off / points.iter().product::<f64>();
            let through = roots(&points[..order - 1]);
            (2..=order + 1).for_each(|j| self.path.add(j, highest * through[j - 2], &self.correction));
        }
    }
}
