//! A window: neighbouring balls and the contacts between them, at the start of a segment; and what a method must say of
//! its motion ([`DenseOutput`]).

use serde::{Deserialize, Serialize};

use crate::engine::flight::{Ball, Flight, Forcing, Rounding};
use crate::engine::{Forecast, Peak};
use crate::model::{BallModel, ContactLaw, MAX_OUTPUT_DERIVATIVE, Mode, Pair};

/// A contact that a wave has yet to reach has a load of less than this part of the largest.
const NEGLIGIBLE_LOAD: f64 = 1e-4;

/// In a chain, damping of a contact below this times `sqrt(k m)` lets the balls oscillate, or nearly so.
const RINGING: f64 = 3.0;

/// A contact at the start of a segment, or during an event while nothing else governs it.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct WindowContact {
    /// Overlap, m.
    pub overlap: f64,
    pub mode: Mode,
}

/// The balls and contacts of a window at the start of a segment, or of a whole chain. Contact `j` lies between balls
/// `j` and `j + 1`.
#[derive(Clone, Copy)]
pub(crate) struct Window<'a> {
    pub flights: &'a [Flight],
    pub models: &'a [BallModel],
    /// The same balls in a run, with their oscillators; empty for a whole chain.
    pub balls: &'a [Ball],
    pub contacts: &'a [WindowContact],
    pub laws: &'a [ContactLaw],
}

impl Window<'_> {
    /// The balls and the law of contact `j`.
    pub fn pair(&self, j: usize) -> Pair<'_> {
        Pair { balls: [&self.models[j], &self.models[j + 1]], law: &self.laws[j] }
    }

    /// Components of the direction of contact `j` along the paths of its balls.
    pub fn parts_along(&self, j: usize) -> [f64; 2] {
        self.pair(j).parts_along([j, j + 1].map(|i| self.flights[i].x))
    }

    /// Rate of the overlap of contact `j`, m/s.
    pub fn overlap_rate(&self, j: usize) -> f64 {
        self.pair(j).overlap_rate([j, j + 1].map(|i| (self.flights[i].x, self.flights[i].v)))
    }

    /// Reduced mass of the balls of contact `j`, kg.
    pub fn reduced_mass(&self, j: usize) -> f64 {
        let [left, right] = [j, j + 1].map(|i| self.models[i].mass);
        left * right / (left + right)
    }

    /// Whether there is a contact `j` and it presses.
    pub fn presses(&self, j: usize) -> bool {
        self.contacts.get(j).is_some_and(|contact| contact.mode == Mode::Pressing)
    }

    /// Whether the force of contact `j` by its law is needed: it presses, or only the force tells when it will again.
    pub fn needs_force(&self, j: usize) -> bool {
        match self.contacts[j].mode {
            Mode::Open => false,
            Mode::Pressing => true,
            Mode::Clipped => self.laws[j].sign_of_force().is_none(),
        }
    }
}

impl Window<'_> {
    /// Whether the front of a wave has yet to pass a contact: one exactly in touch and at rest, or closed but hardly
    /// pressed or moved compared to others.
    pub fn holds_front(&self) -> bool {
        // Force of a contact (N) and rate of its overlap (m/s), as large as they may soon be.
        let load = |(j, contact): (usize, &WindowContact)| {
            let (law, mass) = (&self.laws[j], self.reduced_mass(j));
            let (overlap, rate) = (contact.overlap.abs(), (self.flights[j].v - self.flights[j + 1].v).abs());
            let impedance = law.impedance(mass);
            let load = [law.stiffness * overlap + impedance * rate, impedance / mass * overlap + rate];
            (contact.mode != Mode::Open || load == [0.0; 2]).then_some(load)
        };
        let loads = self.contacts.iter().enumerate().filter_map(load);
        let largest = loads.clone().fold([0.0_f64; 2], |most, load| [most[0].max(load[0]), most[1].max(load[1])]);
        loads.into_iter().any(|load| (0..2).all(|k| load[k] < NEGLIGIBLE_LOAD * largest[k]))
    }

    /// Whether the window moves by linear equations between switchings.
    pub fn is_linear(&self) -> bool {
        !self.models[0].on_arc && self.laws.iter().all(ContactLaw::is_linear)
    }

    /// Whether a closed contact, as part of a chain, has so little damping that the balls oscillate, or nearly so.
    pub fn rings(&self) -> bool {
        let rings = |j: usize| {
            let law = &self.laws[j];
            law.damping_coefficient() < RINGING * (law.stiffness * self.reduced_mass(j)).sqrt()
        };
        self.contacts.iter().enumerate().any(|(j, contact)| contact.mode != Mode::Open && rings(j))
    }
}

