//! Divides a motion into parts that are short enough to be linearised.

use std::ops::Range;

use super::flight::FlightPart;
use super::nodes::{BallNodes, ContactNodes};
use super::record::Recorder;
use super::scene::Scene;
use super::step::{CollocationRule, CollocationStep, IMPLICIT};
use super::unfollowed::Unfollowed;
use crate::engine::cluster::BranchPoint;
use crate::engine::flight::Flight;
use crate::model::Cradle;
use crate::solver::radau::STAGES;
use crate::solver::{NODES, Oscillator, Power, Stretching, Table, weighted};

/// Longest explicit step, times the pace of the fastest change. A larger one needs more terms in the series of a step;
/// half of it needs more steps and a tenth more time.
const EXPLICIT: f64 = 6.0;

/// Undisturbed time, times the fastest decay rate in a step, after which nothing is left of oscillations that decay.
/// Without this limit the derivatives of rows that are pressed together and ring are wrong; with ten times as much,
/// their tapes take three times the time.
const DECAY_TIMES_TO_SETTLE: f64 = 400.0;

/// Longest implicit step of balls that press on each other, times the pace of a pendulum, which does not decay.
/// Rounding grows with the square of the length, because the changes of the forces cancel in the common motion.
const PENDULUM: f64 = 0.1;

/// Longest implicit step of one ball, times its pace: nine stages of order 17 leave a relative error of some 1e-15.
const ALONE: f64 = 2.0;

/// Largest relative change of an overlap by the two highest terms of the interpolation of its force. The error at the
/// end is far smaller: 1e-10 of the derivatives, for viscoelastic contacts 4e-7. With 1e-11 tapes take up to twice the
/// time.
const LARGEST_TAIL: f64 = 1e-8;

/// Most times that a part is halved.
const HALVINGS: u32 = 40;

/// For a motion of unknown paces that has not been halved.
const NOTHING_KNOWN: (Option<[f64; 2]>, u32) = (None, 0);

type AtNodes<const N: usize> = (Vec<BallNodes<N>>, Vec<ContactNodes<N>>);

/// The fastest changes in a motion of neighbours from ball `first` on, times its `length` (s): of oscillations, and of
/// decays.
fn paces<const N: usize>(cradle: &Cradle, first: usize, length: f64, (balls, contacts): &AtNodes<N>) -> [f64; 2] {
    let [mut stiffness, mut decay] = [0.0_f64; 2];
    for (i, ball) in balls.iter().enumerate() {
        let model = &cradle.balls[first + i];
        let beside = [i.checked_sub(1), Some(i)].into_iter().flatten().filter_map(|j| contacts.get(j));
        for m in 0..N {
            let [mut by_place, mut by_rate] = [ball.by_place[m].abs(), 2.0 * model.gamma];
            for contact in beside.clone() {
                by_place += 2.0 * contact.by_overlap[m].abs() / model.mass;
                by_rate += 2.0 * contact.by_rate[m].abs() / model.mass;
            }
            (stiffness, decay) = (stiffness.max(by_place), decay.max(by_rate));
        }
    }
    [length * stiffness.sqrt(), length * decay]
}

/// The pace of the fastest pendulum without its contacts, 1/s.
fn fastest_pendulum(balls: &[BallNodes<STAGES>]) -> f64 {
    let by_places = balls.iter().flat_map(|ball| ball.by_place);
    by_places.fold(0.0, |most: f64, by_place| most.max(by_place.abs())).sqrt()
}

impl CollocationStep<NODES, Table> {
    /// Whether the nodes resolve the forces: the unresolved part changes overlaps by less than [`LARGEST_TAIL`] of
    /// them.
    fn is_resolved(&self, cradle: &Cradle) -> bool {
        let resolved = |(j, contact): (usize, &ContactNodes<NODES>)| {
            let largest = contact.overlap.iter().fold(0.0, |most: f64, overlap| most.max(overlap.abs()));
            let force = self.rule.tail.iter().map(|tail| weighted(tail, &contact.force).abs()).fold(0.0, f64::max);
            self.length * self.length * force <= LARGEST_TAIL * cradle.reduced_mass(self.first + j) * largest
        };
        self.contacts.iter().enumerate().all(resolved)
    }
}

