//! The linear oscillator `x'' + 2 gamma x' + omega^2 x = f(t)` in closed form, `f` a polynomial. "Flight" in
//! docs/theory.md defines the functions `U_k` from which everything here is built.

use serde::{Deserialize, Serialize};

use crate::solver::double_double::DoubleDouble;
use crate::solver::hypotenuse;
use crate::solver::series::INVERSES;

/// Highest derivative of the force that is taken into account.
pub const MAX_FORCE_ORDER: usize = 3;

/// Number of functions `U_0, U_1, ...` that the motion, its integrals and the work of the force need.
pub const BASIS: usize = 2 * MAX_FORCE_ORDER + 4;

/// Natural frequency and decay rate of an oscillator; derived values are not serialized.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(into = "(f64, f64)", from = "(f64, f64)")]
pub struct Oscillator {
    omega2: f64,
    omega: DoubleDouble,
    gamma: f64,
    /// Frequency of the damped oscillation, rad/s; 0 from critical damping on.
    omega_damped: DoubleDouble,
    /// 1 over `omega_damped` (s) and over `omega2` (s2), for `gamma < omega`.
    inverse: (f64, f64),
}

impl From<Oscillator> for (f64, f64) {
    fn from(oscillator: Oscillator) -> Self {
        (oscillator.omega2, oscillator.gamma)
    }
}

impl From<(f64, f64)> for Oscillator {
    fn from((omega2, gamma): (f64, f64)) -> Self {
        Self::new(omega2, gamma)
    }
}

/// Doublings from 1 to the largest double: enough even for an infinite time.
const MOST_DOUBLINGS: f64 = f64::MAX_EXP as f64;

impl Oscillator {
    /// `omega2` >= 0 in 1/s2, `gamma` >= 0 in 1/s; both may be 0 (a free body).
    pub fn new(omega2: f64, gamma: f64) -> Self {
        let omega = DoubleDouble::from(omega2).sqrt();
        let omega_damped = match gamma {
            0.0 => omega,
            _ if gamma < omega.value() => (DoubleDouble::from(omega2) - DoubleDouble::product(gamma, gamma)).sqrt(),
            _ => DoubleDouble::default(),
        };
        let inverse = (1.0 / omega_damped.value(), 1.0 / omega2);
        Self { omega2, omega, gamma, omega_damped, inverse }
    }

    /// Square of the natural frequency, 1/s2.
    pub fn omega2(&self) -> f64 {
        self.omega2
    }

    /// Natural frequency, rad/s.
    pub fn omega(&self) -> f64 {
        self.omega.value()
    }

    /// Decay rate of the amplitude, 1/s.
    pub fn gamma(&self) -> f64 {
        self.gamma
    }

    /// Upper bound of the rates at which the motion and its derivatives change, 1/s.
    pub fn pace(&self) -> f64 {
        self.omega() + 2.0 * self.gamma
    }

    /// The first `COUNT` functions `U_k` at `tau` >= 0 (s), 3 to [`BASIS`] of them.
    #[inline]
    pub fn basis<const COUNT: usize>(&self, tau: DoubleDouble) -> [f64; COUNT] {
        let t = tau.value();
        let reach = (self.omega.value() + 2.0 * self.gamma) * t;
        if reach <= 0.5 {
            self.basis_by_series(t)
        } else if self.gamma <= 0.5 * self.omega.value() {
            self.basis_by_waves(tau)
        } else if self.is_overdamped() {
            self.basis_by_decays(t)
        } else {
            self.basis_by_doubling(t, reach)
        }
    }

    /// `U_-3` to `U_2` at `tau` >= 0 (s), where `U_(k-1) = U_k'`.
    pub fn derivatives(&self, tau: DoubleDouble) -> [f64; 6] {
        let t = tau.value();
        let mut u = [0.0; 6];
        if self.is_overdamped() && self.pace() * t > 0.5 {
            // Once the fast decay is over, the recursion by the equation would cancel.
            let (fast, slow) = self.decay_rates();
            let [of_fast, of_slow] =
                [fast, slow].map(|rate| decay_integrals(rate, t, 2).map(|integral| integral / (fast - slow)));
            u[5] = of_slow[1] - of_fast[1];
            let (mut of_fast, mut of_slow) = (of_fast[0], of_slow[0]);
            for u in u[..5].iter_mut().rev() {
                *u = of_slow - of_fast;
                (of_fast, of_slow) = (-fast * of_fast, -slow * of_slow);
            }
            return u;
        }
        u[3..].copy_from_slice(&self.basis::<3>(tau));
        for k in (0..3).rev() {
            u[k] = -2.0 * self.gamma * u[k + 1] - self.omega2 * u[k + 2];
        }
        u
    }