/// Coefficients of an overlap: as many as the highest derivative by time of its force needs, one more for a dashpot.
pub(crate) type OverlapSeries = [f64; MAX_OUTPUT_DERIVATIVE + 2];

/// The switching that ends a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Switch {
    Onset,
    Release,
    /// The force would begin to pull or, if it is clipped, push again.
    Clip,
}

/// The sign that the unclipped force of a closed contact takes where this mode ends.
pub(crate) fn sign_after_clip(mode: Mode) -> f64 {
    if mode == Mode::Pressing { -1.0 } else { 1.0 }
}

/// What every method must say of the motion of a window on a segment. Balls and contacts are counted within the window,
/// times (s) from the start of the segment. Forces are those of the law without clipping, continued to overlaps below 0
/// ([`ContactLaw::continued`]), where the last step of a pulse may have nodes.
pub(crate) trait DenseOutput {
    /// Displacement of ball `i` (m) and change of its velocity (m/s) up to `tau`. At the start, where many switchings
    /// may come at once, the change must be exactly 0.
    fn moved(&self, i: usize, tau: f64) -> (f64, f64);
    /// Integral of the displacement of ball `i` up to `tau`, m.s.
    fn displacement_integral(&self, i: usize, tau: f64) -> f64;
    /// Integral of the squared velocity of ball `i` up to `tau`, m2/s. A method may enter the sum over a group at its
    /// first ball, weighted with the masses over that ball's.
    fn squared_velocity_integral(&self, i: usize, tau: f64) -> f64;
    /// Work per unit of mass of the acceleration `forcing` on ball `i` up to `tau`, m2/s2.
    fn work(&self, i: usize, forcing: &Forcing, tau: f64) -> f64;
    /// Overlap of contact `j` (m) at `tau`, and change of its rate (m/s) up to then.
    fn overlap(&self, j: usize, tau: f64) -> (f64, f64);
    /// Coefficients of the overlap of a contact as a power series of the time from `tau` on; `None` if the equations
    /// give them as well.
    fn overlap_series(&self, _j: usize, _tau: f64) -> Option<OverlapSeries> {
        None
    }
    /// Impulse of the pressing contact `j` up to `tau`, N.s.
    fn impulse(&self, j: usize, tau: f64) -> f64;
    /// The largest force of the pressing contact `j` between two times; `None` if it is less than `known` (N).
    fn peak(&self, j: usize, from: f64, to: f64, known: f64) -> Option<Peak>;
    /// Energy that the pressing contact `j` dissipates up to `tau`, J. A method may enter the sum over a group at its
    /// first contact.
    fn contact_loss(&self, j: usize, tau: f64) -> f64;

    /// The first `switch` of contact `j` before `until` that may end its mode; `window` is the one described. An
    /// approach of balls side by side by `rounding` is no onset, and a force must change its sign by more.
    fn first(&self, switch: Switch, j: usize, window: &Window, until: f64, rounding: &Rounding) -> Forecast;

    /// Evaluations of closed forms that the searches for switchings have taken so far.
    fn searched(&self) -> u64 {
        0
    }
}
