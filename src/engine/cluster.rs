//! A cluster: neighbouring balls held together by closed contacts, followed from switching to switching.
//!
//! The window of a cluster is its members and the ball in flight on either side (the spectators). One segment covers a stretch
//! of time on which nothing in the window switches and the Taylor series of all motions converge; its end is the next
//! switching or the end of convergence. The state is kept as displacements since the start of the segment and the overlaps
//! by themselves, because overlaps of 1e-8 m are not to be had as differences of positions.

use std::ops::Range;

use super::ball::{Ball, Flight, degree, shifted};
use super::taylor::{Control, Series};
use crate::model::{ContactLaw, Damping};
use crate::solver::double_double::DoubleDouble;
use crate::solver::series;

/// Whether and how a contact of a window acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// No overlap.
    Open,
    /// Overlap, the force follows the law.
    Pressing,
    /// Overlap, the law would pull and is clipped at zero.
    Clipped,
}

impl Mode {
    /// The mode of a closed contact with this overlap (m) and rate (m/s).
    pub fn of_closed(law: &ContactLaw, overlap: f64, rate: f64) -> Self {
        let clipped = match law.damping {
            Damping::HuntCrossley { alpha } => 1.0 + alpha * rate < 0.0,
            Damping::KelvinVoigt { c, pull: false } => law.elastic_force(overlap) + c * rate < 0.0,
            _ => false,
        };
        if clipped { Self::Clipped } else { Self::Pressing }
    }
}

/// A contact of the window at the start of the segment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WindowContact {
    pub overlap: f64,
    pub mode: Mode,
}

/// What ends a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Switch {
    Onset,
    Release,
    /// The force would begin to pull.
    Clip,
    /// The force would push again.
    Unclip,
}

/// Neighbouring balls in contact.
#[derive(Clone, Debug)]
pub(crate) struct Cluster {
    /// Balls that touch another one.
    pub members: Range<usize>,
    /// Members and spectators.
    pub window: Range<usize>,
    /// Start of the current segment.
    pub start: DoubleDouble,
    /// The balls of the window at the start of the segment.
    pub flights: Vec<Flight>,
    /// The contacts of the window, from `window.start` on, at the start of the segment.
    pub contacts: Vec<WindowContact>,
    /// The motion of the window on the current segment.
    pub series: Series,
    /// Length of the current segment, s.
    pub length: f64,
    /// What happens at its end, and in which contact.
    pub switch: Option<(usize, Switch)>,
}

impl Cluster {
    /// Contacts of the window, as indices of the cradle.
    pub fn window_contacts(&self) -> Range<usize> {
        self.window.start..self.window.end - 1
    }

    /// The entry that the cluster has in the event queue: its first contact between members.
    pub fn key(&self) -> usize {
        self.members.start
    }

    /// Time that the current segment ends.
    pub fn end(&self) -> DoubleDouble {
        self.start + self.length
    }

    /// Displacement of ball `i` of the window since the start of the segment (m) and its velocity (m/s), `tau` after it.
    pub fn moved(&self, i: usize, tau: f64) -> (f64, f64) {
        let c = self.series.displacement(i - self.window.start);
        (series::value(c, tau), series::derivative(c, tau))
    }

    /// Overlap (m) and its rate (m/s) in contact `i` of the window, `tau` after the start of the segment.
    pub fn overlap(&self, i: usize, tau: f64) -> (f64, f64) {
        let c = self.series.overlap(i - self.window.start);
        (series::value(c, tau), series::derivative(c, tau))
    }

    /// Mode of contact `i` on the segment.
    pub fn mode(&self, i: usize) -> Mode {
        self.contacts[i - self.window.start].mode
    }

    /// Impulse of contact `i` from the start of the segment to `tau`, N.s.
    pub fn impulse(&self, i: usize, tau: f64) -> f64 {
        match self.mode(i) {
            Mode::Pressing => series::integral(self.series.force(i - self.window.start), tau),
            Mode::Open | Mode::Clipped => 0.0,
        }
    }

    /// Largest force of contact `i` between `from` and `to` after the start of the segment, N.
    pub fn peak(&self, i: usize, from: f64, to: f64) -> f64 {
        match self.mode(i) {
            Mode::Pressing if from < to => series::maximum(self.series.force(i - self.window.start), from, to).max(0.0),
            _ => 0.0,
        }
    }

    /// Energy that contact `i` dissipates from the start of the segment to `tau`, J.
    pub fn contact_loss(&self, i: usize, law: &ContactLaw, tau: f64) -> f64 {
        if law.damping == Damping::None || self.mode(i) == Mode::Open {
            return 0.0;
        }
        let j = i - self.window.start;
        let excess = self.series.dissipative_force(j, self.mode(i) == Mode::Pressing);
        series::product_integral(&excess, &self.series.rate(j), tau)
    }

    /// What member `ball` (index `i`) gathers from the start of the segment to `tau`: see [`super::ball::Tally`].
    pub fn tally(&self, i: usize, ball: &Ball, tau: f64) -> super::ball::Tally {
        let j = i - self.window.start;
        let (flight, displacement) = (&self.flights[j], self.series.displacement(j));
        let mut tally = ball.tally;
        tally.x_integral += flight.x * tau + series::integral(displacement, tau);
        let gamma = ball.oscillator.gamma();
        if gamma > 0.0 {
            let v = self.series.velocity(j);
            tally.drag_loss += 2.0 * gamma * ball.mass * series::product_integral(&v, &v, tau);
        }
        tally.work += ball.mass
            * match degree(&flight.push) {
                0 => flight.push[0] * series::value(displacement, tau),
                _ => series::product_integral(&series::from_derivatives(&flight.push), &self.series.velocity(j), tau),
            };
        tally
    }

    /// Moves the start of the segment to `tau` later. The spectators are taken from their flights.
    pub fn move_start(&mut self, tau: f64, balls: &[Ball]) {
        self.start += tau;
        for (j, contact) in self.contacts.iter_mut().enumerate() {
            contact.overlap = series::value(self.series.overlap(j), tau);
        }
        for (j, flight) in self.flights.iter_mut().enumerate() {
            let i = self.window.start + j;
            *flight = if self.members.contains(&i) {
                let c = self.series.displacement(j);
                Flight {
                    x: flight.x + series::value(c, tau),
                    v: series::derivative(c, tau),
                    push: shifted(&flight.push, tau),
                }
            } else {
                balls[i].flight_at(self.start)
            };
        }
    }

    /// Expands the motions about the start of the segment and finds where the segment ends.
    pub fn expand(&mut self, balls: &[Ball], laws: &[ContactLaw], control: &Control) {
        let (balls, laws) = (&balls[self.window.clone()], &laws[self.window_contacts()]);
        self.series.expand(&self.flights, &self.contacts, balls, laws, control);
        self.length = self.series.converges_for();
        self.switch = None;
        for (j, law) in laws.iter().enumerate() {
            for (watched, falling, switch) in self.series.watches(j, law, self.contacts[j].mode) {
                let crossing = if falling {
                    let negative: Vec<f64> = watched.iter().map(|c| -c).collect();
                    series::first_positive(&negative, self.length)
                } else {
                    series::first_positive(&watched, self.length)
                };
                if let Some(tau) = crossing.filter(|&tau| tau < self.length || self.switch.is_none()) {
                    self.length = tau;
                    self.switch = Some((self.window.start + j, switch));
                }
            }
        }
    }
}
