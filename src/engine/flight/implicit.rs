//! The motion of a ball on a step of implicit collocation. A flight on an arc takes such steps where strong drag keeps
//! power series of the time short. See "Implicit collocation" in docs/theory.md for the equations.

use std::f64::consts::FRAC_PI_2;

use super::free_motion::{Flight, LONGEST_FLIGHT_STEP, forcing_at};
use crate::model::BallModel;
use crate::solver::Oscillator;
use crate::solver::radau::{Matrix, RADAU, STAGES, Stages, inverse};

/// Most iterations for the places of a ball on its arc, and the change, over the length of the pendulum, below which
/// they are known to rounding.
pub(crate) const PLACE_ITERATIONS: usize = 24;
const SAME_PLACE: f64 = 4.0 * f64::EPSILON;

/// Longest step over the time in which the slow part of the motion decays, and shortest step over that by power series.
const OF_DECAY: f64 = 0.5;
const GAIN: f64 = 20.0;

/// The fast part of the motion has decayed if the acceleration exceeds twice that of the slow part by less than this
/// part of gravity and inputs.
const SETTLED: f64 = 1e-12;

/// Allowed size of the highest terms of the velocities, over the largest.
const ALLOWED: f64 = 2e-14;

/// Smallest error allowed, in roundings: differences of the ninth order magnify rounding.
pub(crate) const LEAST_ROUNDINGS: f64 = 100.0;

/// The next step over the one that the error allows, the largest growth of a step, and its factors after too large an
/// error and after one that says nothing (Hairer and Wanner, Solving Ordinary Differential Equations II, 1996, IV.8).
const SAFETY: f64 = 0.9;
const GROWTH: f64 = 4.0;
const SHRINKAGE: [f64; 2] = [0.1, 0.7];
const FAILED: f64 = 0.25;

/// Ratio of the next step to the last one, from the `error` of the last one over the allowed error, not finite if the
/// step failed.
pub(crate) fn next_length(error: f64) -> f64 {
    // The order of the error is the number of stages; a failed step says nothing about it.
    let change = SAFETY * libm::pow(error, -1.0 / STAGES as f64);
    match error {
        _ if error <= 1.0 => change.min(GROWTH),
        _ if error.is_finite() => change.clamp(SHRINKAGE[0], SHRINKAGE[1]),
        _ => FAILED,
    }
}

/// Size of the two highest terms of a polynomial on [0, 1] in Legendre polynomials, from its coefficients of powers.
pub(crate) fn highest_terms(c: &[f64]) -> f64 {
    let n = c.len() - 1;
    let leading = |k: usize| (1..=k).fold(1.0, |product, i| product * (k + i) as f64 / i as f64);
    let last = c[n] / leading(n);
    let before = (c[n - 1] + 0.5 * n as f64 * c[n]) / leading(n - 1);
    last.abs().max(before.abs())
}

/// Acceleration at the time `t` (s) of a ball that keeps its velocity, without contact forces, m/s2.
pub(crate) fn free_acceleration(o: &Oscillator, flight: &Flight, t: f64) -> f64 {
    forcing_at(&flight.forcing, t) - o.omega2() * (flight.x + flight.v * t) - 2.0 * o.gamma() * flight.v
}

/// Response of a pendulum to an acceleration given at the stages.
#[derive(Clone)]
pub(crate) struct Response {
    pub velocity: Matrix,
    pub displacement: Matrix,
}

impl Response {
    /// On a step of this length, s.
    pub fn new(o: &Oscillator, length: f64) -> Self {
        let integral = RADAU.integral * length;
        let twice = integral * integral;
        let pendulum = inverse(&(Matrix::identity() + 2.0 * o.gamma() * integral + o.omega2() * twice));
        Self { velocity: integral * pendulum, displacement: twice * pendulum }
    }
}

/// A ball at the stages of a step.
pub(crate) struct BallStages {
    pub response: Response,
    /// Its acceleration [without contact forces](free_acceleration), and what its arc adds, m/s2.
    pub free_acceleration: Stages,
    pub arc_correction: Stages,
    /// Its displacement along an arc since the start, m.
    pub moved: Stages,
}

