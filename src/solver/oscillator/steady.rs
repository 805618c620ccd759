//! A driven oscillator's motion as a polynomial that follows the force, and a free swing about it.
//!
//! The displacement D with `D'' + 2 gamma D' + omega^2 D = f`, f a polynomial of the time, is `P + h`: P is the
//! polynomial that solves the equation, h the free motion from the rest of the start state. This form is for long
//! times: it has derivatives and integrals over many swings in closed form. For short times it would cancel; the
//! functions `U_k` (`oscillator`) do not.

use nalgebra::Complex;

use super::closed_form::{MAX_FORCE_ORDER, Oscillator};
use crate::solver::series::{integral, of_derivatives};

/// Coefficients of a polynomial of the time, from the constant term on.
type Polynomial = [f64; MAX_FORCE_ORDER + 1];

/// The two parts of a motion, as velocities.
#[derive(Clone, Copy, Debug)]
pub struct Steady {
    /// Coefficients of the velocity P' of the polynomial part; number k in m/s^(1+k).
    velocity: Polynomial,
    /// Velocity (m/s) and acceleration (m/s2) of the free swing at time 0.
    swing: (f64, f64),
}

impl Steady {
    /// For the velocity `v` (m/s) and the acceleration `a` (m/s2) at time 0, under a force with the derivatives
    /// `forcing` at time 0, m/s^(2+j). `None` for a free body, whose motion is a polynomial.
    pub fn new(o: &Oscillator, v: f64, a: f64, forcing: &Polynomial) -> Option<Self> {
        let (damping, omega2) = (2.0 * o.gamma(), o.omega2());
        if omega2 == 0.0 && damping == 0.0 {
            return None;
        }
        // Coefficients of the force; and of P or, without a spring, of P'.
        let force = of_derivatives(*forcing);
        let mut p = [0.0; MAX_FORCE_ORDER + 3];
        for k in (0..=MAX_FORCE_ORDER).rev() {
            let (next, after) = ((k + 1) as f64 * p[k + 1], ((k + 1) * (k + 2)) as f64 * p[k + 2]);
            p[k] =
                if omega2 > 0.0 { (force[k] - damping * next - after) / omega2 } else { (force[k] - next) / damping };
        }
        let velocity: Polynomial = match omega2 > 0.0 {
            true => std::array::from_fn(|k| (k + 1) as f64 * p[k + 1]),
            false => std::array::from_fn(|k| p[k]),
        };
        Some(Self { velocity, swing: (v - velocity[0], a - velocity[1]) })
    }

    /// A bound of the absolute derivative of `order` (3 or 4) of the displacement from `t` (s) until `end`.
    pub fn derivative_bound(&self, o: &Oscillator, t: f64, end: f64, order: i32) -> f64 {
        let [_, _, c, d] = self.velocity.map(f64::abs);
        let followed = if order == 3 { 2.0 * c + 6.0 * d * end } else { 6.0 * d };
        followed + o.derivative_bound(self.swing.0, self.swing.1, t, order)
    }

    /// Integral of the squared velocity from 0 to `t` (s), m2/s, for an oscillator with `gamma < omega`. Nothing
    /// cancels from `omega t` = 1 on, or from 8 on if the force varies.
    pub fn squared_velocity_integral(&self, o: &Oscillator, t: f64) -> f64 {
        let (gamma, (omega, sine, cosine)) = (o.gamma(), o.phase(t));
        // The swing is the real part of (swing.0 - i other) exp(lambda t).
        let other = (self.swing.1 + gamma * self.swing.0) / omega;
        let amplitude = Complex::new(self.swing.0, -other);
        let lambda = Complex::new(-gamma, omega);
        let left = libm::exp(-gamma * t);
        let turned = Complex::new(left * cosine, left * sine);
        // |swing|^2 = (|amplitude|^2 exp(-2 gamma t) + real part of amplitude^2 exp(2 lambda t)) / 2
        let mean = if gamma > 0.0 { -libm::expm1(-2.0 * gamma * t) / (2.0 * gamma) } else { t };
        let Complex { re: waving, .. } =
            amplitude * amplitude * (turned * turned - Complex::new(1.0, 0.0)) / (lambda + lambda);
        let of_swing = 0.5 * ((amplitude * amplitude.conj()).re * mean + waving);
        // By parts: integral P' exp(lambda t) = exp(lambda t) (P' / lambda - P'' / lambda^2 + ...)
        let by_parts = |t: f64| {
            let [a, b, c, d] = self.velocity;
            let terms =
                [a + t * (b + t * (c + t * d)), b + t * (2.0 * c + t * 3.0 * d), 2.0 * c + 6.0 * d * t, 6.0 * d];
            terms.iter().rev().fold(Complex::new(0.0, 0.0), |sum, term| (Complex::new(*term, 0.0) - sum) / lambda)
        };
        let Complex { re: mixed, .. } = amplitude * (turned * by_parts(t) - by_parts(0.0));
        let mut square = [0.0; 2 * MAX_FORCE_ORDER + 1];
        for (i, a) in self.velocity.iter().enumerate() {
            self.velocity.iter().enumerate().for_each(|(j, b)| square[i + j] += a * b);
        }
        integral(&square, t) + 2.0 * mixed + of_swing
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::oscillator::BASIS;

    /// Velocity at `t` from `v` at rest position under the force, by the functions of the oscillator.
    fn velocity(o: &Oscillator, v: f64, forcing: &Polynomial, t: f64) -> f64 {
        let u: [f64; BASIS] = o.basis(t.into());
        v * u[0] + forcing.iter().enumerate().map(|(j, forcing)| forcing * u[j + 1]).sum::<f64>()
    }

    #[test]
    fn oscillator_bounds_hold_and_let_a_settled_motion_go() {
        for (omega2, gamma) in [(5.0, 0.1), (0.0, 0.2), (0.0, 1e-3), (5.0, 30.0)] {
            let o = Oscillator::new(omega2, gamma);
            let forcing = [0.3, -0.2, 0.05, 0.01];
            let steady = Steady::new(&o, 0.4, forcing[0] - 0.8 * gamma, &forcing).unwrap();
            for t in [0.0, 0.5, 4.0, 60.0, 3000.0] {
                let (end, h) = (1.5 * t + 1e-3, 1e-3);
                let bound = steady.derivative_bound(&o, t, end, 3);
                let third = |s: f64| {
                    let at = |k: f64| velocity(&o, 0.4, &forcing, s + k * h);
                    (at(1.0) - 2.0 * at(0.0) + at(-1.0)) / (h * h)
                };
                for s in [t + h, 0.5 * (t + end), end] {
                    let rounding = 1e-9 * velocity(&o, 0.4, &forcing, s).abs() + 1e-6;
                    assert!(third(s).abs() <= 1.01 * bound + rounding, "{omega2} {gamma} {t}: {} {bound}", third(s));
                }
            }
        }
    }
}
