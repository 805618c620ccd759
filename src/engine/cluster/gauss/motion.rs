//! The motion of a window on a step, filled in by the iteration.

use std::cell::{OnceCell, RefCell};

use super::arcs::{ArcNodes, BallOnArc, ContactDirection};
use super::branch_point::BranchPoint;
use crate::engine::cluster::step_control::Problem;
use crate::engine::cluster::window::{Switch, Window, WindowContact};
use crate::engine::flight::{Flight, Forcing, Rounding, degree};
use crate::model::{ContactLaw, Mode, SignOfForce};
use crate::solver::{NODES, Nodes, Oscillator, Stretching};

/// A contact at the start of the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepContact {
    pub law: ContactLaw,
    pub mode: Mode,
    /// Overlap (m) and its rate (m/s).
    pub overlap: f64,
    pub rate: f64,
    /// Inverse masses of the left and the right ball, 1/kg.
    pub inverse_masses: [f64; 2],
    /// Relative acceleration by the inputs.
    pub forcing: Forcing,
    /// Mean pendulum of the two balls, which acts on the overlap: omega^2 (1/s2) and 2 gamma (1/s).
    pub mean: [f64; 2],
    /// Excess of the left pendulum in both values, which acts on the mean of positions and velocities.
    pub unlike: [f64; 2],
    /// Acceleration of the overlap by forcing and gravity at the start, for an overlap of 0, m/s2.
    pub free_at_touch: f64,
    /// Derivatives of the force by overlap (N/m) and rate (N.s/m); 0 unless it presses, has an overlap and pushes.
    pub slopes: (f64, f64),
    /// Relative acceleration at the start, m/s2, and its derivatives by time as far as contact forces cause them; from
    /// the second one on approximate (0 on arcs).
    pub accelerations: [f64; 4],
}

impl StepContact {
    /// Contact `j` of `window`, with the inputs as all that is known to act on it.
    fn new(window: &Window, j: usize, rate: f64, inverse_masses: [f64; 2]) -> Self {
        let Window { flights, contacts, laws, .. } = window;
        let (WindowContact { mode, overlap, .. }, none) = (contacts[j], [0.0; 2]);
        Self {
            law: laws[j],
            mode,
            overlap,
            rate,
            inverse_masses,
            forcing: std::array::from_fn(|k| flights[j].forcing[k] - flights[j + 1].forcing[k]),
            mean: none,
            unlike: none,
            free_at_touch: 0.0,
            slopes: if mode == Mode::Pressing { laws[j].force_slopes(overlap, rate) } else { (0.0, 0.0) },
            accelerations: [0.0; 4],
        }
    }

    /// Relative acceleration (m/s2) by the forces (N) of its left neighbour, itself and its right neighbour.
    fn pushed(&self, [left, own, right]: [f64; 3]) -> f64 {
        (left - own) * self.inverse_masses[0] - (own - right) * self.inverse_masses[1]
    }

    /// Change of the forcing within `time` (s), m/s2.
    pub fn varying(&self, time: f64) -> f64 {
        let [_, first, second, third] = self.forcing;
        time * (first + 0.5 * time * (second + time / 3.0 * third))
    }

    /// The expression with the sign of its force, if the force may be clipped.
    pub fn sign(&self) -> Option<SignOfForce> {
        if self.mode == Mode::Open { None } else { self.law.sign_of_force() }
    }

    /// The switching at which its overlap vanishes.
    pub fn switch(&self) -> Switch {
        if self.mode == Mode::Open { Switch::Onset } else { Switch::Release }
    }

    /// Whether its balls are side by side, as far as rounding tells.
    pub fn is_resting(&self, rounding: &Rounding) -> bool {
        rounding.is_rest(self.overlap, self.rate)
    }
}

/// Scales for the errors of a step.
pub(super) struct Tolerance<'a> {
    pub problem: &'a Problem<'a>,
    /// Allowed size of the two highest Legendre coefficients over the scale of the velocities.
    pub tail: f64,
    /// The longest step, s.
    pub longest: f64,
}

/// Values at the nodes of a step, or at the nodes of a part of it.
#[derive(Clone, Debug, Default)]
pub(super) struct Samples {
    /// Times of the nodes, s.
    pub times: Nodes,
    /// For each contact: overlap (m) and its rate (m/s; rough unless the iteration needs rates).
    pub overlaps: Vec<Nodes>,
    pub rates: Vec<Nodes>,
    /// Forces (N), with one of 0 at either end.
    pub forces: Vec<Nodes>,
    /// For each ball: displacement (m) and velocity (m/s; rough unless the iteration needs rates).
    pub balls: Vec<[Nodes; 2]>,
}

