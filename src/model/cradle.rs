//! The coefficients of the equations, derived from the parameters: masses, oscillators and contact laws.

use super::contact::ContactLaw;
use super::damping::{Damping, Elastic, Growth};
use super::parameters::{ContactModel, Parameters, PendulumModel};
use crate::solver::dual::Scalar;

/// One ball on its pendulum: `x'' + 2 gamma x' + omega2 x = (forces) / mass`, or the same on an arc.
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
    /// The same in other numbers.
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

    /// Horizontal force (N) of pendulum and drag on the support at the position `x` (m) and the velocity `v` (m/s).
    pub fn support_force(&self, x: S, v: S) -> S {
        self.mass * (self.omega2 * x + S::from(2.0) * self.gamma * v)
    }

    /// Acceleration (m/s2) at `x` (m) and `v` (m/s) under the sum of contact forces (N) and `forcing` by the inputs.
    pub fn acceleration(&self, x: S, v: S, force: S, forcing: S) -> S {
        force / self.mass + forcing - self.omega2 * x - S::from(2.0) * self.gamma * v
    }
}

/// All balls and contacts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cradle<S = f64> {
    /// From left to right.
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
    /// Derives the coefficients of the equations from `p`, whose values are in their ranges.
    pub fn new(p: &Parameters) -> Self {
        Self::along(p, p)
    }

    /// Refuses parameters whose products or quotients leave the range of doubles, although each of them is in its
    /// range.
    pub(crate) fn check(&self) -> Result<(), String> {
        let check = |holds: bool, what: std::fmt::Arguments, value: f64| {
            let side = if value == 0.0 { "small" } else { "large" };
            let text = || {
                format!("{what} is too {side} for a double; allowed: values for which it is in the range of doubles")
            };
            if holds { Ok(()) } else { Err(text()) }
        };
        let finite = |what: std::fmt::Arguments, value: f64| check(value.is_finite(), what, value);
        let positive = |what: std::fmt::Arguments, value: f64| check(value > 0.0 && value.is_finite(), what, value);
        for (i, ball) in (1..).zip(&self.balls) {
            positive(format_args!("ball.mass * ball.massRatio[{i}]"), ball.mass)?;
            positive(format_args!("pendulum.length * pendulum.lengthRatio[{i}]"), ball.length)?;
            finite(format_args!("gravity / (pendulum.length * pendulum.lengthRatio[{i}])"), ball.omega2)?;
            finite(format_args!("pendulum.drag / (2 * ball.mass * ball.massRatio[{i}])"), ball.gamma)?;
        }
        for (i, law) in (1..).zip(&self.contacts) {
            finite(format_args!("the stiffness times contact.stiffnessRatio[{i}]"), law.stiffness)?;
            let damping = law.damping.coefficient;
            if law.damping.growth == Growth::RootOfStiffness && !damping.is_finite() {
                return Err(format!(
                    "contact.restitution ^ contact.lossRatio[{i}] is too small for contact.dampingLaw = \
                     constantRestitution; allowed: above 0, at least about 1e-300"
                ));
            }
            finite(format_args!("the damping of contact {i}"), damping)?;
            finite(format_args!("contact.gap[{i}] + contact.deadBand"), law.clearance)?;
            let pivots = if self.on_arcs() { law.pivots } else { 0.0 };
            finite(format_args!("2 * ball.radius + contact.gap[{i}]"), pivots)?;
        }
        Ok(())
    }

    /// Reduced mass of the balls of contact `j`, kg.
    pub fn reduced_mass(&self, j: usize) -> f64 {
        let (left, right) = (self.balls[j].mass, self.balls[j + 1].mass);
        left * right / (left + right)
    }

    /// An upper bound (m/s) of the speeds that the balls reach by their energy at these states, `x` and overlaps in m,
    /// `v` in m/s, and by accelerations `forcing(i)` (m/s2) within one unit of their time.
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

impl<S: Scalar> Cradle<S> {
    /// Whether the balls move on arcs.
    pub fn on_arcs(&self) -> bool {
        self.balls[0].on_arc
    }

    /// The same cradle in other numbers.
    pub fn map<T>(&self, number: impl Fn(S) -> T + Copy) -> Cradle<T> {
        Cradle {
            balls: self.balls.iter().map(|ball| ball.map(number)).collect(),
            contacts: self.contacts.iter().map(|law| law.map(number)).collect(),
            rigid: self.rigid,
        }
    }

    /// The same in dual numbers, with the derivatives of the coefficients for derivatives `tangent` of the parameters.
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
        let (stiffness, overlap_ref, exponent) = match p.contact_model {
            ContactModel::PowerLaw => (one(|p| p.stiffness), one(|p| p.overlap_ref), one(|p| p.exponent)),
            ContactModel::Hertz => {
                let stiffness = hertz_stiffness(one(|p| p.young_modulus), one(|p| p.poisson_ratio), one(|p| p.radius));
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
            let reduced_mass = left * (right / (left + right));
            let elastic = Elastic { stiffness: stiffness * ratios[j], overlap_ref, exponent, reduced_mass };
            ContactLaw {
                stiffness: elastic.stiffness,
                overlap_ref,
                exponent,
                clearance: gaps[j] + one(|p| p.dead_band),
                pivots: S::from(2.0) * one(|p| p.radius) + gaps[j],
                damping: if rigid { Damping::default() } else { Damping::selected(p, one, &elastic, losses[j]) },
                restitution: if rigid { one(|p| p.restitution).pow(losses[j]) } else { S::default() },
            }
        };
        let contacts = (0..gaps.len()).map(contact).collect();
        Self { balls, contacts, rigid }
    }
}

/// `K = 4/3 E* sqrt(R*)` of two equal spheres, N/m^(3/2), with `E* = E / (2 (1 - nu^2))` and `R* = R / 2`, for Young's
/// modulus E (Pa), Poisson's ratio nu and the radius R (m) (Johnson, Contact Mechanics, 1985, section 4.2).
pub fn hertz_stiffness<S: Scalar>(young_modulus: S, poisson_ratio: S, radius: S) -> S {
    let modulus = young_modulus / (S::from(2.0) * (S::from(1.0) - poisson_ratio * poisson_ratio));
    S::from(4.0 / 3.0) * modulus * (S::from(0.5) * radius).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hertz_stiffness_of_one_inch_steel_balls() {
        assert!((hertz_stiffness(2.1e11, 0.3, 0.0127) - 12_259_521_115.776_325).abs() < 1e-4);
    }
}
