//! The outcome of an elastic impact of two balls, in closed form: see "The impact of two" in docs/theory.md.

use std::cell::OnceCell;
use std::f64::consts::PI;
use std::sync::{Arc, OnceLock};

use serde::{Deserialize, Serialize};

use crate::engine::Peak;
use crate::engine::arc_impact::{ImpactResult, ImpactShape, outcome};
use crate::engine::cluster::{Cluster, power_of_stretching};
use crate::engine::flight::{Ball, Flight, RunningIntegrals, degree, integrals_of_inputs};
use crate::model::{ContactLaw, Cradle};
use crate::solver::{DoubleDouble, Dual, Scalar, hypotenuse};

/// Number of terms of the expansion, and the largest `alpha + |beta|` for which its error is below rounding.
const TERMS: usize = 7;
const EXPANSION_LIMIT: f64 = 1e-3;

/// Coefficients of `beta^(k-j) alpha^j` in an expansion.
type Expansion<S = f64> = [[S; TERMS]; TERMS];

/// Coefficients of the expansions for one exponent of the force law, each computed on first use.
#[derive(Clone, Debug, Default)]
pub(crate) struct ImpactCoefficients {
    p: f64,
    /// Of the integrals of `dq / sqrt(...)` and of `q dq / sqrt(...)`.
    integrals: OnceLock<Box<[Expansion; 2]>>,
    /// Coefficients for derivatives.
    derivatives: OnceLock<Box<PulseCoefficients>>,
    /// Coefficients for balls on arcs.
    shape: OnceLock<Box<ImpactShape>>,
}

/// Derivatives of the first two expansions by the exponent p, and expansions of the integrals of `q^g sqrt(...) dq` for
/// g = 0 and for the exponent s of the damping.
#[derive(Clone, Debug)]
struct PulseCoefficients {
    by_exponent: [Expansion; 2],
    works: [Expansion; 2],
}

/// A dimensionless impact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PulseShape {
    /// The integrals of `dq / sqrt(...)` and of `q dq / sqrt(...)`, and their derivatives by alpha, beta and p.
    pub integrals: [[f64; 4]; 2],
    /// The integrals of `q^g sqrt(...) dq` for g = 0 and for the exponent s of the damping.
    pub works: [f64; 2],
}

impl ImpactCoefficients {
    /// Coefficients for the contacts of a cradle, which have one exponent.
    pub fn of(cradle: &Cradle) -> Arc<Self> {
        Arc::new(Self::new(cradle.contacts.first().map_or(1.0, |law| law.exponent)))
    }

    /// Coefficients for the exponent `p` of the force law.
    pub fn new(p: f64) -> Self {
        Self { p, ..Self::default() }
    }

    fn integrals(&self) -> &[Expansion; 2] {
        self.integrals.get_or_init(|| Box::new([0.0, 1.0].map(|g| coefficients(self.p, g, -0.5))))
    }

    /// The dimensionless impact by this law; `None` where its expansion does not hold.
    pub fn pulse(&self, law: &ContactLaw, alpha: f64, beta: f64) -> Option<PulseShape> {
        let (p, damping) = (law.exponent, law.damping_exponent());
        let expands = alpha + beta.abs() < EXPANSION_LIMIT;
        if !expands {
            return None; // Also if they are NaN.
        }
        let derivatives = self.derivatives.get_or_init(|| {
            let by_exponent = |g: f64| {
                let along: Expansion<Dual> = coefficients(Dual::with_tangent(p, 1.0), g.into(), -0.5);
                along.map(|row| row.map(Dual::tangent))
            };
            let works = [0.0, damping].map(|g| coefficients(p, g, 0.5));
            Box::new(PulseCoefficients { by_exponent: [0.0, 1.0].map(by_exponent), works })
        });
        let number = Dual::with_tangent;
        let integral = |of: usize| {
            let (table, by_exponent) = (&self.integrals()[of], &derivatives.by_exponent[of]);
            let by_alpha = expansion(table, number(alpha, 1.0), beta.into());
            let by_beta = expansion(table, alpha.into(), number(beta, 1.0)).tangent();
            [by_alpha.value(), by_alpha.tangent(), by_beta, expansion(by_exponent, alpha, beta)]
        };
        let works = derivatives.works.each_ref().map(|table| expansion(table, alpha, beta));
        Some(PulseShape { integrals: [0, 1].map(integral), works })
    }

