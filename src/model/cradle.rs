//! The coefficients of the equations, derived from the parameters: masses, oscillators and contact laws.

use super::contact::ContactLaw;
use super::damping::{Damping, Elastic, Growth};
use super::parameters::{ContactModel, Parameters, PendulumModel};
use crate::solver::dual::Scalar;

/// One ball on its pendulum: `x'' + 2 gamma x' + omega2 x = (forces) / mass`, or the equation of an arc.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BallModel<S = f64> {
    /// Mass, kg.
    pub mass: S,
    /// Square of the natural angular frequency, g/L, 1/s2.
    pub omega2: S,
    /// Decay rate b/(2 m) of the amplitude, 1/s.
    pub gamma: S,
    /// Length L, m.
    pub length: S,
    /// Gravity g, m/s2.
    pub gravity: S,
    /// Whether it moves on an arc. Its state is then that along its path: `s = L angle` (m) and its rate (m/s).
    pub on_arc: bool,
}

impl<S: Scalar> BallModel<S> {
    /// The ball with every number converted.
    pub fn map<T>(&self, number: impl Fn(S) -> T) -> BallModel<T> {
        BallModel {
            mass: number(self.mass),
            omega2: number(self.omega2),
            gamma: number(self.gamma),
            length: number(self.length),
            gravity: number(self.gravity),
            on_arc: self.on_arc,
        }
    }

    /// Horizontal force (N) of pendulum and drag on the support at the position `x` (m) and the velocity `v` (m/s), on
    /// a line.
    pub fn support_force(&self, x: S, v: S) -> S {
        self.mass * (self.omega2 * x + S::from(2.0) * self.gamma * v)
    }

    /// Acceleration (m/s2) on a line at `x` (m) and `v` (m/s) under the contact forces (N) and the `forcing` (m/s2) of
    /// the inputs.
    pub fn acceleration(&self, x: S, v: S, force: S, forcing: S) -> S {
        force / self.mass + forcing - self.omega2 * x - S::from(2.0) * self.gamma * v
    }
}

/// The coefficients of all balls and contacts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cradle<S = f64> {
    /// The balls from left to right.
    pub balls: Vec<BallModel<S>>,
    /// Contact `i` lies between ball `i` and ball `i + 1`. Rigid contacts have no stiffness.
    pub contacts: Vec<ContactLaw<S>>,
    /// Whether the contacts are rigid.
    pub rigid: bool,
}

impl BallModel {
    /// Time in which the phase of the pendulum advances by one radian, s; 1 s without gravity.
    pub fn unit_of_time(&self) -> f64 {
        if self.omega2 > 0.0 { 1.0 / self.omega2.sqrt() } else { 1.0 }
    }
}

impl Cradle {
    /// Derives the coefficients from `p`, whose values must be in their ranges.
    pub fn new(p: &Parameters) -> Self {
        Self::along(p, p)
    }

    /// Refuses parameters whose products or quotients leave the range of doubles, although each parameter is in its own
    /// range. `self` must be derived from `p`.
    pub(crate) fn check(&self, p: &Parameters) -> Result<(), String> {
        let check = |holds: bool, what: std::fmt::Arguments, value: f64| {
            let side = if value == 0.0 { "small" } else { "large" };
            let text = || {
                format!("{what} is too {side} for a double; allowed: values for which it is in the range of doubles")
            };
            if holds { Ok(()) } else { Err(text()) }
        };
        let finite = |what: std::fmt::Arguments, value: f64| check(value.is_finite(), what, value);
        let positive = |what: std::fmt::Arguments, value: f64| check(value > 0.0 && value.is_finite(), what, value);
        for (i, (radius, modulus)) in (1..).zip(p.radius_ratio.iter().zip(&p.young_modulus_ratio)) {
            positive(format_args!("ball.radius * ball.radiusRatio[{i}]"), p.radius * radius)?;
            positive(format_args!("ball.youngModulus * ball.youngModulusRatio[{i}]"), p.young_modulus * modulus)?;
        }
        for (i, ball) in (1..).zip(&self.balls) {
            positive(format_args!("ball.mass * ball.massRatio[{i}]"), ball.mass)?;
            positive(format_args!("pendulum.length * pendulum.lengthRatio[{i}]"), ball.length)?;
            finite(format_args!("gravity / (pendulum.length * pendulum.lengthRatio[{i}])"), ball.omega2)?;
            finite(format_args!("pendulum.drag / (2 * ball.mass * ball.massRatio[{i}])"), ball.gamma)?;
        }
        for (i, law) in (1..).zip(&self.contacts) {
            finite(format_args!("the stiffness times contact.stiffnessRatio[{i}]"), law.stiffness)?;
            let damping = law.damping.coefficient;
            if law.damping.growth == Growth::RootOfStiffness && damping == f64::INFINITY {
                return Err(format!(
                    "contact.restitution ^ contact.lossRatio[{i}] is too small for contact.dampingLaw = \
                     constantRestitution; allowed: above 0, not below about 1e-600"
                ));
            }
            finite(format_args!("the damping of contact {i}"), damping)?;
            finite(format_args!("contact.gap[{i}] + contact.deadBand"), law.clearance)?;
            let pivots = if self.on_arcs() { law.pivots } else { 0.0 };
            finite(format_args!("the distance of the pivots at contact.gap[{i}]"), pivots)?;
        }
        Ok(())
    }

