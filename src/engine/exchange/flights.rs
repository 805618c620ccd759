//! Flight from the current state: on to the next onset with the inputs held, or back to one that was stepped over.

use super::run::Exchange;
use crate::engine::flight::{Ball, Flight, Separation};
use crate::engine::{Forecast, Unrecorded, run::Engine};
use crate::model::{BallModel, Mode, ONSET_PERIODS};
use crate::solver::{DoubleDouble, Smooth, root::rising_zero};

/// Farthest look back for an onset, in radians of the swing or decay times, or without gravity and drag in s. Far
/// beyond any step.
const LONGEST_LOOK_BACK: f64 = 1.5;

/// Largest effort of one look ahead, in units of about a tenth of a microsecond; the next event continues.
const LOOK_AHEAD: u64 = 40_000;

/// Times that differ by less than this part of the larger of 1 s and the time count as equal.
const SAME_TIME: f64 = 1e-13;

/// An approach by less than this part of the nominal speed is rounding.
const RESOLVED_SPEED: f64 = 1e-15;

impl Exchange {
    /// Largest difference between equal times, s.
    pub(super) fn margin(&self) -> f64 {
        SAME_TIME * self.time.abs().max(1.0)
    }

    /// The balls in flight from now on, anchored at the time 0, without closed contacts.
    pub(super) fn flights(&self) -> Vec<Ball> {
        let state = &self.state;
        let ball = |(i, model)| {
            let forcing = [state.forcings[i], 0.0, 0.0, 0.0];
            let mut ball = Ball::new(model, DoubleDouble::default(), Flight { x: state.x[i], v: state.v[i], forcing });
            // Hosts may have stepped far over an onset: series that look back should hold for long.
            ball.starts_long = true;
            ball
        };
        self.cradle.balls.iter().enumerate().map(ball).collect()
    }

    /// An engine for all balls from now on, its time 0.
    pub(super) fn engine_now(&self) -> Engine {
        self.engine_at(&self.flights(), &(0..self.balls()), 0.0, &self.closed(), &mut Unrecorded)
    }

    /// Relative motion of the balls of contact `j` along the flights of `balls`, `tau` (s) from now.
    pub(super) fn separation(&self, balls: &[Ball], j: usize, tau: f64) -> Separation {
        let from =
            |anchor, overlap| Separation::new(&balls[j], &balls[j + 1], anchor, overlap, &self.cradle.contacts[j]);
        let mut flight = from(DoubleDouble::ZERO, self.state.overlaps[j]);
        while let Some(end) = flight.end_before(tau.into()) {
            flight = from(end, flight.at_time(end).0);
        }
        flight
    }

    /// When the open contact `j` closed, relative to now (s), if it is due: its balls overlap and approach each other,
    /// or meet within the margin.
    pub(super) fn due_onset(&self, balls: &[Ball], j: usize) -> Option<f64> {
        let (overlap, rate) = self.overlap_and_rate(j);
        if self.is_followed(j) {
            return None;
        }
        if rate.is_nan() || rate <= RESOLVED_SPEED * self.scales.speed {
            // Balls that touch within rounding may be about to press each other slowly. If the event announced for that
            // did not close the contact, it would be announced again and again.
            let announced =
                matches!(self.next, Forecast::At(time) if time <= self.time) && self.next_contact == Some(j);
            let still = rate.abs() <= RESOLVED_SPEED * self.scales.speed;
            let due = announced && still && overlap.abs() <= self.separation(balls, j, 0.0).rounding;
            return due.then_some(0.0);
        }
        if overlap > 0.0 {
            return Some(self.place_of_touch(balls, j, 0.0).unwrap_or(0.0));
        }
        (-overlap <= rate * self.margin()).then_some(-overlap / rate)
    }

    /// Whether an event has followed contact `j` beyond now.
    pub(super) fn is_followed(&self, j: usize) -> bool {
        self.contacts[j].followed_until.is_some_and(|until| until > self.time)
    }

    /// When the flight of the balls of contact `j` begins, relative to now (s): when they part, or up to when an event
    /// has followed them. `None` if that is not after the time `from`.
    pub(super) fn parting(&self, balls: &[Ball], j: usize, from: f64) -> Option<f64> {
        let followed = self.contacts[j].followed_until.map(|until| until - self.time).filter(|until| *until > from);
        let from = followed.unwrap_or(from);
        let (overlap, rate) = self.separation(balls, j, from).at_time(from.into());
        let parts = if overlap > 0.0 && rate < 0.0 { self.place_of_touch(balls, j, from) } else { None };
        parts.filter(|parting| *parting > from).or(followed)
    }

    /// When the overlap of a contact, positive at the time `from`, is 0, relative to now (s): before `from` if the
    /// balls approach each other, after it if they part. `None` if that is out of reach.
    fn place_of_touch(&self, balls: &[Ball], j: usize, from: f64) -> Option<f64> {
        let at = |tau: f64| {
            let flight = self.separation(balls, j, tau);
            flight.at(tau - flight.anchor.value())
        };
        let pace = |ball: &BallModel| ball.omega2.sqrt() + 2.0 * ball.gamma;
        let pace = self.cradle.balls.iter().map(pace).fold(0.0, f64::max);
        let farthest = if pace > 0.0 { LONGEST_LOOK_BACK / pace } else { LONGEST_LOOK_BACK };
        let [overlap, rate, _] = at(from);
        let mut way = -overlap / rate;
        if way == 0.0 {
            return Some(from); // Too near to resolve.
        }
        while at(from + way.clamp(-farthest, farthest))[0] > 0.0 {
            if way.abs() >= farthest {
                return None;
            }
            way *= 2.0;
        }
        way = way.clamp(-farthest, farthest);
        let gap = |share: f64| {
            let [overlap, rate, acceleration] = at(from + share * way);
            [-overlap, -rate * way, -acceleration * way * way]
        };
        Some(from + way * rising_zero(gap, (0.0, -overlap), (1.0, gap(1.0)[0])))
    }

    /// The next onset after now, as far as [`Engine::find_next_onset`] would look, and its contact.
    pub(super) fn find_next_onset(&self) -> (Forecast, Option<usize>) {
        if !self.is_rigid() && self.modes.iter().any(|mode| *mode != Mode::Open) {
            return (Forecast::not_before(self.time, self.time), None);
        }
        let mut engine = self.engine_now();
        let limit = DoubleDouble::from(ONSET_PERIODS * self.cradle.period());
        let earliest = (self.time + self.margin()).max(self.time.next_up());
        let later = |tau: DoubleDouble| (DoubleDouble::from(self.time) + tau).value_up().max(earliest);
        // Events due now come at the next representable time.
        match engine.seek_onset(engine.onsets, f64::NEG_INFINITY, limit, LOOK_AHEAD) {
            Forecast::At((tau, contact)) => (Forecast::At(later(tau)), contact.filter(|_| !self.is_rigid())),
            Forecast::NotBefore((tau, _)) => (Forecast::NotBefore(later(tau)), None),
            Forecast::Never => (Forecast::Never, None),
        }
    }
}