/// The motion at one time.
#[derive(Clone, Debug, Default)]
pub(super) struct MotionAtTime {
    /// The time (s); none before the first.
    pub tau: Option<f64>,
    /// See [`GaussStep::weights`].
    pub weights: [Nodes; 3],
    /// For each ball: displacement (m), change of velocity (m/s), and integral of the displacement (m.s). For each
    /// contact: these values of the left ball less the right one, 0 if the contact does not press.
    pub balls: Vec<[f64; 3]>,
    pub relative: Vec<[f64; 3]>,
    /// For each contact: overlap (m) and the change of its rate (m/s).
    pub contacts: Vec<[f64; 2]>,
    /// For a time early in the step: values at nodes up to that time, and their weights in the integral (s); on first
    /// use.
    pub early: OnceCell<Option<(Samples, Nodes)>>,
}

/// The motion of a window on a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct GaussStep {
    pub(super) stretching: Stretching,
    /// Length of the step, s.
    pub(super) length: f64,
    /// Time up to which it holds, s: its end, or where a force changes its sign.
    pub(super) until: f64,
    /// The contact that switches at that time, and how.
    pub(super) end: Option<(usize, Switch)>,
    /// The pendulums of the balls, and their states at the start.
    pub(super) oscillators: Vec<Oscillator>,
    pub(super) flights: Vec<Flight>,
    /// Whether some pendulums differ.
    pub(super) unlike: bool,
    pub(super) contacts: Vec<StepContact>,
    /// The branch point at overlap 0.
    pub(super) branch_point: Option<BranchPoint>,
    /// Whether a forcing varies, whether there is drag, and whether the iteration needs rates.
    pub(super) varies: bool,
    pub(super) drags: bool,
    pub(super) needs_rates: bool,
    pub(super) at_nodes: Samples,
    /// Acceleration of each contact and each ball at the nodes, m/s2.
    pub(super) accelerations: Vec<Nodes>,
    pub(super) ball_accelerations: Vec<Nodes>,
    /// Directions and factors, if balls move on arcs.
    pub(super) arcs: ArcNodes,
    /// The values at the time asked for last.
    pub(super) moment: RefCell<MotionAtTime>,
}

impl GaussStep {
    /// Takes the state of `window` at the start of a step.
    pub(super) fn start(&mut self, window: &Window) {
        let Window { flights, models, balls, .. } = window;
        self.moment.get_mut().tau = None;
        self.flights.clear();
        self.flights.extend_from_slice(flights);
        self.contacts.clear();
        self.oscillators.clear();
        self.oscillators.extend(balls.iter().map(|ball| ball.oscillator));
        self.arcs.models.clear();
        if models[0].on_arc {
            (self.unlike, self.varies, self.drags) = (false, false, false);
            self.start_along_arcs(window);
        } else {
            self.unlike = self.oscillators.iter().any(|oscillator| *oscillator != self.oscillators[0]);
            self.varies = flights.iter().any(|flight| degree(&flight.forcing) > 0);
            self.drags = self.oscillators.iter().any(|o| o.gamma() > 0.0);
            self.start_on_lines(window);
        }
        self.branch_point = BranchPoint::of(self.contacts.iter().map(|contact| &contact.law));
        let lossy = self.contacts.iter().any(|contact| !contact.law.is_elastic());
        self.needs_rates = self.drags || self.varies || lossy;
        let count = self.contacts.len();
        let Samples { overlaps, rates, forces, balls, .. } = &mut self.at_nodes;
        for values in [overlaps, rates, &mut self.accelerations] {
            values.resize(count, [0.0; NODES]);
        }
        forces.clear();
        forces.resize(count + 2, [0.0; NODES]);
        balls.resize(count + 1, [[0.0; NODES]; 2]);
        self.ball_accelerations.resize(count + 1, [0.0; NODES]);
    }

    fn start_on_lines(&mut self, window: &Window) {
        let Window { flights, models, laws, .. } = window;
        for (j, law) in laws.iter().enumerate() {
            let (left, right) = (&flights[j], &flights[j + 1]);
            let pendulums = [&self.oscillators[j], &self.oscillators[j + 1]].map(|o| [o.omega2(), 2.0 * o.gamma()]);
            let mean = [0, 1].map(|k| 0.5 * (pendulums[0][k] + pendulums[1][k]));
            let unlike = [0, 1].map(|k| pendulums[0][k] - pendulums[1][k]);
            let inverse_masses = [j, j + 1].map(|i| 1.0 / models[i].mass);
            let contact = StepContact::new(window, j, left.v - right.v, inverse_masses);
            let free_at_touch = contact.forcing[0] - mean[0] * law.clearance - 0.5 * unlike[0] * (left.x + right.x);
            self.contacts.push(StepContact { mean, unlike, free_at_touch, ..contact });
        }
        self.for_each_under(0, |j, contact, forces| {
            let both = flights[j].v + flights[j + 1].v;
            let swing =
                -contact.mean[0] * contact.overlap - contact.mean[1] * contact.rate - 0.5 * contact.unlike[1] * both;
            contact.accelerations[0] = contact.pushed(forces) + (contact.free_at_touch + swing);
        });
        for k in 1..4 {
            self.for_each_under(k, |_, contact, changes| contact.accelerations[k] = contact.pushed(changes));
        }
    }

