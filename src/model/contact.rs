//! The force law of one contact, by which the engine uses damping laws: all code that depends on these.

use super::damping::{Damping, SignOfForce};
use crate::solver::dual::{Dual, Scalar};
use crate::solver::series::{power_term, product_term};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Whether and how a contact acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mode {
    /// No overlap.
    #[default]
    Open,
    /// Overlap, the force follows the law.
    Pressing,
    /// Overlap, the law would pull and is clipped at zero.
    Clipped,
}

/// One contact: the elastic law `F = k (d / d_ref)^(p-1) d` for overlaps d > 0, and its damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLaw<S = f64> {
    /// Secant stiffness k at the overlap `overlap_ref`, N/m.
    pub stiffness: S,
    /// Reference overlap d_ref, m.
    pub overlap_ref: S,
    /// Exponent p, 1 to 10.
    pub exponent: S,
    /// Distance between the neighbours' surfaces at rest that must close before the spring acts (gap + dead band), m.
    pub clearance: S,
    /// Horizontal distance between the pivots, m; used where balls move on arcs.
    pub pivots: S,
    /// Damping law.
    pub damping: Damping<S>,
}

impl<S: Scalar> ContactLaw<S> {
    /// The law in its simplest form: a viscoelastic contact whose exponent is and stays 1 is one of Kelvin and Voigt.
    pub fn simplified(self) -> Self {
        match self.damping {
            Damping::Viscoelastic { relaxation } if self.whole_exponent() == Some(1) => {
                let c = relaxation * self.stiffness;
                Self { damping: Damping::KelvinVoigt { c, pull: false }, ..self }
            }
            _ => self,
        }
    }

    /// The same law in other numbers.
    pub fn map<T>(&self, number: impl Fn(S) -> T) -> ContactLaw<T> {
        ContactLaw {
            stiffness: number(self.stiffness),
            overlap_ref: number(self.overlap_ref),
            exponent: number(self.exponent),
            clearance: number(self.clearance),
            pivots: number(self.pivots),
            damping: self.damping.map(number),
        }
    }

    /// `(d / d_ref)^(p-1)` at the overlap `d` (m). Continued to `d <= 0`; `None` there if the exponent is not whole.
    fn power(&self, d: S) -> Option<S> {
        let ratio = d / self.overlap_ref;
        Some(match self.whole_exponent() {
            Some(p) => (1..p).fold(S::from(1.0), |power, _| power * ratio),
            None if d.value() <= 0.0 => return None,
            None if self.exponent.value() == 1.5 && self.exponent.tangent() == 0.0 => ratio.sqrt(),
            None => ratio.pow(self.exponent - S::from(1.0)),
        })
    }

    /// Elastic force at the overlap `d`, N; 0 for `d <= 0`.
    pub fn elastic_force(&self, d: S) -> S {
        let power = if d.value() <= 0.0 { None } else { self.power(d) };
        power.map_or(S::default(), |power| self.stiffness * power * d)
    }

    /// Elastic energy at the overlap `d`, J; 0 for `d <= 0`.
    pub fn elastic_energy(&self, d: S) -> S {
        self.elastic_force(d) * d / (self.exponent + S::from(1.0))
    }

    /// Elastic force at the overlap `d` (m), N, and factor of its rate in the law, N.s/m; continued as [`Self::power`].
    fn parts(&self, d: S) -> Option<(S, S)> {
        let secant = self.stiffness * self.power(d)?;
        let by_rate = match self.damping {
            Damping::None => S::default(),
            Damping::KelvinVoigt { c, .. } => c,
            Damping::HuntCrossley { alpha } => alpha * secant * d,
            Damping::Viscoelastic { relaxation } => self.exponent * relaxation * secant,
        };
        Some((secant * d, by_rate))
    }

    /// Force at the overlap `d` (m) and its rate (m/s), not clipped, N; not continued: 0 for `d <= 0`.
    pub fn unclipped_force(&self, d: S, rate: S) -> S {
        let parts = if d.value() <= 0.0 { None } else { self.parts(d) };
        parts.map_or(S::default(), |(elastic, by_rate)| elastic + by_rate * rate)
    }

    /// The exponent as an integer, if it is and stays one: powers are then products.
    pub fn whole_exponent(&self) -> Option<usize> {
        let whole = self.exponent.value() as usize;
        (whole as f64 == self.exponent.value() && self.exponent.tangent() == 0.0).then_some(whole)
    }
}

impl ContactLaw {
    /// A simple expression with the sign of the force, if there is one.
    pub fn sign_of_force(&self) -> Option<SignOfForce> {
        match self.damping {
            Damping::HuntCrossley { alpha } => Some(SignOfForce { constant: 1.0, by_overlap: 0.0, by_rate: alpha }),
            // The force is `F_el (d + p A r) / d`.
            Damping::Viscoelastic { relaxation } => {
                Some(SignOfForce { constant: 0.0, by_overlap: 1.0, by_rate: self.exponent * relaxation })
            }
            Damping::None | Damping::KelvinVoigt { .. } => None,
        }
    }

    /// Whether the law clips its force at zero.
    pub fn clips(&self) -> bool {
        match self.damping {
            Damping::None | Damping::KelvinVoigt { pull: true, .. } => false,
            Damping::KelvinVoigt { .. } | Damping::HuntCrossley { .. } | Damping::Viscoelastic { .. } => true,
        }
    }

    /// Coefficient c of Kelvin and Voigt's laws, `F = F_el + c r`, N.s/m; 0 for the others.
    pub fn damping_coefficient(&self) -> f64 {
        match self.damping {
            Damping::KelvinVoigt { c, .. } => c,
            Damping::None | Damping::HuntCrossley { .. } | Damping::Viscoelastic { .. } => 0.0,
        }
    }

