//! The elastic impact of two balls that nothing else touches: its outcome without integrating it.
//!
//! For equal undamped pendulums under constant inputs the motion splits in two. The centre of mass swings like a ball. The
//! overlap moves in a potential, so its rate has reversed when the contact opens: the outcome needs no integration, and the
//! duration is a quadrature. With `u` the closing rate, `mu` the reduced mass and `q` the overlap over the one that the
//! contact alone would reach, `q_0`,
//!
//! ```text
//! T = 2 (q_0 / u) integral dq / sqrt(1 - q^(p+1) - beta q - alpha q^2)
//! ```
//!
//! where alpha and beta are what gravity and inputs do during the contact. For p = 1 that is an arc tangent; else it is
//! expanded in alpha and beta, which are of the order of (contact time / period)^2. The terms follow from the action integral
//! `S(E) = integral sqrt(E - P(q)) dq`, whose derivative by E is the time (Landau and Lifshitz, Mechanics, sections 12 and 49),
//! and from `integral q^m / sqrt(E - q^(p+1)) dq = E^(e_m) B_m`, with Euler's beta function in `B_m`.

use std::cell::OnceCell;

use super::ball::{Ball, Flight, Tally, degree};
use super::cluster::Cluster;
use crate::model::{ContactLaw, Damping};
use crate::solver::double_double::DoubleDouble;

/// Largest alpha or beta that the expansion is used for: its error is of third order, below the rounding.
const SMALL: f64 = 2e-6;

/// `B_m = B((m+1)/(p+1), 1/2) / (p+1)` for m = 0 to 4, and the exponents `e_m = (m+1)/(p+1) - 1/2`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    b: [f64; 5],
    e: [f64; 5],
}

impl Shape {
    /// For the exponent `p` of the force law.
    pub fn new(p: f64) -> Self {
        let share = |m: usize| (m + 1) as f64 / (p + 1.0);
        let beta = |m: usize| {
            let gammas = libm::tgamma(share(m)) / libm::tgamma(share(m) + 0.5);
            std::f64::consts::PI.sqrt() * gammas / (p + 1.0)
        };
        Self { b: std::array::from_fn(beta), e: std::array::from_fn(|m| share(m) - 0.5) }
    }

    /// `integral dq / sqrt(1 - q^(p+1) - beta q - alpha q^2)` between the roots at 0 and near 1.
    fn time(&self, alpha: f64, beta: f64) -> f64 {
        let (b, e) = (&self.b, &self.e);
        let second = beta * beta * e[2] * (e[2] - 1.0) * b[2]
            + 2.0 * alpha * beta * e[3] * (e[3] - 1.0) * b[3]
            + alpha * alpha * e[4] * (e[4] - 1.0) * b[4];
        b[0] - (beta * e[1] * b[1] + alpha * e[2] * b[2]) + 0.5 * second
    }

    /// The same integral with `q` in the numerator, to first order.
    fn time_times_overlap(&self, alpha: f64, beta: f64) -> f64 {
        self.b[1] - (beta * self.e[2] * self.b[2] + alpha * self.e[3] * self.b[3])
    }
}

/// The overlap during an impact: how long, how much, and its integral.
struct Course {
    duration: f64,
    peak_overlap: f64,
    overlap_integral: f64,
}

/// An impact under way whose outcome is known.
#[derive(Clone, Debug)]
pub(crate) struct PairImpact {
    pub start: DoubleDouble,
    pub duration: f64,
    /// Displacement of both balls over the impact, m: the overlap is 0 at either end.
    pub displacement: f64,
    /// Velocities of the left and the right ball after it, m/s.
    pub velocities: [f64; 2],
    /// Impulse, N.s, and largest force, N.
    pub impulse: f64,
    pub peak: f64,
    /// What the left and the right ball gather.
    pub tallies: [Tally; 2],
    /// The inside, segment by segment, for those who look at it; `None` until then.
    pub inside: OnceCell<Vec<Cluster>>,
}