    fn start_along_arcs(&mut self, window: &Window) {
        let Window { flights, models, laws, .. } = window;
        let arcs = &mut self.arcs;
        arcs.models.extend_from_slice(models);
        let balls: Vec<BallOnArc<1>> = arcs.models.iter().zip(*flights).map(BallOnArc::at_start).collect();
        let lengths = |j: usize| [arcs.models[j].length, arcs.models[j + 1].length];
        arcs.starts.clear();
        arcs.starts.extend((0..laws.len()).map(|j| window.pair(j).distances([flights[j].x, flights[j + 1].x])));
        let direction = |j: usize| ContactDirection::new(&balls[j], &balls[j + 1], lengths(j), arcs.starts[j]);
        let directions: Vec<ContactDirection<1>> = (0..laws.len()).map(direction).collect();
        let factors = |j: usize| ContactDirection::factors(&directions, j, &arcs.models).map(|[factor]| factor);
        let factors: Vec<[f64; 3]> = (0..laws.len()).map(factors).collect();
        for j in 0..laws.len() {
            let inverse_masses = [j, j + 1].map(|i| 1.0 / arcs.models[i].mass);
            let [[l], [r]] = directions[j].along;
            let rate = balls[j].approach(&balls[j + 1], &directions[j]);
            let contact = StepContact::new(window, j, rate, [l * l * inverse_masses[0], r * r * inverse_masses[1]]);
            self.contacts.push(StepContact { free_at_touch: directions[j].free[0], ..contact });
        }
        arcs.begin(&balls, &directions, &factors);
        let pushed = |j: usize, forces: [f64; 3]| {
            let [left, own, right] = factors[j];
            left * forces[0] + own * forces[1] + right * forces[2]
        };
        self.for_each_under(0, |j, contact, forces| {
            contact.accelerations[0] = pushed(j, forces) + contact.free_at_touch
        });
        self.for_each_under(1, |j, contact, changes| contact.accelerations[1] = pushed(j, changes));
    }

    /// Whether there is a contact `j` and it presses.
    pub(super) fn presses(&self, j: usize) -> bool {
        self.contacts.get(j).is_some_and(|contact| contact.mode == Mode::Pressing)
    }

    pub fn stretching(&self) -> Stretching {
        self.stretching
    }

    pub(super) fn on_arcs(&self) -> bool {
        !self.arcs.models.is_empty()
    }

    /// Whether balls must be followed at the nodes; if not, the centres of mass of groups fly freely.
    pub(super) fn needs_balls(&self) -> bool {
        self.unlike || self.drags || self.varies || self.on_arcs()
    }

    /// The fastest rate of a pendulum, 1/s.
    pub(super) fn pace(&self) -> f64 {
        self.oscillators.iter().map(Oscillator::pace).fold(0.0, f64::max)
    }

    /// Calls `enter` with the index of each contact, the contact, and derivative `k` of the forces of its left
    /// neighbour, itself and its right neighbour; 0 for those that do not press.
    fn for_each_under(&mut self, k: usize, enter: impl Fn(usize, &mut StepContact, [f64; 3])) {
        let force = |contact: Option<&StepContact>| {
            contact
                .filter(|contact| contact.mode == Mode::Pressing)
                .map_or(0.0, |contact| derivative_of_force(contact, k))
        };
        let (mut left, mut own) = (0.0, force(self.contacts.first()));
        for j in 0..self.contacts.len() {
            let right = force(self.contacts.get(j + 1));
            enter(j, &mut self.contacts[j], [left, own, right]);
            (left, own) = (own, right);
        }
    }
}

/// Derivative `k` (0 to 3) of the force of a contact by time at the start, N/s^k: exact for an elastic force and for a
/// dashpot, rough for other damping from the second one on.
fn derivative_of_force(contact: &StepContact, k: usize) -> f64 {
    let StepContact { slopes: (by_overlap, by_rate), overlap, rate, accelerations, .. } = *contact;
    if k == 0 {
        return contact.law.unclipped_force(overlap, rate);
    }
    let (exponent, overlap) = (contact.law.exponent, overlap.max(f64::MIN_POSITIVE)); // without overlap the slope is 0
    let second_slope = (exponent - 1.0) * by_overlap / overlap;
    let by_second_slope = match k {
        1 => 0.0,
        2 => second_slope * rate * rate,
        _ => second_slope * ((exponent - 2.0) * rate * rate / overlap + 3.0 * accelerations[0]) * rate,
    };
    let moved = if k == 1 { rate } else { accelerations[k - 2] };
    by_second_slope + by_overlap * moved + by_rate * accelerations[k - 1]
}
