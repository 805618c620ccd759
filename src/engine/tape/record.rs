//! Records a run in parts, as they end.

use std::ops::Range;
use std::sync::Arc;

use super::arc_impact::ArcImpactPart;
use super::coefficients::{Coefficients, numbers_of_state};
use super::end::{Direction, End, cradle_along};
use super::events::{Closing, Jump, LastStepBegins, Overlap, Time, TimeShift};
use super::gradient::{Tape, TapedPart, Tuning};
use super::impact::ImpactPart;
use super::part::Part;
use super::scene::{ChainAtTime, Scene};
use super::unfollowed::Unfollowed;
use crate::engine::HeldInputs;
use crate::engine::chain_state::ChainState;
use crate::engine::cluster::{Cluster, Switch};
use crate::engine::flight::Ball;
use crate::engine::pair_impact::{ImpactCoefficients, PairImpact};
use crate::model::{Cradle, Inputs, Mode, Parameters};
use crate::solver::DoubleDouble;

/// Most numbers in a tape: 256 MiB; and in all parts that are followed along a direction: some seconds of work.
const MOST_NUMBERS: usize = 1 << 25;
const MOST_FOLLOWED: usize = 1 << 27;

/// Numbers that a tuning holds for each number of the state: parameters, coefficients and derivatives by them.
const NUMBERS_OF_TUNING: usize = 20;

/// Index of the common time.
const COMMON: u64 = 0;

/// Smallest rate of an overlap at an onset, over the velocities of its balls, for which they get a time of their own. A
/// shift by `d(overlap) / rate` and back loses precision by their ratio, the common time by up to 1e5.
const LEAST_RATE: f64 = 1e-6;

/// Where the parts go.
#[derive(Clone, Debug)]
pub(crate) enum Sink {
    /// All are kept.
    Tape(Vec<TapedPart>),
    /// Each is applied to the changes of the state along one direction.
    Direction(Box<Along>),
}

/// Changes along a direction: of the coefficients that act, and of the state so far.
#[derive(Clone, Debug)]
pub(crate) struct Along {
    tangent: Option<Parameters>,
    inputs: Inputs,
    coefficients: Coefficients,
    state: Vec<f64>,
}

impl Default for Sink {
    fn default() -> Self {
        Self::Tape(Vec::new())
    }
}

impl Sink {
    /// Along a direction, from this change of the state on.
    pub fn along((tangent, inputs): Direction, state: Vec<f64>) -> Self {
        let (tangent, coefficients) = (tangent.cloned(), Coefficients::zero(inputs.force.len()));
        Self::Direction(Box::new(Along { tangent, inputs: inputs.clone(), coefficients, state }))
    }
}

/// What a run notes while it is recorded.
#[derive(Clone, Debug)]
pub(crate) struct Recorder {
    sink: Sink,
    tunings: Vec<Tuning>,
    numbers: usize,
    /// When the last step begins, s, and for which balls it has.
    step_start: DoubleDouble,
    begun: Vec<bool>,
    /// The largest force of each contact in the last step so far, N.
    peaks: Vec<f64>,
    /// Index of the time at which the state of each ball holds, and number of times so far.
    times: Vec<u64>,
    shifts: u64,
    /// Which contacts press in the motion recorded so far.
    pressing: Vec<bool>,
    /// For the first of balls that press on each other: the end of their range, and the time since which nothing has
    /// happened to them.
    undisturbed: Vec<(usize, DoubleDouble)>,
    /// Along a direction, derivative of the time of the first onset since this was last cleared, s.
    pub next_onset: Option<f64>,
    /// Why a part is missing.
    failed: Option<Unfollowed>,
}

impl Recorder {
    /// A recorder for the run from now on, whose last step begins at the time `step_start` (s).
    pub fn new(sink: Sink, cradle: &Cradle, step_start: f64) -> Self {
        let (balls, contacts) = (cradle.balls.len(), cradle.contacts.len());
        Self {
            sink,
            tunings: Vec::new(),
            numbers: 0,
            step_start: step_start.into(),
            begun: vec![false; balls],
            peaks: vec![0.0; contacts],
            times: vec![COMMON; balls],
            pressing: vec![false; contacts],
            undisturbed: vec![(0, DoubleDouble::ZERO); balls],
            shifts: COMMON,
            next_onset: None,
            failed: None,
        }
    }