impl PairImpact {
    /// The impact of `left` and `right`, both in flight and anchored at its `start`, with their overlap 0 there; `None` if the
    /// two do not allow it to be solved in closed form.
    pub fn new(left: &Ball, right: &Ball, law: &ContactLaw, shape: &Shape) -> Option<Self> {
        let (l, r, o) = (&left.flight, &right.flight, &left.oscillator);
        let simple = law.damping == Damping::None && o.gamma() == 0.0 && left.oscillator == right.oscillator;
        let rate = l.v - r.v;
        if !simple || rate <= 0.0 || degree(&l.push) + degree(&r.push) > 0 {
            return None;
        }
        let total = left.mass + right.mass;
        let (left_share, right_share) = (left.mass / total, right.mass / total);
        let reduced = left.mass * right_share;
        let pull = o.omega2() * law.clearance - (l.push[0] - r.push[0]);
        let course = course(law, shape, o.omega2(), reduced, rate, pull)?;
        let t = course.duration;

        let centre = Flight {
            x: left_share * l.x + right_share * r.x,
            v: left_share * l.v + right_share * r.v,
            push: [left_share * l.push[0] + right_share * r.push[0], 0.0, 0.0, 0.0],
        };
        let u = o.basis(t.into(), 4);
        let displacement = centre.displacement(o, &u);
        // Not as a difference of velocities: what gravity does in a microsecond would drown in their rounding.
        let speed_up = (centre.push[0] - o.omega2() * centre.x) * u[1] - o.omega2() * centre.v * u[2];
        let velocities = if left.mass == right.mass {
            [r.v + speed_up, l.v + speed_up]
        } else {
            [l.v - 2.0 * right_share * rate + speed_up, r.v + 2.0 * left_share * rate + speed_up]
        };
        let common = centre.displacement_integral(o, &u);
        let tally = |ball: &Ball, of_overlap: f64| Tally {
            x_integral: ball.flight.x * t + common + of_overlap * course.overlap_integral,
            drag_loss: 0.0,
            work: ball.mass * ball.flight.push[0] * displacement,
        };
        Some(Self {
            start: left.anchor,
            duration: t,
            displacement,
            velocities,
            impulse: reduced * (2.0 * rate - pull * t - o.omega2() * course.overlap_integral),
            peak: law.elastic_force(course.peak_overlap),
            tallies: [tally(left, right_share), tally(right, -left_share)],
            inside: OnceCell::new(),
        })
    }

    /// When the contact opens.
    pub fn end(&self) -> DoubleDouble {
        self.start + self.duration
    }

    /// An upper bound of how far the left ball has gone to the left or the right ball to the right `tau` (s) after the start,
    /// but for the accelerations other than by the contact: the contact pushes them outwards, so they lag behind the chord.
    pub fn chord(&self, ball: usize, tau: f64) -> f64 {
        if tau < self.duration {
            self.displacement * tau / self.duration
        } else {
            self.displacement + self.velocities[ball] * (tau - self.duration)
        }
    }
}

/// Solves the overlap's motion `d'' = -omega2 d - pull - F(d) / mass` from `d = 0`, `d' = rate` to its return to 0.
fn course(law: &ContactLaw, shape: &Shape, omega2: f64, mass: f64, rate: f64, pull: f64) -> Option<Course> {
    if law.whole_exponent() == Some(1) {
        let frequency2 = omega2 + law.stiffness / mass;
        let frequency = frequency2.sqrt();
        let duration = 2.0 / frequency * libm::atan2(rate * frequency, pull);
        let (offset, amplitude) = (pull / frequency2, rate / frequency);
        let radius = (offset * offset + amplitude * amplitude).sqrt();
        // The difference of the two without cancellation.
        let peak_overlap = if offset > 0.0 { amplitude * amplitude / (radius + offset) } else { radius - offset };
        let overlap_integral = (2.0 * rate - pull * duration) / frequency2;
        return Some(Course { duration, peak_overlap, overlap_integral });
    }
    let p = law.exponent;
    // k d_ref^2 (d / d_ref)^(p+1) / (p+1) = mass rate^2 / 2.
    let ratio = 0.5 * (p + 1.0) * mass * rate * rate / (law.stiffness * law.overlap_ref * law.overlap_ref);
    let reach = law.overlap_ref * libm::pow(ratio, 1.0 / (p + 1.0));
    let (alpha, beta) = (omega2 * reach * reach / (rate * rate), 2.0 * pull * reach / (rate * rate));
    if !(alpha + beta.abs() < SMALL) {
        return None;
    }
    // 1 = q^(p+1) + alpha q^2 + beta q at the peak, by one Newton step from the first-order root.
    let first = (alpha + beta) / (p + 1.0);
    let second = first * (0.5 * p * first - (2.0 * alpha + beta) / (p + 1.0));
    let peak_overlap = reach * (1.0 - first - second);
    Some(Course {
        duration: 2.0 * reach / rate * shape.time(alpha, beta),
        peak_overlap,
        overlap_integral: 2.0 * reach * reach / rate * shape.time_times_overlap(alpha, beta),
    })
}