    /// Solves the overlap's motion `d'' = -omega2 d - load - F(d) / mass` from `d = 0`, `d' = rate` to its return to 0.
    /// Returns its duration (s), largest overlap (m) and integral (m.s).
    fn compression(&self, law: &ContactLaw, omega2: f64, mass: f64, rate: f64, load: f64) -> Option<[f64; 3]> {
        if law.whole_exponent() == Some(1) {
            let frequency2 = omega2 + law.stiffness / mass;
            let frequency = frequency2.sqrt();
            let duration = 2.0 / frequency * libm::atan2(rate * frequency, load);
            let (offset, amplitude) = (load / frequency2, rate / frequency);
            let radius = hypotenuse(offset * offset + amplitude * amplitude, offset, amplitude);
            // The difference of radius and offset without cancellation.
            let peak_overlap = if offset > 0.0 { amplitude * amplitude / (radius + offset) } else { radius - offset };
            let overlap_integral = (2.0 * rate - load * duration) / frequency2;
            return Some([duration, peak_overlap, overlap_integral]);
        }
        let (p, reach) = (law.exponent, law.largest_overlap(mass, rate));
        let (alpha, beta) = (omega2 * reach * reach / (rate * rate), 2.0 * load * reach / (rate * rate));
        let expands = alpha + beta.abs() < EXPANSION_LIMIT;
        if !expands {
            return None; // Also if they are NaN.
        }
        // At the peak 1 = q^(p+1) + alpha q^2 + beta q: Newton's method from the first-order root.
        let mut q = 1.0 - (alpha + beta) / (p + 1.0);
        for _ in 0..if alpha + beta.abs() > 1e-8 { 3 } else { 0 } {
            let power = libm::pow(q, p);
            q -= (q * (power + alpha * q + beta) - 1.0) / ((p + 1.0) * power + 2.0 * alpha * q + beta);
        }
        let [time, overlap] = self.integrals();
        let duration = 2.0 * reach / rate * expansion(time, alpha, beta);
        let overlap_integral = 2.0 * reach * reach / rate * expansion(overlap, alpha, beta);
        Some([duration, reach * q, overlap_integral])
    }
}

/// Euler's beta function B(s, r + 1), for r = -1/2 or 1/2.
fn beta_function<S: Scalar>(share: S, r: f64) -> S {
    let (s, root) = (share.value(), PI.sqrt());
    let value = root * libm::tgamma(s) / libm::tgamma(s + 0.5);
    let mut found = S::with_tangent(value, 0.0);
    if share.tangent() != 0.0 {
        // The small difference of the digamma functions at s + 1/2 and s: by recursion up to s + 16, from there on by
        // its asymptotic series.
        let steps = (0..16).map(|k| 0.5 / ((s + f64::from(k)) * (s + f64::from(k) + 0.5))).sum::<f64>();
        let inverse = 1.0 / (s + 16.0);
        let square = inverse * inverse;
        let series = 0.5 + inverse * (0.125 - square * (1.0 / 64.0 - square * (1.0 / 128.0 - square * 17.0 / 2048.0)));
        found = S::with_tangent(value, -value * (steps + inverse * series) * share.tangent());
    }
    if r < 0.0 { found } else { found * S::from(0.5) / (share + S::from(0.5)) }
}

/// Coefficients of the expansion of the integral of `q^g (1 - P)^r`, r = -1/2 or 1/2, with `P = q^(p+1) + P_1` and
/// `P_1 = beta q + alpha q^2`.
///
/// With the energy E over that at the onset, the integral is the sum over k of `(-1)^k / k! (d/dE)^k` of the integral
/// of `q^g P_1^k (E - q^(p+1))^r` at E = 1. The integral of `q^m (E - q^(p+1))^r` is `E^(s + r) B(s, r + 1) / (p+1)`
/// with `s = (m+1) / (p+1)` and Euler's beta function B.
fn coefficients<S: Scalar>(p: S, g: S, r: f64) -> Expansion<S> {
    let mut table = [[S::default(); TERMS]; TERMS];
    let (one, number) = (S::from(1.0), |k: usize| S::from(k as f64));
    for (k, row) in table.iter_mut().enumerate() {
        let mut binomial = 1.0;
        for (j, coefficient) in row[..=k].iter_mut().enumerate() {
            let share = (number(k + j) + g + one) / (p + one);
            let beta_function = beta_function(share, r) / (p + one);
            let derivatives =
                (0..k).fold(one, |product, i| product * (share + S::from(r) - number(i)) / -number(i + 1));
            *coefficient = S::from(binomial) * beta_function * derivatives;
            binomial *= (k - j) as f64 / (j + 1) as f64;
        }
    }
    table
}

