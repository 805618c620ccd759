//! Records a run in parts, from its switchings, as an observer of it.

use std::ops::Range;
use std::sync::Arc;

use super::group::PressedBalls;
use super::map::{COEFFICIENTS, Map, OF_BALL, STATE, V, X, numbers_of_coefficients};
use super::oscillation::Oscillation;
use super::{Tape, Tuning};
use crate::engine::flight::{Flight, Forcing, shifted};
use crate::engine::{HeldInputs, Observer, cluster::WindowContact, derivatives::chain_state::ChainState};
use crate::model::{ContactLaw, Cradle, Inputs, Mode, Parameters};
use crate::solver::{DoubleDouble, Power, Stretching};

/// Numbers that a tape may hold: 128 MiB.
const MOST_NUMBERS: usize = 1 << 24;

/// Numbers that a tuning holds for each coefficient: about as many parameters, and their shares in a gradient.
const NUMBERS_OF_TUNING: usize = 4;

/// Allowed difference between the ends of a tape and of the run, over the amplitude. In moving chains up to 3e-12 was
/// found, even where ten balls amplify small changes by 1e37; some runs that come to rest in contact differ by more.
const AGREEMENT: f64 = 1e-9;

/// How often a segment that is too long is halved.
const HALVINGS: u32 = 40;

pub(crate) struct Recorder {
    tunings: Vec<Arc<Tuning>>,
    /// Whether there is no tape: it would have too many parts.
    failed: bool,
    parts: Vec<Map>,
    numbers: usize,
    /// For each ball: its state (m, m/s), and the time that it refers to, s.
    x: Vec<f64>,
    v: Vec<f64>,
    time: Vec<DoubleDouble>,
    /// Time of the last switching, s.
    last: DoubleDouble,
    /// For each contact: its overlap (m), if it is closed.
    overlaps: Vec<Option<f64>>,
    inputs: HeldInputs,
}

impl Observer for Recorder {
    fn switching(&mut self, contact: usize, time: DoubleDouble, closes: bool) {
        self.failed = self.failed || self.switch(contact, time, closes).is_none();
        self.last = time;
    }

    fn stop(&self) -> Option<f64> {
        self.failed.then(|| self.last.value_up())
    }
}

impl Recorder {
    /// At the start, at this time (s).
    pub fn new(time: f64, start: &ChainState) -> Self {
        let balls = start.flights.len();
        let overlap = |contact: &WindowContact| (contact.mode != Mode::Open).then_some(contact.overlap);
        Self {
            tunings: Vec::new(),
            failed: false,
            parts: Vec::new(),
            numbers: 0,
            overlaps: start.contacts.iter().map(overlap).collect(),
            x: start.flights.iter().map(|ball| ball.x).collect(),
            v: start.flights.iter().map(|ball| ball.v).collect(),
            time: vec![time.into(); balls],
            last: time.into(),
            inputs: HeldInputs::constant(Inputs::zero(balls), time),
        }
    }

    /// These parameters and inputs act from now on; `None` if no tape can follow them.
    pub fn begin(&mut self, parameters: &Parameters, inputs: &HeldInputs) -> Option<()> {
        if self.tunings.last().is_none_or(|last| last.parameters.tunables() != parameters.tunables()) {
            let cradle = Cradle::new(parameters);
            if cradle.on_arcs() || cradle.restitution.is_some() || !cradle.contacts.iter().all(ContactLaw::is_elastic) {
                return None;
            }
            self.tunings.push(Arc::new(Tuning { parameters: parameters.clone(), cradle }));
            self.hold(NUMBERS_OF_TUNING * numbers_of_coefficients(self.x.len()))?;
        }
        self.inputs.clone_from(inputs);
        Some(())
    }

    /// Ends them at this time (s).
    pub fn end(&mut self, until: f64) -> Option<()> {
        self.failed = self.failed || (0..self.x.len()).try_for_each(|ball| self.advance(ball, until.into())).is_none();
        (!self.failed).then_some(())
    }

