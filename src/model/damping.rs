//! The damping laws of contacts. Each adds `C (d / d_ref)^s r` to the elastic force `k d (d / d_ref)^(p-1)`, for an
//! overlap d > 0 and its rate r. [`contact`](super::contact) and [`forces`](super::forces) compute the forces.
//!
//! # A new law
//!
//! A damping law of this form needs a variant of [`DampingLaw`], with arms in [`Parameters::contacts_lose`] and
//! [`Damping::selected`]; C = 0 means no damping. A new exponent s is a variant of [`Growth`]: the compiler then asks
//! for arms in `contact.rs` and `forces.rs`. A new coefficient is one more parameter, whose name goes into
//! `LOSS_PARAMETERS` of the table of variables. The methods use these functions of a
//! [`ContactLaw`](super::ContactLaw):
//!
//! - outputs, `bdf`, `adams` and `rk4`: `force`; `bdf` and peaks also `force_slopes`;
//! - series and derivatives by time: `force_series`, `unclipped_force`, `sign_of_force`, `damping_coefficient`, and, to
//!   an order of magnitude, `relaxation_time` and `largest_negligible_overlap`;
//! - Gauss collocation: `unclipped_forces`, `damping_forces`, `sign_of_force`, `branch_exponents` and `relaxes_within`;
//!   at the start of a step `unclipped_force` and `force_slopes`;
//! - implicit collocation: `continued`; where it is `None`, only steps that stay at d > 0 succeed;
//! - natural modes: `is_linear` and `damping_coefficient`; the impact of two: `is_elastic`;
//! - events: `mode_when_closed` and `clips`.
//!
//! Clipping follows from `sign_of_force`, `(d / d_ref)^(p-s) + b r`, because rounding may change the sign of the
//! computed force where the elastic force almost vanishes.
//!
//! A new elastic law needs arms in `elastic_force`, `elastic_energy`, `elastic_continued`, `power`, `force_series`,
//! `unclipped_forces`, `whole_exponent`, `branch_exponents`, `static_overlap` (finite even where nothing balances the
//! force, because scales of velocities follow from it) and `largest_overlap` (to a few digits). Under a power law the
//! deepest contact is the stiffest, and many scales rest on that. The following places assume a power law; each needs
//! an arm for the new law or must refuse it:
//!
//! - `is_linear`, [`Damping::selected`], `sign_of_force` and `damping_for`; `largest_negligible_overlap` and
//!   `relaxation_time`, which use inverse powers; `relaxes_within`, which takes force times overlap as p + 1 times
//!   the energy;
//! - `PairImpact::new` and `along_arcs`, which ask only whether the law is elastic; `law_derivatives` of the tape;
//! - Gauss collocation, for which a step that suits the largest overlap suits all smaller ones. A slope that changes
//!   within much less than the largest overlap needs a limit where a step is planned (`Planner::new`) and one at its
//!   nodes (`conclude` returns `TooLong`), or all nodes may lie beyond the change. `SENSITIVITY` and the forecasts of
//!   `plan.rs` use the exponent;
//! - `Cluster::describe`: by implicit collocation, undamped contacts that ring by a small part of the largest speed
//!   lose 1e-10 of the energy;
//! - `Dynamics::new`, whose scale of overlaps is `largest_overlap`: `adams` and `bdf` may lose two digits.

use super::parameters::{DampingLaw, Parameters};
use crate::solver::dual::Scalar;

/// Damping of a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Damping<S = f64> {
    /// Factor C of the rate at the overlap d_ref, N.s/m, >= 0; 0 if the contact is elastic.
    pub coefficient: S,
    /// How damping grows with the overlap: the exponent s.
    pub growth: Growth,
    /// Whether the total force is clipped at 0.
    pub clipped: bool,
}

/// How damping grows with the overlap: the exponent s, for a contact with the exponent p.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Growth {
    /// `s = 0`.
    #[default]
    Constant,
    /// Like the elastic force: `s = p`.
    Force,
    /// Like the stiffness of the contact: `s = p - 1`.
    Stiffness,
    /// Like the root of the stiffness: `s = (p - 1) / 2`.
    RootOfStiffness,
}

impl Growth {
    /// The exponent s for the exponent `p`.
    pub fn exponent<S: Scalar>(self, p: S) -> S {
        match self {
            Self::Constant => S::default(),
            Self::Force => p,
            Self::Stiffness => p - S::from(1.0),
            Self::RootOfStiffness => S::from(0.5) * (p - S::from(1.0)),
        }
    }
}

/// What a damping law may depend on besides its own parameter: the elastic law of a contact and the balls.
pub struct Elastic<S> {
    /// Secant stiffness k at the overlap `overlap_ref`, N/m.
    pub stiffness: S,
    /// Reference overlap d_ref, m.
    pub overlap_ref: S,
    /// Exponent p.
    pub exponent: S,
    /// Reduced mass of the two balls, kg.
    pub reduced_mass: S,
}

impl<S: Scalar> Damping<S> {
    /// The law that `p` selects. `number` reads its parameter; `loss_ratio` multiplies the losses, or is the exponent
    /// of e.
    pub fn selected(
        p: &Parameters,
        number: impl Fn(fn(&Parameters) -> f64) -> S,
        elastic: &Elastic<S>,
        loss_ratio: S,
    ) -> Self {
        let Elastic { stiffness, overlap_ref, exponent, reduced_mass } = *elastic;
        let (coefficient, growth) = match p.damping_law {
            DampingLaw::KelvinVoigt | DampingLaw::KelvinVoigtNoPull => {
                (loss_ratio * number(|p| p.damping), Growth::Constant)
            }
            DampingLaw::HuntCrossley => {
                (loss_ratio * number(|p| p.hunt_crossley) * stiffness * overlap_ref, Growth::Force)
            }
            DampingLaw::Viscoelastic => {
                (loss_ratio * number(|p| p.relaxation_time) * exponent * stiffness, Growth::Stiffness)
            }
            DampingLaw::ConstantRestitution => {
                let ratio = damping_ratio(half_decrement(number(|p| p.restitution), loss_ratio));
                let critical = (S::from(2.0) * (exponent + S::from(1.0)) * stiffness * reduced_mass).sqrt();
                (ratio * critical, Growth::RootOfStiffness)
            }
        };
        Self { coefficient, growth, clipped: p.damping_law != DampingLaw::KelvinVoigt }
    }