impl Recorder {
    /// Adds the motion of balls over a time in which no force reaches its peak.
    pub(super) fn press_between_peaks(
        &mut self,
        scene: &Scene,
        balls: Range<usize>,
        [from, to]: [f64; 2],
        releases: bool,
    ) {
        if from >= to {
            return;
        }
        if balls.len() == 1 && !scene.cradle.on_arcs() {
            return self.fly_on_line(scene, balls.start, [from, to]);
        }
        // The derivative by the exponent has the logarithm of an overlap: time is stretched where that begins or ends
        // at 0.
        let vanishes = |tau: f64| (balls.start..balls.end - 1).any(|j| scene.motion.overlap(j, tau).0 <= 0.0);
        let stretched = scene.motion.stretching();
        let power = BranchPoint::of(scene.cradle.contacts.iter()).map_or(Power::Square, |point| point.power);
        let [start, end] = [Stretching::AtStart(power), Stretching::AtEnd(power)];
        match (stretched, vanishes(from), releases || vanishes(to)) {
            (Stretching::None, true, false) => self.linearise(scene, balls, [from, to], start, NOTHING_KNOWN),
            (Stretching::None, false, true) => self.linearise(scene, balls, [from, to], end, NOTHING_KNOWN),
            (_, true, true) => {
                let middle = 0.5 * (from + to);
                self.linearise(scene, balls.clone(), [from, middle], start, NOTHING_KNOWN);
                self.linearise(scene, balls, [middle, to], end, NOTHING_KNOWN);
            }
            (own, ..) => self.linearise(scene, balls, [from, to], own, NOTHING_KNOWN),
        }
    }

    fn fly_on_line(&mut self, scene: &Scene, ball: usize, [from, to]: [f64; 2]) {
        let (model, length) = (&scene.cradle.balls[ball], to - from);
        let parts = (length / Oscillator::new(model.omega2, model.gamma).longest()).ceil().max(1.0);
        let mut k = 0.0;
        while k < parts && self.failure().is_none() {
            let tau = from + length / parts * k;
            let ((x, v), [force, support]) = (scene.motion.state(ball, tau), scene.inputs_of(ball, tau));
            let external = force.map(|force| force / model.mass);
            let start = Flight { x, v, forcing: std::array::from_fn(|k| external[k] - support[k]) };
            self.enter(scene.cradle, FlightPart { ball, start, external, length: length / parts });
            k += 1.0;
        }
    }

    /// Adds the motion of `balls` from `from` to `to` (s) in as many parts as needed. A motion twice as long, if any,
    /// has the paces `known`; this one is what is left after so many `halvings`.
    fn linearise(
        &mut self,
        scene: &Scene,
        balls: Range<usize>,
        [from, to]: [f64; 2],
        stretching: Stretching,
        (known, halvings): (Option<[f64; 2]>, u32),
    ) {
        let (cradle, first, length) = (scene.cradle, balls.start, to - from);
        let since = self.undisturbed_for(scene, &balls, from);
        let [mut swing, mut decay] = match known {
            Some(paces) => paces.map(|pace| 0.5 * pace),
            None if balls.len() == 1 => [0.0; 2],
            None => paces(cradle, first, length, &scene.nodes(&balls, [from, to], &[1.0])),
        };
        // Halving ends when parts are as short as the undisturbed time before them. By then what decays fast is over,
        // and what decays slowly is resolved; oscillations, too, must be one or the other.
        let graded = since > 0.0 && length <= 1.01 * since;
        let alone = |[swing, decay]: [f64; 2]| balls.len() == 1 && swing + decay <= ALONE;
        if alone([swing, decay]) || graded && 2.0 * decay > EXPLICIT {
            let rule = &*IMPLICIT;
            let at_nodes = scene.nodes(&balls, [from, to], rule.times());
            [swing, decay] = paces(cradle, first, length, &at_nodes);
            let settled =
                decay > EXPLICIT && (swing <= 2.0 * EXPLICIT || decay * since >= DECAY_TIMES_TO_SETTLE * length);
            let alone = alone([swing, decay]);
            let (balls, contacts) = at_nodes;
            if alone || settled && length * fastest_pendulum(&balls) <= PENDULUM {
                return self.enter(cradle, CollocationStep { first, length, rule, balls, contacts });
            }
        }
        if swing + decay <= 2.0 * EXPLICIT {
            let rule = stretching.table();
            let at_nodes = scene.nodes(&balls, [from, to], rule.times());
            [swing, decay] = paces(cradle, first, length, &at_nodes);
            let (balls, contacts) = at_nodes;
            let step = CollocationStep { first, length, rule, balls, contacts };
            if swing + decay <= EXPLICIT && step.is_resolved(cradle) {
                return self.enter(cradle, step);
            }
        }
        if halvings == HALVINGS || self.failure().is_some() {
            return self.fail(Unfollowed::Unresolved);
        }
        let (first_half, second_half) = match stretching {
            Stretching::None => (Stretching::None, Stretching::None),
            Stretching::AtStart(_) => (stretching, Stretching::None),
            Stretching::AtEnd(_) => (Stretching::None, stretching),
        };
        let (middle, known) = (0.5 * (from + to), (Some([swing, decay]), halvings + 1));
        self.linearise(scene, balls.clone(), [from, middle], first_half, known);
        self.linearise(scene, balls, [middle, to], second_half, known);
    }
}
