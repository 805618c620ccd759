//! The motion of a window on a step: what the iteration fills in, and what is read off it.

use std::cell::RefCell;

use super::output::Moment;
use crate::engine::cluster::window::{Switch, Window};
use crate::engine::flight::{Flight, Rounding, degree};
use crate::model::{ContactLaw, Mode, SignOfForce};
use crate::solver::gauss::{NODES, Nodes, Stretching};
use crate::solver::oscillator::Oscillator;

/// A contact at the start of the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Track {
    pub law: ContactLaw,
    pub mode: Mode,
    /// Overlap (m) and its rate (m/s).
    pub overlap: f64,
    pub rate: f64,
    /// Of the ball on the left and of the one on the right, 1/kg.
    pub inverse_masses: [f64; 2],
    /// Relative motion of the two without contact forces: that of a pendulum, as all are equal.
    pub free: Flight,
    /// What forcing and gravity accelerate an overlap of 0 by at the start, m/s2.
    pub pull: f64,
    /// Relative acceleration of the two at the start, m/s2, and what the contact forces change it by, m/s3.
    pub acceleration: f64,
    pub jerk: f64,
}

impl Track {
    /// What the forces of the contact on the left, its own and that on the right accelerate it by.
    fn pushed(&self, [left, own, right]: [f64; 3]) -> f64 {
        (left - own) * self.inverse_masses[0] - (own - right) * self.inverse_masses[1]
    }

    /// What the forcing changes by within `time` (s), m/s2.
    pub fn varying(&self, time: f64) -> f64 {
        let [_, first, second, third] = self.free.forcing;
        time * (first + 0.5 * time * (second + time / 3.0 * third))
    }

    /// What has the sign of its force, if that may be clipped.
    pub fn sign(&self) -> Option<SignOfForce> {
        if self.mode == Mode::Open { None } else { self.law.sign_of_force() }
    }

    /// The switching that it comes to where its overlap vanishes.
    pub fn switch(&self) -> Switch {
        if self.mode == Mode::Open { Switch::Onset } else { Switch::Release }
    }

    /// Whether its balls are side by side, as far as rounding tells.
    pub fn is_resting(&self, rounding: &Rounding) -> bool {
        rounding.is_rest(self.overlap, self.rate)
    }
}

/// The motion of a window on a step.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    pub(super) stretching: Stretching,
    /// Length of the step, s.
    pub(super) length: f64,
    /// Up to when it holds: to its end, or to where a force changes its sign, s.
    pub(super) until: f64,
    /// The contact whose switching is then, and what that is.
    pub(super) end: Option<(usize, Switch)>,
    /// The pendulum of all balls, and their states at the start.
    pub(super) oscillator: Oscillator,
    pub(super) flights: Vec<Flight>,
    pub(super) tracks: Vec<Track>,
    /// Whether a forcing varies, and whether the iteration takes the rates.
    pub(super) varies: bool,
    pub(super) needs_rates: bool,
    /// Values at the nodes, a contact each: overlap (m), its rate (m/s; rough unless the iteration takes them), its acceleration (m/s2).
    pub(super) overlaps: Vec<Nodes>,
    pub(super) rates: Vec<Nodes>,
    pub(super) accelerations: Vec<Nodes>,
    /// Forces (N), with one of 0 at either end.
    pub(super) forces: Vec<Nodes>,
    /// What is known at the time that was asked for last.
    pub(super) moment: RefCell<Moment>,
}

impl Default for Motion {
    fn default() -> Self {
        Self {
            stretching: Stretching::None,
            length: 0.0,
            until: 0.0,
            end: None,
            oscillator: Oscillator::new(0.0, 0.0),
            flights: Vec::new(),
            tracks: Vec::new(),
            varies: false,
            needs_rates: false,
            overlaps: Vec::new(),
            rates: Vec::new(),
            accelerations: Vec::new(),
            forces: Vec::new(),
            moment: RefCell::default(),
        }
    }
}

impl Motion {
    /// With room for so many contacts.
    pub fn with_capacity(contacts: usize) -> Self {
        let nodes = || Vec::with_capacity(contacts);
        Self {
            flights: Vec::with_capacity(contacts + 1),
            tracks: Vec::with_capacity(contacts),
            overlaps: nodes(),
            rates: nodes(),
            accelerations: nodes(),
            forces: Vec::with_capacity(contacts + 2),
            moment: RefCell::new(Moment::with_capacity(contacts + 2)),
            ..Self::default()
        }
    }

    /// The state of `window`, whose pendulums are equal, at the start of a step.
    pub(super) fn start(&mut self, window: &Window) {
        let Window { flights, balls, contacts, laws } = window;
        let o = balls[0].oscillator;
        (self.oscillator, self.end) = (o, None);
        self.flights.clear();
        self.flights.extend_from_slice(flights);
        self.tracks.clear();
        for (j, (contact, law)) in contacts.iter().zip(*laws).enumerate() {
            let (left, right) = (&flights[j], &flights[j + 1]);
            let forcing = std::array::from_fn(|k| left.forcing[k] - right.forcing[k]);
            let rate = left.v - right.v;
            self.tracks.push(Track {
                law: *law,
                mode: contact.mode,
                overlap: contact.overlap,
                rate,
                inverse_masses: [1.0 / balls[j].mass, 1.0 / balls[j + 1].mass],
                free: Flight { x: contact.overlap + law.clearance, v: rate, forcing },
                pull: forcing[0] - o.omega2() * law.clearance,
                acceleration: 0.0,
                jerk: 0.0,
            });
        }
        let force = |track: &Track| track.law.unclipped_force(track.overlap, track.rate);
        self.for_each_under(force, |track, forces| {
            let free = track.pull - o.omega2() * track.overlap - 2.0 * o.gamma() * track.rate;
            track.acceleration = track.pushed(forces) + free;
        });
        let change = |track: &Track| {
            let (by_overlap, by_rate) = track.law.force_slopes(track.overlap, track.rate);
            by_overlap * track.rate + by_rate * track.acceleration
        };
        self.for_each_under(change, |track, changes| track.jerk = track.pushed(changes));
        self.varies = flights.iter().any(|flight| degree(&flight.forcing) > 0);
        self.needs_rates = o.gamma() > 0.0 || self.tracks.iter().any(|track| !track.law.is_elastic());
        let contacts = self.tracks.len();
        for values in [&mut self.overlaps, &mut self.rates, &mut self.accelerations] {
            values.resize(contacts, [0.0; NODES]);
        }
        self.forces.clear();
        self.forces.resize(contacts + 2, [0.0; NODES]);
    }

    /// Hands each contact the `force` of the one on its left, its own and that of the one on its right, 0 for those that do not press.
    fn for_each_under(&mut self, force: impl Fn(&Track) -> f64, mut enter: impl FnMut(&mut Track, [f64; 3])) {
        let force = |track: Option<&Track>| track.filter(|track| track.mode == Mode::Pressing).map_or(0.0, &force);
        let (mut left, mut own) = (0.0, force(self.tracks.first()));
        for j in 0..self.tracks.len() {
            let right = force(self.tracks.get(j + 1));
            enter(&mut self.tracks[j], [left, own, right]);
            (left, own) = (own, right);
        }
    }
}
