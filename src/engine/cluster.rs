//! A cluster: neighbouring balls held together by closed contacts, followed from switching to switching.
//!
//! The window of a cluster is its members and the ball in flight on either side (the spectators). One segment covers a stretch
//! of time on which nothing in the window switches and the Taylor series of all motions converge; its end is the next
//! switching or the end of convergence. The state is kept as displacements since the start of the segment and the overlaps
//! by themselves, because overlaps of 1e-8 m are not to be had as differences of positions.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::ball::{Ball, Flight, Rounding, Tally, shifted};
use super::modes::{self, Modes};
use super::taylor::{Control, Series};
use crate::model::{ContactLaw, Damping};
use crate::solver::double_double::DoubleDouble;

/// Whether and how a contact of a window acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
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
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
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

/// How the motion of a window is described.
#[derive(Clone, Debug)]
pub(crate) enum Motion {
    Series(Series),
    Modes(Modes),
}

/// Calls the same method of whatever describes the motion.
macro_rules! of_motion {
    ($motion:expr, $method:ident($($argument:expr),*)) => {
        match &$motion {
            Motion::Series(series) => series.$method($($argument),*),
            Motion::Modes(modes) => modes.$method($($argument),*),
        }
    };
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
    pub motion: Motion,
    /// Segments since the last switching, and how many it were when the current one began.
    pub quiet: u32,
    pub quiet_before: u32,
    /// Length of the current segment, s.
    pub length: f64,
    /// What happens at its end, and in which contact.
    pub switch: Option<(usize, Switch)>,
}

