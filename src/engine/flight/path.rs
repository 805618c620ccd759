//! The flight of a ball on its arc, as power series of the time. See "Arcs" in docs/theory.md for the equations.
//!
//! A [`Path`] holds as long as its last terms are below rounding, or, under strong drag, for a step of implicit
//! collocation; a ball that flies on takes the next one ([`Piece`]).

use super::free_motion::{
    Flight, Forcing, LONGEST_FLIGHT_STEP, RunningIntegrals, degree, forcing_at, integral_of, shifted,
};
use super::implicit;
use crate::model::BallModel;
use crate::solver::radau::STAGES;
use crate::solver::series::{INVERSES, LANES, bound, of_derivatives, product_term, value_and_derivatives};
use crate::solver::{DoubleDouble, MAX_FORCE_ORDER, crossing::first_positive, quadrature::gauss_legendre};

/// Number of coefficients, usually and at first. More of them make longer steps, each of which costs more; as the next
/// impact may follow at once, a flight begins with a short step.
pub(super) const TERMS: usize = 26;
pub(super) const FEW: usize = 9;
pub(super) type Terms = [f64; TERMS];

/// Size of the last terms over the largest, for the length of a step.
const NEGLIGIBLE_TERMS: f64 = 1e-18;

/// Why a ball cannot go on along its arc.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Its string is horizontal.
    Horizontal,
    /// Its string would have to push.
    Slack,
    /// It stays in contact with the next ball, and the two do not swing as one.
    Held,
    /// Its impact with the next ball does not push a ball along its arc, or pushes it against the sense of others in
    /// touch.
    Across,
    /// It and the next ball go over or through each other: the centre of one crosses the string of the other.
    Sides,
}

/// Length of a step, s, and the velocity (m/s) as a polynomial of the time over that length.
type Velocity = (f64, [f64; STAGES + 1]);

/// Coefficients of s (m) and of the sine and cosine of the angle, as functions of the time over `unit`.
#[derive(Clone, Debug)]
pub(crate) struct Path {
    pub(super) terms: usize,
    pub(super) unit: f64,
    /// How long the series hold, s, backwards and forwards, and a bound of the absolute s until then, m.
    pub before: f64,
    pub length: f64,
    pub(super) reach: f64,
    /// Rate at the start, m/s.
    v: f64,
    s: Terms,
    pub(super) sin: Terms,
    pub(super) cos: Terms,
}

impl Path {
    /// The path from this state on, by a `long` or a short step.
    pub fn new(ball: &BallModel, flight: &Flight, long: bool) -> Self {
        let terms = if long { TERMS } else { FEW };
        let BallModel { omega2, gamma, length, gravity, .. } = *ball;
        let largest = flight.forcing.iter().fold(0.0, |most: f64, f| most.max(f.abs()));
        let pace = omega2.sqrt() + 2.0 * gamma + flight.v.abs() / length + (largest / length).sqrt();
        let unit = if pace > 0.0 { 1.0 / pace } else { 1.0 };
        let forcing = scaled(&flight.forcing, unit);
        let (varies, damping) = (degree(&flight.forcing), 2.0 * gamma / unit);
        let mut path = Self::begin(terms, unit, flight);
        path.expand(ball, |k, s, sin, cos| {
            let next = (k + 1) as f64;
            let pushed: f64 = (0..=varies.min(k)).map(|i| forcing[i] * cos[k - i]).sum();
            let a = pushed - gravity * sin[k] - damping * next * s[k + 1];
            a * unit * unit / (next * (next + 1.0))
        });
        let size = |k: usize| path.s[k].abs().max(length * path.sin[k].abs()).max(length * path.cos[k].abs());
        let scale = (1..MAX_FORCE_ORDER + 3).map(size).fold(0.0, f64::max);
        let last = size(terms - 2).max(size(terms - 1));
        let length = if last > 0.0 {
            let small = NEGLIGIBLE_TERMS * scale / last;
            unit * libm::pow(small, if small > 1.0 { INVERSES[terms - 1] } else { INVERSES[terms - 2] })
        } else {
            LONGEST_FLIGHT_STEP
        };
        path.set_lengths([length.min(LONGEST_FLIGHT_STEP); 2]);
        if long && let Some(step) = implicit::step(ball, flight, path.length) {
            return Self::implicit(ball, flight, step, path.length);
        }
        path
    }

    /// The path by a step of implicit collocation, from its length (s) and velocity. Backwards it holds as long as the
    /// series, `before` (s).
    fn implicit(ball: &BallModel, flight: &Flight, (length, velocity): Velocity, before: f64) -> Self {
        let mut path = Self::begin(TERMS, length, flight);
        path.expand(ball, |k, _, _, _| velocity.get(k + 1).map_or(0.0, |c| c * length / (k + 2) as f64));
        path.set_lengths([before, length]);
        path
    }