    /// Records with these parameters from now on.
    pub fn under(&mut self, parameters: &Parameters) {
        match &mut self.sink {
            Sink::Direction(along) => {
                let direction = (along.tangent.as_ref(), &along.inputs);
                along.coefficients = Coefficients::along(&cradle_along(parameters, direction), &along.inputs);
            }
            Sink::Tape(_) => {
                if self.tunings.last().is_none_or(|last| !last.parameters.is_tuned_as(parameters)) {
                    self.tunings.push(Tuning::new(parameters));
                    self.count_numbers(NUMBERS_OF_TUNING * numbers_of_state(parameters.balls()));
                }
            }
        }
    }

    /// The tape of the run with this end; `None` if the recorder follows a direction.
    pub fn tape(self, end: End) -> Option<Tape> {
        let Sink::Tape(parts) = self.sink else { return None };
        Some(Tape { tunings: self.tunings, parts, end })
    }

    /// The change of the state along the direction.
    pub fn changes(&self) -> Option<&[f64]> {
        if let Sink::Direction(along) = &self.sink { Some(&along.state) } else { None }
    }

    /// Why a part is missing, if one is.
    pub fn failure(&self) -> Option<Unfollowed> {
        self.failed
    }

    /// For how long nothing has happened to `balls` before the time `tau` (s), s.
    pub(super) fn undisturbed_for(&self, scene: &Scene, balls: &Range<usize>, tau: f64) -> f64 {
        (scene.start + tau - self.undisturbed[balls.start].1).value()
    }

    /// Counts more numbers; fails beyond the limit.
    fn count_numbers(&mut self, numbers: usize) {
        self.numbers = self.numbers.saturating_add(numbers);
        let most = if let Sink::Tape(_) = self.sink { MOST_NUMBERS } else { MOST_FOLLOWED };
        if self.numbers > most {
            self.fail(Unfollowed::TooLong);
        }
    }

    pub(super) fn enter(&mut self, cradle: &Cradle, part: impl Part + 'static) {
        self.count_numbers(part.numbers());
        if self.failed.is_some() {
            return;
        }
        match &mut self.sink {
            Sink::Direction(along) => part.forward(cradle, &along.coefficients, &mut along.state),
            Sink::Tape(parts) => parts.push((self.tunings.len() - 1, Arc::new(part))),
        }
    }

    /// Begins the last step for `balls`, whose motion from `from` to `to` (s after `start`) is entered next, unless it
    /// begins later. Returns its start, if that is within the motion.
    fn begin_step(&mut self, scene: &Scene, balls: Range<usize>, [from, to]: [f64; 2]) -> Option<f64> {
        let since = (self.step_start - scene.start).value();
        if since >= to || balls.clone().all(|i| self.begun[i]) {
            return None;
        }
        if from < since {
            return Some(since);
        }
        self.use_common_time(scene, &balls, from);
        for i in balls {
            if !std::mem::replace(&mut self.begun[i], true) {
                self.enter(scene.cradle, LastStepBegins { ball: i, state: scene.motion.state(i, from) });
            }
        }
        None
    }

    /// Begins the last step for all other balls, at the end of the run.
    pub fn end(&mut self, cradle: &Cradle, state: impl Fn(usize) -> (f64, f64)) {
        for i in 0..self.begun.len() {
            if !std::mem::replace(&mut self.begun[i], true) {
                self.enter(cradle, LastStepBegins { ball: i, state: state(i) });
            }
        }
    }

    /// Records the flight of ball `i` of `balls` from its anchor to the time `t`.
    pub fn fly(&mut self, i: usize, balls: &[Ball], t: DoubleDouble, cradle: &Cradle, inputs: &HeldInputs) {
        let scene = Scene { motion: &balls, start: balls[i].anchor, cradle, inputs };
        let beside = i.saturating_sub(1)..(i + 1).min(self.pressing.len());
        self.pressing[beside].fill(false);
        self.record_pressing(&scene, i..i + 1, [0.0, (t - balls[i].anchor).value()], false);
    }

