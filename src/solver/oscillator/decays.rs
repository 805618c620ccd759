//! Sums of two decays: what the velocity of an overdamped oscillator is under a constant force.

/// The motion of an overdamped oscillator: its velocity is the sum of two decays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Decays {
    /// The fast and the slow one.
    pub parts: [Decay; 2],
}

/// `amplitude exp(-rate t)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Decay {
    /// In 1/s.
    pub rate: f64,
    /// In m/s, with the magnitude of what it was computed from.
    pub amplitude: f64,
    pub magnitude: f64,
}

impl Decays {
    /// With the rates `fast` and `slow` (1/s), for the velocity `v` (m/s) and the acceleration but for that by the
    /// velocity, `force` (m/s2), at time 0.
    pub fn new((fast, slow): (f64, f64), v: f64, force: f64) -> Self {
        let decay = |rate: f64, difference: f64| Decay {
            rate,
            amplitude: difference / (fast - slow),
            magnitude: (rate * v.abs() + force.abs()) / (fast - slow),
        };
        Self { parts: [decay(fast, fast * v - force), decay(slow, force - slow * v)] }
    }

    /// Rates (1/s) and velocities (m/s) of the decays at `t` (s).
    pub fn velocities(&self, t: f64) -> [(f64, f64); 2] {
        self.parts.map(|decay| (decay.rate, decay.amplitude * libm::exp(-decay.rate * t)))
    }

    /// A bound of the absolute derivative of order `k` >= 2 of the displacement from the time `t` (s) on.
    pub fn derivative_bound(&self, t: f64, k: i32) -> f64 {
        self.velocities(t).into_iter().map(|(rate, v)| v.abs() * power(rate, k - 1)).sum()
    }
}

/// `rate^k`.
pub(super) fn power(rate: f64, k: i32) -> f64 {
    (0..k).fold(1.0, |power, _| power * rate)
}
