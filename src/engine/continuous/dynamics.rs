//! The chain as one system of ordinary differential equations.

use serde::{Deserialize, Serialize};

use super::path::NordsieckStep;
use crate::engine::flight::{Forcing, forcing_at, shifted};
use crate::engine::{EngineError, HeldInputs};
use crate::model::{BallModel, ContactLaw, Cradle};
use crate::solver::{DoubleDouble, crossing, series};

/// Velocities down to this part of the largest are computed to the tolerance, or resting balls would creep apart.
const VELOCITY_SCALE: f64 = 1e-4;
/// Positions, overlaps (m) and velocities (m/s) stay below this, or energies overflow.
const LARGEST: f64 = 1e150;
/// Overlaps above this many overlaps of an impact are computed to the tolerance; below, the velocities decide.
const OVERLAP_SCALE: f64 = 100.0;

/// The right-hand side for a cradle of n balls. The state is
///
/// - n positions (m), n velocities (m/s) and the n-1 overlaps (m), negative while apart,
/// - the impulses of the n-1 contacts (N.s),
/// - the energy dissipated (J), the work of the inputs (J) and the integral of the force on the support (N.s).
///
/// Overlaps are unknowns because differences of positions do not resolve them. The rates do not depend on the last two
/// lines.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Dynamics {
    #[serde(skip)]
    pub cradle: Cradle,
    /// Accelerations of the balls by the inputs, expanded about `since`.
    #[serde(skip)]
    pub forcings: Vec<Forcing>,
    pub since: DoubleDouble,
    /// Relative tolerance.
    pub tolerance: f64,
    /// Scales of the tolerances: of positions (m), velocities (m/s) and overlaps (m).
    scales: [f64; 3],
    /// Scale of the energy dissipated, J.
    energy_scale: f64,
}

/// Accelerations of the balls by the inputs, expanded about the time `since` (s).
pub(super) fn forcings(cradle: &Cradle, inputs: &HeldInputs, since: f64) -> Vec<Forcing> {
    inputs.forcings(cradle).iter().map(|forcing| shifted(forcing, since - inputs.since)).collect()
}

impl Dynamics {
    /// The dynamics from the state `y` at `since` (s) on. The error allowed is `tolerance` times the larger of a
    /// component and its scale: for positions the distance at the [speed in reach](Cradle::speed_in_reach) within one
    /// unit of time of a pendulum, for velocities [`VELOCITY_SCALE`] times that speed, for overlaps [`OVERLAP_SCALE`]
    /// times the overlap of an impact at that speed.
    pub fn new(cradle: Cradle, inputs: &HeldInputs, since: f64, y: &[f64], tolerance: f64) -> Self {
        let (forcings, since) = (forcings(&cradle, inputs, since), since.into());
        let mut dynamics = Self { cradle, forcings, since, tolerance, scales: [1.0; 3], energy_scale: 1.0 };
        let (n, largest) = (dynamics.balls(), |most: f64, forcing: &f64| most.max(forcing.abs()));
        let motion = [&y[..n], &y[n..2 * n], &y[2 * n..3 * n - 1]];
        let fastest = dynamics.cradle.speed_in_reach(motion, |i| dynamics.forcings[i].iter().fold(0.0, largest));
        if fastest > 0.0 {
            let lightest = dynamics.cradle.balls.iter().fold(f64::INFINITY, |mass, ball| mass.min(ball.mass));
            // Squares leave the range of doubles before the motion does.
            let [least, most] = [f64::MIN_POSITIVE, f64::MAX];
            dynamics.energy_scale = (0.5 * lightest * fastest * fastest).clamp(least, most);
            let way =
                dynamics.cradle.balls.iter().map(|ball| fastest * ball.unit_of_time()).fold(f64::INFINITY, f64::min);
            let contacts = dynamics.cradle.contacts.iter().enumerate();
            let overlaps = contacts.map(|(j, law)| law.largest_overlap(dynamics.cradle.reduced_mass(j), fastest));
            let scales = [way, VELOCITY_SCALE * fastest, OVERLAP_SCALE * overlaps.fold(way, f64::min)];
            dynamics.scales = scales.map(|scale| scale.clamp(least, most));
        }
        dynamics
    }

    pub fn is_sound(&self) -> bool {
        let positive = |value: &f64| *value > 0.0 && value.is_finite();
        self.since.is_sound() && self.scales.iter().chain([&self.tolerance, &self.energy_scale]).all(positive)
    }