    /// The mode of a closed contact at this overlap (m) and rate (m/s).
    pub fn mode_when_closed(&self, overlap: f64, rate: f64) -> Mode {
        let closed = |overlap: f64| if overlap > 0.0 { overlap } else { f64::MIN_POSITIVE };
        let clipped = match self.sign_of_force() {
            Some(sign) => sign.at(overlap, rate) < 0.0,
            None => self.clips() && self.unclipped_force(closed(overlap), rate) < 0.0,
        };
        if clipped { Mode::Clipped } else { Mode::Pressing }
    }

    /// Coefficient `k` of the power series of the elastic force, from the first `k + 1` of the overlap; `powers` keeps
    /// the intermediate series. Where the overlap vanishes, a fractional power has no series: zero.
    pub fn elastic_coefficient(&self, overlap: &[f64], powers: &mut Vec<f64>, k: usize) -> f64 {
        let (scale, stride) = (1.0 / self.overlap_ref, overlap.len());
        let power = match self.whole_exponent() {
            Some(1) => return self.stiffness * overlap[k],
            Some(p) => {
                // The lower powers, one after the other.
                powers.resize(p * stride, 0.0);
                powers[k] = overlap[k] * scale;
                for q in 1..p {
                    let (base, lower) = (&powers[..stride], &powers[(q - 1) * stride..q * stride]);
                    powers[q * stride + k] = product_term(base, lower, k);
                }
                powers[(p - 1) * stride + k]
            }
            None => {
                powers.resize(stride, 0.0);
                powers[k] = if overlap[0] <= 0.0 {
                    0.0
                } else if k == 0 {
                    self.elastic_force(overlap[0]) / (self.stiffness * self.overlap_ref)
                } else {
                    power_term(overlap, powers, self.exponent, k)
                };
                powers[k]
            }
        };
        self.stiffness * self.overlap_ref * power
    }

    /// One coefficient of the power series of the unclipped force, from those of the elastic force, of the overlap's
    /// rate and, where the law needs it, of the `product` of the two or of `elastic_rate`, the time derivative (N/s).
    pub fn force_coefficient(
        &self,
        elastic: f64,
        rate: f64,
        product: impl FnOnce() -> f64,
        elastic_rate: impl FnOnce() -> f64,
    ) -> f64 {
        match self.damping {
            Damping::None => elastic,
            Damping::KelvinVoigt { c, .. } => elastic + c * rate,
            Damping::HuntCrossley { alpha } => elastic + alpha * product(),
            Damping::Viscoelastic { relaxation } => elastic + relaxation * elastic_rate(),
        }
    }

    /// The coefficients of the elastic force to be computed next for [`Self::force_coefficient`] number `k`: that one
    /// and, for the time derivative, the next.
    pub fn elastic_terms_due(&self, k: usize) -> Range<usize> {
        match self.damping {
            Damping::None | Damping::KelvinVoigt { .. } | Damping::HuntCrossley { .. } => k..k + 1,
            Damping::Viscoelastic { .. } => k + usize::from(k > 0)..k + 2,
        }
    }

    /// Force at the overlap `d` (m) and its rate (m/s), N.
    pub fn force(&self, d: f64, rate: f64) -> f64 {
        let force = self.unclipped_force(d, rate);
        if self.clips() { force.max(0.0) } else { force }
    }

    /// Derivatives of the force by the overlap (N/m) and by its rate (N.s/m); 0 while open or clipped.
    pub fn force_slopes(&self, d: f64, rate: f64) -> (f64, f64) {
        match self.continued(d, rate) {
            Some((force, by_overlap, by_rate)) if d > 0.0 && !(self.clips() && force < 0.0) => (by_overlap, by_rate),
            _ => (0.0, 0.0),
        }
    }

    /// Whether it dissipates nothing.
    pub fn is_elastic(&self) -> bool {
        self.damping == Damping::None
    }

    /// Whether the force is a linear function of the overlap and its rate while the contact presses.
    pub fn is_linear(&self) -> bool {
        self.exponent == 1.0 && matches!(self.damping, Damping::None | Damping::KelvinVoigt { .. })
    }

    /// Mechanical impedance of a linear contact hit by a reduced mass `m` (kg), N.s/m: an upper bound of its largest
    /// force over the rate at which it closes.
    pub fn impedance(&self, m: f64) -> f64 {
        self.damping_coefficient() + (self.stiffness * m).sqrt()
    }

    /// Overlap (m) at which the elastic force is `force` (N, >= 0).
    pub fn static_overlap(&self, force: f64) -> f64 {
        self.overlap_ref * libm::pow(force / (self.stiffness * self.overlap_ref), 1.0 / self.exponent)
    }

    /// Elastic force at the overlap `d` (N) and its derivative (N/m); for `d <= 0` continued if the exponent is whole.
    pub fn elastic_continued(&self, d: f64) -> Option<(f64, f64)> {
        self.power(d).map(|power| (self.stiffness * power * d, self.exponent * self.stiffness * power))
    }

    /// Unclipped force (N) at the overlap `d` (m) and its rate (m/s), with derivatives (N/m, N.s/m), continued as
    /// [`Self::elastic_continued`].
    pub fn continued(&self, d: f64, rate: f64) -> Option<(f64, f64, f64)> {
        let (elastic, slope) = self.elastic_continued(d)?;
        if self.is_elastic() {
            return Some((elastic, slope, 0.0));
        }
        let (_, by_rate) = self.map(Dual::from).parts(Dual::with_tangent(d, 1.0))?;
        let force = Dual::with_tangent(elastic, slope) + by_rate * Dual::from(rate);
        Some((force.value(), force.tangent(), by_rate.value()))
    }
}
