//! The motion of an oscillator under a constant force as a search for its crossings wants it: with derivatives, bounds
//! of the next ones, and how much of each is rounding.

use super::closed_form::Oscillator;
use super::decays::{Decay, Decays, power};

/// The displacement since time 0, at one time; each value with the sum of the magnitudes that it was computed from.
#[derive(Clone, Copy, Debug)]
pub struct Response {
    /// Change of the velocity since time 0, m/s.
    pub change_of_rate: (f64, f64),
    /// The displacement (m) and its first four derivatives.
    pub derivatives: [(f64, f64); 5],
    /// Rates (1/s) and velocities (m/s) of the decays that it is the sum of, if it is.
    decays: Option<[(f64, f64); 2]>,
}

impl Response {
    /// Of an oscillator whose velocity is the sum of two decays, at `t` (s).
    fn of_decays(decays: &Decays, t: f64) -> Self {
        let (mut change_of_rate, mut derivatives) = ((0.0, 0.0), [(0.0, 0.0); 5]);
        let velocities = decays.parts.map(|Decay { rate, amplitude, magnitude }| {
            let reach = rate * t;
            let (left, lost) = if reach < 0.5 {
                let lost = -libm::expm1(-reach);
                (1.0 - lost, lost)
            } else {
                let left = libm::exp(-reach);
                (left, 1.0 - left)
            };
            let add = |sum: &mut (f64, f64), factor: f64| {
                sum.0 += amplitude * factor;
                sum.1 += magnitude * factor.abs();
            };
            add(&mut change_of_rate, -lost);
            add(&mut derivatives[0], if rate > 0.0 { lost / rate } else { t });
            let mut factor = left;
            for sum in &mut derivatives[1..] {
                add(sum, factor);
                factor *= -rate;
            }
            (rate, amplitude * left)
        });
        Self { change_of_rate, derivatives, decays: Some(velocities) }
    }
}

/// An oscillator under a constant force.
#[derive(Clone, Debug)]
pub struct ForcedOscillator {
    oscillator: Oscillator,
    /// Velocity (m/s) and acceleration but for that by the velocity (m/s2) at time 0.
    v: f64,
    force: f64,
    /// The velocity of an overdamped one, and from when on the two decays do not cancel each other, s.
    decays: Option<Decays>,
    from: f64,
}

impl ForcedOscillator {
    /// From the velocity `v` (m/s) on under the acceleration `force` (m/s2).
    pub fn new(oscillator: Oscillator, v: f64, force: f64) -> Self {
        let from = 0.5 / (oscillator.omega() + 2.0 * oscillator.gamma());
        Self { oscillator, v, force, decays: oscillator.decays(v, force), from }
    }

    /// The oscillator.
    pub fn oscillator(&self) -> &Oscillator {
        &self.oscillator
    }

    /// Integral of the displacement from time 0 to `t` (s), m.s.
    pub fn displacement_integral(&self, t: f64) -> f64 {
        let [_, _, u2, u3] = self.oscillator.basis(t.into());
        self.v * u2 + self.force * u3
    }

    /// Integral of the velocity squared from time 0 to where the motion is `response`, m2/s: what the damping takes
    /// from the energy `v^2/2 + omega^2 x^2/2 - f x`, for gamma > 0.
    pub fn squared_velocity_integral(&self, response: &Response) -> f64 {
        let ((change, _), (x, _)) = (response.change_of_rate, response.derivatives[0]);
        let o = &self.oscillator;
        let lost = -0.5 * change * (2.0 * self.v + change) - 0.5 * o.omega2() * x * x + self.force * x;
        lost / (2.0 * o.gamma())
    }

    /// The motion at `t` (s) after time 0.
    pub fn at(&self, t: f64) -> Response {
        if let Some(decays) = self.decays.filter(|_| t >= self.from) {
            return Response::of_decays(&decays, t);
        }
        let Self { oscillator: o, v, force, .. } = self;
        let [fourth, third, second, first, u1, u2] = o.derivatives(t.into());
        let sum = |by_velocity: f64, by_force: f64| {
            let (a, b) = (v * by_velocity, force * by_force);
            (a + b, a.abs() + b.abs())
        };
        let slowed = -2.0 * o.gamma() * u1 - o.omega2() * u2;
        Response {
            change_of_rate: sum(slowed, u1),
            derivatives: [sum(u1, u2), sum(first, u1), sum(second, first), sum(third, second), sum(fourth, third)],
            decays: None,
        }
    }

    /// A bound of the absolute derivative of order `k` >= 2 of `a` times the displacement and `b` times the velocity
    /// from the time `t` (s) on, where the motion is `response`.
    pub fn derivative_bound(&self, response: &Response, t: f64, k: i32, a: f64, b: f64) -> f64 {
        if let Some(decays) = &self.decays {
            let decays = response.decays.unwrap_or_else(|| decays.velocities(t));
            // The two often all but cancel each other in a slow decay.
            return decays.into_iter().map(|(rate, v)| (v * (a - b * rate)).abs() * power(rate, k - 1)).sum();
        }
        let acceleration = self.force - 2.0 * self.oscillator.gamma() * self.v;
        let bound = |factor: f64, k: i32| match factor {
            0.0 => 0.0,
            _ => factor.abs() * self.oscillator.derivative_bound(self.v, acceleration, t, k),
        };
        bound(a, k) + bound(b, k + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_derivative_exceeds_its_bound_from_then_on() {
        let free = ForcedOscillator::new(Oscillator::new(0.0, 0.0), 1.0, 2.0);
        assert_eq!([2, 3].map(|k| free.derivative_bound(&free.at(0.1), 0.1, k, 1.0, 0.0)), [2.0, 0.0]);
        for gamma in [0.0, 0.3, 0.79, 0.9, 1.0, 1.1, 1.2, 1.24, 1.3, 5.0] {
            for (v, force) in [(1.0, 0.0), (0.0, 1.0), (0.3, -2.0)] {
                let forced = ForcedOscillator::new(Oscillator::new(1.0, gamma), v, force);
                for (from, k) in [(0.0, 2), (0.5, 3), (4.0, 2), (13.0, 3), (13.0, 4)] {
                    let bound = (1.0 + 1e-12) * forced.derivative_bound(&forced.at(from), from, k, 1.0, 0.0);
                    let most = (0..100).map(|i| forced.at(from + 0.1 * f64::from(i)).derivatives[k as usize].0.abs());
                    assert!(most.fold(0.0, f64::max) <= bound, "{gamma}, {v}, {force}: order {k} from {from}");
                }
            }
        }
    }

    #[test]
    fn decays_agree_with_the_functions_of_the_oscillator() {
        for (omega2, gamma) in [(5.0, 3.0), (5.0, 40.0), (0.0, 2.0), (1e4, 3e6)] {
            let oscillator = Oscillator::new(omega2, gamma);
            for (v, force) in [(1.0, 0.0), (0.0, 1.0), (0.3, -2.0)] {
                let forced = ForcedOscillator::new(oscillator, v, force);
                for t in [0.26, 0.7, 3.0, 40.0].map(|reach| reach / gamma) {
                    let u: [f64; 3] = oscillator.basis(t.into());
                    let response = forced.at(t);
                    let expected = [v * u[1] + force * u[2], v * u[0] + force * u[1]];
                    for ((value, magnitude), expected) in response.derivatives.into_iter().zip(expected) {
                        assert!(
                            (value - expected).abs() <= 1e-14 * magnitude,
                            "{omega2} {gamma} {t}: {value} {expected}"
                        );
                    }
                }
            }
        }
    }
}