    /// The state with these positions (m) and velocities (m/s), and with sums of 0.
    pub fn start(cradle: &Cradle, x: &[f64], v: &[f64]) -> Vec<f64> {
        let overlap = |(law, x): (&ContactLaw, &[f64])| x[0] - x[1] - law.clearance;
        let mut y = [x, v].concat();
        y.extend(cradle.contacts.iter().zip(x.windows(2)).map(overlap));
        y.resize(4 * x.len() + 1, 0.0);
        y
    }

    pub fn balls(&self) -> usize {
        self.cradle.balls.len()
    }

    pub fn v(&self, i: usize) -> usize {
        self.balls() + i
    }

    pub fn overlap(&self, i: usize) -> usize {
        2 * self.balls() + i
    }

    pub fn impulse(&self, i: usize) -> usize {
        3 * self.balls() - 1 + i
    }

    /// Places of the energy dissipated, the work of the inputs and the integral of the force on the support.
    pub fn sums(&self) -> [usize; 3] {
        [2, 1, 0].map(|before| 4 * self.balls() - before)
    }

    /// The first component of `y` (a state, its rates, or the beginning of either) with which no run can go on: it is
    /// NaN, infinite or, for positions, velocities and overlaps, beyond [`LARGEST`].
    pub fn beyond_range(&self, y: &[f64]) -> Option<usize> {
        let (dynamic, sums) = y.split_at(self.impulse(0).min(y.len()));
        let of_sums = || sums.iter().position(|y| !y.is_finite()).map(|sum| dynamic.len() + sum);
        dynamic.iter().position(|y| y.is_nan() || y.abs() > LARGEST).or_else(of_sums)
    }

    /// The error where this component of the state has left the range of doubles.
    pub fn lost(&self, component: usize, time: DoubleDouble) -> EngineError {
        let (time, n) = (time.value(), self.balls());
        match component {
            i if i < 2 * n => EngineError::NotFinite { time, ball: i % n },
            i if i < self.sums()[0] => EngineError::ContactNotFinite { time, contact: (i - 2 * n) % (n - 1) },
            _ => EngineError::EnergyNotFinite { time },
        }
    }

    /// Acceleration of ball `i` by the inputs, m/s2.
    pub fn forcing(&self, i: usize, t: DoubleDouble) -> f64 {
        forcing_at(&self.forcings[i], (t - self.since).value())
    }

    /// The overlap of contact `i` on a step as a series in the elapsed part of the step.
    pub fn overlap_series(&self, path: &NordsieckStep, i: usize) -> Vec<f64> {
        let mut series: Vec<f64> = (0..=path.degree).map(|j| path.column(j)[self.overlap(i)]).collect();
        series.resize(series.len().max(3), 0.0);
        // Moves the origin from the end of the step to its start.
        for k in 1..=path.degree {
            for j in (k..=path.degree).rev() {
                series[j - 1] -= series[j];
            }
        }
        series
    }

    /// Whether contact `i`, open or closed at both ends of the step, might switch in between, by a quick bound.
    fn might_switch(&self, path: &NordsieckStep, i: usize) -> bool {
        let end = path.last()[self.overlap(i)];
        let sign = if end > 0.0 { -1.0 } else { 1.0 };
        let mut bound = sign * end;
        for j in 1..=path.degree {
            let term = sign * path.column(j)[self.overlap(i)];
            bound += if j.is_multiple_of(2) { term } else { -term }.max(0.0);
        }
        bound > 0.0
    }

    /// Writes the rates of the state `y`.
    pub fn rates(&self, t: DoubleDouble, y: &[f64], rates: &mut [f64]) {
        let n = self.balls();
        let (mut loss, mut work, mut support, mut from_left) = (0.0, 0.0, 0.0, 0.0);
        for (i, ball) in self.cradle.balls.iter().enumerate() {
            let (x, v, forcing) = (y[i], y[n + i], self.forcing(i, t));
            let mut from_right = 0.0;
            if let Some(law) = self.cradle.contacts.get(i) {
                let (overlap, rate) = (y[2 * n + i], v - y[n + i + 1]);
                if overlap > 0.0 {
                    from_right = law.force(overlap, rate);
                    loss += (from_right - law.elastic_force(overlap)) * rate;
                }
                rates[2 * n + i] = rate;
                rates[3 * n - 1 + i] = from_right;
            }
            rates[i] = v;
            rates[n + i] = ball.acceleration(x, v, from_left - from_right, forcing);
            loss += 2.0 * ball.gamma * ball.mass * v * v;
            work += ball.mass * forcing * v;
            support += ball.support_force(x, v);
            from_left = from_right;
        }
        rates[4 * n - 2..].copy_from_slice(&[loss, work, support]);
    }

