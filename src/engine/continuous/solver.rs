//! A solver of ordinary differential equations with its history.

use serde::{Deserialize, Serialize};

use super::corrector::MAX_ORDER;
use super::dynamics::Dynamics;
use super::path::Path;
use crate::engine::EngineError;
use crate::model::WorkCounters;
use crate::solver::DoubleDouble;

pub(super) const LONGEST: f64 = 1e3;
/// Largest ratio of the second step to the first one, which is a guess.
const FIRST_GROWTH: f64 = 1e4;

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Method {
    /// Adams-Moulton of orders 1 to 12, solved by fixed-point iteration: for motions that are not stiff.
    Adams,
    /// Backward differentiation of orders 1 to 5, solved by Newton's method: for stiff motions.
    Bdf,
    /// The classical Runge-Kutta formula with steps of this length, s.
    RungeKutta(f64),
}

impl Method {
    /// Highest degree of the polynomials over a step, in multistep methods their highest order.
    pub(super) fn max_degree(self) -> usize {
        match self {
            Self::Adams => MAX_ORDER,
            Self::Bdf => 5,
            Self::RungeKutta(_) => 3,
        }
    }

    /// Degree of the allocated polynomials: a multistep method also tries the order above.
    fn room(self) -> usize {
        self.max_degree() + usize::from(!matches!(self, Self::RungeKutta(_)))
    }
}

/// Whether double-doubles resolve steps of `step` (s) at the time `t`.
pub(super) fn resolved(t: DoubleDouble, step: f64) -> bool {
    step > 1e-32 * t.value().abs().max(1.0)
}

/// A run of one of the methods.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Solver {
    pub method: Method,
    pub path: Path,
    /// Where a step is tried.
    #[serde(skip)]
    pub(super) trial: Path,
    /// Lengths of the last steps, s, the latest first.
    pub(super) steps: [f64; MAX_ORDER + 1],
    /// Order of the next step and its length, s.
    pub(super) order: usize,
    pub(super) step: f64,
    /// Steps until another order is considered.
    pub(super) wait: usize,
    /// Largest growth of the next step.
    pub(super) growth: f64,
    /// Correction `e` of the last step, and that of the one before with its spread, if stored.
    pub(super) correction: Vec<f64>,
    pub(super) kept: Vec<f64>,
    pub(super) kept_spread: Option<f64>,
    /// Working memory for states and rates.
    #[serde(skip)]
    pub(super) state: Vec<f64>,
    #[serde(skip)]
    pub(super) rates: Vec<f64>,
    pub work: WorkCounters,
}

impl Solver {
    /// Starts at the state `y` at time `t`, after this `work`. Unless the method has a fixed step, the first step is
    /// one of order 1 that changes the state by no more than the allowed error.
    pub fn new(method: Method, dynamics: &Dynamics, t: DoubleDouble, y: &[f64], work: WorkCounters) -> Self {
        let path = Path::resting(t, y, method.room());
        let mut solver = Self {
            method,
            trial: path.clone(),
            path,
            steps: [0.0; MAX_ORDER + 1],
            order: 1,
            step: 0.0,
            wait: 2,
            growth: FIRST_GROWTH,
            correction: vec![0.0; y.len()],
            kept: vec![0.0; y.len()],
            kept_spread: None,
            state: y.to_vec(),
            rates: vec![0.0; y.len()],
            work,
        };
        solver.evaluate(dynamics, t);
        let pace = dynamics.size(&solver.state, &solver.rates);
        solver.step = match method {
            Method::RungeKutta(step) => step,
            Method::Adams | Method::Bdf if pace > 0.0 => (1.0 / pace).min(LONGEST),
            Method::Adams | Method::Bdf => 1.0,
        };
        (solver.path.step, solver.path.degree) = (solver.step, 1);
        solver.set_slope(solver.step);
        solver
    }

    /// Restores it from plain data; `None` if it does not fit this method and `size` components. Any values pass if it
    /// is `broken`.
    pub fn restored(mut self, method: Method, size: usize, broken: bool) -> Option<Self> {
        let lengths = self.steps.iter().all(|step| *step >= 0.0 && step.is_finite());
        let next = self.step > 0.0 && self.growth >= 1.0 && self.step.max(self.growth).is_finite();
        let kept = self.correction.iter().chain(&self.kept).chain(&self.kept_spread).all(|value| value.is_finite());
        let sound = self.method == method
            && self.path.is_sound(size, method.room(), broken)
            && [self.correction.len(), self.kept.len()] == [size; 2]
            && (1..=method.max_degree()).contains(&self.order)
            && (1..=method.max_degree()).contains(&self.path.degree)
            && (1..=MAX_ORDER + 2).contains(&self.wait)
            && (broken || (self.path.step > 0.0 && lengths && next && kept));
        self.trial = self.path.clone();
        self.state = vec![0.0; size];
        self.rates = vec![0.0; size];
        sound.then_some(self)
    }

    /// Makes a step; fails if it would have to be shorter than double-doubles resolve.
    pub fn step(&mut self, dynamics: &Dynamics) -> Result<(), EngineError> {
        let made = match self.method {
            Method::RungeKutta(step) => self.runge_kutta(dynamics, step),
            Method::Adams | Method::Bdf => self.multistep(dynamics),
        };
        self.work.steps = self.work.steps.saturating_add(u64::from(made.is_ok()));
        made
    }

    pub(super) fn evaluate(&mut self, dynamics: &Dynamics, t: DoubleDouble) {
        dynamics.rates(t, &self.state, &mut self.rates);
        self.work.evaluations = self.work.evaluations.saturating_add(1);
    }

    /// Sets the slope of the path at its end from the last rates, for steps of this length (s).
    pub(super) fn set_slope(&mut self, step: f64) {
        self.path.column_mut(1).iter_mut().zip(&self.rates).for_each(|(c, rate)| *c = step * rate);
    }

    /// Makes a step of the classical method of order 4, of length `h` (s). Within it the solution is the cubic
    /// polynomial with the states and rates at both ends (Hermite's).
    fn runge_kutta(&mut self, dynamics: &Dynamics, h: f64) -> Result<(), EngineError> {
        let (from, to) = (self.path.end, self.path.end + h);
        if !resolved(from, h) {
            return Err(EngineError::StepTooSmall { time: from.value(), step: h });
        }
        // Rates times the step: those at the last stage, and the sum of all.
        self.kept.copy_from_slice(self.path.column(1));
        self.correction.copy_from_slice(self.path.column(1));
        for (share, weight) in [(0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
            let y = self.path.last().iter().zip(&self.kept);
            self.state.iter_mut().zip(y).for_each(|(state, (y, k))| *state = y + share * k);
            self.evaluate(dynamics, from + share * h);
            self.kept.iter_mut().zip(&self.rates).for_each(|(k, rate)| *k = h * rate);
            self.correction.iter_mut().zip(&self.kept).for_each(|(sum, k)| *sum += weight * k);
        }
        let y = self.path.last().iter().zip(&self.correction);
        self.state.iter_mut().zip(y).for_each(|(state, (y, sum))| *state = y + sum / 6.0);
        self.evaluate(dynamics, to);
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