    /// Power series for the two highest functions, the recursion downwards for the others.
    fn basis_by_series<const COUNT: usize>(&self, t: f64) -> [f64; COUNT] {
        let mut u = [0.0; COUNT];
        let (damping, stiffness) = (2.0 * self.gamma * t, self.omega2 * t * t);
        let mut powers = [1.0; COUNT];
        for k in 1..COUNT {
            powers[k] = powers[k - 1] * t * INVERSES[k];
        }
        let (top, below) = (COUNT - 1, COUNT - 2);
        let (mut falling_top, mut falling_below) = (1.0, 1.0);
        let (mut sum_top, mut sum_below) = (1.0, 1.0);
        // Terms a_m t^k / (k+m)! with a_0 = 1, a_1 = -2 gamma t, a_(m+2) = -2 gamma t a_(m+1) - omega^2 t^2 a_m.
        let (mut a, mut a_next) = (1.0_f64, -damping);
        let mut m = 0;
        while m < 40 && (a_next.abs() + stiffness * a.abs()) * falling_below >= 1e-18 {
            let terms = if self.gamma == 0.0 {
                a *= -stiffness; // Every other term is zero.
                2
            } else {
                (a, a_next) = (a_next, -damping * a_next - stiffness * a);
                1
            };
            for _ in 0..terms {
                m += 1;
                falling_top *= INVERSES[top + m];
                falling_below *= INVERSES[below + m];
            }
            sum_top += a * falling_top;
            sum_below += a * falling_below;
        }
        u[top] = powers[top] * sum_top;
        u[below] = powers[below] * sum_below;
        for k in (0..below).rev() {
            u[k] = powers[k] - 2.0 * self.gamma * u[k + 1] - self.omega2 * u[k + 2];
        }
        u
    }

    /// Sine and cosine of the phase, reduced in double-double; the recursion upwards for the others.
    fn basis_by_waves<const COUNT: usize>(&self, tau: DoubleDouble) -> [f64; COUNT] {
        let mut u = [0.0; COUNT];
        let (sine, cosine) = sin_cos(self.omega_damped * tau);
        let t = tau.value();
        let envelope = if self.gamma == 0.0 { 1.0 } else { libm::exp(-self.gamma * t) };
        u[1] = envelope * sine * self.inverse.0;
        u[0] = envelope * cosine - self.gamma * u[1];
        let mut power = 1.0;
        for k in 2..COUNT {
            u[k] = (power - u[k - 2] - 2.0 * self.gamma * u[k - 1]) * self.inverse.1;
            power *= t * INVERSES[k - 1];
        }
        u
    }

    /// Frequency of the damped oscillation (rad/s), for `gamma < omega`, with sine and cosine of its phase at `t` (s).
    pub(super) fn phase(&self, t: f64) -> (f64, f64, f64) {
        let (sine, cosine) = sin_cos(self.omega_damped * DoubleDouble::from(t));
        (self.omega_damped.value(), sine, cosine)
    }

    /// Whether the motion is a sum of two decays whose rates differ at least by a factor of 4; false without damping.
    pub(super) fn is_overdamped(&self) -> bool {
        self.gamma > 0.0 && self.gamma >= 1.25 * self.omega.value()
    }

    /// Reciprocal of the natural frequency, or of the slow rate where the motion is a sum of two decays, s; infinite
    /// for a free body.
    pub fn time_scale(&self) -> f64 {
        match self.omega.value() {
            0.0 => f64::INFINITY,
            _ if self.is_overdamped() => 1.0 / self.decay_rates().1,
            omega => 1.0 / omega,
        }
    }

    /// The rate at which a velocity decays right after the start, 1/s: the fast one of two decays.
    pub fn fast_decay(&self) -> f64 {
        if self.is_overdamped() { self.decay_rates().0 } else { self.gamma }
    }

    /// Rates of the two decays of an overdamped oscillator, fast and slow, 1/s.
    pub(super) fn decay_rates(&self) -> (f64, f64) {
        let ratio = self.omega.value() / self.gamma;
        let fast = self.gamma * (1.0 + (1.0 - ratio * ratio).sqrt());
        (fast, self.omega2 / fast)
    }

    /// Rates (1/s) and velocities at time 0 (m/s) of the two decays, fast and slow, of an overdamped oscillator, from
    /// its velocity `v` (m/s) and its acceleration without damping, `force` (m/s2), at time 0.
    pub(super) fn decays(&self, v: f64, force: f64) -> Option<[[f64; 2]; 2]> {
        let (fast, slow) = self.is_overdamped().then(|| self.decay_rates())?;
        Some([[fast, (fast * v - force) / (fast - slow)], [slow, (force - slow * v) / (fast - slow)]])
    }

    /// `U_k` as differences of the repeated integrals of two exponentials.
    fn basis_by_decays<const COUNT: usize>(&self, t: f64) -> [f64; COUNT] {
        let (fast, slow) = self.decay_rates();
        let (of_fast, of_slow) = (decay_integrals(fast, t, COUNT), decay_integrals(slow, t, COUNT));
        let mut u = [0.0; COUNT];
        u[0] = (fast * of_fast[0] - slow * of_slow[0]) / (fast - slow);
        for k in 1..COUNT {
            u[k] = (of_slow[k - 1] - of_fast[k - 1]) / (fast - slow);
        }
        u
    }

