//! The force law of one contact: elastic and damping force.

use super::damping::{Damping, Growth};
use crate::solver::dual::{Dual, Scalar};
use crate::solver::power::{is_whole, power};
use crate::solver::series::PowerSeries;
use serde::{Deserialize, Serialize};

/// How a contact acts.
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
    /// Coefficient of restitution of a rigid contact, 1, 0 to 1.
    pub restitution: S,
}

/// `(d / d_ref)^w + b r`, which has the sign of the force for overlaps d (m) above 0 and rates r (m/s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignOfForce {
    /// Reference overlap d_ref, m.
    overlap_ref: f64,
    /// The exponent w.
    exponent: f64,
    /// The factor b, s/m.
    pub by_rate: f64,
}

impl SignOfForce {
    /// Its value at the overlap `d` (m) and its `rate` (m/s).
    pub fn at(&self, d: f64, rate: f64) -> f64 {
        let by_overlap = match self.exponent {
            0.0 => 1.0,
            1.0 => d / self.overlap_ref,
            exponent => power((d / self.overlap_ref).max(0.0), exponent),
        };
        by_overlap + self.by_rate * rate
    }

    /// Lower bound (0 or more) of its value at rate 0, for any overlap.
    pub fn least(&self) -> f64 {
        if self.exponent == 0.0 { 1.0 } else { 0.0 }
    }

    /// How wrong it may be at the overlap `d` (m) if `d` is known to within `position` (m) and its rate to within
    /// `velocity` (m/s).
    pub fn error_bound(&self, d: f64, position: f64, velocity: f64) -> f64 {
        let slope = match self.exponent {
            0.0 => 0.0,
            1.0 => 1.0,
            exponent => exponent * power(d.max(0.0) / self.overlap_ref, exponent - 1.0),
        };
        slope * position / self.overlap_ref + self.by_rate * velocity
    }

    /// Its power series in time, from those of the overlap (m) and of its rate (m/s); the latter may be shorter.
    /// Fractional powers of a `negligible` overlap are left out.
    pub fn series(&self, overlap: &[f64], rate: &[f64], negligible: bool) -> Vec<f64> {
        let mut powers = PowerSeries::new(self.exponent, 1.0 / self.overlap_ref);
        let left_out = negligible && !is_whole(self.exponent);
        let mut power = |k: usize| if left_out { 0.0 } else { powers.term(overlap, k) };
        rate.iter().enumerate().map(|(k, rate)| power(k) + self.by_rate * rate).collect()
    }
}

impl<S: Scalar> ContactLaw<S> {
    /// The law with every number converted.
    pub fn map<T>(&self, number: impl Fn(S) -> T) -> ContactLaw<T> {
        ContactLaw {
            stiffness: number(self.stiffness),
            overlap_ref: number(self.overlap_ref),
            exponent: number(self.exponent),
            clearance: number(self.clearance),
            pivots: number(self.pivots),
            damping: self.damping.map(&number),
            restitution: number(self.restitution),
        }
    }

    /// `(d / d_ref)^(p-1)` at the overlap `d` (m). For `d <= 0` it is continued if the exponent is whole, else `None`.
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

    /// Elastic force (N) and damping force over rate (N.s/m) at the overlap `d` (m). Continued to `d <= 0`, unless one
    /// of them has a branch point at 0.
    pub fn parts(&self, d: S) -> Option<(S, S)> {
        let power = self.power(d)?;
        let elastic = self.stiffness * power * d;
        if self.damping.coefficient == S::default() {
            return Some((elastic, S::default()));
        }
        let grown = match self.damping.growth {
            Growth::Constant => S::from(1.0),
            Growth::Force => power * d / self.overlap_ref,
            Growth::Stiffness => power,
            Growth::RootOfStiffness => match self.whole_exponent() {
                Some(p) if p % 2 == 1 => (0..p / 2).fold(S::from(1.0), |root, _| root * (d / self.overlap_ref)),
                _ if d.value() <= 0.0 => return None,
                _ => power.sqrt(),
            },
        };
        Some((elastic, self.damping.coefficient * grown))
    }

    /// Exponent s of the overlap in its damping.
    pub fn damping_exponent(&self) -> S {
        self.damping.growth.exponent(self.exponent)
    }

