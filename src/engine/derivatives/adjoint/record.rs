//! Records a run in parts, from its switchings, as an observer of it.

use std::collections::BTreeMap;
use std::ops::Range;

use super::flown::{REACH, flown};
use super::group::Group;
use super::map::Map;
use super::pair::Pair;
use super::readout::End;
use super::{Tape, Tuning};
use crate::engine::derivatives::chain_state::ChainState;
use crate::engine::flight::{Flight, Forcing, shifted};
use crate::engine::inputs::HeldInputs;
use crate::engine::observer::{Observer, Pulse};
use crate::model::{ContactLaw, Cradle, Inputs, Mode, Parameters};
use crate::solver::double_double::DoubleDouble;
use crate::solver::gauss::{Power, Stretching};
use crate::solver::oscillator::Oscillator;

/// Numbers that a tape may hold: 128 MiB.
const MOST_NUMBERS: usize = 1 << 24;

/// Part of the amplitude of the motion, and of the velocities that go with it, by which a tape may end elsewhere than
/// the run. Up to 3e-12 were found in moving chains, also where ten balls amplify small changes by 1e37; some runs that
/// come to rest in contact end elsewhere.
const AGREEMENT: f64 = 1e-9;

/// How often a segment that is too long is halved.
const HALVINGS: u32 = 40;

/// Records a run on its way.
pub(crate) struct Recorder {
    tunings: Vec<Tuning>,
    /// The place of the tuning with these parameters, given by their bits.
    places: BTreeMap<[u64; 5], usize>,
    /// The tuning that acts.
    tuning: usize,
    /// Whether there is no tape: it would have too many parts.
    failed: bool,
    parts: Vec<Map>,
    /// Numbers held.
    numbers: usize,
    /// Each ball: its state, and the time that it refers to, s.
    x: Vec<f64>,
    v: Vec<f64>,
    time: Vec<DoubleDouble>,
    /// Time of the last switching, s.
    last: DoubleDouble,
    /// Each contact: its overlap, if it is closed.
    overlaps: Vec<Option<f64>>,
    /// From when on these inputs act (s): external forces, N, and the acceleration of the support, m/s2.
    since: f64,
    pushes: Vec<Forcing>,
    support: Forcing,
}

impl Observer for Recorder {
    fn pulse(&mut self, _pulse: Pulse) {}

    fn switching(&mut self, contact: usize, time: DoubleDouble, closes: bool) {
        self.failed = self.failed || self.switch(contact, time, closes).is_none();
        self.last = time;
    }

    fn stop(&self) -> Option<f64> {
        self.failed.then(|| self.last.value_up())
    }
}

impl Tape {
    /// Whether there can be tapes of runs with these parameters.
    pub(crate) fn takes(parameters: &Parameters) -> bool {
        let cradle = Cradle::new(parameters);
        cradle.restitution.is_none() && cradle.contacts.iter().all(ContactLaw::is_elastic)
    }
}

impl Recorder {
    /// At the start, at this time (s).
    pub fn new(time: f64, start: ChainState) -> Self {
        let balls = start.x.len();
        let overlap = |(overlap, mode): (&f64, &Mode)| (*mode != Mode::Open).then_some(*overlap);
        Self {
            tunings: Vec::new(),
            places: BTreeMap::new(),
            tuning: 0,
            failed: false,
            parts: Vec::new(),
            numbers: 0,
            overlaps: start.overlaps.iter().zip(&start.modes).map(overlap).collect(),
            x: start.x,
            v: start.v,
            time: vec![time.into(); balls],
            last: time.into(),
            since: time,
            pushes: Vec::new(),
            support: Forcing::default(),
        }
    }

    /// These parameters and inputs act from now on.
    pub fn begin(&mut self, parameters: &Parameters, inputs: &HeldInputs) -> Option<()> {
        let next = self.tunings.len();
        self.tuning = *self.places.entry(parameters.tunables().map(f64::to_bits)).or_insert(next);
        if self.tuning == next {
            let cradle = Cradle::new(parameters);
            let oscillators: Vec<Oscillator> =
                cradle.balls.iter().map(|ball| Oscillator::new(ball.omega2, ball.gamma)).collect();
            let sizes =
                [size_of_val(&cradle.balls[..]), size_of_val(&cradle.contacts[..]), size_of_val(&oscillators[..])];
            self.tunings.push(Tuning { parameters: parameters.clone(), cradle, oscillators });
            // Parameters have about as many numbers as the coefficients that follow from them.
            self.hold(2 * sizes.iter().sum::<usize>() / size_of::<f64>())?;
        }
        self.since = inputs.since;
        let polynomial = |of: &dyn Fn(&Inputs) -> f64| derivatives(inputs, of);
        self.pushes = (0..self.x.len()).map(|i| polynomial(&|inputs| inputs.force[i])).collect();
        self.support = polynomial(&|inputs| inputs.support_acceleration);
        Some(())
    }

