//! The outcome of an elastic impact of two balls, in closed form: see "The impact of two" in docs/theory.md.

use std::cell::OnceCell;

use serde::{Deserialize, Serialize};

use crate::engine::arc_impact::{ImpactResult, Shape, outcome};
use crate::engine::cluster::{Cluster, power_of_stretching};
use crate::engine::flight::{Ball, Flight, RunningIntegrals, degree, integrals_of_inputs};
use crate::model::ContactLaw;
use crate::solver::{DoubleDouble, hypotenuse};

/// Terms of the expansion, and the largest `alpha + |beta|` for which its error is below the rounding.
const TERMS: usize = 7;
const SMALL: f64 = 1e-3;

/// Coefficients of the expansion for one exponent of the force law.
#[derive(Clone, Debug, Default)]
pub(crate) struct ImpactCoefficients {
    /// Of `beta^(k-j) alpha^j` in the integral of `dq / sqrt(...)`.
    time: [[f64; TERMS]; TERMS],
    /// The same for `q dq / sqrt(...)`.
    overlap: [[f64; TERMS]; TERMS],
    /// For balls on arcs, computed on first use.
    shape: OnceCell<Box<Shape>>,
}

impl ImpactCoefficients {
    /// For the exponent `p` of the force law.
    pub fn new(p: f64) -> Self {
        Self { time: coefficients(p, 0), overlap: coefficients(p, 1), shape: OnceCell::new() }
    }

    /// Solves the overlap's motion `d'' = -omega2 d - pull - F(d) / mass` from `d = 0`, `d' = rate` to its return to 0.
    /// Returns its duration (s), largest overlap (m) and integral (m.s).
    fn compression(&self, law: &ContactLaw, omega2: f64, mass: f64, rate: f64, pull: f64) -> Option<[f64; 3]> {
        if law.whole_exponent() == Some(1) {
            let frequency2 = omega2 + law.stiffness / mass;
            let frequency = frequency2.sqrt();
            let duration = 2.0 / frequency * libm::atan2(rate * frequency, pull);
            let (offset, amplitude) = (pull / frequency2, rate / frequency);
            let radius = hypotenuse(offset * offset + amplitude * amplitude, offset, amplitude);
            // The difference of the two without cancellation.
            let peak_overlap = if offset > 0.0 { amplitude * amplitude / (radius + offset) } else { radius - offset };
            let overlap_integral = (2.0 * rate - pull * duration) / frequency2;
            return Some([duration, peak_overlap, overlap_integral]);
        }
        let (p, reach) = (law.exponent, law.largest_overlap(mass, rate));
        let (alpha, beta) = (omega2 * reach * reach / (rate * rate), 2.0 * pull * reach / (rate * rate));
        let expands = alpha + beta.abs() < SMALL;
        if !expands {
            return None; // Also where they are no numbers.
        }
        // 1 = q^(p+1) + alpha q^2 + beta q at the peak: Newton from the first-order root.
        let mut q = 1.0 - (alpha + beta) / (p + 1.0);
        for _ in 0..if alpha + beta.abs() > 1e-8 { 3 } else { 0 } {
            let power = libm::pow(q, p);
            q -= (q * (power + alpha * q + beta) - 1.0) / ((p + 1.0) * power + 2.0 * alpha * q + beta);
        }
        let duration = 2.0 * reach / rate * expansion(&self.time, alpha, beta);
        let overlap_integral = 2.0 * reach * reach / rate * expansion(&self.overlap, alpha, beta);
        Some([duration, reach * q, overlap_integral])
    }
}

/// With `P = q^(p+1) + P_1`, `P_1 = beta q + alpha q^2`, and E the energy over that of the onset, the integral of `q^g
/// / sqrt(1 - P)` is the sum over k of `(-1)^k / k! (d/dE)^k` of the integral of `q^g P_1^k / sqrt(E - q^(p+1))` at E =
/// 1, and that of `q^m / sqrt(E - q^(p+1))` is `E^(s - 1/2) B(s, 1/2) / (p+1)` with `s = (m+1) / (p+1)` and Euler's
/// beta function B.
fn coefficients(p: f64, g: usize) -> [[f64; TERMS]; TERMS] {
    let mut table = [[0.0; TERMS]; TERMS];
    for (k, row) in table.iter_mut().enumerate() {
        let mut binomial = 1.0;
        for (j, coefficient) in row[..=k].iter_mut().enumerate() {
            let share = (k + j + g + 1) as f64 / (p + 1.0);
            let beta_function =
                std::f64::consts::PI.sqrt() * libm::tgamma(share) / libm::tgamma(share + 0.5) / (p + 1.0);
            let derivatives = (0..k).fold(1.0, |product, i| product * (share - 0.5 - i as f64) / -((i + 1) as f64));
            *coefficient = binomial * beta_function * derivatives;
            binomial *= (k - j) as f64 / (j + 1) as f64;
        }
    }
    table
}

