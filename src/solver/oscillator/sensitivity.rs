//! How the motion of the oscillator depends on its frequency and its decay rate.

use super::closed_form::{BASIS, MAX_FORCE_ORDER, Oscillator, decay_integrals};
use crate::solver::series::INVERSES;

/// Number of functions `Z_-1, Z_0, ...` that the motion needs.
const COUNT: usize = MAX_FORCE_ORDER + 4;

/// Largest phase and decay for which the power series of `Z_k` has no terms that cancel.
const SERIES_LIMIT: f64 = 4.0;

impl Oscillator {
    /// The longest time (s) for which [`Self::sensitivities`] holds. Near critical damping there are only power series.
    pub fn longest(&self) -> f64 {
        let near_critical = self.gamma() > 0.5 * self.omega() && !self.is_overdamped();
        if near_critical { SERIES_LIMIT / self.pace() } else { f64::INFINITY }
    }

    /// `Z_-1`, `Z_0`, ... at `t` >= 0 (s), from its functions `u` then: `Z_k = -dU_k / d(omega^2)`, and `dU_k / dgamma`
    /// is `-2 Z_(k-1)`.
    ///
    /// They are the convolutions of `U_1` and `U_k`. From the Laplace transforms, `s^(1-k) / q` of `U_k` and
    /// `s^(1-k) / q^2` of `Z_k` with `q = s^2 + 2 gamma s + omega^2`, follow
    /// `2 Z_(k-1) + 2 gamma Z_k = t U_k - (k-1) U_(k+1)` and `Z_(k-2) + 2 gamma Z_(k-1) + omega^2 Z_k = U_k`.
    pub fn sensitivities(&self, t: f64, u: &[f64; BASIS]) -> [f64; COUNT] {
        let (omega2, gamma) = (self.omega2(), self.gamma());
        let known = |k: usize| t * u[k] - (k as f64 - 1.0) * u[k + 1];
        let (mut z, top) = ([0.0; COUNT], COUNT - 1);
        if gamma > 0.0 && self.pace() * t > SERIES_LIMIT {
            if self.is_overdamped() {
                return self.by_decays(t, u);
            }
            // Together the two equations give each function directly.
            let distance = 2.0 * (omega2 - gamma * gamma);
            for k in 1..top {
                z[k + 1] = (2.0 * u[k] - known(k - 1) - gamma * known(k)) / distance;
            }
            (0..2).rev().for_each(|k| z[k] = 0.5 * known(k) - gamma * z[k + 1]);
            return z;
        }
        z[top] = if gamma > 0.0 { self.highest(t) } else { 0.5 * known(top) };
        (0..top).rev().for_each(|k| z[k] = 0.5 * known(k) - gamma * z[k + 1]);
        z
    }

    /// The last of the functions by its power series.
    fn highest(&self, t: f64) -> f64 {
        let (damping, stiffness) = (2.0 * self.gamma() * t, self.omega2() * t * t);
        let mut power = (1..=COUNT).fold(1.0, |power, k| power * t * INVERSES[k]);
        // Coefficients of the expansions of s^2 / q and of s^4 / q^2 in powers of 1/s.
        let ([mut a, mut a_before], [mut b, mut b_before]) = ([1.0, 0.0], [1.0, 0.0]);
        let mut sum = power;
        for m in 1..40 {
            (a, a_before) = (-damping * a - stiffness * a_before, a);
            (b, b_before) = (a - damping * b - stiffness * b_before, b);
            power *= INVERSES[COUNT + m];
            sum += b * power;
        }
        sum
    }

    /// The functions as differences of two decays and of their derivatives by the rates.
    fn by_decays(&self, t: f64, u: &[f64; BASIS]) -> [f64; COUNT] {
        let (fast, slow) = self.decay_rates();
        let of_rate = |rate: f64| {
            let decay = decay_integrals(rate, t, COUNT - 1);
            let mut g = [0.0; COUNT];
            (g[0], g[1]) = (rate * (rate * t - 2.0) * decay[0], (1.0 - rate * t) * decay[0]);
            (0..COUNT - 2).for_each(|k| g[k + 2] = t * decay[k] - k as f64 * decay[k + 1]);
            (g, decay[0])
        };
        let ((of_fast, fast_left), (of_slow, slow_left)) = (of_rate(fast), of_rate(slow));
        let distance = fast - slow;
        let below = (slow * slow * slow_left - fast * fast * fast_left) / distance;
        std::array::from_fn(|k| {
            let u = if k == 0 { below } else { u[k - 1] };
            (of_fast[k] + of_slow[k] - 2.0 * u) / (distance * distance)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oscillator_sensitivities_are_derivatives() {
        for (omega2, gamma) in [(5.0, 0.0), (5.0, 0.3), (5.0, 2.3), (5.0, 40.0), (0.0, 0.0), (0.0, 0.5), (0.0, 30.0)] {
            for t in [1e-3, 0.2, 0.7, 1.9, 5.0, 13.0] {
                let at = |omega2: f64, gamma: f64| Oscillator::new(omega2, gamma).basis::<BASIS>(t.into());
                let (o, u) = (Oscillator::new(omega2, gamma), at(omega2, gamma));
                if t > o.longest() {
                    continue;
                }
                let z = o.sensitivities(t, &u);
                for k in 0..COUNT - 1 {
                    let h = 1e-5 * (1.0 + gamma);
                    let difference = (at(omega2, gamma + h)[k] - at(omega2, gamma)[k]) / h;
                    let second = (at(omega2, gamma + 2.0 * h)[k] - at(omega2, gamma)[k]) / (2.0 * h);
                    let by_gamma = 2.0 * difference - second;
                    let size = u[k].abs() * t + by_gamma.abs();
                    assert!(
                        (by_gamma + 2.0 * z[k]).abs() <= 1e-5 * size,
                        "{omega2} {gamma} {t} {k}: {by_gamma} {}",
                        z[k]
                    );
                }
                for k in 2..COUNT - 1 {
                    let off = z[k - 1] + 2.0 * gamma * z[k] + omega2 * z[k + 1] - u[k];
                    let size = z[k - 1].abs() + 2.0 * gamma * z[k].abs() + omega2 * z[k + 1].abs();
                    assert!(off.abs() <= 1e-11 * size, "{omega2} {gamma} {t} {k}: {off} {size}");
                }
            }
        }
    }
}