    /// Reduced mass of the balls of contact `j`, kg.
    pub fn reduced_mass(&self, j: usize) -> f64 {
        let (left, right) = (self.balls[j].mass, self.balls[j + 1].mass);
        left * right / (left + right)
    }

    /// Scale (m/s) of the speeds that the balls reach from these states (`x` and overlaps in m, `v` in m/s): by their
    /// velocities, by the energy of pendulums and contacts, and by accelerations `forcing(i)` (m/s2) within one unit of
    /// time of a pendulum.
    pub fn speed_in_reach(&self, [x, v, overlaps]: [&[f64]; 3], forcing: impl Fn(usize) -> f64) -> f64 {
        let held = |j: usize| self.contacts.get(j).map_or(0.0, |law| law.elastic_energy(overlaps[j]));
        let of_ball = |(i, ball): (usize, &BallModel)| {
            let unit = ball.unit_of_time();
            let energy = held(i) + if i > 0 { held(i - 1) } else { 0.0 };
            let height = if ball.omega2 > 0.0 { x[i].abs() / unit } else { 0.0 };
            let by_forces = (2.0 * energy / ball.mass).sqrt().max(forcing(i).abs() * unit);
            v[i].abs().max(height).max(by_forces)
        };
        self.balls.iter().enumerate().map(of_ball).fold(0.0, f64::max)
    }

    /// Period of the first ball for small angles, s; infinite without gravity.
    pub fn period(&self) -> f64 {
        match self.balls[0].omega2 {
            0.0 => f64::INFINITY,
            omega2 => std::f64::consts::TAU / omega2.sqrt(),
        }
    }
}

impl Parameters {
    /// Refuses parameters whose products or quotients leave the range of doubles; see [`Cradle::check`].
    pub(crate) fn check_coefficients(&self) -> Result<(), String> {
        Cradle::new(self).check(self)
    }
}

impl<S: Scalar> Cradle<S> {
    /// Whether the balls move on arcs.
    pub fn on_arcs(&self) -> bool {
        self.balls[0].on_arc
    }

    /// The cradle with every number converted.
    pub fn map<T>(&self, number: impl Fn(S) -> T + Copy) -> Cradle<T> {
        Cradle {
            balls: self.balls.iter().map(|ball| ball.map(number)).collect(),
            contacts: self.contacts.iter().map(|law| law.map(number)).collect(),
            rigid: self.rigid,
        }
    }

    /// Derives the coefficients from `p`; in dual numbers with their derivatives for the derivatives `tangent` of the
    /// parameters.
    pub fn along(p: &Parameters, tangent: &Parameters) -> Self {
        let one = |field: fn(&Parameters) -> f64| S::with_tangent(field(p), field(tangent));
        let each = |field: fn(&Parameters) -> &[f64]| {
            let pairs = field(p).iter().zip(field(tangent));
            pairs.map(|(value, tangent)| S::with_tangent(*value, *tangent)).collect::<Vec<S>>()
        };
        let ball = |(mass_ratio, length_ratio): (S, S)| {
            let mass = one(|p| p.mass) * mass_ratio;
            let length = one(|p| p.length) * length_ratio;
            let gamma = S::from(0.5) * one(|p| p.drag) / mass;
            let gravity = one(|p| p.gravity);
            let on_arc = p.pendulum == PendulumModel::Circular;
            BallModel { mass, omega2: gravity / length, gamma, length, gravity, on_arc }
        };
        let times = |one: S, ratios: Vec<S>| ratios.into_iter().map(move |ratio| one * ratio).collect::<Vec<S>>();
        let radii = times(one(|p| p.radius), each(|p| &p.radius_ratio));
        let moduli = times(one(|p| p.young_modulus), each(|p| &p.young_modulus_ratio));
        let pair = |of_balls: &[S], j: usize| [of_balls[j], of_balls[j + 1]];
        let elastic_constants = |j: usize| match p.contact_model {
            ContactModel::PowerLaw => (one(|p| p.stiffness), one(|p| p.overlap_ref), one(|p| p.exponent)),
            ContactModel::Hertz => {
                let stiffness = hertz_stiffness(pair(&moduli, j), one(|p| p.poisson_ratio), pair(&radii, j));
                (stiffness, S::from(1.0), S::from(1.5))
            }
            ContactModel::Rigid => (S::default(), S::from(1.0), S::from(1.0)),
        };
        let rigid = p.contact_model == ContactModel::Rigid;
        let balls: Vec<BallModel<S>> =
            each(|p| &p.mass_ratio).into_iter().zip(each(|p| &p.length_ratio)).map(ball).collect();
        let (ratios, gaps, losses) = (each(|p| &p.stiffness_ratio), each(|p| &p.gap), each(|p| &p.loss_ratio));
        let contact = |j: usize| {
            let [left, right] = [balls[j].mass, balls[j + 1].mass];
            let reduced_mass = reduced([left, right]);
            let (stiffness, overlap_ref, exponent) = elastic_constants(j);
            let elastic = Elastic { stiffness: stiffness * ratios[j], overlap_ref, exponent, reduced_mass };
            ContactLaw {
                stiffness: elastic.stiffness,
                overlap_ref,
                exponent,
                clearance: gaps[j] + one(|p| p.dead_band),
                pivots: radii[j] + radii[j + 1] + gaps[j],
                damping: if rigid { Damping::default() } else { Damping::selected(p, one, &elastic, losses[j]) },
                restitution: if rigid { one(|p| p.restitution).pow(losses[j]) } else { S::default() },
            }
        };
        let contacts = (0..gaps.len()).map(contact).collect();
        Self { balls, contacts, rigid }
    }
}