impl Cluster {
    /// The balls `members`, and as spectators those beside them that are in `window`. The motion is left to
    /// [`Self::expand`], with the number of segments since the last switching.
    pub fn new(
        members: Range<usize>,
        window: Range<usize>,
        start: DoubleDouble,
        flights: Vec<Flight>,
        contacts: Vec<WindowContact>,
        quiet: u32,
    ) -> Self {
        let motion = Motion::default();
        Self {
            members,
            window,
            start,
            flights,
            contacts,
            motion,
            quiet,
            quiet_before: quiet,
            length: 0.0,
            switch: None,
        }
    }

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
        let j = i - self.window.start;
        let (displacement, change) = of_motion!(self.motion, moved(j, tau));
        (displacement, self.flights[j].v + change)
    }

    /// Overlap (m) and its rate (m/s) in contact `i` of the window, `tau` after the start of the segment.
    pub fn overlap(&self, i: usize, tau: f64) -> (f64, f64) {
        let j = i - self.window.start;
        let (overlap, change) = of_motion!(self.motion, overlap(j, tau));
        (overlap, (self.flights[j].v - self.flights[j + 1].v) + change)
    }

    /// Mode of contact `i` on the segment.
    pub fn mode(&self, i: usize) -> Mode {
        self.contacts[i - self.window.start].mode
    }

    /// Impulse of contact `i` from the start of the segment to `tau`, N.s.
    pub fn impulse(&self, i: usize, tau: f64) -> f64 {
        match self.mode(i) {
            Mode::Pressing => of_motion!(self.motion, impulse(i - self.window.start, tau)),
            Mode::Open | Mode::Clipped => 0.0,
        }
    }

    /// The larger of `known` and the largest force of contact `i` between `from` and `to` after the start of the segment, N.
    pub fn peak(&self, i: usize, from: f64, to: f64, known: f64) -> f64 {
        match self.mode(i) {
            Mode::Pressing if from < to => of_motion!(self.motion, peak(i - self.window.start, from, to, known)),
            _ => known,
        }
    }

    /// Energy that contact `i` dissipates from the start of the segment to `tau`, J.
    pub fn contact_loss(&self, i: usize, law: &ContactLaw, tau: f64) -> f64 {
        match self.mode(i) {
            Mode::Pressing if law.damping != Damping::None => {
                of_motion!(self.motion, contact_loss(i - self.window.start, tau))
            }
            // The spring gives back nothing of what it holds.
            Mode::Clipped => {
                let before = self.contacts[i - self.window.start].overlap;
                law.elastic_energy(before) - law.elastic_energy(self.overlap(i, tau).0)
            }
            _ => 0.0,
        }
    }

    /// What member `ball` (index `i`), which had gathered `tally` at the start of the segment, has gathered `tau` after it.
    pub fn tally(&self, i: usize, tally: &Tally, ball: &Ball, tau: f64) -> Tally {
        let j = i - self.window.start;
        let flight = &self.flights[j];
        let mut tally = *tally;
        tally.x_integral += flight.x * tau + of_motion!(self.motion, displacement_integral(j, tau));
        tally.work += ball.mass
            * match &self.motion {
                Motion::Series(series) => series.work(j, &flight.push, tau),
                Motion::Modes(modes) => flight.push[0] * modes.moved(j, tau).0,
            };
        let gamma = ball.oscillator.gamma();
        if gamma > 0.0 {
            tally.drag_loss += 2.0 * gamma * ball.mass * of_motion!(self.motion, squared_velocity_integral(j, tau));
        }
        tally
    }

    /// Moves the start of the segment to `tau` later. The spectators are taken from their flights.
    pub fn move_start(&mut self, tau: f64, balls: &[Ball]) {
        self.start += tau;
        for (j, contact) in self.contacts.iter_mut().enumerate() {
            contact.overlap = of_motion!(self.motion, overlap(j, tau)).0;
        }
        for (j, flight) in self.flights.iter_mut().enumerate() {
            let i = self.window.start + j;
            *flight = if self.members.contains(&i) {
                let (displacement, change) = of_motion!(self.motion, moved(j, tau));
                Flight { x: flight.x + displacement, v: flight.v + change, push: shifted(&flight.push, tau) }
            } else {
                balls[i].flight_at(self.start)
            };
        }
    }

    /// Describes the motion from the start of the segment on and finds where the segment ends.
    ///
    /// Right after a switching it is series: they keep the exact zeros of balls that the motion has not reached. Once some
    /// segments have passed without any switching, the contacts are stiff for the pace of the motion, or closed for long.
    pub fn expand(&mut self, balls: &[Ball], laws: &[ContactLaw], control: &Control) {
        let (balls, laws) = (&balls[self.window.clone()], &laws[self.window_contacts()]);
        let damped = laws.iter().any(|law| law.damping != Damping::None);
        let patience = if damped { 3 } else { 12 };
        if self.quiet > patience && modes::apply_to(&self.flights, &self.contacts, balls, laws) {
            let modes = Modes::new(&self.flights, &self.contacts, balls, laws);
            self.length = self.horizon(modes.highest_frequency());
            self.motion = Motion::Modes(modes);
        } else {
            let mut series = match std::mem::take(&mut self.motion) {
                Motion::Series(series) => series,
                Motion::Modes(_) => Series::default(),
            };
            series.expand(&self.flights, &self.contacts, balls, laws, control);
            self.length = series.converges_for();
            self.motion = Motion::Series(series);
        }
        self.quiet_before = self.quiet;
        self.switch = None;
        let rounding = self.flights.iter().zip(balls).map(|(flight, ball)| flight.rounding(&ball.oscillator));
        let rounding = rounding.fold(Rounding::default(), Rounding::max);
        for (j, law) in laws.iter().enumerate() {
            let switch = of_motion!(self.motion, first_switch(j, law, self.contacts[j].mode, self.length, &rounding));
            if let Some((tau, switch)) = switch {
                self.length = tau;
                self.switch = Some((self.window.start + j, switch));
            }
        }
        self.quiet = if self.switch.is_some() { 0 } else { self.quiet.saturating_add(1) };
    }

    /// How far ahead switchings are looked for, s: some oscillations at first, more and more while nothing happens.
    fn horizon(&self, frequency: f64) -> f64 {
        let first = if frequency > 0.0 { 16.0 / frequency } else { 1.0 };
        (first * libm::exp2(self.quiet.min(60) as f64)).min(LONGEST)
    }
}

/// Longest segment, s.
const LONGEST: f64 = 1e6;

impl Default for Motion {
    fn default() -> Self {
        Self::Series(Series::default())
    }
}
