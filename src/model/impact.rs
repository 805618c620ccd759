//! Scales of an impact of two balls, by which the methods of the engine choose their steps.

use super::contact::ContactLaw;
use super::damping::Damping;

/// Duration of an elastic impact times closing rate over largest overlap: pi if linear, 2 for very large exponents.
const DURATION: f64 = 2.9;

impl ContactLaw {
    /// Overlap d (m) below which the contact force, without a dashpot's, changes the velocity of a mass `m` (kg)
    /// closing at `rate` (m/s) by less than `dv` (m/s) within the time `d / rate`, but no longer than `duration` (s).
    pub fn largest_negligible_overlap(&self, m: f64, rate: f64, dv: f64, duration: f64) -> f64 {
        let p = self.exponent;
        // F = k d_ref (d / d_ref)^p; F d / rate = m dv, or F duration = m dv.
        let unit = m * dv / (self.stiffness * self.overlap_ref);
        let by_rate = libm::pow(unit * rate.abs() / self.overlap_ref, 1.0 / (p + 1.0));
        let by_time = if duration > 0.0 { libm::pow(unit / duration, 1.0 / p) } else { f64::INFINITY };
        let elastic = self.overlap_ref * by_rate.max(by_time);
        match self.damping {
            // The impulse of `A dF_el/dt` is `A F_el`.
            Damping::Viscoelastic { relaxation } => elastic.min(self.static_overlap(m * dv / relaxation)),
            Damping::None | Damping::KelvinVoigt { .. } | Damping::HuntCrossley { .. } => elastic,
        }
    }

    /// Duration (s) of an elastic impact of the reduced mass `m` (kg) at `rate` (m/s), to a few percent: a time scale.
    pub fn time_scale(&self, m: f64, rate: f64) -> f64 {
        if rate > 0.0 { DURATION * self.largest_overlap(m, rate) / rate } else { f64::INFINITY }
    }

    /// Speed (m/s) that an `acceleration` (m/s2) gives a reduced mass `m` (kg) from rest until its contact balances it.
    pub fn speed_from_rest(&self, m: f64, acceleration: f64) -> f64 {
        (acceleration * self.static_overlap(m * acceleration)).sqrt()
    }

    /// Time (s) in which damping alone reduces the rate to 1/e, at the largest overlap of the impact; infinite
    /// without damping.
    pub fn relaxation_time(&self, m: f64, rate: f64) -> f64 {
        match self.damping {
            Damping::None => f64::INFINITY,
            Damping::KelvinVoigt { c, .. } => m / c,
            Damping::HuntCrossley { alpha } => m / (alpha * self.elastic_force(self.largest_overlap(m, rate))),
            Damping::Viscoelastic { relaxation } => {
                // Strong damping stops the mass where its impulse `A F_el` equals the momentum.
                let (d, stopping) = (self.largest_overlap(m, rate), m * rate / relaxation);
                let force = self.elastic_force(d);
                let (d, force) = if force > stopping { (self.static_overlap(stopping), stopping) } else { (d, force) };
                m * d / (relaxation * self.exponent * force)
            }
        }
    }

    /// Whether that is shorter than this `part` of the time scale. Weak damping is told without powers: at the largest
    /// overlap, force times overlap is p + 1 times the energy.
    pub fn relaxes_within(&self, part: f64, m: f64, rate: f64) -> bool {
        let (p, energy) = (self.exponent, 0.5 * m * rate * rate);
        let is_weak = match self.damping {
            Damping::None => true,
            Damping::KelvinVoigt { .. } => false,
            Damping::HuntCrossley { alpha } => alpha * DURATION * part * (p + 1.0) * energy <= m * rate,
            Damping::Viscoelastic { relaxation } => {
                let reached = 0.5 * (p + 1.0) * relaxation * rate * (DURATION * part * p).max(1.0);
                self.elastic_energy(reached) <= energy
            }
        };
        !is_weak && self.relaxation_time(m, rate) < part * self.time_scale(m, rate)
    }

    /// Largest overlap of that impact, m.
    pub fn largest_overlap(&self, m: f64, rate: f64) -> f64 {
        let p = self.exponent;
        // Energy balance: k d_ref^2 (d/d_ref)^(p+1) / (p+1) = m rate^2 / 2.
        let squares = 0.5 * (p + 1.0) * m * rate * rate / (self.stiffness * self.overlap_ref * self.overlap_ref);
        if squares < f64::MIN_POSITIVE {
            // The same where squares of slow rates underflow.
            let ratio = rate.abs() * (0.5 * (p + 1.0) * m / self.stiffness).sqrt() / self.overlap_ref;
            return self.overlap_ref * libm::pow(ratio, 2.0 / (p + 1.0));
        }
        self.overlap_ref * libm::pow(squares, 1.0 / (p + 1.0))
    }
}
