//! A window: a stretch of neighbouring balls and the contacts between them, at the start of a segment that is followed
//! as a whole; and what a method has to tell of its motion ([`DenseOutput`]).

use serde::{Deserialize, Serialize};

use crate::engine::flight::{Ball, Flight, Forcing, Rounding};
use crate::engine::{Forecast, Peak};
use crate::model::{BallModel, ContactLaw, MAX_OUTPUT_DERIVATIVE, Mode, Pair};

/// The load of a contact that a wave has yet to reach is less than this part of the largest.
const NEGLIGIBLE: f64 = 1e-4;

/// Contacts in a chain whose damping is less than this times `sqrt(k m)` let the balls oscillate or nearly so.
const RINGING: f64 = 3.0;

/// A contact at the start of a segment, or during an event while nothing else governs it.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct WindowContact {
    /// In m.
    pub overlap: f64,
    pub mode: Mode,
}

/// The balls and contacts of a window at the start of a segment, or of a whole chain. Contact `j` is that of balls `j`
/// and `j + 1`.
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
    /// The balls of contact `j` and its law.
    pub fn pair(&self, j: usize) -> Pair<'_> {
        Pair { balls: [&self.models[j], &self.models[j + 1]], law: &self.laws[j] }
    }

    /// The parts of the direction of contact `j` along the paths of its balls.
    pub fn parts_along(&self, j: usize) -> [f64; 2] {
        self.pair(j).parts_along([j, j + 1].map(|i| self.flights[i].x))
    }

    /// Rate of the overlap of contact `j`, m/s.
    pub fn overlap_rate(&self, j: usize) -> f64 {
        self.pair(j).overlap_rate([j, j + 1].map(|i| (self.flights[i].x, self.flights[i].v)))
    }

    /// Reduced mass of its balls, kg.
    pub fn reduced_mass(&self, j: usize) -> f64 {
        let [left, right] = [j, j + 1].map(|i| self.models[i].mass);
        left * right / (left + right)
    }

    /// Whether there is a contact `j` and it presses.
    pub fn presses(&self, j: usize) -> bool {
        self.contacts.get(j).is_some_and(|contact| contact.mode == Mode::Pressing)
    }

    /// Whether the force of contact `j` by its law matters: it presses, or only the force tells when it will again.
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
    /// pressed or moved for what others are.
    pub fn holds_front(&self) -> bool {
        // The force of a contact (N) and its rate (m/s) as they may be before long.
        let load = |(j, contact): (usize, &WindowContact)| {
            let (law, mass) = (&self.laws[j], self.reduced_mass(j));
            let (overlap, rate) = (contact.overlap.abs(), (self.flights[j].v - self.flights[j + 1].v).abs());
            let impedance = law.impedance(mass);
            let load = [law.stiffness * overlap + impedance * rate, impedance / mass * overlap + rate];
            (contact.mode != Mode::Open || load == [0.0; 2]).then_some(load)
        };
        let loads = self.contacts.iter().enumerate().filter_map(load);
        let largest = loads.clone().fold([0.0_f64; 2], |most, load| [most[0].max(load[0]), most[1].max(load[1])]);
        loads.into_iter().any(|load| (0..2).all(|k| load[k] < NEGLIGIBLE * largest[k]))
    }

    /// Whether it moves by linear equations between its switchings.
    pub fn is_linear(&self) -> bool {
        !self.models[0].on_arc && self.laws.iter().all(ContactLaw::is_linear)
    }

    /// Whether a closed contact is damped so little, for its part in a chain, that the balls oscillate or nearly so.
    pub fn rings(&self) -> bool {
        let rings = |j: usize| {
            let law = &self.laws[j];
            law.damping_coefficient() < RINGING * (law.stiffness * self.reduced_mass(j)).sqrt()
        };
        self.contacts.iter().enumerate().any(|(j, contact)| contact.mode != Mode::Open && rings(j))
    }
}

/// Coefficients of an overlap: up to those of the highest derivative by time of its force, one more for a dashpot.
pub(crate) type OverlapSeries = [f64; MAX_OUTPUT_DERIVATIVE + 2];

/// What ends a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Switch {
    Onset,
    Release,
    /// The force would begin to pull or, of a clipped contact, push again.
    Clip,
}

/// The sign that the unclipped force of a closed contact in this mode gets where clipping begins or ends.
pub(crate) fn sign_after_clip(mode: Mode) -> f64 {
    if mode == Mode::Pressing { -1.0 } else { 1.0 }
}

/// The motion of a window on a segment: what every method must provide. Balls and contacts are counted within the
/// window, times (s) from the start of the segment. Forces are those of the law without clipping, continued to overlaps
/// below 0 ([`ContactLaw::continued`]), where the last step of a pulse may have nodes.
pub(crate) trait DenseOutput {
    /// Displacement of ball `i` (m) and the change of its velocity (m/s) till `tau`. At the start, where many
    /// switchings may come at once, the change must be exactly 0.
    fn moved(&self, i: usize, tau: f64) -> (f64, f64);
    /// Integral of that displacement, m.s.
    fn displacement_integral(&self, i: usize, tau: f64) -> f64;
    /// Integral of the squared velocity of ball `i`, m2/s. A method may enter the sum over a group, weighted with the
    /// masses over that of the group's first ball, at that ball.
    fn squared_velocity_integral(&self, i: usize, tau: f64) -> f64;
    /// Work per unit of mass of the acceleration `forcing` on ball `i`, m2/s2.
    fn work(&self, i: usize, forcing: &Forcing, tau: f64) -> f64;
    /// Overlap of contact `j` (m) at `tau` and the change of its rate (m/s) till then.
    fn overlap(&self, j: usize, tau: f64) -> (f64, f64);
    /// Coefficients of that overlap as a power series of the time from `tau` on, unless the equations give them.
    fn overlap_series(&self, _j: usize, _tau: f64) -> Option<OverlapSeries> {
        None
    }
    /// Impulse of the pressing contact `j`, N.s.
    fn impulse(&self, j: usize, tau: f64) -> f64;
    /// The largest force of the pressing contact `j` between two times; `None` if it is less than `known` (N).
    fn peak(&self, j: usize, from: f64, to: f64, known: f64) -> Option<Peak>;
    /// Energy that the pressing contact `j` dissipates, J. A method may enter that of a group at its first contact.
    fn contact_loss(&self, j: usize, tau: f64) -> f64;

    /// The first `switch` of contact `j` of the `window` described, before `until`; one that may end its mode. Balls
    /// side by side approach each other by `rounding`: that is no onset. A force must change its sign by more.
    fn first(&self, switch: Switch, j: usize, window: &Window, until: f64, rounding: &Rounding) -> Forecast;

    /// Evaluations of closed forms that the searches for switchings have taken so far.
    fn searched(&self) -> u64 {
        0
    }
}