    /// The tape, if there is one that ends where the run did.
    pub fn tape(self, end: &ChainState) -> Option<Tape> {
        let Self { tunings, parts, x, v, overlaps, .. } = self;
        let (tuning, acting) = (tunings.len() - 1, Arc::clone(tunings.last()?));
        let most =
            |value: fn(&Flight) -> f64| end.flights.iter().fold(0.0, |most: f64, ball| most.max(value(ball).abs()));
        let near = |own: &[f64], value: fn(&Flight) -> f64, size: f64| {
            own.iter().zip(&end.flights).all(|(own, ball)| (own - value(ball)).abs() <= AGREEMENT * size)
        };
        // Where all balls pass the middle, or turn, positions or velocities alone give the scale of both.
        let omega = acting.cradle.balls[0].omega2.sqrt();
        let (position, velocity) = (most(|ball| ball.x), most(|ball| ball.v));
        let swing = if omega > 0.0 { velocity / omega } else { 0.0 };
        let near =
            near(&x, |ball| ball.x, position.max(swing)) && near(&v, |ball| ball.v, velocity.max(omega * position));
        let closed = |(overlap, end): (&Option<f64>, &WindowContact)| overlap.is_some() == (end.mode != Mode::Open);
        let closed = overlaps.iter().zip(&end.contacts).all(closed);
        (!self.failed && closed && near).then(|| {
            let sums = sums(&acting.cradle, tuning, &x, &v, &overlaps);
            Tape { tunings, parts, sums }
        })
    }

    fn switch(&mut self, contact: usize, time: DoubleDouble, closes: bool) -> Option<()> {
        if self.overlaps[contact].is_some() == closes {
            return Some(());
        }
        for ball in [contact, contact + 1] {
            self.advance(ball, time)?;
        }
        self.overlaps[contact] = closes.then_some(0.0);
        Some(())
    }

    /// Advances a ball to `until` (s), with those that it presses on.
    fn advance(&mut self, ball: usize, until: DoubleDouble) -> Option<()> {
        let length = (until - self.time[ball]).value();
        if length <= 0.0 {
            return Some(());
        }
        let closed = |j: &usize| self.overlaps[*j].is_some();
        let first = ball - (0..ball).rev().take_while(closed).count();
        let end = ball + (ball..self.overlaps.len()).take_while(closed).count() + 1;
        let contacts = first..end - 1;
        let tuning = Arc::clone(self.tunings.last()?);
        let (models, laws) = (&tuning.cradle.balls[first..end], &tuning.cradle.contacts[contacts]);
        if let Some(oscillation) = Oscillation::of(models, laws) {
            let pieces = oscillation.pieces(length);
            self.room(pieces, Map::numbers_of(models.len()))?;
            (0..pieces as usize).try_for_each(|_| self.oscillate(&oscillation, first..end, length / pieces))?;
        } else {
            // Forces of contacts that close at the start or open at the end grow from there with any power of time.
            let half = 0.5 * length;
            self.press(first..end, half, Stretching::AtStart(Power::Square), HALVINGS)?;
            self.press(first..end, half, Stretching::AtEnd(Power::Square), HALVINGS)?;
        }
        self.time[first..end].fill(until);
        Some(())
    }

    /// Adds a part of this length (s), with the displacements and velocities of its balls at the end.
    fn enter(&mut self, first: usize, length: f64, part: Map, ends: &[(f64, f64)]) -> Option<()> {
        self.hold(Map::numbers_of(ends.len()))?;
        self.parts.push(part);
        for (i, (moved, v)) in (first..).zip(ends) {
            self.x[i] += moved;
            self.v[i] = *v;
            self.time[i] += length;
        }
        for (j, pair) in (first..).zip(ends.windows(2)) {
            self.overlaps[j] = self.overlaps[j].map(|overlap| overlap + (pair[0].0 - pair[1].0));
        }
        Some(())
    }

    /// The external force on this ball (N) and the acceleration of the support (m/s2), expanded about its time.
    fn inputs_of(&self, ball: usize) -> [Forcing; 2] {
        let (inputs, tau) = (&self.inputs, (self.time[ball] - self.inputs.since.into()).value());
        let of = [inputs.derivatives(|i| i.force[ball]), inputs.derivatives(|i| i.support_acceleration)];
        of.map(|input| shifted(&input, tau))
    }

    fn oscillate(&mut self, oscillation: &Oscillation, balls: Range<usize>, length: f64) -> Option<()> {
        let flight = |ball: usize| {
            let [push, support] = self.inputs_of(ball);
            let mass = oscillation.models[ball - balls.start].mass;
            let forcing = std::array::from_fn(|k| push[k] / mass - support[k]);
            (Flight { x: self.x[ball], v: self.v[ball], forcing }, push)
        };
        let overlap = self.overlaps.get(balls.start).copied().flatten().unwrap_or_default();
        let place = (balls.start, self.tunings.len() - 1);
        let left = flight(balls.start);
        let right = if balls.len() == 1 { left } else { flight(balls.start + 1) };
        let (part, ends) = oscillation.follow(place, [left, right], overlap, length);
        self.enter(balls.start, length, part, &ends[..balls.len()])
    }

