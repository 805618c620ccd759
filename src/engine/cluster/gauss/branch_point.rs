//! Where forces are not smooth: at an overlap of 0, if they go with fractional powers of it.

use crate::model::ContactLaw;
use crate::solver::Power;

/// See [`BranchPoint::smoothness`]; guarded by `awkward_starts_keep_their_energy` and
/// `balls_that_rattle_keep_their_energy_at_all_times`.
const ROUGH: f64 = 0.01;
const FRACTIONAL: f64 = 0.3;

/// Where forces have a branch point at an overlap of 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BranchPoint {
    /// The power by which time is stretched there.
    pub power: Power,
    /// Allowed size of the highest Legendre coefficients over that for smooth forces. A force that is a fractional power
    /// of `c` for any stretching has coefficients that fall slowly, and the end of the step is less exact; most of all a
    /// damping force that starts with a power below 1.
    pub smoothness: f64,
}

impl BranchPoint {
    /// That of contacts with these laws, which have one exponent and one law of damping, but some may be elastic.
    pub fn of<'a>(laws: impl Iterator<Item = &'a ContactLaw> + Clone) -> Option<Self> {
        laws.clone().find(|law| !law.is_elastic()).or(laws.clone().next()).and_then(Self::new)
    }

    /// That of contacts with this law. With `c^q`, a force that goes with `d^e` goes, times the pace of the time, with
    /// `c^(q e + q - 1)`: a polynomial if that is whole, nearly one if it is large. Higher powers than necessary shorten
    /// the steps; whole exponents need none.
    fn new(law: &ContactLaw) -> Option<Self> {
        let exponents = law.branch_exponents();
        let least = exponents.clone().reduce(f64::min)?;
        // Fourth powers pay only for the roughest forces.
        let powers = if least < 1.0 { &Power::ALL[..] } else { &[Power::Square, Power::Cube] };
        if let Some(power) = powers.iter().copied().find(|power| power.resolves(exponents.clone())) {
            return Some(Self { power, smoothness: 1.0 });
        }
        let power = if least > 2.0 { Power::Square } else { Power::Cube };
        Some(Self { power, smoothness: if least < 1.0 { ROUGH } else { FRACTIONAL } })
    }
}

/// The power by which time is stretched where a contact with this law opens or closes.
pub(crate) fn power_of_stretching(law: &ContactLaw) -> Option<Power> {
    BranchPoint::new(law).map(|branch_point| branch_point.power)
}