    /// Force before clipping at the overlap `d` (m) and its `rate` (m/s), N; 0 for `d <= 0`.
    pub fn unclipped_force(&self, d: S, rate: S) -> S {
        let parts = if d.value() <= 0.0 { None } else { self.parts(d) };
        parts.map_or(S::default(), |(elastic, by_rate)| elastic + by_rate * rate)
    }

    /// The exponent if it is an integer and has no derivative: powers are then products.
    pub fn whole_exponent(&self) -> Option<usize> {
        let whole = self.exponent.value() as usize;
        (whole as f64 == self.exponent.value() && self.exponent.tangent() == 0.0).then_some(whole)
    }
}

impl ContactLaw {
    /// The force divided by `k d_ref (d / d_ref)^s`, which has the same sign. `None` without damping and for a dashpot:
    /// there the force itself is as simple.
    pub fn sign_of_force(&self) -> Option<SignOfForce> {
        if self.is_elastic() || self.has_dashpot() {
            return None;
        }
        Some(SignOfForce {
            overlap_ref: self.overlap_ref,
            exponent: self.exponent - self.damping_exponent(),
            by_rate: self.damping.coefficient / (self.stiffness * self.overlap_ref),
        })
    }

    /// Whether the law clips its force at zero.
    pub fn clips(&self) -> bool {
        self.damping.clipped && !self.is_elastic()
    }

    /// Whether the damping is a dashpot's, `F = F_el + c r`.
    pub fn has_dashpot(&self) -> bool {
        self.damping_exponent() == 0.0
    }

    /// Coefficient c of the dashpot, N.s/m; 0 without a dashpot.
    pub fn damping_coefficient(&self) -> f64 {
        if self.has_dashpot() { self.damping.coefficient } else { 0.0 }
    }

    /// Those exponents of the overlap in the force that are not whole: with one, the force has a branch point at 0.
    pub fn branch_exponents(&self) -> impl Iterator<Item = f64> + Clone {
        let of_damping = if self.is_elastic() { 0.0 } else { self.damping_exponent() };
        [self.exponent, of_damping].into_iter().filter(|exponent| !is_whole(*exponent))
    }

    /// Whether the force is a smooth function of overlap and rate at overlap 0.
    pub fn is_smooth(&self) -> bool {
        self.branch_exponents().next().is_none()
    }

    /// Mode of a closed contact at this overlap (m) and rate (m/s).
    pub fn mode_when_closed(&self, overlap: f64, rate: f64) -> Mode {
        let closed = |overlap: f64| if overlap > 0.0 { overlap } else { f64::MIN_POSITIVE };
        let clipped = match self.sign_of_force() {
            Some(sign) => sign.at(overlap, rate) < 0.0,
            None => self.clips() && self.unclipped_force(closed(overlap), rate) < 0.0,
        };
        if clipped { Mode::Clipped } else { Mode::Pressing }
    }

    /// What the power series of the force consist of, as factors and powers: the elastic force `k d_ref (d / d_ref)^p`,
    /// and the impulse of the damping, `C d_ref / (s+1) (d / d_ref)^(s+1)`, whose rate is the damping force. If the
    /// overlap is `negligible`, only the part of a dashpot.
    pub fn force_series(&self, negligible: bool) -> [Option<(f64, PowerSeries)>; 2] {
        let scale = 1.0 / self.overlap_ref;
        let grown = self.damping_exponent() + 1.0;
        let elastic = (self.stiffness * self.overlap_ref, PowerSeries::new(self.exponent, scale));
        let damping = (self.damping.coefficient * self.overlap_ref / grown, PowerSeries::new(grown, scale));
        let damps = !self.is_elastic() && (!negligible || self.has_dashpot());
        [(!negligible).then_some(elastic), damps.then_some(damping)]
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
        self.damping.coefficient == 0.0
    }

    /// Whether the force is a linear function of the overlap and its rate while the contact presses.
    pub fn is_linear(&self) -> bool {
        self.exponent == 1.0 && (self.is_elastic() || self.has_dashpot())
    }

    /// Mechanical impedance of a linear contact for a reduced mass `m` (kg), N.s/m: an upper bound of the largest force
    /// over the closing rate.
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

    /// Unclipped force (N) at the overlap `d` (m) and its rate (m/s), with its derivatives by both (N/m, N.s/m),
    /// continued like [`Self::parts`].
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