    /// The change `e` of the state `y` over the allowed error, for the components that the rates depend on.
    pub fn size(&self, y: &[f64], e: &[f64]) -> f64 {
        let n = self.balls();
        let mut most = 0.0;
        for (range, scale) in [0..n, n..2 * n, 2 * n..3 * n - 1].into_iter().zip(self.scales) {
            for (y, e) in y[range.clone()].iter().zip(&e[range]) {
                let size = e.abs() / scale.max(y.abs());
                if !size.is_finite() || y.abs() > LARGEST {
                    return f64::INFINITY;
                }
                most = size.max(most);
            }
        }
        most / self.tolerance
    }

    /// The error `e` of the state `y` over the allowed one. Includes the energy dissipated: a clipped contact loses the
    /// energy of its spring without any effect on the balls.
    pub fn error(&self, y: &[f64], e: &[f64]) -> f64 {
        let [loss, ..] = self.sums();
        let loss = e[loss].abs() / (self.tolerance * self.energy_scale.max(y[loss].abs()));
        if loss.is_finite() { loss.max(self.size(y, e)) } else { f64::INFINITY }
    }

    /// For Newton's method with the Jacobian J of the rates at `y`: a function that replaces `e` by the solution of
    /// `(1 - gamma J) solution = e`, except in components that the rates do not depend on.
    ///
    /// Positions and overlaps are eliminated by `e_x = r_x + gamma e_v` and the like. The matrix for the velocities is
    /// then `M + gamma C + gamma^2 K` with the masses, dampings and stiffnesses, symmetric, positive definite and
    /// tridiagonal. Its factors `L D L'` need no pivoting (Golub and Van Loan, Matrix Computations, section 4.3.6).
    pub fn newton(&self, y: &[f64], gamma: f64) -> impl FnMut(&mut [f64]) + use<> {
        let (n, balls) = (self.balls(), self.cradle.balls.clone());
        let ball = |ball: &BallModel| ball.mass * (1.0 + gamma * (2.0 * ball.gamma + gamma * ball.omega2));
        let mut diagonal: Vec<f64> = balls.iter().map(ball).collect();
        let mut beside = vec![0.0; n.saturating_sub(1)];
        let mut stiffness = beside.clone();
        for (i, law) in self.cradle.contacts.iter().enumerate() {
            let (by_overlap, by_rate) = law.force_slopes(y[2 * n + i], y[n + i] - y[n + i + 1]);
            let coupling = gamma * (by_rate + gamma * by_overlap);
            diagonal[i] += coupling;
            diagonal[i + 1] += coupling;
            beside[i] = -coupling;
            stiffness[i] = gamma * by_overlap;
        }
        for i in 0..beside.len() {
            let factor = beside[i] / diagonal[i];
            diagonal[i + 1] -= factor * beside[i];
            beside[i] = factor;
        }
        let mut velocities = vec![0.0; n];
        move |e| {
            let mut from_left = 0.0;
            for (i, ball) in balls.iter().enumerate() {
                let from_right = stiffness.get(i).map_or(0.0, |k| k * e[2 * n + i]);
                velocities[i] = ball.mass * (e[n + i] - gamma * ball.omega2 * e[i]) + from_left - from_right;
                from_left = from_right;
            }
            for (i, factor) in beside.iter().enumerate() {
                velocities[i + 1] -= factor * velocities[i];
            }
            velocities.iter_mut().zip(&diagonal).for_each(|(velocity, d)| *velocity /= d);
            for (i, factor) in beside.iter().enumerate().rev() {
                velocities[i] -= factor * velocities[i + 1];
            }
            for (i, velocity) in velocities.iter().enumerate() {
                e[i] += gamma * velocity;
                e[n + i] = *velocity;
            }
            for (i, pair) in velocities.windows(2).enumerate() {
                e[2 * n + i] += gamma * (pair[0] - pair[1]);
            }
        }
    }

    /// For a step yet to be accepted: the fraction at which a contact switches for a moment that the ends do not show.
    pub fn overlooked(&self, path: &NordsieckStep) -> Option<f64> {
        let shown = |i: usize| {
            if !self.might_switch(path, i) {
                return None;
            }
            let mut series = self.overlap_series(path, i);
            let end = series::value(&series, 1.0);
            if (series[0] > 0.0) != (end > 0.0) {
                return None;
            }
            if end > 0.0 {
                series.iter_mut().for_each(|c| *c = -*c);
            }
            let (place, highest) = crossing::maximum(&series, 0.0, 1.0);
            (highest > self.tolerance * self.scales[2] && place > 0.0 && place < 1.0).then_some(place)
        };
        (0..self.cradle.contacts.len()).filter_map(shown).reduce(f64::min)
    }
}