/// Sums the expansion until the rest is below rounding. Single terms may be 0 before that (for p = 3 the first in
/// beta).
fn expansion<S: Scalar>(table: &Expansion, alpha: S, beta: S) -> S {
    let (mut sum, mut size) = (S::default(), 1.0);
    for (k, row) in table.iter().enumerate() {
        // beta^k (row_0 + row_1 alpha/beta + ...) without the division.
        let (mut term, mut alpha_power) = (S::default(), S::from(1.0));
        for (j, c) in row[..=k].iter().enumerate() {
            term += S::from(*c) * alpha_power * (j..k).fold(S::from(1.0), |power, _| power * beta);
            alpha_power = alpha_power * alpha;
        }
        sum += term;
        size *= alpha.value() + beta.value().abs();
        // The linear terms may be 0 and still have derivatives.
        if k > 0 && size < 1e-18 {
            break;
        }
    }
    sum
}

/// An impact under way whose outcome is known.
///
/// A saved state holds only its contact; the rest is computed again.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct PairImpact {
    pub contact: usize,
    #[serde(skip)]
    pub start: DoubleDouble,
    #[serde(skip)]
    pub outcome: ImpactResult,
    /// Running integrals of the left and the right ball.
    #[serde(skip)]
    pub integrals: [RunningIntegrals; 2],
    /// Segments of its motion, computed on first use.
    #[serde(skip)]
    pub interior: OnceCell<Vec<Interior>>,
}

#[derive(Clone, Debug)]
pub(crate) struct Interior {
    pub segment: Cluster,
    /// Sums over the segments before: the impulse of the contact, N.s, and the integrals of the two balls.
    pub impulse: f64,
    pub integrals: [RunningIntegrals; 2],
}

impl Interior {
    pub fn since(&self, t: DoubleDouble) -> f64 {
        (t - self.segment.start).value().max(0.0)
    }
}

impl PairImpact {
    /// The impact in `contact` of two balls in flight, anchored at its start with overlap 0; `None` if it has no closed
    /// form.
    pub fn new(
        contact: usize,
        [left, right]: [&Ball; 2],
        law: &ContactLaw,
        coefficients: &ImpactCoefficients,
    ) -> Option<Self> {
        if left.model.on_arc {
            return Self::along_arcs(contact, [left, right], law, coefficients);
        }
        let (l, r, o) = (&left.flight, &right.flight, &left.oscillator);
        let simple = law.is_elastic() && o.gamma() == 0.0 && left.oscillator == right.oscillator;
        let rate = l.v - r.v;
        if !simple || rate <= 0.0 || degree(&l.forcing) + degree(&r.forcing) > 0 {
            return None;
        }
        let total = left.model.mass + right.model.mass;
        let (left_share, right_share) = (left.model.mass / total, right.model.mass / total);
        let reduced = left.model.mass * right_share;
        let load = o.omega2() * law.clearance - (l.forcing[0] - r.forcing[0]);
        let [t, peak_overlap, overlap_integral] = coefficients.compression(law, o.omega2(), reduced, rate, load)?;
        if !(t.is_finite() && t > 0.0) {
            return None; // Beyond the range of doubles.
        }
        let centre = centre_of_mass([l, r], [left_share, right_share]);
        let u: [f64; 4] = o.basis(t.into());
        let displacement = centre.displacement(o, &u);
        // A difference of velocities would lose the effect of gravity in a microsecond to rounding.
        let speed_up = (centre.forcing[0] - o.omega2() * centre.x) * u[1] - o.omega2() * centre.v * u[2];
        let velocities = if left.model.mass == right.model.mass {
            [r.v + speed_up, l.v + speed_up]
        } else {
            [l.v - 2.0 * right_share * rate + speed_up, r.v + 2.0 * left_share * rate + speed_up]
        };
        let common = centre.displacement_integral(o, &u);
        let integrals = |ball: &Ball, of_overlap: f64| RunningIntegrals {
            support: (o.omega2() * (ball.flight.x * t + common + of_overlap * overlap_integral)).into(),
            drag_loss: 0.0,
            work: ball.model.mass * ball.flight.forcing[0] * displacement,
        };
        let outcome = ImpactResult {
            duration: t,
            displacements: [displacement; 2],
            velocities,
            impulse: reduced * (2.0 * rate - load * t - o.omega2() * overlap_integral),
            // Without losses the way back takes as long.
            peak: Peak { force: law.elastic_force(peak_overlap), time: 0.5 * t },
        };
        let integrals = [integrals(left, right_share), integrals(right, -left_share)];
        Some(Self { contact, start: left.anchor, outcome, integrals, interior: OnceCell::new() })
    }

