//! The motion of neighbours as a run has computed it, at nodes in time and at single times.

use std::ops::Range;

use super::events::{Overlap, PeakPart};
use super::nodes::{BallNodes, ContactNodes};
use crate::engine::chain_state::ChainState;
use crate::engine::cluster::Cluster;
use crate::engine::flight::{Ball, Forcing, forcing_at, shifted};
use crate::engine::{HeldInputs, Peak};
use crate::model::Cradle;
use crate::solver::{DoubleDouble, Stretching};

/// The motion of neighbours in a part of a run, and what acts.
pub(super) struct Scene<'a> {
    pub motion: &'a dyn Motion,
    /// Time from which the motion counts its times.
    pub start: DoubleDouble,
    pub cradle: &'a Cradle,
    pub inputs: &'a HeldInputs,
}

/// A part of a run as it was computed.
pub(super) trait Motion {
    /// Position (m) and velocity (m/s) of ball `i` at the time `tau` (s).
    fn state(&self, i: usize, tau: f64) -> (f64, f64);
    /// Overlap of contact `j` (m) and its rate (m/s) at the time `tau` (s).
    fn overlap(&self, j: usize, tau: f64) -> (f64, f64);
    /// The largest force of contact `j` between two times; `None` if it is less than `known` (N).
    fn peak(&self, _j: usize, _between: [f64; 2], _known: f64) -> Option<Peak> {
        None
    }
    /// How time is stretched so that forces are smooth.
    fn stretching(&self) -> Stretching {
        Stretching::None
    }
}

impl Motion for Cluster {
    fn state(&self, i: usize, tau: f64) -> (f64, f64) {
        let (displacement, v) = self.moved(i, tau);
        (self.flights[i - self.window.start].x + displacement, v)
    }

    fn overlap(&self, j: usize, tau: f64) -> (f64, f64) {
        let (overlap, rate) = Cluster::overlap(self, j, tau);
        // A contact that has just closed has no overlap; a sum of modes leaves rounding.
        let at_start = self.contacts[j - self.window.start].overlap;
        (if tau == 0.0 { at_start } else { overlap }, rate)
    }

    fn peak(&self, j: usize, [from, to]: [f64; 2], known: f64) -> Option<Peak> {
        Cluster::peak(self, j, from, to, known)
    }

    fn stretching(&self) -> Stretching {
        Cluster::stretching(self)
    }
}

/// Flights of balls from their anchors on.
impl Motion for &[Ball] {
    fn state(&self, i: usize, tau: f64) -> (f64, f64) {
        let (displacement, v) = self[i].moved(self[i].anchor + tau);
        (self[i].flight.x + displacement, v)
    }

    fn overlap(&self, _: usize, _: f64) -> (f64, f64) {
        (f64::NEG_INFINITY, 0.0)
    }
}

/// Acceleration along its path (m/s2) of ball `i`, without contact, in this state (m, m/s) at the time `t`.
pub(super) fn acceleration(
    (cradle, inputs): (&Cradle, &HeldInputs),
    i: usize,
    t: DoubleDouble,
    (x, v): (f64, f64),
) -> f64 {
    let model = &cradle.balls[i];
    let [forcing, ..] = shifted(&inputs.forcing(i, model.mass), (t - inputs.since.into()).value());
    forcing * model.place(x).cos - model.gravity * model.restoring(x) - 2.0 * model.gamma * v
}

/// A chain at one time.
pub(super) struct ChainAtTime<'a> {
    pub state: &'a ChainState,
    pub cradle: &'a Cradle,
}

impl Motion for ChainAtTime<'_> {
    fn state(&self, i: usize, _: f64) -> (f64, f64) {
        (self.state.flights[i].x, self.state.flights[i].v)
    }

    fn overlap(&self, j: usize, tau: f64) -> (f64, f64) {
        let states = [j, j + 1].map(|i| self.state(i, tau));
        (self.state.contacts[j].overlap, self.cradle.pair(j).overlap_rate(states))
    }
}

