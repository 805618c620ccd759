//! Forces of a contact at many overlaps at once: the formulas of `contact`, in loops that compilers vectorise.

use std::array;

use super::contact::ContactLaw;
use super::damping::Damping;
use crate::solver::power::powers;

impl ContactLaw {
    /// Whether the exponent is a whole number and a half: the force is then smooth in the root of the overlap.
    pub fn has_root(&self) -> bool {
        let twice = 2.0 * self.exponent;
        twice as usize as f64 == twice && twice as usize % 2 == 1
    }

    /// The secant stiffness `k (d / d_ref)^(p-1)` at several overlaps (m), none < 0, times the `distances` (m):
    /// products, and one factor for the fractional part of the exponent.
    #[inline(always)]
    fn secant_forces<const N: usize>(&self, overlaps: &[f64; N], distances: &[f64; N]) -> [f64; N] {
        let scale = 1.0 / self.overlap_ref;
        let ratios = overlaps.map(|overlap| overlap * scale);
        let mut forces = distances.map(|distance| self.stiffness * distance);
        let mut times =
            |factors: &[f64; N]| forces.iter_mut().zip(factors).for_each(|(force, factor)| *force *= factor);
        // Finite differences in tests go below an exponent of 1.
        let whole = (self.exponent as usize).max(1);
        match self.exponent - whole as f64 {
            0.0 => {}
            0.5 => times(&ratios.map(f64::sqrt)),
            part => times(&powers(&ratios, part)),
        }
        (1..whole).for_each(|_| times(&ratios));
        forces
    }

    /// [`Self::unclipped_force`] at several overlaps (m) and rates (m/s), N. At overlaps <= 0 only `c r` is left.
    #[inline(always)]
    pub fn unclipped_forces<const N: usize>(&self, overlaps: &[f64; N], rates: &[f64; N]) -> [f64; N] {
        let overlaps = overlaps.map(positive);
        let distances = match self.damping {
            Damping::None | Damping::KelvinVoigt { .. } => overlaps,
            Damping::HuntCrossley { alpha } => array::from_fn(|m| overlaps[m] * (1.0 + alpha * rates[m])),
            // The elastic force with `d + p A r` in place of `d`, without a division by `d`.
            Damping::Viscoelastic { relaxation } => {
                let relaxation = self.exponent * relaxation;
                array::from_fn(|m| overlaps[m] + relaxation * rates[m])
            }
        };
        let mut forces = self.secant_forces(&overlaps, &distances);
        if let Damping::KelvinVoigt { c, .. } = self.damping {
            forces.iter_mut().zip(rates).for_each(|(force, rate)| *force += c * rate);
        }
        forces
    }

    /// Damping parts of the forces, N; as a difference they would lose digits where damping is weak.
    pub fn damping_forces<const N: usize>(&self, overlaps: &[f64; N], rates: &[f64; N]) -> [f64; N] {
        let overlaps = overlaps.map(positive);
        let distances = match self.damping {
            Damping::None => return [0.0; N],
            Damping::KelvinVoigt { c, .. } => return rates.map(|rate| c * rate),
            Damping::HuntCrossley { alpha } => array::from_fn(|m| overlaps[m] * (alpha * rates[m])),
            Damping::Viscoelastic { relaxation } => {
                let relaxation = self.exponent * relaxation;
                rates.map(|rate| relaxation * rate)
            }
        };
        self.secant_forces(&overlaps, &distances)
    }
}

/// The overlap, or 0 if it is negative; NaN stays NaN.
fn positive(overlap: f64) -> f64 {
    if overlap <= 0.0 { 0.0 } else { overlap }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Damping;

    /// Overlaps without force, and NaN.
    #[test]
    fn open_contacts_have_none_and_nan_stays() {
        let dampings =
            [Damping::None, Damping::HuntCrossley { alpha: 0.4 }, Damping::Viscoelastic { relaxation: 1e-6 }];
        for (damping, exponent) in dampings.into_iter().flat_map(|damping| [1.0, 1.5, 2.3].map(|p| (damping, p))) {
            let law = ContactLaw { stiffness: 1e10, overlap_ref: 1e-6, exponent, clearance: 0.0, pivots: 0.0, damping };
            assert_eq!(law.unclipped_forces(&[0.0, -1e-6], &[0.0; 2]), [0.0; 2], "{law:?}");
            assert!(law.unclipped_forces(&[f64::NAN], &[0.1])[0].is_nan(), "{law:?}");
        }
    }
}