    #[inline(never)] // for the same reason as `Ball::piece`
    fn along_arcs(
        contact: usize,
        balls: [&Ball; 2],
        law: &ContactLaw,
        coefficients: &ImpactCoefficients,
    ) -> Option<Self> {
        let (models, flights) = (balls.map(|ball| ball.model), balls.map(|ball| &ball.flight));
        let steady = |k: usize| models[k].gamma == 0.0 && degree(&flights[k].forcing) == 0;
        if !(law.is_elastic() && law.exponent <= ImpactShape::HIGHEST && steady(0) && steady(1)) {
            return None;
        }
        let shape =
            coefficients.shape.get_or_init(|| Box::new(ImpactShape::new(law.exponent, power_of_stretching(law))));
        let outcome = outcome(&models, flights, law, shape)?;
        let ImpactResult { duration, displacements, .. } = outcome;
        let integrals = [0, 1].map(|k| integrals_of_inputs(&models[k], flights[k], duration, &|_| displacements[k]));
        Some(Self { contact, start: balls[0].anchor, outcome, integrals, interior: OnceCell::new() })
    }

    pub fn end(&self) -> DoubleDouble {
        self.start + self.outcome.duration
    }

    /// An upper bound (m) of the outward displacement of a ball `tau` (s) after the start by the contact alone. The
    /// contact pushes outwards, so the ball lags behind the chord.
    pub fn chord(&self, ball: usize, tau: f64) -> f64 {
        if tau < self.outcome.duration {
            self.outcome.displacements[ball] * tau / self.outcome.duration
        } else {
            self.outcome.displacements[ball] + self.outcome.velocities[ball] * (tau - self.outcome.duration)
        }
    }
}

/// The flight of the centre of mass of two balls, with these shares in the mass, under constant inputs.
#[inline]
fn centre_of_mass([left, right]: [&Flight; 2], shares: [f64; 2]) -> Flight {
    let mean = |of: fn(&Flight) -> f64| shares[0] * of(left) + shares[1] * of(right);
    Flight { x: mean(|flight| flight.x), v: mean(|flight| flight.v), forcing: [mean(|f| f.forcing[0]), 0.0, 0.0, 0.0] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::quadrature::gauss_legendre;

    /// `integral q^g dq / sqrt(1 - q^(p+1) - beta q - alpha q^2)` up to the root by quadrature, for exponents with `2
    /// p` whole. With `q = root cos^2 theta` the integrand is smooth. The radicand, 0 at `root`, is divided by `root -
    /// q` term by term, so nothing cancels.
    fn by_quadrature(p: f64, alpha: f64, beta: f64, g: i32) -> f64 {
        let mut root = 1.0;
        for _ in 0..50 {
            let rest = 1.0 - libm::pow(root, p + 1.0) - beta * root - alpha * root * root;
            root += rest / ((p + 1.0) * libm::pow(root, p) + beta + 2.0 * alpha * root);
        }
        let twice = 2 * (p + 1.0) as i32 + i32::from(p.fract() != 0.0);
        let end = root.sqrt();
        let integrand = |theta: f64| {
            let s = end * libm::cos(theta);
            let power = (0..twice).map(|i| end.powi(i) * s.powi(twice - 1 - i)).sum::<f64>() / (end + s);
            2.0 * s * s.powi(2 * g) / (power + beta + alpha * (root + s * s)).sqrt()
        };
        gauss_legendre(&integrand, 0.0, std::f64::consts::FRAC_PI_2, 20)
    }

    /// Includes vanishing terms: for p = 3 the one linear in beta, for p = 5 the one linear in alpha.
    #[test]
    fn pair_impact_expansion_agrees_with_quadrature() {
        let disturbances =
            [(0.0, 0.0), (0.0, 9e-4), (0.0, -9e-4), (9e-4, 0.0), (1e-4, 2e-4), (3e-4, -6e-4), (1e-30, 1e-5)];
        for p in [1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 7.0, 10.0] {
            for (alpha, beta) in disturbances {
                let coefficients = ImpactCoefficients::new(p);
                for (table, g) in coefficients.integrals().iter().zip([0, 1]) {
                    let (sum, quadrature) = (expansion(table, alpha, beta), by_quadrature(p, alpha, beta, g));
                    let off = sum / quadrature - 1.0;
                    assert!(off.abs() < 1e-14, "p={p} g={g} alpha={alpha:e} beta={beta:e}: off by {off:e}");
                }
            }
        }
    }
}
