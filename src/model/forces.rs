//! Forces of a contact at many overlaps at once: the formulas of `contact` in loops that compilers vectorise.

use super::contact::ContactLaw;
use super::damping::{Damping, Growth};
use crate::solver::power::powers;

impl ContactLaw {
    /// `(d / d_ref)` and `(d / d_ref)^(p-1)` at several overlaps d (m), none < 0. The powers are products, with one
    /// factor for the fractional part of the exponent.
    #[inline(always)]
    fn ratios_and_powers<const N: usize>(&self, overlaps: &[f64; N]) -> [[f64; N]; 2] {
        let scale = 1.0 / self.overlap_ref;
        let ratios = overlaps.map(|overlap| overlap * scale);
        // Finite differences in tests use exponents below 1.
        let whole = (self.exponent as usize).max(1);
        let mut powers = match self.exponent - whole as f64 {
            0.0 => [1.0; N],
            0.5 => ratios.map(f64::sqrt),
            part => powers(&ratios, part),
        };
        for _ in 1..whole {
            powers.iter_mut().zip(&ratios).for_each(|(power, ratio)| *power *= ratio);
        }
        [ratios, powers]
    }

    /// [`Self::unclipped_force`] at several overlaps (m) and rates (m/s), N. At overlaps <= 0 only the `c r` of a
    /// dashpot is left.
    #[inline(always)]
    pub fn unclipped_forces<const N: usize>(&self, overlaps: &[f64; N], rates: &[f64; N]) -> [f64; N] {
        let overlaps = overlaps.map(positive);
        let ([ratios, powers], mut forces) = (self.ratios_and_powers(&overlaps), [0.0; N]);
        let (k, Damping { coefficient: c, growth, .. }) = (self.stiffness, self.damping);
        // One loop for each law: compilers do not move the choice out of a common loop.
        macro_rules! forces {
            ($m:ident: $force:expr) => {
                for $m in 0..N {
                    forces[$m] = $force;
                }
            };
        }
        match growth {
            _ if self.is_elastic() => forces!(m: k * overlaps[m] * powers[m]),
            Growth::Constant => forces!(m: k * overlaps[m] * powers[m] + c * rates[m]),
            Growth::Force => forces!(m: (k * overlaps[m] + c * ratios[m] * rates[m]) * powers[m]),
            Growth::Stiffness => forces!(m: (k * overlaps[m] + c * rates[m]) * powers[m]),
            Growth::RootOfStiffness => forces!(m: k * overlaps[m] * powers[m] + c * powers[m].sqrt() * rates[m]),
        }
        forces
    }

    /// Damping forces, N. As differences of forces they would lose digits where damping is weak.
    pub fn damping_forces<const N: usize>(&self, overlaps: &[f64; N], rates: &[f64; N]) -> [f64; N] {
        let [ratios, powers] = self.ratios_and_powers(&overlaps.map(positive));
        let mut forces = rates.map(|rate| self.damping.coefficient * rate);
        let mut times = |factors: [f64; N]| forces.iter_mut().zip(factors).for_each(|(force, factor)| *force *= factor);
        match self.damping.growth {
            Growth::Constant => {}
            Growth::Force => {
                times(powers);
                times(ratios);
            }
            Growth::Stiffness => times(powers),
            Growth::RootOfStiffness => times(powers.map(f64::sqrt)),
        }
        forces
    }
}

/// The overlap, or 0 if it is negative; NaN stays NaN.
fn positive(overlap: f64) -> f64 {
    if overlap <= 0.0 { 0.0 } else { overlap }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn force_of_an_open_contact_is_zero_and_nan_stays() {
        let grown = [Growth::Force, Growth::Stiffness, Growth::RootOfStiffness];
        let dampings = grown.map(|growth| Damping { coefficient: 1e3, growth, clipped: true });
        for (damping, exponent) in
            dampings.into_iter().chain([Damping::default()]).flat_map(|damping| [1.5, 2.3].map(|p| (damping, p)))
        {
            let law = ContactLaw {
                stiffness: 1e10,
                overlap_ref: 1e-6,
                exponent,
                clearance: 0.0,
                pivots: 0.0,
                damping,
                restitution: 0.0,
            };
            assert_eq!(law.unclipped_forces(&[0.0, -1e-6], &[0.0; 2]), [0.0; 2], "{law:?}");
            assert!(law.unclipped_forces(&[f64::NAN], &[0.1])[0].is_nan(), "{law:?}");
        }
    }
}
