//! Where forces are not smooth: at overlap 0, if they go with fractional powers of the overlap.

use crate::model::ContactLaw;
use crate::solver::Power;

/// See [`BranchPoint::smoothness`]; guarded by `touching_rows_keep_their_energy_from_awkward_starts` and
/// `rattling_balls_keep_their_energy_at_all_times`.
const LEAST_SMOOTHNESS: f64 = 0.01;
const FRACTIONAL: f64 = 0.3;

/// A branch point of the forces at overlap 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BranchPoint {
    /// The power by which time is stretched there.
    pub power: Power,
    /// Allowed size of the highest Legendre coefficients over that for smooth forces. If a force is a fractional power
    /// of `c` for any stretching, its coefficients fall slowly and the end of the step is less exact; most of all with
    /// a damping force that starts with a power below 1.
    pub smoothness: f64,
}

impl BranchPoint {
    /// The branch point of contacts with these laws, which have one exponent and one damping law; some may be elastic.
    pub fn of<'a>(laws: impl Iterator<Item = &'a ContactLaw> + Clone) -> Option<Self> {
        laws.clone().find(|law| !law.is_elastic()).or(laws.clone().next()).and_then(Self::new)
    }

    /// The branch point of this law. With `c^q`, a force that goes with `d^e`, times the pace of the time, goes with
    /// `c^(q e + q - 1)`: a polynomial if that exponent is whole, nearly one if it is large. Higher powers than
    /// necessary shorten the steps; whole exponents need none.
    fn new(law: &ContactLaw) -> Option<Self> {
        let exponents = law.branch_exponents();
        let least = exponents.clone().reduce(f64::min)?;
        // Fourth powers pay only for the roughest forces.
        let powers = if least < 1.0 { &Power::ALL[..] } else { &[Power::Square, Power::Cube] };
        if let Some(power) = powers.iter().copied().find(|power| power.resolves(exponents.clone())) {
            return Some(Self { power, smoothness: 1.0 });
        }
        let power = if least > 2.0 { Power::Square } else { Power::Cube };
        Some(Self { power, smoothness: if least < 1.0 { LEAST_SMOOTHNESS } else { FRACTIONAL } })
    }
}

/// The power by which time is stretched where a contact with this law opens or closes.
pub(crate) fn power_of_stretching(law: &ContactLaw) -> Option<Power> {
    BranchPoint::new(law).map(|branch_point| branch_point.power)
}