/// Sums the expansion up to where the rest is below the rounding; single terms may be 0 (for p = 3 the first in beta).
fn expansion(table: &[[f64; TERMS]; TERMS], alpha: f64, beta: f64) -> f64 {
    let (mut sum, mut size) = (0.0, 1.0);
    for (k, row) in table.iter().enumerate() {
        // beta^k (row_0 + row_1 alpha/beta + ...) without the division.
        let (mut term, mut alpha_power) = (0.0, 1.0);
        for (j, c) in row[..=k].iter().enumerate() {
            term += c * alpha_power * (j..k).fold(1.0, |power, _| power * beta);
            alpha_power *= alpha;
        }
        sum += term;
        size *= alpha + beta.abs();
        if size < 1e-18 {
            break;
        }
    }
    sum
}

/// An impact under way whose outcome is known.
///
/// A saved state has only its contact, and computes it anew.
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
    /// Its segments, computed on first use.
    #[serde(skip)]
    pub interior: OnceCell<Vec<Interior>>,
}

#[derive(Clone, Debug)]
pub(crate) struct Interior {
    pub segment: Cluster,
    /// Sums over the previous segments: the impulse of the contact, N.s, and the integrals of the two balls.
    pub impulse: f64,
    pub integrals: [RunningIntegrals; 2],
}

impl Interior {
    pub fn since(&self, t: DoubleDouble) -> f64 {
        (t - self.segment.start).value().max(0.0)
    }
}

impl PairImpact {
    /// The impact in `contact` of its balls, in flight, anchored at its start with overlap 0; `None` without closed
    /// form.
    pub fn new(
        contact: usize,
        [left, right]: [&Ball; 2],
        law: &ContactLaw,
        coefficients: &ImpactCoefficients,
    ) -> Option<Self> {
        if left.model.on_arc {
            return Self::on_arcs(contact, [left, right], law, coefficients);
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
        let pull = o.omega2() * law.clearance - (l.forcing[0] - r.forcing[0]);
        let [t, peak_overlap, overlap_integral] = coefficients.compression(law, o.omega2(), reduced, rate, pull)?;
        if !(t.is_finite() && t > 0.0) {
            return None; // Beyond the range of doubles.
        }

        let centre = Flight {
            x: left_share * l.x + right_share * r.x,
            v: left_share * l.v + right_share * r.v,
            forcing: [left_share * l.forcing[0] + right_share * r.forcing[0], 0.0, 0.0, 0.0],
        };
        let u: [f64; 4] = o.basis(t.into());
        let displacement = centre.displacement(o, &u);
        // Not as a difference of velocities, in whose rounding gravity's effect in a microsecond would drown.
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
            impulse: reduced * (2.0 * rate - pull * t - o.omega2() * overlap_integral),
            peak: law.elastic_force(peak_overlap),
        };
        let integrals = [integrals(left, right_share), integrals(right, -left_share)];
        Some(Self { contact, start: left.anchor, outcome, integrals, interior: OnceCell::new() })
    }

    #[inline(never)] // for the same reason as `Ball::piece`
    fn on_arcs(contact: usize, balls: [&Ball; 2], law: &ContactLaw, coefficients: &ImpactCoefficients) -> Option<Self> {
        let (models, flights) = (balls.map(|ball| ball.model), balls.map(|ball| &ball.flight));
        let steady = |k: usize| models[k].gamma == 0.0 && degree(&flights[k].forcing) == 0;
        if !(law.is_elastic() && law.exponent <= Shape::HIGHEST && steady(0) && steady(1)) {
            return None;
        }
        let shape = coefficients.shape.get_or_init(|| Box::new(Shape::new(law.exponent, power_of_stretching(law))));
        let outcome = outcome(&models, flights, law, shape)?;
        let ImpactResult { duration, displacements, .. } = outcome;
        let integrals = [0, 1].map(|k| integrals_of_inputs(&models[k], flights[k], duration, &|_| displacements[k]));
        Some(Self { contact, start: balls[0].anchor, outcome, integrals, interior: OnceCell::new() })
    }

    pub fn end(&self) -> DoubleDouble {
        self.start + self.outcome.duration
    }

    /// An upper bound of the outward displacement of a ball `tau` (s) after the start, without accelerations other than
    /// by the contact: the contact pushes outwards, so balls lag behind the chord.
    pub fn chord(&self, ball: usize, tau: f64) -> f64 {
        if tau < self.outcome.duration {
            self.outcome.displacements[ball] * tau / self.outcome.duration
        } else {
            self.outcome.displacements[ball] + self.outcome.velocities[ball] * (tau - self.outcome.duration)
        }
    }
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

    /// Also where single terms vanish: for p = 3 the one linear in beta, for p = 5 the one linear in alpha.
    #[test]
    fn expansion_agrees_with_quadrature() {
        let disturbances =
            [(0.0, 0.0), (0.0, 9e-4), (0.0, -9e-4), (9e-4, 0.0), (1e-4, 2e-4), (3e-4, -6e-4), (1e-30, 1e-5)];
        for p in [1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 7.0, 10.0] {
            for (alpha, beta) in disturbances {
                let coefficients = ImpactCoefficients::new(p);
                for (table, g) in [(&coefficients.time, 0), (&coefficients.overlap, 1)] {
                    let (sum, quadrature) = (expansion(table, alpha, beta), by_quadrature(p, alpha, beta, g));
                    let off = sum / quadrature - 1.0;
                    assert!(off.abs() < 1e-14, "p={p} g={g} alpha={alpha:e} beta={beta:e}: off by {off:e}");
                }
            }
        }
    }
}
