//! The classical Runge-Kutta method of order 4 with steps of fixed length.

use serde::{Deserialize, Serialize};

use super::system::{Path, StepCounters, Stuck, System, resolved};
use crate::solver::double_double::DoubleDouble;

/// A run over a [`System`]. Its steps end at multiples of their length after the start; between their ends the solution
/// is the cubic polynomial with the states and rates there (Hermite's).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RungeKutta {
    start: DoubleDouble,
    /// Length of a step, s.
    step: f64,
    /// The last step.
    pub path: Path,
    /// Rates at the end of the path.
    rates: Vec<f64>,
    /// Room for a state, its rates, and the sum of the rates.
    #[serde(skip)]
    state: Vec<f64>,
    #[serde(skip)]
    stage: Vec<f64>,
    #[serde(skip)]
    sum: Vec<f64>,
    /// What it took so far.
    pub work: StepCounters,
}

impl RungeKutta {
    /// Starts at the state `y` at time `t` with steps of `step` > 0 s.
    pub fn new(step: f64, system: &impl System, t: DoubleDouble, y: &[f64]) -> Self {
        let room = vec![0.0; y.len()];
        let mut rates = room.clone();
        system.rates(t, y, &mut rates);
        Self {
            start: t,
            step,
            path: Path::resting(t, y, 3),
            rates,
            state: room.clone(),
            stage: room.clone(),
            sum: room,
            work: StepCounters { steps: 0, evaluations: 1 },
        }
    }

    /// Takes up again what was put down as plain data; nothing if it is not of these steps (s) and `size` components.
    /// Its values may be anything if it is `broken`.
    pub fn restored(mut self, step: f64, size: usize, broken: bool) -> Option<Self> {
        let end = self.start + DoubleDouble::product(self.work.steps as f64, step);
        let finite = self.rates.iter().all(|rate| rate.is_finite());
        let sound = self.path.is_sound(size, 3, broken)
            && self.rates.len() == size
            && (broken || (self.step == step && self.start.is_sound() && self.path.end == end && finite));
        (self.state, self.stage, self.sum) = (vec![0.0; size], vec![0.0; size], vec![0.0; size]);
        sound.then_some(self)
    }

    /// Makes a step.
    ///
    /// # Errors
    /// [`Stuck`] if a step is shorter than the clock resolves.
    pub fn step(&mut self, system: &impl System) -> Result<(), Stuck> {
        let h = self.step;
        let from = self.path.end;
        let to = self.start + DoubleDouble::product((self.work.steps + 1) as f64, h);
        if !resolved(from, h) {
            return Err(Stuck { step: h });
        }
        self.sum.copy_from_slice(&self.rates);
        self.stage.copy_from_slice(&self.rates);
        for (share, weight) in [(0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
            let y = self.path.last().iter().zip(&self.stage);
            self.state.iter_mut().zip(y).for_each(|(state, (y, rate))| *state = y + share * h * rate);
            system.rates(from + share * h, &self.state, &mut self.stage);
            self.sum.iter_mut().zip(&self.stage).for_each(|(sum, rate)| *sum += weight * rate);
        }
        let y = self.path.last().iter().zip(&self.sum);
        self.state.iter_mut().zip(y).for_each(|(state, (y, sum))| *state = y + h / 6.0 * sum);
        system.rates(to, &self.state, &mut self.stage);
        self.join(to);
        self.work.steps = self.work.steps.saturating_add(1);
        self.work.evaluations = self.work.evaluations.saturating_add(4);
        Ok(())
    }

    /// The cubic from the last state and rates to `state` and the rates in `stage`.
    fn join(&mut self, to: DoubleDouble) {
        let h = self.step;
        for i in 0..self.state.len() {
            let (y0, y1, r0, r1) = (self.path.last()[i], self.state[i], h * self.rates[i], h * self.stage[i]);
            let (a, b) = (y0 - y1 + r1, r0 - r1);
            for (j, c) in [y1, r1, 3.0 * a + b, 2.0 * a + b].into_iter().enumerate() {
                self.path.column_mut(j)[i] = c;
            }
        }
        (self.path.end, self.path.step, self.path.degree) = (to, h, 3);
        std::mem::swap(&mut self.rates, &mut self.stage);
    }
}
