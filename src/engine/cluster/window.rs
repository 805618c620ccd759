//! A window: a stretch of neighbouring balls and the contacts between them, at the start of a segment that is followed
//! as a whole.

use serde::{Deserialize, Serialize};

use super::equations::Equations;
use crate::engine::flight::{Ball, Flight, Forcing};
use crate::model::{BallModel, ContactLaw, MAX_OUTPUT_DERIVATIVE, Mode};

/// The load of a contact that a wave has yet to reach is less than this part of the largest.
const NEGLIGIBLE: f64 = 1e-4;

/// Contacts in a chain whose damping is less than this times `sqrt(k m)` let the balls oscillate or nearly so.
const RINGING: f64 = 3.0;

/// A contact of the window at the start of the segment.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct WindowContact {
    pub overlap: f64,
    pub mode: Mode,
}

/// The balls and contacts of a window at the start of a segment.
#[derive(Clone, Copy)]
pub(crate) struct Window<'a> {
    pub flights: &'a [Flight],
    pub balls: &'a [Ball],
    pub contacts: &'a [WindowContact],
    pub laws: &'a [ContactLaw],
}

impl Window<'_> {
    /// Whether there is a contact `j` and it presses.
    pub fn presses(&self, j: usize) -> bool {
        self.contacts.get(j).is_some_and(|contact| contact.mode == Mode::Pressing)
    }

    /// Number of closed contacts.
    pub fn closed(&self) -> usize {
        self.contacts.iter().filter(|contact| contact.mode != Mode::Open).count()
    }

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

    /// Whether a closed contact is damped so little, for its part in a chain, that the balls oscillate or nearly so.
    pub fn rings(&self) -> bool {
        let rings = |j: usize| {
            let law = &self.laws[j];
            law.damping_coefficient() < RINGING * (law.stiffness * self.reduced_mass(j)).sqrt()
        };
        self.contacts.iter().enumerate().any(|(j, contact)| contact.mode != Mode::Open && rings(j))
    }

    /// Reduced mass of the balls of contact `j`, kg.
    pub fn reduced_mass(&self, j: usize) -> f64 {
        let (left, right) = (self.balls[j].mass, self.balls[j + 1].mass);
        left * right / (left + right)
    }
}

impl Equations<f64> for Window<'_> {
    fn balls(&self) -> usize {
        self.balls.len()
    }

    fn ball(&self, i: usize) -> BallModel {
        let Ball { mass, oscillator, .. } = &self.balls[i];
        BallModel { mass: *mass, omega2: oscillator.omega2(), gamma: oscillator.gamma() }
    }

    fn position(&self, i: usize) -> f64 {
        self.flights[i].x
    }

    fn velocity(&self, i: usize) -> f64 {
        self.flights[i].v
    }

    fn forcing(&self, i: usize) -> &Forcing {
        &self.flights[i].forcing
    }

    fn law(&self, j: usize) -> &ContactLaw {
        &self.laws[j]
    }

    fn overlap(&self, j: usize) -> f64 {
        self.contacts[j].overlap
    }

    fn mode(&self, j: usize) -> Mode {
        self.contacts[j].mode
    }
}

/// Coefficients of an overlap: as many as its force has up to the highest derivative by time, and one more for a
/// dashpot.
pub(crate) type OverlapSeries<S = f64> = [S; MAX_OUTPUT_DERIVATIVE + 2];

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

/// The switching that ends this mode of a closed contact unless its release does: the sign that the force then gets,
/// and what it is.
pub(crate) fn clipping(mode: Mode) -> (f64, Switch) {
    if mode == Mode::Pressing { (-1.0, Switch::Clip) } else { (1.0, Switch::Unclip) }
}
