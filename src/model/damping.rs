//! The damping laws of contacts, with their coefficients. [`contact`](super::contact) computes the forces.

use super::parameters::{DampingLaw, Parameters};
use crate::solver::dual::Scalar;

/// Damping of a contact, with its coefficient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Damping<S = f64> {
    /// Elastic contact.
    None,
    /// Adds `c` times the rate of the overlap.
    KelvinVoigt {
        /// Damping, N.s/m, >= 0.
        c: S,
        /// Whether the total may be negative.
        pull: bool,
    },
    /// Multiplies the elastic force by `1 + alpha` times the rate of the overlap; never negative.
    HuntCrossley {
        /// Factor, s/m, >= 0.
        alpha: S,
    },
    /// Adds A times the rate of the elastic force, `A dF_el/dt`; never negative.
    Viscoelastic {
        /// Relaxation time A, s, >= 0.
        relaxation: S,
    },
}

/// `constant + by_overlap d + by_rate r` has the sign of a force for every overlap d (m) above 0 and rate r (m/s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignOfForce {
    /// Without a unit.
    pub constant: f64,
    /// 1/m.
    pub by_overlap: f64,
    /// s/m.
    pub by_rate: f64,
}

impl SignOfForce {
    /// At the overlap `d` (m) and its rate (m/s).
    pub fn at(&self, d: f64, rate: f64) -> f64 {
        self.constant + self.by_overlap * d + self.by_rate * rate
    }

    /// As a power series of the time, from those of the overlap (m) and of its rate (m/s), which may be shorter.
    pub fn series(&self, overlap: &[f64], rate: &[f64]) -> Vec<f64> {
        let terms = overlap.iter().zip(rate).map(|(d, rate)| self.by_overlap * *d + self.by_rate * *rate);
        let mut series: Vec<f64> = terms.collect();
        series[0] += self.constant;
        series
    }
}

impl<S: Scalar> Damping<S> {
    /// The law that `p` selects, with coefficients by `number`. A coefficient that is and stays 0 means no damping.
    pub fn selected(p: &Parameters, number: impl Fn(fn(&Parameters) -> f64) -> S) -> Self {
        let (c, alpha, relaxation) =
            (number(|p| p.damping), number(|p| p.hunt_crossley), number(|p| p.relaxation_time));
        let (coefficient, law) = match p.damping_law {
            DampingLaw::KelvinVoigt => (c, Self::KelvinVoigt { c, pull: true }),
            DampingLaw::KelvinVoigtNoPull => (c, Self::KelvinVoigt { c, pull: false }),
            DampingLaw::HuntCrossley => (alpha, Self::HuntCrossley { alpha }),
            DampingLaw::Viscoelastic => (relaxation, Self::Viscoelastic { relaxation }),
        };
        if coefficient.value() > 0.0 || coefficient.tangent() != 0.0 { law } else { Self::None }
    }

    /// The same law in other numbers.
    pub fn map<T>(&self, number: impl Fn(S) -> T) -> Damping<T> {
        match *self {
            Self::None => Damping::None,
            Self::KelvinVoigt { c, pull } => Damping::KelvinVoigt { c: number(c), pull },
            Self::HuntCrossley { alpha } => Damping::HuntCrossley { alpha: number(alpha) },
            Self::Viscoelastic { relaxation } => Damping::Viscoelastic { relaxation: number(relaxation) },
        }
    }
}
