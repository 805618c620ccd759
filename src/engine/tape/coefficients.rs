//! The order of the numbers of a state and of the coefficients.

use crate::model::{BallModel, ContactLaw, Cradle, Inputs};
use crate::solver::power::power;
use crate::solver::{Dual, Scalar};

/// Numbers of the state of a ball and of the contact at its right: position (m) and velocity (m/s) along the path;
/// impulse since the start, the same at the start of the last step (N.s), and largest force in that step (N); how much
/// later these hold (s), see [`TimeShift`](super::events::TimeShift); and, while the contact presses, its overlap (m),
/// which differences of the positions would not resolve.
pub(super) const STATE: usize = 7;
pub(super) const X: usize = 0;
pub(super) const V: usize = 1;
pub(super) const IMPULSE: usize = 2;
pub(super) const BEFORE: usize = 3;
pub(super) const PEAK: usize = 4;
pub(super) const TIME: usize = 5;
pub(super) const OVERLAP: usize = 6;

/// How many numbers the state of all balls has; the last is the momentum at the start of the last step, N.s.
pub(super) fn numbers_of_state(balls: usize) -> usize {
    balls * STATE + 1
}

/// Coefficients of a ball, then of the contact at its right: of its law, then of its geometry.
pub(super) const MASS: usize = 0;
pub(super) const GAMMA: usize = 1;
pub(super) const LENGTH: usize = 2;
pub(super) const GRAVITY: usize = 3;
pub(super) const FORCE: usize = 4;
const OF_BALL: usize = 5;
pub(super) const OF_LAW: usize = 4;
pub(super) const CLEARANCE: usize = OF_BALL + OF_LAW;
const PIVOTS: usize = CLEARANCE + 1;
pub(super) const RESTITUTION: usize = PIVOTS + 1;
const COEFFICIENTS: usize = RESTITUTION + 1;

/// Changes of the coefficients, ball by ball, then of the acceleration of the support; or the derivatives of a number
/// by these.
#[derive(Clone, Debug)]
pub(crate) struct Coefficients(Vec<f64>);

impl Coefficients {
    pub fn zero(balls: usize) -> Self {
        Self(vec![0.0; balls * COEFFICIENTS + 1])
    }

    /// The changes along a direction: of the coefficients by the tangents of `cradle`, of the inputs by `inputs`.
    pub fn along(cradle: &Cradle<Dual>, inputs: &Inputs) -> Self {
        let mut changes = Self::zero(cradle.balls.len());
        for (i, ball) in cradle.balls.iter().enumerate() {
            let BallModel { mass, gamma, length, gravity, .. } = *ball;
            changes.of_ball_mut(i)[..FORCE].copy_from_slice(&[mass, gamma, length, gravity].map(Dual::tangent));
            changes.of_ball_mut(i)[FORCE] = inputs.force[i];
            let Some(law) = cradle.contacts.get(i) else { continue };
            let ContactLaw { stiffness, overlap_ref, exponent, clearance, pivots, damping, restitution } = *law;
            let numbers = [stiffness, overlap_ref, exponent, damping.coefficient, clearance, pivots, restitution];
            changes.of_ball_mut(i)[OF_BALL..].copy_from_slice(&numbers.map(Dual::tangent));
        }
        *changes.support_mut() = inputs.support_acceleration;
        changes
    }

    /// The coefficients of ball `i` and of the contact at its right.
    pub fn of_ball(&self, i: usize) -> &[f64] {
        &self.0[i * COEFFICIENTS..][..COEFFICIENTS]
    }

    pub fn of_ball_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.0[i * COEFFICIENTS..][..COEFFICIENTS]
    }

    /// The coefficients of the law of contact `j`, in the order of [`law_derivatives`].
    pub fn of_law(&self, j: usize) -> &[f64; OF_LAW] {
        self.of_ball(j)[OF_BALL..].first_chunk().expect("a ball has more coefficients")
    }

    pub fn of_law_mut(&mut self, j: usize) -> &mut [f64; OF_LAW] {
        self.of_ball_mut(j)[OF_BALL..].first_chunk_mut().expect("a ball has more coefficients")
    }

    /// Changes of what the linkage of contact `j` depends on: 0 for the two places, then two lengths and the pivots.
    pub fn of_linkage(&self, j: usize) -> [f64; 5] {
        let (left, right) = (self.of_ball(j), self.of_ball(j + 1));
        [0.0, 0.0, left[LENGTH], right[LENGTH], left[PIVOTS]]
    }

    /// Adds derivatives by the lengths and the pivots of contact `j`.
    pub fn add_of_linkage(&mut self, j: usize, by: &[f64; 5]) {
        self.of_ball_mut(j + 1)[LENGTH] += by[3];
        let left = self.of_ball_mut(j);
        left[LENGTH] += by[2];
        left[PIVOTS] += by[4];
    }

    /// Whether the changes leave the flight of ball `i` as it is.
    pub fn leave(&self, i: usize) -> bool {
        self.support() == 0.0 && self.of_ball(i)[..OF_BALL].iter().all(|change| *change == 0.0)
    }

    /// Changes of the motion of ball `i` on a line: decay rate, square of the frequency, and acceleration by the
    /// inputs.
    pub fn of_motion(&self, i: usize, model: &BallModel) -> [f64; 3] {
        let of = self.of_ball(i);
        let frequency = (of[GRAVITY] - model.omega2 * of[LENGTH]) / model.length;
        [of[GAMMA], frequency, of[FORCE] / model.mass - self.support()]
    }

    /// Adds derivatives by decay rate, square of the frequency, and acceleration.
    pub fn add_of_motion(&mut self, i: usize, model: &BallModel, [gamma, frequency, forcing]: [f64; 3]) {
        *self.support_mut() -= forcing;
        let of = self.of_ball_mut(i);
        of[GAMMA] += gamma;
        of[GRAVITY] += frequency / model.length;
        of[LENGTH] -= frequency * model.omega2 / model.length;
        of[FORCE] += forcing / model.mass;
    }

    pub fn support(&self) -> f64 {
        self.0[self.0.len() - 1]
    }

    pub fn support_mut(&mut self) -> &mut f64 {
        let end = self.0.len();
        &mut self.0[end - 1]
    }

    /// The sum of the products with `changes`. A change can be infinite, for a restitution of 0 with a loss ratio below
    /// 1; where nothing depends on it, it does not count.
    pub fn dot(&self, changes: &Self) -> f64 {
        let acts = |(by, change): &(&f64, &f64)| **change != 0.0 && **by != 0.0;
        let products = self.0.iter().zip(&changes.0).filter(acts);
        products.map(|(by, change)| by * change).sum()
    }
}

/// Derivatives of the force of a contact by the coefficients of its law, at constant overlap (m) and rate (m/s).
pub(super) fn law_derivatives(law: &ContactLaw, overlap: f64, rate: f64) -> [f64; OF_LAW] {
    // A dashpot acts as soon as the contact has closed.
    let overlap = overlap.max(f64::MIN_POSITIVE);
    let (elastic, s) = (law.elastic_force(overlap), law.damping_exponent());
    let grown = power(overlap / law.overlap_ref, s) * rate;
    let damping = law.damping.coefficient * grown;
    let faster = law.damping.growth.exponent(Dual::with_tangent(law.exponent, 1.0)).tangent();
    let by_exponent = (elastic + faster * damping) * libm::log(overlap / law.overlap_ref);
    let by_reference = ((1.0 - law.exponent) * elastic - s * damping) / law.overlap_ref;
    [elastic / law.stiffness, by_reference, by_exponent, grown]
}