impl BallStages {
    pub fn new(response: Response, o: &Oscillator, flight: &Flight, times: &Stages) -> Self {
        let free_acceleration = times.map(|t| free_acceleration(o, flight, t));
        Self { response, free_acceleration, arc_correction: Stages::zeros(), moved: Stages::zeros() }
    }

    /// Improves its motion along its arc by one iteration, with the accelerations `pressed` of contact forces (m/s2).
    /// Returns whether its places are known to rounding; `None` if it swings beyond 90 degrees.
    pub fn move_by(&mut self, model: &BallModel, flight: &Flight, times: &Stages, pressed: &Stages) -> Option<bool> {
        let moved =
            flight.v * times + self.response.displacement * (self.free_acceleration + self.arc_correction + pressed);
        let change = (moved - self.moved).amax();
        self.moved = moved;
        let places = moved.add_scalar(flight.x);
        let correction = |place: f64, t: f64| model.arc_correction(place, forcing_at(&flight.forcing, t));
        self.arc_correction = places.zip_map(times, correction);
        (places.amax() < FRAC_PI_2 * model.length).then_some(change <= SAME_PLACE * model.length)
    }

    /// Its velocities with the accelerations `pressed` of contact forces (m/s2), m/s.
    pub fn velocities(&self, flight: &Flight, pressed: &Stages) -> Stages {
        (self.response.velocity * (self.free_acceleration + self.arc_correction + pressed)).add_scalar(flight.v)
    }
}

/// A step of a flight on an arc, if it is many times longer than that `by_series` (s): its length (s), and the velocity
/// (m/s) as a polynomial of the time over that length.
pub(super) fn step(ball: &BallModel, flight: &Flight, by_series: f64) -> Option<(f64, [f64; STAGES + 1])> {
    let BallModel { omega2, gamma, gravity, .. } = *ball;
    // How strongly the forces along the path may change with the place, 1/s2.
    let stiffness = omega2 + flight.forcing[0].abs() / ball.length;
    let mut length = (OF_DECAY * 2.0 * gamma / stiffness).min(LONGEST_FLIGHT_STEP);
    // Only if it is drag that keeps the series short: then they cover at least one of its decay times.
    let pays = |length: f64| length >= GAIN * by_series && 2.0 * gamma * by_series >= 1.0;
    if !pays(length) {
        return None;
    }
    let (sin, cos) = libm::sincos(flight.x / ball.length);
    let (restoring, forcing) = (gravity * sin, flight.forcing[0] * cos);
    let acceleration = forcing - restoring - 2.0 * gamma * flight.v;
    let (forces, slow) = (forcing.abs() + restoring.abs(), stiffness * flight.v.abs() + flight.forcing[1].abs());
    let settled = acceleration.abs() <= SETTLED * forces + slow / gamma;
    // Rounding of the velocity at which drag balances gravity and inputs, m/s.
    let rounding = f64::EPSILON * forces / (2.0 * gamma);
    let oscillator = Oscillator::new(omega2, gamma);
    while settled && pays(length) {
        let error = match velocities(ball, &oscillator, flight, length) {
            Some(velocities) => {
                let polynomial = RADAU.polynomial_from(flight.v, &velocities);
                let allowed = (ALLOWED * velocities.amax()).max(LEAST_ROUNDINGS * rounding);
                let error = highest_terms(&polynomial) / allowed;
                if error <= 1.0 {
                    return Some((length, polynomial));
                }
                error
            }
            None => f64::INFINITY,
        };
        length *= next_length(error);
    }
    None
}

fn velocities(ball: &BallModel, o: &Oscillator, flight: &Flight, length: f64) -> Option<Stages> {
    let (times, none) = (RADAU.nodes * length, Stages::zeros());
    let mut stages = BallStages::new(Response::new(o, length), o, flight, &times);
    for _ in 0..PLACE_ITERATIONS {
        if stages.move_by(ball, flight, &times, &none)? {
            return Some(stages.velocities(flight, &none));
        }
    }
    None
}
