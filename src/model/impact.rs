//! Scales of the impact of two balls, by which the methods of the engine choose their steps.

use super::contact::ContactLaw;

/// Duration of an elastic impact times closing rate over largest overlap: pi if linear, 2 for very large exponents.
const DURATION: f64 = 2.9;

impl ContactLaw {
    /// Overlap d (m) below which the contact force, without a dashpot's, changes the velocity of a mass `m` (kg)
    /// closing at `rate` (m/s) by less than `dv` (m/s) within the time `d / rate`, or within `duration` (s) if that is
    /// shorter.
    pub fn largest_negligible_overlap(&self, m: f64, rate: f64, dv: f64, duration: f64) -> f64 {
        let p = self.exponent;
        // F = k d_ref (d / d_ref)^p; F d / rate = m dv, or F duration = m dv.
        let unit = m * dv / (self.stiffness * self.overlap_ref);
        let by_rate = libm::pow(unit * rate.abs() / self.overlap_ref, 1.0 / (p + 1.0));
        let by_time = if duration > 0.0 { libm::pow(unit / duration, 1.0 / p) } else { f64::INFINITY };
        let elastic = self.overlap_ref * by_rate.max(by_time);
        if self.damping_coefficient() != 0.0 || self.is_elastic() {
            elastic
        } else {
            elastic.min(self.stopped_at(m * dv))
        }
    }

    /// Overlap (m) at which the impulse of the damping is this `momentum` (N.s); infinite without damping.
    fn stopped_at(&self, momentum: f64) -> f64 {
        // The impulse is C d_ref (d / d_ref)^(s+1) / (s+1).
        let grown = self.damping_exponent() + 1.0;
        let unit = self.damping.coefficient * self.overlap_ref / grown;
        self.overlap_ref * libm::pow(momentum / unit, 1.0 / grown)
    }

    /// Duration (s) of an elastic impact of the reduced mass `m` (kg) at `rate` (m/s), to a few percent.
    pub fn time_scale(&self, m: f64, rate: f64) -> f64 {
        if rate > 0.0 { DURATION * self.largest_overlap(m, rate) / rate } else { f64::INFINITY }
    }

    /// Speed (m/s) that an `acceleration` (m/s2) gives a reduced mass `m` (kg) from rest until its contact balances it.
    pub fn speed_from_rest(&self, m: f64, acceleration: f64) -> f64 {
        (acceleration * self.static_overlap(m * acceleration)).sqrt()
    }

    /// Time (s) in which damping alone, at the largest overlap of the impact, reduces the rate to 1/e; infinite without
    /// damping.
    pub fn relaxation_time(&self, m: f64, rate: f64) -> f64 {
        if self.is_elastic() {
            return f64::INFINITY;
        }
        let ratio = self.largest_overlap(m, rate).min(self.stopped_at(m * rate)) / self.overlap_ref;
        m / (self.damping.coefficient * libm::pow(ratio, self.damping_exponent()))
    }

    /// Whether the [relaxation time](Self::relaxation_time), at the largest overlap of an elastic impact, is below this
    /// `part` of [`Self::time_scale`].
    pub fn relaxes_within(&self, part: f64, m: f64, rate: f64) -> bool {
        let (p, unit) = (self.exponent, self.overlap_ref);
        // (d / d_ref)^(p+1) at the largest overlap d, where force times overlap is p + 1 times the energy.
        let energies = 0.5 * (p + 1.0) * m * rate * rate / (self.stiffness * unit * unit);
        let power = match (self.damping_exponent() + 1.0) / (p + 1.0) {
            1.0 => energies,
            0.5 => energies.sqrt(),
            exponent => libm::pow(energies, exponent),
        };
        DURATION * part * self.damping.coefficient * unit * power > m * rate
    }

    /// Largest overlap of an elastic impact of the reduced mass `m` (kg) at `rate` (m/s), m.
    pub fn largest_overlap(&self, m: f64, rate: f64) -> f64 {
        let p = self.exponent;
        // Energy balance: k d_ref^2 (d/d_ref)^(p+1) / (p+1) = m rate^2 / 2.
        let squares = 0.5 * (p + 1.0) * m * rate * rate / (self.stiffness * self.overlap_ref * self.overlap_ref);
        if squares < f64::MIN_POSITIVE {
            // The root of that expression does not underflow for slow rates.
            let ratio = rate.abs() * (0.5 * (p + 1.0) * m / self.stiffness).sqrt() / self.overlap_ref;
            return self.overlap_ref * libm::pow(ratio, 2.0 / (p + 1.0));
        }
        self.overlap_ref * libm::pow(squares, 1.0 / (p + 1.0))
    }
}