    /// Records an `impact` of two of `balls`, anchored at its start, if it can be linearised in closed form; returns
    /// whether it can.
    pub fn strike(
        &mut self,
        impact: &PairImpact,
        balls: &[Ball],
        coefficients: &ImpactCoefficients,
        (cradle, inputs): (&Cradle, &HeldInputs),
    ) -> bool {
        let scene = Scene { motion: &balls, start: impact.start, cradle, inputs };
        let j = impact.contact;
        let (pair, length, begins) = (cradle.pair(j), impact.outcome.duration, self.step_start - impact.start);
        if 0.0 < begins.value() && begins.value() < length {
            return false;
        }
        let start @ [(_, left), (_, right)] = [j, j + 1].map(|i| (balls[i].flight.x, balls[i].flight.v));
        if left - right <= LEAST_RATE * left.abs().max(right.abs()) {
            return false;
        }
        let forcing = [j, j + 1].map(|i| balls[i].flight.forcing[0]);
        let external = [j, j + 1].map(|i| scene.inputs_of(i, 0.0)[0][0] / cradle.balls[i].mass);
        let acting = (start, forcing, external);
        let (arc, line) = match cradle.on_arcs() {
            true => (ArcImpactPart::new(&pair, j, acting, coefficients), None),
            false => (None, ImpactPart::shape(&pair, start, forcing, coefficients)),
        };
        if arc.is_none() && line.is_none() {
            return false;
        }
        for i in j..j + 2 {
            self.begin_step(&scene, i..i + 1, [0.0, length]);
            self.use_common_time(&scene, &(i..i + 1), 0.0);
        }
        let peak = impact.outcome.peak.force;
        let largest = (self.begun[j] && peak > self.peaks[j]).then(|| pair.law.static_overlap(peak));
        if largest.is_some() {
            self.peaks[j] = peak;
        }
        self.pressing[j] = false;
        if let Some(part) = arc {
            self.enter(cradle, ArcImpactPart { largest, ..part });
        }
        if let Some((shape, reach)) = line {
            self.enter(cradle, ImpactPart { contact: j, start, forcing, external, shape, reach, largest });
        }
        true
    }

    /// Records the motion of the members of a cluster from its start for `length` (s); that is its whole segment if it
    /// `ends`.
    pub fn follow(&mut self, cluster: &Cluster, length: f64, ends: bool, cradle: &Cradle, inputs: &HeldInputs) {
        let scene = Scene { motion: cluster, start: cluster.start, cradle, inputs };
        let mut first = cluster.members.start;
        for end in cluster.members.clone() {
            let presses = end + 1 < cluster.members.end && cluster.mode(end) == Mode::Pressing;
            if !presses {
                if let Some(pressing) = self.pressing.get_mut(end) {
                    *pressing = false;
                }
                let releases = cluster.switch.filter(|(_, switch)| *switch == Switch::Release && ends);
                let released = releases.map(|(j, _)| j).filter(|j| (first..end).contains(j));
                self.record_pressing(&scene, first..end + 1, [0.0, length], released.is_some());
                if let Some(j) = released {
                    self.jump(&scene, j, length, -1.0);
                }
                first = end + 1;
            }
        }
    }

    /// Moves the states of `balls`, which press on each other or are a single ball, to the common time.
    fn use_common_time(&mut self, scene: &Scene, balls: &Range<usize>, tau: f64) {
        if self.times[balls.clone()].iter().any(|time| *time != COMMON) {
            self.shift(scene, balls, tau, Time::Common, COMMON);
        }
    }

    /// Moves those states of `balls` that hold at another time `to` this one, of this index.
    fn shift(&mut self, scene: &Scene, balls: &Range<usize>, tau: f64, to: Time, number: u64) {
        let motions = scene.motions(balls, tau, false).into_iter().zip(&self.times[balls.clone()]);
        let motions = motions.map(|(motion, time)| (*time != number).then_some(motion)).collect();
        self.times[balls.clone()].fill(number);
        self.enter(scene.cradle, TimeShift { first: balls.start, balls: motions, to });
    }

    /// Gives `balls`, whose motion begins at `tau` (s), one time: that of a ball that has its own, or of the fastest
    /// onset among them unless it is slow.
    fn use_own_time(&mut self, scene: &Scene, balls: &Range<usize>, tau: f64) {
        if balls.len() == 1 {
            return self.use_common_time(scene, balls, tau);
        }
        let (times, first) = (&self.times[balls.clone()], balls.start);
        let differ = times.iter().any(|time| *time != times[0]);
        match times.iter().position(|time| *time != COMMON) {
            Some(k) if differ => {
                let number = times[k];
                self.shift(scene, balls, tau, Time::Of(first + k), number);
            }
            Some(_) => {}
            None => {
                let fastest = balls.clone().map(|i| scene.motion.state(i, tau).1.abs()).fold(0.0, f64::max);
                let onsets = (first..balls.end - 1).filter(|j| scene.motion.overlap(*j, tau).0 == 0.0);
                let onsets = onsets.map(|j| scene.overlap(j, tau)).filter(|onset| onset.rate() > LEAST_RATE * fastest);
                if let Some(onset) = onsets.max_by(|a, b| a.rate().total_cmp(&b.rate())) {
                    self.shifts += 1;
                    let contact = onset.contact;
                    self.shift(scene, balls, tau, Time::Onset(onset), self.shifts);
                    self.pressing[contact] = true;
                    self.enter(scene.cradle, Closing { contact, overlap: None });
                }
            }
        }
    }