    /// They have acted until this time (s).
    pub fn end(&mut self, until: f64) -> Option<()> {
        self.failed = self.failed || (0..self.x.len()).try_for_each(|ball| self.advance(ball, until.into())).is_none();
        (!self.failed).then_some(())
    }

    /// The tape, if there is one that ends where the run did.
    pub fn tape(self, end: &ChainState) -> Option<Tape> {
        let Self { tunings, tuning, parts, x, v, overlaps, .. } = self;
        let most = |values: &[f64]| values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let near = |own: &[f64], values: &[f64], size: f64| {
            own.iter().zip(values).all(|(own, value)| (own - value).abs() <= AGREEMENT * size)
        };
        // Where all balls pass the middle, or turn, the one that they have gives the size of the other.
        let omega = tunings[tuning].oscillators[0].omega();
        let (position, velocity) = (most(&end.x), most(&end.v));
        let swing = if omega > 0.0 { velocity / omega } else { 0.0 };
        let near = near(&x, &end.x, position.max(swing)) && near(&v, &end.v, velocity.max(omega * position));
        let closed = overlaps.iter().zip(&end.modes).all(|(overlap, mode)| overlap.is_some() == (*mode != Mode::Open));
        (!self.failed && closed && near).then(|| {
            let end = End::new(&tunings[tuning].cradle, &x, &v, &overlaps);
            Tape { tunings, parts, last: tuning, end }
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

    /// Moves a ball on to `until` (s), with those that it presses on.
    fn advance(&mut self, ball: usize, until: DoubleDouble) -> Option<()> {
        let length = (until - self.time[ball]).value();
        if length <= 0.0 {
            return Some(());
        }
        let first = (0..ball).rev().take_while(|j| self.overlaps[*j].is_some()).last().unwrap_or(ball);
        let end =
            (ball..self.overlaps.len()).take_while(|j| self.overlaps[*j].is_some()).last().map_or(ball, |j| j + 1) + 1;
        let contacts = first..end - 1;
        let Tuning { cradle, oscillators, .. } = &self.tunings[self.tuning];
        let pair = contacts.clone().next().and_then(|j| Pair::of(&cradle.balls[first..end], &cradle.contacts[j]));
        let pieces = |fastest: &Oscillator| (fastest.pace() * length / REACH).ceil().max(1.0);
        if contacts.is_empty() {
            let pieces = pieces(&oscillators[ball]);
            self.room(pieces, Map::numbers_of(1))?;
            (0..pieces as usize).try_for_each(|_| self.fly(ball, length / pieces))?;
        } else if let Some(pair) = pair {
            let pieces = pieces(&pair.oscillators[1]);
            self.room(pieces, Map::numbers_of(2))?;
            (0..pieces as usize).try_for_each(|_| self.press_pair(&pair, first, length / pieces))?;
        } else {
            // The forces of contacts that close at the start or open at the end grow from there with any power of the
            // time.
            let half = 0.5 * length;
            self.press(first..end, half, Stretching::AtStart(Power::Square), HALVINGS)?;
            self.press(first..end, half, Stretching::AtEnd(Power::Square), HALVINGS)?;
        }
        self.time[first..end].fill(until);
        Some(())
    }

    /// Adds a part of this length (s), which takes its balls so far: displacements and velocities.
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

    fn fly(&mut self, ball: usize, length: f64) -> Option<()> {
        let (flight, push) = self.flight(ball);
        let Tuning { cradle, oscillators, .. } = &self.tunings[self.tuning];
        let (model, oscillator) = (&cradle.balls[ball], &oscillators[ball]);
        let (part, end) = flown((ball, self.tuning), model, oscillator, (&flight, &push), length);
        self.enter(ball, length, part, &[end])
    }

    /// Inputs, which are these polynomials, as they act on this ball from now on.
    fn seen_from(&self, ball: usize, input: &Forcing) -> Forcing {
        shifted(input, (self.time[ball] - self.since.into()).value())
    }

    /// The flight of a ball from now on, and the external force (N).
    fn flight(&self, ball: usize) -> (Flight, Forcing) {
        let mass = self.tunings[self.tuning].cradle.balls[ball].mass;
        let [push, support] = [&self.pushes[ball], &self.support].map(|input| self.seen_from(ball, input));
        let forcing = std::array::from_fn(|k| push[k] / mass - support[k]);
        (Flight { x: self.x[ball], v: self.v[ball], forcing }, push)
    }

    fn press_pair(&mut self, pair: &Pair, first: usize, length: f64) -> Option<()> {
        let [left, right] = [first, first + 1].map(|ball| self.flight(ball));
        let overlap = self.overlaps[first].unwrap_or_default();
        let (flights, pushes) = ([left.0, right.0], [left.1, right.1]);
        let (part, ends) = pair.press((first, self.tuning), &flights, &pushes, overlap, length);
        self.enter(first, length, part, &ends)
    }

    /// Moves `balls`, which press on each other, on by `length` (s), in as many parts as that takes.
    fn press(&mut self, balls: Range<usize>, length: f64, stretching: Stretching, halvings: u32) -> Option<()> {
        self.room(1.0, Group::numbers_of(balls.len()))?;
        let (tuning, contacts) = (self.tuning, balls.start..balls.end - 1);
        let cradle = &self.tunings[tuning].cradle;
        let pushes: Vec<Forcing> = balls.clone().map(|ball| self.seen_from(ball, &self.pushes[ball])).collect();
        let overlaps = self.overlaps[contacts.clone()].iter().map(|overlap| overlap.unwrap_or_default());
        let group = Group {
            first: balls.start,
            tuning,
            models: &cradle.balls[balls.clone()],
            laws: &cradle.contacts[contacts],
            x: &self.x[balls.clone()],
            v: &self.v[balls.clone()],
            overlaps: &overlaps.collect::<Vec<f64>>(),
            pushes: &pushes,
            support: &self.seen_from(balls.start, &self.support),
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

    /// Holds so many numbers more, if there is room.
    fn hold(&mut self, numbers: usize) -> Option<()> {
        self.numbers = self.numbers.saturating_add(numbers);
        self.room(0.0, 0)
    }

    /// Whether there is room for so many parts of so many numbers, before time and memory go into them.
    fn room(&self, parts: f64, numbers: usize) -> Option<()> {
        (self.numbers as f64 + parts * numbers as f64 <= MOST_NUMBERS as f64).then_some(())
    }
}

/// An input with its derivatives by time.
fn derivatives(inputs: &HeldInputs, of: &dyn Fn(&Inputs) -> f64) -> Forcing {
    let mut found = Forcing::default();
    found.iter_mut().zip(inputs.orders()).for_each(|(to, inputs)| *to = of(inputs));
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::run::Engine;

    /// The start of a run, and a recorder of it.
    fn begun(parameters: &Parameters) -> (Engine, Recorder) {
        let run = Engine::new(parameters, &Inputs::zero(parameters.balls()), 0.0).unwrap();
        let mut recorder = Recorder::new(0.0, run.last_step().end);
        recorder.begin(parameters, &run.inputs).unwrap();
        (run, recorder)
    }

    #[test]
    fn parameters_that_come_back_take_no_room() {
        let p = Parameters::default_for(5);
        let (run, mut recorder) = begun(&p);
        let one = recorder.numbers;
        assert!(one > 0);
        for _ in 0..100 {
            for drag in [0.01, p.drag] {
                recorder.begin(&Parameters { drag, ..p.clone() }, &run.inputs).unwrap();
            }
        }
        assert_eq!((recorder.tunings.len(), recorder.tuning, recorder.numbers), (2, 0, 2 * one));
        recorder.numbers = MOST_NUMBERS;
        assert!(recorder.begin(&p, &run.inputs).is_some());
        assert!(recorder.begin(&Parameters { drag: 0.02, ..p }, &run.inputs).is_none());
    }

    #[test]
    fn a_run_that_is_too_long_is_not_followed_to_its_end() {
        let (mut run, mut recorder) = begun(&Parameters::default_for(3));
        recorder.numbers = MOST_NUMBERS;
        run.advance(100.0, &mut recorder).unwrap();
        assert!((0.1..2.0).contains(&run.time), "{}", run.time);
        assert!(recorder.end(100.0).is_none() && recorder.tape(&run.last_step().end).is_none());
    }
}