    /// A path with only the state at the start.
    fn begin(terms: usize, unit: f64, flight: &Flight) -> Self {
        let mut s = [0.0; TERMS];
        (s[0], s[1]) = (flight.x, flight.v * unit);
        let [sin, cos] = [[0.0; TERMS]; 2];
        Self { terms, unit, before: 0.0, length: 0.0, reach: 0.0, v: flight.v, s, sin, cos }
    }

    /// Computes all terms. `next` gives term `k + 2` of s from the terms of s up to `k + 1` and of sine and cosine up
    /// to `k`.
    #[inline(always)]
    fn expand(&mut self, ball: &BallModel, next: impl Fn(usize, &Terms, &Terms, &Terms) -> f64) {
        let Self { terms, s, sin, cos, .. } = self;
        // Products of series need one of the two backwards.
        let [mut angle, mut sin_back, mut cos_back] = [[0.0; TERMS]; 3];
        (sin[0], cos[0]) = libm::sincos(s[0] / ball.length);
        for k in 0..*terms {
            if k > 0 {
                angle[k] = k as f64 * s[k] / ball.length;
                sin[k] = dot(&angle[1..=k], &cos_back[TERMS - k..]) * INVERSES[k];
                cos[k] = -dot(&angle[1..=k], &sin_back[TERMS - k..]) * INVERSES[k];
            }
            (sin_back[TERMS - 1 - k], cos_back[TERMS - 1 - k]) = (sin[k], cos[k]);
            if k + 2 < *terms {
                s[k + 2] = next(k, s, sin, cos);
            }
        }
    }

    fn set_lengths(&mut self, [before, length]: [f64; 2]) {
        (self.before, self.length, self.reach) = (before, length, bound(&self.s, length / self.unit));
    }

    /// Displacement (m) within `tau` (s), and velocity then (m/s).
    #[inline(always)]
    fn moved(&self, tau: f64) -> (f64, f64) {
        let time = tau / self.unit;
        // Of the displacement, less that at constant velocity, over the square of the time.
        let [quotient, change, _] = value_and_derivatives(&self.s[2..self.terms], time);
        (self.v * tau + time * time * quotient, self.v + time * (2.0 * quotient + time * change) / self.unit)
    }

    /// What first ends the flight while the series hold, and when, s.
    pub fn fault(&self, ball: &BallModel, flight: &Flight) -> Option<(f64, Fault)> {
        let until = self.length / self.unit;
        let first = |c: &Terms| if c[0] < 0.0 { Some(0.0) } else { first_positive(c, -1.0, 0.0, until) };
        let horizontal = if self.reach > 1.5 * ball.length { first(&self.cos) } else { None };
        let slack = if flight.forcing == Forcing::default() {
            None
        } else {
            let forcing = scaled(&flight.forcing, self.unit);
            let rate: Terms = std::array::from_fn(|k| match self.s.get(k + 1) {
                Some(s) => (k + 1) as f64 * s / self.unit,
                None => 0.0,
            });
            let tension_over_mass = |k: usize| {
                let pushed: f64 = (0..forcing.len().min(k + 1)).map(|i| forcing[i] * self.sin[k - i]).sum();
                product_term(&rate, &rate, k) / ball.length + ball.gravity * self.cos[k] + pushed
            };
            first(&std::array::from_fn(tension_over_mass))
        };
        let faults = [(horizontal, Fault::Horizontal), (slack, Fault::Slack)].into_iter();
        let timed = faults.filter_map(|(time, fault)| Some((time? * self.unit, fault)));
        timed.reduce(|a, b| if b.0 < a.0 { b } else { a })
    }
}

/// The sum of the products of coefficients of two series, one of them backwards.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((groups, rest), (others, other)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut sums = [0.0; LANES];
    for (a, b) in groups.iter().zip(others) {
        (0..LANES).for_each(|lane| sums[lane] += a[lane] * b[lane]);
    }
    let rest: f64 = rest.iter().zip(other).map(|(a, b)| a * b).sum();
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
}

/// Coefficients of a forcing as a function of the time over `unit`.
fn scaled(forcing: &Forcing, unit: f64) -> Forcing {
    let mut factor = 1.0;
    of_derivatives(*forcing).map(|f| {
        let scaled = f * factor;
        factor *= unit;
        scaled
    })
}