    /// Advances `balls`, which press on each other, by `length` (s), in as many parts as needed.
    fn press(&mut self, balls: Range<usize>, length: f64, stretching: Stretching, halvings: u32) -> Option<()> {
        self.room(1.0, PressedBalls::numbers_of(balls.len()))?;
        let (tuning, contacts) = (self.tunings.len() - 1, balls.start..balls.end - 1);
        let cradle = &self.tunings[tuning].cradle;
        let [_, support] = self.inputs_of(balls.start);
        let pushes: Vec<Forcing> = balls.clone().map(|ball| self.inputs_of(ball)[0]).collect();
        let overlaps = self.overlaps[contacts.clone()].iter().map(|overlap| overlap.unwrap_or_default());
        let group = PressedBalls {
            first: balls.start,
            tuning,
            models: &cradle.balls[balls.clone()],
            laws: &cradle.contacts[contacts],
            x: &self.x[balls.clone()],
            v: &self.v[balls.clone()],
            overlaps: &overlaps.collect::<Vec<f64>>(),
            pushes: &pushes,
            support: &support,
            length,
            table: stretching.table(),
        };
        if let Some((part, ends)) = group.press() {
            return self.enter(balls.start, length, part, &ends);
        }
        let halvings = halvings.checked_sub(1)?;
        let (first, second) = match stretching {
            Stretching::None => (Stretching::None, Stretching::None),
            Stretching::AtStart(_) => (stretching, Stretching::None),
            Stretching::AtEnd(_) => (Stretching::None, stretching),
        };
        self.press(balls.clone(), 0.5 * length, first, halvings)?;
        self.press(balls, 0.5 * length, second, halvings)
    }

    /// Counts this many more numbers, if there is room.
    fn hold(&mut self, numbers: usize) -> Option<()> {
        self.numbers = self.numbers.saturating_add(numbers);
        self.room(0.0, 0)
    }

    /// Whether there is room for this many parts of this many numbers.
    fn room(&self, parts: f64, numbers: usize) -> Option<()> {
        (self.numbers as f64 + parts * numbers as f64 <= MOST_NUMBERS as f64).then_some(())
    }
}

/// Derivatives of energy, momentum and force on the support in this state (m, m/s), with overlaps (m) where closed.
fn sums(cradle: &Cradle, tuning: usize, x: &[f64], v: &[f64], overlaps: &[Option<f64>]) -> Map {
    let mut map = Map::of_rows(3, 0, cradle.balls.len(), tuning);
    for (i, ball) in cradle.balls.iter().enumerate() {
        let (x, v, mass) = (x[i], v[i], ball.mass);
        // m (v^2 + omega2 x^2) / 2, m v, and m (omega2 x + 2 gamma v), by x, v and the coefficients.
        let of_energy = [0.5 * (v * v + ball.omega2 * x * x), 0.5 * mass * x * x, 0.0];
        let of_force = [ball.omega2 * x + 2.0 * ball.gamma * v, mass * x, 2.0 * mass * v];
        for (number, by_x, by_v, by_ball) in [
            (0, mass * ball.omega2 * x, mass * v, of_energy),
            (1, 0.0, mass, [v, 0.0, 0.0]),
            (2, mass * ball.omega2, 2.0 * mass * ball.gamma, of_force),
        ] {
            let [state, coefficients] = map.row(number);
            (state[STATE * i + X], state[STATE * i + V]) = (by_x, by_v);
            coefficients[COEFFICIENTS * i..][..by_ball.len()].copy_from_slice(&by_ball);
        }
    }
    let [state, coefficients] = map.row(0);
    for (j, law) in cradle.contacts.iter().enumerate() {
        let Some(overlap) = overlaps[j].filter(|overlap| *overlap > 0.0) else { continue };
        // F d / (p + 1).
        let (force, stored) = (law.elastic_force(overlap), law.elastic_energy(overlap));
        state[STATE * j + X] += force;
        state[STATE * (j + 1) + X] -= force;
        let by_reference = (1.0 - law.exponent) * stored / law.overlap_ref;
        let by_exponent = stored * (libm::log(overlap / law.overlap_ref) - 1.0 / (law.exponent + 1.0));
        let by_law = [stored / law.stiffness, by_reference, by_exponent, -force];
        coefficients[COEFFICIENTS * j + OF_BALL..][..by_law.len()].copy_from_slice(&by_law);
    }
    map
}
