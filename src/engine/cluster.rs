//! A cluster: neighbouring balls held together by closed contacts, followed from switching to switching.
//!
//! The window of a cluster is its members and the ball in flight on either side (the spectators). One segment covers a stretch
//! of time on which nothing in the window switches and the Taylor series of all motions converge; its end is the next
//! switching or the end of convergence. The state is kept as displacements since the start of the segment and the overlaps
//! by themselves, because overlaps of 1e-8 m are not to be had as differences of positions.

use std::ops::Range;

use super::ball::{Ball, Flight, Tally, shifted};
use super::taylor::{Control, Series};
use crate::model::{ContactLaw, Damping};
use crate::solver::double_double::DoubleDouble;

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
        self.series.moved(i - self.window.start, tau)
    }

    /// Overlap (m) and its rate (m/s) in contact `i` of the window, `tau` after the start of the segment.
    pub fn overlap(&self, i: usize, tau: f64) -> (f64, f64) {
        self.series.overlap(i - self.window.start, tau)
    }

    /// Mode of contact `i` on the segment.
    pub fn mode(&self, i: usize) -> Mode {
        self.contacts[i - self.window.start].mode
    }

    /// Impulse of contact `i` from the start of the segment to `tau`, N.s.
    pub fn impulse(&self, i: usize, tau: f64) -> f64 {
        match self.mode(i) {
            Mode::Pressing => self.series.impulse(i - self.window.start, tau),
            Mode::Open | Mode::Clipped => 0.0,
        }
    }

    /// Largest force of contact `i` between `from` and `to` after the start of the segment, N.
    pub fn peak(&self, i: usize, from: f64, to: f64) -> f64 {
        match self.mode(i) {
            Mode::Pressing if from < to => self.series.peak(i - self.window.start, from, to).max(0.0),
            _ => 0.0,
        }
    }

    /// Energy that contact `i` dissipates from the start of the segment to `tau`, J.
    pub fn contact_loss(&self, i: usize, law: &ContactLaw, tau: f64) -> f64 {
        if law.damping == Damping::None || self.mode(i) == Mode::Open {
            return 0.0;
        }
        self.series.contact_loss(i - self.window.start, self.mode(i) == Mode::Pressing, tau)
    }

    /// What member `ball` (index `i`), which had gathered `tally` at the start of the segment, has gathered `tau` after it.
    pub fn tally(&self, i: usize, tally: &Tally, ball: &Ball, tau: f64) -> Tally {
        let j = i - self.window.start;
        let flight = &self.flights[j];
        let mut tally = *tally;
        tally.x_integral += flight.x * tau + self.series.displacement_integral(j, tau);
        tally.work += ball.mass * self.series.work(j, &flight.push, tau);
        let gamma = ball.oscillator.gamma();
        if gamma > 0.0 {
            tally.drag_loss += 2.0 * gamma * ball.mass * self.series.squared_velocity_integral(j, tau);
        }
        tally
    }

    /// Moves the start of the segment to `tau` later. The spectators are taken from their flights.
    pub fn move_start(&mut self, tau: f64, balls: &[Ball]) {
        self.start += tau;
        for (j, contact) in self.contacts.iter_mut().enumerate() {
            contact.overlap = self.series.overlap(j, tau).0;
        }
        for (j, flight) in self.flights.iter_mut().enumerate() {
            let i = self.window.start + j;
            *flight = if self.members.contains(&i) {
                let (displacement, v) = self.series.moved(j, tau);
                Flight { x: flight.x + displacement, v, push: shifted(&flight.push, tau) }
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
            if let Some((tau, switch)) = self.series.first_switch(j, law, self.contacts[j].mode, self.length) {
                self.length = tau;
                self.switch = Some((self.window.start + j, switch));
            }
        }
    }
}