    /// The law with every number converted.
    pub fn map<T>(&self, number: impl Fn(S) -> T) -> Damping<T> {
        Damping { coefficient: number(self.coefficient), growth: self.growth, clipped: self.clipped }
    }
}

/// Half the logarithmic decrement of an impact, `-log(e^q) / 2`, for a coefficient of restitution e from 0 to 1 and a
/// loss ratio q; 0 for q = 0.
fn half_decrement<S: Scalar>(restitution: S, loss_ratio: S) -> S {
    let (e, q) = (restitution.value(), loss_ratio.value());
    let product = |a: f64, b: f64| if a == 0.0 { 0.0 } else { a * b };
    let log = libm::log(e);
    let change = product(loss_ratio.tangent(), log) + product(restitution.tangent(), product(q, 1.0 / e));
    S::with_tangent(-0.5 * product(q, log), -0.5 * change)
}

/// Damping ratio zeta of a contact of [`Growth::RootOfStiffness`] for which two balls alone collide with the
/// coefficient of restitution `exp(-2 h)`, h >= 0.
///
/// With `z = d^((p+1)/2)` and `d tau = d^((p-1)/2) dt` the overlap is a damped linear oscillator, released where its
/// force vanishes: `zeta = cos(beta)` with `beta cot(beta) = h`, or beyond `h = 1` `zeta = cosh(b)` with
/// `b coth(b) = h` (for p = 1: Schwager and Poeschel, Granular Matter 9, 2007, 465).
fn damping_ratio<S: Scalar>(h: S) -> S {
    let (h, tangent) = (h.value(), h.tangent());
    if h == f64::INFINITY {
        return S::with_tangent(h, tangent);
    }
    // `y` is `beta^2` or `-b^2`.
    let (zeta, slope, y) = if h < 1.0 {
        // In terms of the cotangent t of beta.
        let beta_at = |t: f64| libm::atan2(1.0, t);
        let slope_at = |t: f64| beta_at(t) - t / (1.0 + t * t);
        let t = monotonically(0.0, |t| (h - t * beta_at(t)) / slope_at(t));
        let inverse_sine = (1.0 + t * t).sqrt();
        (t / inverse_sine, 1.0 / (inverse_sine * inverse_sine * inverse_sine * slope_at(t)), beta_at(t) * beta_at(t))
    } else {
        let slope_at = |b: f64| 1.0 / libm::tanh(b) - b / (libm::sinh(b) * libm::sinh(b));
        let b = monotonically(h, |b| (h - b / libm::tanh(b)) / slope_at(b));
        (libm::cosh(b), libm::sinh(b) / slope_at(b), -b * b)
    };
    // Near critical damping: the power series in y of both derivatives by y.
    let slope = if y.abs() < 0.01 {
        let of_zeta = 0.5 - y * (1.0 / 12.0 - y * (1.0 / 240.0 - y / 10080.0));
        of_zeta / (1.0 / 3.0 + y * (2.0 / 45.0 + y * (2.0 / 315.0 + y * (4.0 / 4725.0 + y * 2.0 / 18711.0))))
    } else {
        slope
    };
    S::with_tangent(zeta, if tangent == 0.0 { 0.0 } else { slope * tangent })
}

/// A root by Newton's method, from a side from which steps never overshoot it. Ends when a step goes back or vanishes.
fn monotonically(start: f64, step: impl Fn(f64) -> f64) -> f64 {
    let (mut at, first) = (start, step(start));
    let mut change = first;
    while change * first > 0.0 && at + change != at {
        at += change;
        change = step(at);
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::Dual;

    /// Checks the ratio against its equation, and its derivative against differences.
    #[test]
    fn damping_ratios_give_their_restitution() {
        for h in [0.0, 1e-12, 5e-4, 0.05, 0.3, 0.9, 0.999, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.01, 2.0, 30.0, 300.0] {
            let found = damping_ratio(Dual::with_tangent(h, 1.0));
            let zeta = found.value();
            let root = ((zeta - 1.0).abs() * (zeta + 1.0)).sqrt();
            let angle = if zeta < 1.0 { libm::atan2(root, zeta) } else { libm::log1p(zeta - 1.0 + root) };
            let back = if root > 0.0 { zeta * angle / root } else { 1.0 };
            assert!((back - h).abs() <= 1e-15 * (1.0 + h), "h = {h}: {zeta}, {back}");
            let step = 1e-5 * (h + 1.0).min(1.0);
            let around = [h + step, (h - step).max(0.0)];
            let [more, less] = around.map(damping_ratio);
            let difference = (more - less) / (around[0] - around[1]);
            if h > 1e-3 {
                assert!((found.tangent() / difference - 1.0).abs() < 1e-8, "h = {h}: {found:?}, {difference}");
            }
        }
        assert_eq!(damping_ratio(half_decrement(1.0, 1.0)), 0.0);
        assert_eq!(damping_ratio(half_decrement(0.0, 0.0)), 0.0);
        assert_eq!(damping_ratio(half_decrement(0.0, 1.0)), f64::INFINITY);
    }
}