impl Scene<'_> {
    /// The external force on this ball (N) and the acceleration of the support (m/s2), expanded about the time `tau`
    /// (s).
    pub fn inputs_of(&self, ball: usize, tau: f64) -> [Forcing; 2] {
        let age = (self.start + tau - self.inputs.since.into()).value();
        let of = [self.inputs.derivatives(|i| i.force[ball]), self.inputs.derivatives(|i| i.support_acceleration)];
        of.map(|input| shifted(&input, age))
    }

    /// Balls, and contacts between them, at nodes from `from` to `to` (s).
    pub fn nodes<const N: usize>(
        &self,
        balls: &Range<usize>,
        [from, to]: [f64; 2],
        times: &[f64; N],
    ) -> (Vec<BallNodes<N>>, Vec<ContactNodes<N>>) {
        let mut motions = vec![[[0.0; N]; 2]; balls.len()];
        let mut overlaps = vec![[[0.0; N]; 2]; balls.len() - 1];
        // Node by node: results for one time are kept for all balls.
        for m in 0..N {
            let tau = from + (to - from) * times[m];
            for (k, [x, v]) in motions.iter_mut().enumerate() {
                (x[m], v[m]) = self.motion.state(balls.start + k, tau);
            }
            for (k, [overlap, rate]) in overlaps.iter_mut().enumerate() {
                (overlap[m], rate[m]) = self.motion.overlap(balls.start + k, tau);
            }
        }
        let contact = |(k, overlaps): (usize, &[[f64; N]; 2])| {
            let (j, [left, right]) = (balls.start + k, [0, 1].map(|side| motions[k + side].each_ref()));
            let ends = match self.cradle.on_arcs() {
                true => [from, to].map(|tau| [j, j + 1].map(|i| self.motion.state(i, tau).0)),
                false => [[0.0; 2]; 2],
            };
            ContactNodes::new(self.cradle, j, *overlaps, [left, right], ends)
        };
        let contacts: Vec<ContactNodes<N>> = overlaps.iter().enumerate().map(contact).collect();
        let ball = |(k, motion): (usize, &[[f64; N]; 2])| {
            let pushed = std::array::from_fn(|m| {
                let from_left = k.checked_sub(1).map_or(0.0, |left| contacts[left].forces(m)[1]);
                from_left + contacts.get(k).map_or(0.0, |right| right.forces(m)[0])
            });
            let inputs = self.inputs_of(balls.start + k, from).map(|input| {
                let [_, a, b, c] = input;
                [input, [a, b, c, 0.0]].map(|of| times.map(|c| forcing_at(&of, (to - from) * c)))
            });
            BallNodes::new(&self.cradle.balls[balls.start + k], *motion, &pushed, inputs)
        };
        (motions.iter().enumerate().map(ball).collect(), contacts)
    }

    /// For each of `balls` at the time `tau` (s): velocity (m/s), acceleration (m/s2), and for the contact at its right
    /// the force (N) and the rate of the overlap (m/s); without or `with` the force of a contact that just closes.
    pub fn motions(&self, balls: &Range<usize>, tau: f64, with: bool) -> Vec<[f64; 4]> {
        let (nodes, contacts) = self.nodes(balls, [tau, tau], &[0.0]);
        let acts = |contact: &&ContactNodes<1>| with || contact.overlap[0] > 0.0;
        let motion = |(k, node): (usize, &BallNodes<1>)| {
            let model = &self.cradle.balls[balls.start + k];
            let ignored = |k: usize, side: usize| {
                contacts.get(k).filter(|contact| !acts(contact)).map_or(0.0, |contact| contact.forces(0)[side])
            };
            let ignored = (ignored(k.wrapping_sub(1), 1) + ignored(k, 0)) / model.mass;
            let a = node.acceleration(model, 0, self.inputs_of(balls.start + k, tau)[1][0]) - ignored;
            let force = contacts.get(k).filter(acts).map_or(0.0, |contact| contact.force[0]);
            [node.v[0], a, force, contacts.get(k).map_or(0.0, |contact| contact.rate[0])]
        };
        nodes.iter().enumerate().map(motion).collect()
    }

    /// The overlap of contact `j` at the time `tau` (s) as a function of the state.
    pub fn overlap(&self, j: usize, tau: f64) -> Overlap {
        Overlap::new(self.cradle, j, [j, j + 1].map(|i| self.motion.state(i, tau)))
    }

    /// The largest force of contact `j` between two times (s), if it is larger than `known` (N).
    pub fn largest_force(&self, j: usize, between: [f64; 2], known: f64) -> Option<Peak> {
        self.motion.peak(j, between, known).filter(|peak| peak.force > known)
    }

    /// The force of contact `j` between `balls` at the time `tau` (s) as a function of the state: where it is largest
    /// or, at the end of a motion, may still grow.
    pub fn peak_part(&self, balls: &Range<usize>, j: usize, tau: f64, at_end: bool) -> PeakPart {
        let (_, mut contacts) = self.nodes(balls, [tau, tau], &[0.0]);
        let (k, motions) = (j - balls.start, self.motions(balls, tau, true));
        let at = contacts.swap_remove(k);
        let states = [j, j + 1].map(|i| self.motion.state(i, tau));
        let acceleration_of_overlap =
            self.cradle.pair(j).overlap_acceleration(states, [k, k + 1].map(|k| motions[k][1]));
        let growth = at.by_overlap[0] * at.rate[0] + at.by_rate[0] * acceleration_of_overlap;
        // It has just closed: the later it does so, the farther apart its balls are.
        let closes = at.overlap[0] <= 0.0 && at.rate[0] > 0.0;
        PeakPart {
            by_overlap: if closes { -growth / at.rate[0] } else { 0.0 },
            by_time: if at_end { growth } else { 0.0 },
            contact: j,
            at,
        }
    }
}
