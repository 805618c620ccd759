//! The motion of an oscillator under a constant force, with derivatives and bounds for the search for crossings.

use std::cell::Cell;

use super::closed_form::{Oscillator, power};

#[derive(Clone, Debug)]
pub struct ForcedOscillator {
    pub oscillator: Oscillator,
    /// Velocity (m/s) and acceleration without damping (m/s2) at time 0.
    v: f64,
    force: f64,
    /// The last time with the functions there: many calls are for the same time.
    last: Cell<Option<(f64, [f64; 6])>>,
}

impl ForcedOscillator {
    /// The motion from the velocity `v` (m/s) under the acceleration `force` (m/s2).
    pub fn new(oscillator: Oscillator, v: f64, force: f64) -> Self {
        Self { oscillator, v, force, last: Cell::new(None) }
    }

    /// Integral of the displacement from time 0 to `t` (s), m.s.
    pub fn displacement_integral(&self, t: f64) -> f64 {
        let [_, _, u2, u3] = self.oscillator.basis(t.into());
        self.v * u2 + self.force * u3
    }

    /// Integral of the squared velocity from time 0 to `t` (s), m2/s, for gamma > 0: from the loss of the energy
    /// `v^2/2 + omega^2 x^2/2 - f x`.
    pub fn squared_velocity_integral(&self, t: f64) -> f64 {
        let ([x, ..], change) = self.at(t);
        let o = &self.oscillator;
        let lost = -0.5 * change * (2.0 * self.v + change) - 0.5 * o.omega2() * x * x + self.force * x;
        lost / (2.0 * o.gamma())
    }

    /// The displacement since time 0 (m), its first four derivatives, and the change of the velocity (m/s), at `t` (s).
    pub fn at(&self, t: f64) -> ([f64; 5], f64) {
        let Self { oscillator: o, v, force, .. } = self;
        let u = self.functions(t);
        let slowed = -2.0 * o.gamma() * u[4] - o.omega2() * u[5];
        (std::array::from_fn(|k| v * u[4 - k] + force * u[5 - k]), v * slowed + force * u[4])
    }

    fn functions(&self, t: f64) -> [f64; 6] {
        match self.last.get() {
            Some((time, functions)) if time == t => functions,
            _ => {
                let functions = self.oscillator.derivatives(t.into());
                self.last.set(Some((t, functions)));
                functions
            }
        }
    }

    /// A bound of the absolute derivative `k` >= 2 of `a` times displacement plus `b` times velocity, from `t` (s) on.
    pub fn derivative_bound(&self, t: f64, k: i32, a: f64, b: f64) -> f64 {
        if let Some([[fast, v_fast], [slow, v_slow]]) = self.oscillator.decays(self.v, self.force) {
            // What is left of the decays at `t`: the slow one from `U_0` and `U_1`, the fast one from `U_-3`, where it
            // dominates.
            let [third, .., u0, u1, _] = self.functions(t);
            let of_slow = u0 + fast * u1;
            let of_fast = (power(slow, 4) * of_slow - (fast - slow) * third).abs() / power(fast, 4);
            // In a slow decay the two terms often almost cancel, so they are bounded together.
            let bound = |rate: f64, v: f64| (v * (a - b * rate)).abs() * power(rate, k - 1);
            return bound(fast, v_fast) * of_fast + bound(slow, v_slow) * of_slow;
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
    fn oscillator_derivatives_stay_below_their_bounds() {
        let free = ForcedOscillator::new(Oscillator::new(0.0, 0.0), 1.0, 2.0);
        assert_eq!([2, 3].map(|k| free.derivative_bound(0.1, k, 1.0, 0.0)), [2.0, 0.0]);
        for gamma in [0.0, 0.3, 0.79, 0.9, 1.0, 1.1, 1.2, 1.24, 1.3, 5.0] {
            for (v, force) in [(1.0, 0.0), (0.0, 1.0), (0.3, -2.0)] {
                let forced = ForcedOscillator::new(Oscillator::new(1.0, gamma), v, force);
                for (from, k) in [(0.0, 2), (0.5, 3), (4.0, 2), (13.0, 3), (13.0, 4)] {
                    let bound = (1.0 + 1e-12) * forced.derivative_bound(from, k, 1.0, 0.0);
                    let most = (0..100).map(|i| forced.at(from + 0.1 * f64::from(i)).0[k as usize].abs());
                    assert!(most.fold(0.0, f64::max) <= bound, "{gamma}, {v}, {force}: order {k} from {from}");
                }
            }
        }
    }
}
