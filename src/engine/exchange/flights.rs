//! Flight from the current state, forwards and backwards: where the host's integration has gone past an onset, an event
//! goes back.

use super::run::Exchange;
use crate::engine::flight::{Ball, Flight};
use crate::next::Next;
use crate::solver::double_double::DoubleDouble;

/// How far back an onset is looked for, in radians of the pendulums' swing or decay times, or in s without gravity and
/// drag: far beyond a step of any integration.
const FARTHEST: f64 = 1.5;

/// Steps of Newton's method and of bisection for an onset in the past.
const STEPS: usize = 200;

/// Part of the time within which two events count as one: 1e-13 of the larger of 1 s and the time.
const SAME_TIME: f64 = 1e-13;

/// An approach by less than this part of the nominal speed is rounding.
const RESOLVED: f64 = 1e-15;

impl Exchange {
    /// What counts as the same time, s.
    pub(super) fn margin(&self) -> f64 {
        SAME_TIME * self.time.abs().max(1.0)
    }

    /// The balls as they fly from now on, anchored at the time 0, but for contacts that are closed.
    pub(super) fn flights(&self) -> Vec<Ball> {
        let state = &self.state;
        let ball = |(i, model)| {
            let forcing = [state.forcings[i], 0.0, 0.0, 0.0];
            Ball::new(model, DoubleDouble::default(), Flight { x: state.x[i], v: state.v[i], forcing })
        };
        self.cradle.balls.iter().enumerate().map(ball).collect()
    }

    /// Overlap of contact `j` (m) and its rate (m/s) `tau` (s) from now, along the flights of `balls`.
    pub(super) fn overlap_in_flight(&self, balls: &[Ball], j: usize, tau: f64) -> (f64, f64) {
        let [(left, v_left), (right, v_right)] = [j, j + 1].map(|i| balls[i].moved(tau.into()));
        (self.state.overlaps[j] + (left - right), v_left - v_right)
    }

    /// When contact `j` closes, from now (s), if it is open and that is now or past: its balls overlap and approach
    /// each other, or they meet within the margin.
    pub(super) fn due_onset(&self, balls: &[Ball], j: usize) -> Option<f64> {
        let (overlap, rate) = self.overlap_and_rate(j);
        if self.is_followed(j) {
            return None;
        }
        if rate.is_nan() || rate <= RESOLVED * self.scales.speed {
            return self.begins_to_press(balls, j).then_some(0.0);
        }
        if overlap > 0.0 {
            return Some(self.past_onset(balls, j).unwrap_or(0.0));
        }
        (-overlap <= rate * self.margin()).then_some(-overlap / rate)
    }

    /// Whether the onset of contact `j` was announced for now, and its balls touch but for rounding: side by side, they
    /// are about to press each other, however slowly. That event closes the contact; without, it would be announced for
    /// ever.
    pub(super) fn begins_to_press(&self, balls: &[Ball], j: usize) -> bool {
        let noise = balls[j..j + 2].iter().map(|ball| ball.flight.rounding(&ball.oscillator).position);
        let is_due = matches!(self.next, Next::At(time) if time <= self.time) && self.next_contact == Some(j);
        let (overlap, rate) = self.overlap_and_rate(j);
        is_due && overlap.abs() <= noise.fold(0.0, f64::max) && rate.abs() <= RESOLVED * self.scales.speed
    }

    /// Whether an event has followed contact `j` to later than now.
    pub(super) fn is_followed(&self, j: usize) -> bool {
        self.contacts[j].followed_until.is_some_and(|until| until > self.time)
    }

    /// When the flight of the balls of contact `j` begins, from now (s), if at the time `from` (s from now) it has yet
    /// to: where they part, or where an event has followed them to.
    pub(super) fn parting(&self, balls: &[Ball], j: usize, from: f64) -> Option<f64> {
        let followed = self.contacts[j].followed_until.map(|until| until - self.time).filter(|until| *until > from);
        self.parting_after(balls, j, followed.unwrap_or(from)).or(followed)
    }

    /// When the balls of contact `j` part, from now (s), if at the time `from` (s from now) they overlap and have yet
    /// to.
    fn parting_after(&self, balls: &[Ball], j: usize, from: f64) -> Option<f64> {
        let (overlap, rate) = self.overlap_in_flight(balls, j, from);
        if overlap.is_nan() || overlap <= 0.0 || rate >= 0.0 {
            return None;
        }
        let mut tau = from;
        for _ in 0..STEPS {
            let (overlap, rate) = self.overlap_in_flight(balls, j, tau);
            let next = tau - overlap / rate;
            if (next - tau).abs() <= f64::EPSILON * tau.abs() {
                break;
            }
            tau = next;
        }
        (tau > from && tau.is_finite()).then_some(tau)
    }

    /// When contact `j`, which overlaps and whose balls approach each other, has closed, from now (s, <= 0); nothing if
    /// it cannot be told.
    fn past_onset(&self, balls: &[Ball], j: usize) -> Option<f64> {
        let (overlap, rate) = self.overlap_and_rate(j);
        let pace = |ball: &Ball| ball.oscillator.omega() + 2.0 * ball.oscillator.gamma();
        let pace = pace(&balls[j]).max(pace(&balls[j + 1]));
        let farthest = if pace > 0.0 { -FARTHEST / pace } else { -FARTHEST };
        let mut late = 0.0;
        let mut early = -overlap / rate;
        while self.overlap_in_flight(balls, j, early.max(farthest)).0 > 0.0 {
            if early <= farthest {
                return None;
            }
            (late, early) = (early, 2.0 * early);
        }
        early = early.max(farthest);
        // Newton's method, kept within what brackets the onset.
        let mut tau = early;
        for _ in 0..STEPS {
            let (overlap, rate) = self.overlap_in_flight(balls, j, tau);
            if overlap > 0.0 {
                late = tau
            } else {
                early = tau
            }
            let newton = tau - overlap / rate;
            let next = if newton >= early && newton <= late { newton } else { 0.5 * (early + late) };
            if next == tau || (next - tau).abs() <= f64::EPSILON * tau.abs() {
                return Some(next);
            }
            tau = next;
        }
        Some(tau)
    }
}