/// `K = 4/3 E* sqrt(R*)` of two spheres, N/m^(3/2), with `1/E* = (1 - nu^2) (1/E_l + 1/E_r)` and
/// `1/R* = 1/R_l + 1/R_r`, for Young's moduli E (Pa), Poisson's ratio nu and the radii R (m) (Johnson, Contact
/// Mechanics, 1985, section 4.2).
pub fn hertz_stiffness<S: Scalar>(young_moduli: [S; 2], poisson_ratio: S, radii: [S; 2]) -> S {
    let modulus = reduced(young_moduli) / (S::from(1.0) - poisson_ratio * poisson_ratio);
    S::from(4.0 / 3.0) * modulus * reduced(radii).sqrt()
}

/// The number whose inverse is the sum of the inverses of these two, which are above 0. Equal numbers give exactly
/// half, the order changes no bit, and no intermediate value leaves the range of doubles.
fn reduced<S: Scalar>([a, b]: [S; 2]) -> S {
    let (least, most) = if b.value() < a.value() { (b, a) } else { (a, b) };
    least / (S::from(1.0) + least / most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::Dual;

    #[test]
    fn hertz_stiffness_of_one_inch_steel_balls() {
        assert!((hertz_stiffness([2.1e11; 2], 0.3, [0.0127; 2]) - 12_259_521_115.776_325).abs() < 1e-4);
    }

    /// Equal spheres: compares with the simpler formula, to the bit, with derivatives.
    #[test]
    fn equal_spheres_are_half_of_one() {
        let number = |k: u32| 0.1 + f64::from(k) * 0.618_033_988_749_895;
        for k in 0..2000 {
            let (value, tangent) = (number(k), number(7 * k % 31) - 9.0);
            let (modulus, poisson) = (Dual::with_tangent(1e9 * value, tangent), Dual::with_tangent(0.3, 0.2 * tangent));
            let radius = Dual::with_tangent(0.01 * number(k * k % 97), 0.3 * tangent);
            let half = modulus / (Dual::from(2.0) * (Dual::from(1.0) - poisson * poisson));
            let expected = Dual::from(4.0 / 3.0) * half * (Dual::from(0.5) * radius).sqrt();
            let found = hertz_stiffness([modulus; 2], poisson, [radius; 2]);
            assert_eq!(found.value().to_bits(), expected.value().to_bits(), "{k}");
            assert_eq!(found.tangent().to_bits(), expected.tangent().to_bits(), "{k}");
        }
    }

    /// Compares with `1/E* = (1 - nu^2) (1/E_l + 1/E_r)` and `1/R* = 1/R_l + 1/R_r` as written. The order of the
    /// spheres changes no bit.
    #[test]
    fn unlike_spheres_have_the_stiffness_of_hertz() {
        let plane = |modulus: f64| (1.0 - 0.09) / modulus;
        for [left, right] in [[1.0, 1.0], [2.0, 0.5], [1e-3, 40.0], [7.0, 1e12], [1e-100, 1e100]] {
            let (moduli, radii) = ([2.1e11 * left, 2.1e11 * right], [0.01 * right, 0.01 * left]);
            let (curvature, compliance) = (1.0 / radii[0] + 1.0 / radii[1], plane(moduli[0]) + plane(moduli[1]));
            let (found, expected) = (hertz_stiffness(moduli, 0.3, radii), 4.0 / 3.0 / compliance / curvature.sqrt());
            assert!((found / expected - 1.0).abs() < 1e-15, "{left} {right}: {found} {expected}");
            let [[a, b], [c, d]] = [moduli, radii];
            assert_eq!(found.to_bits(), hertz_stiffness([b, a], 0.3, [d, c]).to_bits());
        }
    }
}