    /// Bound of the absolute derivative of order `k` >= 2 of the position from the time `t` on, under a constant force,
    /// for the velocity `v` and the acceleration `a` at time 0.
    ///
    /// The velocity follows the equation without force: a decaying wave, a sum of two decays, or near critical damping
    /// a decay times at most `|v| + |a + gamma v| t`.
    pub fn derivative_bound(&self, v: f64, a: f64, t: f64, k: i32) -> f64 {
        let (omega, gamma) = (self.omega.value(), self.gamma);
        if gamma == 0.0 {
            let swing = hypotenuse(a * a + self.omega2 * v * v, a, omega * v);
            return (2..k).fold(swing, |bound, _| bound * omega);
        }
        let turned = a + gamma * v;
        if let Some(decays) = self.decays(v, a + 2.0 * gamma * v) {
            decays.into_iter().map(|[rate, v]| v.abs() * libm::exp(-rate * t) * power(rate, k - 1)).sum()
        } else if gamma <= 0.8 * omega {
            let sine = turned / self.omega_damped.value();
            hypotenuse(v * v + sine * sine, v, sine) * libm::exp(-gamma * t) * power(omega, k - 1)
        } else {
            // Beyond critical damping the slower decay outlasts the other.
            let rate = gamma - (gamma * gamma - omega * omega).max(0.0).sqrt();
            (v.abs() + turned.abs() * (t.max(1.0 / rate) + 1.0 / omega))
                * libm::exp(-rate * t)
                * power(2.0 * omega, k - 1)
        }
    }

    /// By the series at a fraction of the time, then by doubling: the flow composed with itself. For near critical
    /// damping, where the other forms would cancel.
    fn basis_by_doubling<const COUNT: usize>(&self, t: f64, reach: f64) -> [f64; COUNT] {
        let doublings = libm::ceil(libm::log2(reach / 0.5)).clamp(1.0, MOST_DOUBLINGS) as i32;
        let mut h = t * libm::exp2(-doublings as f64);
        let mut u = self.basis_by_series(h);
        for _ in 0..doublings {
            let mut powers = [1.0; COUNT];
            for k in 1..COUNT {
                powers[k] = powers[k - 1] * h * INVERSES[k];
            }
            let mut twice = [0.0; COUNT];
            twice[0] = u[0] * u[0] - self.omega2 * u[1] * u[1];
            for k in 1..COUNT {
                // After h the response to tau^(k-2)/(k-2)! is U_k, its velocity U_(k-1); then the shifted force acts.
                let forced: f64 = (2..=k).map(|j| powers[k - j] * u[j]).sum();
                twice[k] = u[k] + u[k - 1] * u[1] + forced - self.omega2 * u[k] * u[2];
            }
            u = twice;
            h *= 2.0;
        }
        u
    }
}

/// Sine and cosine of a double-double angle (rad): the phase of a pendulum after an hour is 1e4 rad.
fn sin_cos(angle: DoubleDouble) -> (f64, f64) {
    let (sine, cosine) = libm::sincos(angle.value());
    (sine + angle.rest() * cosine, cosine - angle.rest() * sine)
}

/// `rate^k`.
pub(super) fn power(rate: f64, k: i32) -> f64 {
    (0..k).fold(1.0, |power, _| power * rate)
}

/// The first `count` of `exp(-rate t)` and its repeated integrals from 0; the others are 0.
pub(super) fn decay_integrals(rate: f64, t: f64, count: usize) -> [f64; BASIS] {
    let mut h = [0.0; BASIS];
    let reach = rate * t;
    if reach > 1.0 {
        h[0] = libm::exp(-reach);
        let mut power = 1.0;
        for k in 1..count {
            h[k] = (power - h[k - 1]) / rate;
            power *= t * INVERSES[k];
        }
    } else {
        let mut power = 1.0;
        for (k, h) in h[..count].iter_mut().enumerate() {
            let (mut term, mut sum) = (1.0, 1.0);
            for m in 1..25 {
                term *= -reach * INVERSES[k + m];
                sum += term;
                if term.abs() < 1e-18 {
                    break;
                }
            }
            *h = power * sum;
            power *= t * INVERSES[k + 1];
        }
    }
    h
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oscillator_recursion_holds_in_every_regime() {
        for t in [1e-9, 1e-3, 0.2, 0.7, 1.9, 13.0] {
            let regimes = [(5.0, 0.0), (5.0, 0.3), (5.0, 2.3), (5.0, 40.0), (0.0, 0.0), (0.0, 0.5), (0.0, 30.0)];
            for (omega2, gamma) in regimes {
                let u = Oscillator::new(omega2, gamma).basis::<BASIS>(t.into());
                let mut power = 1.0_f64;
                for k in 0..BASIS - 2 {
                    let off = u[k] + 2.0 * gamma * u[k + 1] + omega2 * u[k + 2] - power;
                    assert!(off.abs() <= 1e-14 * power.max(1.0), "omega2={omega2} gamma={gamma} t={t} k={k}: {off}");
                    power *= t / (k + 1) as f64;
                }
            }
        }
    }
}