/// Impulse over the mass (m/s) and work (J) of the inputs on a motion along the path, for `tau` (s) from `flight` on,
/// whether or not the ball is in flight. `moved` is the displacement since the start, m.
pub(crate) fn integrals_of_inputs(
    ball: &BallModel,
    flight: &Flight,
    tau: f64,
    moved: &dyn Fn(f64) -> f64,
) -> RunningIntegrals {
    let mut sums = RunningIntegrals::default();
    if flight.forcing == Forcing::default() {
        return sums;
    }
    sums.support = integral_of(&flight.forcing, tau).into();
    // The horizontal displacement, without a difference of positions.
    let way = |t: f64| {
        let (moved, half) = (moved(t), 0.5 / ball.length);
        2.0 * ball.length * libm::sin(half * moved) * libm::cos(flight.x / ball.length + half * moved)
    };
    sums.work = ball.mass * forcing_at(&flight.forcing, tau) * way(tau);
    if degree(&flight.forcing) > 0 {
        // By parts, because displacements are smoother than velocities.
        let [_, a, b, c] = flight.forcing;
        let rest = |t: f64| forcing_at(&[a, b, c, 0.0], t) * way(t);
        sums.work -= ball.mass * gauss_legendre(&rest, 0.0, tau, 2);
    }
    sums
}

/// The anchor and the state that a flight begins with, and whether with a long step.
pub(super) type Origin = (DoubleDouble, Flight, bool);

/// The part of a flight that one [`Path`] describes.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub origin: Origin,
    pub start: DoubleDouble,
    /// State at the start of this part, and integrals up to there.
    pub flight: Flight,
    pub before: RunningIntegrals,
    pub path: Path,
    /// What ends the flight, in this part or before, and when.
    pub fault: Option<(DoubleDouble, Fault)>,
}

impl Piece {
    /// The first part of a flight.
    pub fn first(ball: &BallModel, origin: Origin) -> Self {
        let ((start, flight, long), before) = (origin, RunningIntegrals::default());
        let mut piece = Self { origin, start, flight, before, path: Path::new(ball, &flight, long), fault: None };
        piece.look_for_fault(ball);
        piece
    }

    /// Whether it is the first part of this flight or lies on the way from there to the time `t`.
    #[inline]
    pub fn leads_to(&self, origin: Origin, t: DoubleDouble) -> bool {
        let (anchor, ..) = origin;
        let forwards = anchor <= self.start && self.start <= t;
        let backwards = t <= self.start && self.start <= anchor;
        self.origin == origin && (self.start == anchor || if t > anchor { forwards } else { backwards })
    }

    fn look_for_fault(&mut self, ball: &BallModel) {
        if self.fault.is_none() {
            let fault = self.path.fault(ball, &self.flight);
            self.fault = fault.map(|(tau, fault)| (self.start + tau, fault));
        }
    }

    /// Whether it holds at the time `t`; also true for NaN, and for a part without length.
    #[inline]
    pub fn holds_at(&self, t: DoubleDouble) -> bool {
        let tau = (t - self.start).value();
        let length = self.length(tau);
        let beyond = tau.abs() > length && length > 0.0;
        !beyond
    }

    /// How long this part holds in the direction of `tau`, s.
    #[inline]
    fn length(&self, tau: f64) -> f64 {
        if tau < 0.0 { self.path.before } else { self.path.length }
    }

    /// Goes on to the part for the time `t`, by at most so many parts; returns whether that is reached.
    pub fn go_on(&mut self, ball: &BallModel, t: DoubleDouble, most: u64) -> bool {
        for _ in 0..most {
            if self.holds_at(t) {
                return true;
            }
            let tau = (t - self.start).value();
            let step = self.length(tau).copysign(tau);
            self.before = self.integrals(ball, step);
            self.flight = self.flight_at(step);
            self.start += step;
            self.path = Path::new(ball, &self.flight, true);
            self.look_for_fault(ball);
        }
        false
    }

    /// Displacement since the anchor of the flight (m) and velocity (m/s), `tau` (s) after the start of this part.
    pub fn moved(&self, tau: f64) -> (f64, f64) {
        let (displacement, u) = self.path.moved(tau);
        ((self.flight.x - self.origin.1.x) + displacement, u)
    }

    pub fn flight_at(&self, tau: f64) -> Flight {
        let (displacement, v) = self.path.moved(tau);
        let forcing = shifted(&self.flight.forcing, tau);
        Flight { x: self.flight.x + displacement, v, forcing }
    }

    /// Integrals since the anchor of the flight, up to `tau` (s) after the start of this part.
    pub fn integrals(&self, ball: &BallModel, tau: f64) -> RunningIntegrals {
        let mut sums = self.before;
        sums.add(&integrals_of_inputs(ball, &self.flight, tau, &|t| self.path.moved(t).0));
        if ball.gamma > 0.0 {
            let squared_velocity = |t: f64| self.path.moved(t).1.powi(2);
            sums.drag_loss += 2.0 * ball.gamma * ball.mass * gauss_legendre(&squared_velocity, 0.0, tau, 2);
        }
        sums
    }
}