    /// Records that contact `j` closes (1) or opens (-1) at `tau` (s): with a dashpot its force jumps.
    fn jump(&mut self, scene: &Scene, j: usize, tau: f64, sign: f64) {
        let growth = sign * scene.cradle.contacts[j].unclipped_force(f64::MIN_POSITIVE, 1.0);
        if growth != 0.0 {
            let along = scene.overlap(j, tau).linkage.along;
            self.enter(scene.cradle, Jump { contact: j, along, growth });
        }
    }

    /// Records that the motion is interrupted in this state at the time `t`: all states hold at the common time again.
    pub fn interrupt(&mut self, state: &ChainState, t: DoubleDouble, cradle: &Cradle, inputs: &HeldInputs) {
        self.undisturbed.fill((0, t));
        let moment = ChainAtTime { state, cradle };
        let scene = Scene { motion: &moment, start: t, cradle, inputs };
        let mut first = 0;
        for end in 0..cradle.balls.len() {
            if state.contacts.get(end).is_none_or(|contact| contact.mode != Mode::Pressing) {
                self.use_common_time(&scene, &(first..end + 1), 0.0);
                first = end + 1;
            }
        }
    }

    /// Notes that contact `j` closes, with its balls in these states.
    pub fn onset(&mut self, j: usize, states: [(f64, f64); 2], cradle: &Cradle) {
        if let (Sink::Direction(along), None) = (&self.sink, self.next_onset) {
            let overlap = Overlap::new(cradle, j, states);
            self.next_onset = Some(-overlap.change(&along.coefficients, &along.state) / overlap.rate());
        }
    }

    /// Notes why something is not followed.
    pub fn fail(&mut self, why: Unfollowed) {
        self.failed = self.failed.or(Some(why));
    }

    /// Records the motion of balls that press on each other, or of a single ball; if it `releases`, a contact opens at
    /// its end.
    fn record_pressing(&mut self, scene: &Scene, balls: Range<usize>, [from, to]: [f64; 2], releases: bool) {
        if from >= to {
            return;
        }
        if let Some(middle) = self.begin_step(scene, balls.clone(), [from, to]) {
            self.record_pressing(scene, balls.clone(), [from, middle], false);
            return self.record_pressing(scene, balls, [middle, to], releases);
        }
        let closes = (balls.start..balls.end - 1).any(|j| !self.pressing[j]);
        if closes || balls.len() == 1 || self.undisturbed[balls.start].0 != balls.end {
            self.undisturbed[balls.start] = (balls.end, scene.start + from);
        }
        self.use_own_time(scene, &balls, from);
        for j in balls.start..balls.end - 1 {
            if !std::mem::replace(&mut self.pressing[j], true) {
                let overlap = Some(scene.overlap(j, from).at_one_time());
                self.enter(scene.cradle, Closing { contact: j, overlap });
                if scene.motion.overlap(j, from).0 <= 0.0 {
                    self.jump(scene, j, from, 1.0);
                }
            }
        }
        let mut since = from;
        for (tau, j, force) in self.peaks_within(scene, &balls, [from, to]) {
            self.press_between_peaks(scene, balls.clone(), [since, tau], releases && tau == to);
            self.peaks[j] = force;
            self.enter(scene.cradle, scene.peak_part(&balls, j, tau, tau == to));
            since = tau;
        }
        self.press_between_peaks(scene, balls, [since, to], releases);
    }

    /// The contacts between `balls` whose force exceeds all before it in the step: when (s), which, and the force (N),
    /// in the order of time.
    fn peaks_within(&self, scene: &Scene, balls: &Range<usize>, between: [f64; 2]) -> Vec<(f64, usize, f64)> {
        if !self.begun[balls.start] {
            return Vec::new();
        }
        let peak = |j: usize| scene.largest_force(j, between, self.peaks[j]).map(|peak| (peak.time, j, peak.force));
        let mut found: Vec<_> = (balls.start..balls.end - 1).filter_map(peak).collect();
        found.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
        found
    }
}
