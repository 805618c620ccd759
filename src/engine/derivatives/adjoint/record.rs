//! Takes a run down in parts, from its switchings.

use std::ops::Range;

use super::flown::{Flown, REACH, moved};
use super::pair::Pair;
use super::readout::End;
use super::segment::{Group, Segment};
use super::{Part, Tape, Tuning};
use crate::engine::derivatives::chain_state::ChainState;
use crate::engine::derivatives::history::Stretch;
use crate::engine::flight::{Flight, Forcing, shifted};
use crate::engine::inputs::HeldInputs;
use crate::engine::observer::{Observer, Pulse};
use crate::model::{ContactLaw, Cradle, Inputs, Mode, Parameters};
use crate::solver::double_double::DoubleDouble;
use crate::solver::gauss::Stretching;
use crate::solver::oscillator::Oscillator;

/// Numbers that a tape may hold: 128 MiB.
const MOST_NUMBERS: usize = 1 << 24;

/// Numbers of a flight.
const FLIGHT: usize = 16;

/// How often a segment that is too long is halved.
const HALVINGS: u32 = 40;

/// A contact that closes or opens.
#[derive(Clone, Copy, Debug)]
struct Switching {
    time: DoubleDouble,
    contact: usize,
    closes: bool,
}

/// The switchings of a run, in the order in which they were told.
#[derive(Clone, Debug, Default)]
pub(crate) struct Switchings(Vec<Switching>);

impl Observer for Switchings {
    fn pulse(&mut self, _pulse: Pulse) {}

    fn switching(&mut self, contact: usize, time: DoubleDouble, closes: bool) {
        self.0.push(Switching { time, contact, closes });
    }
}

/// A run on its way.
struct Recorder {
    tunings: Vec<Tuning>,
    parts: Vec<Part>,
    /// Numbers held.
    numbers: usize,
    /// Each ball: its state, and the time that it refers to, s.
    x: Vec<f64>,
    v: Vec<f64>,
    time: Vec<DoubleDouble>,
    /// Each contact: its overlap, if it is closed.
    overlaps: Vec<Option<f64>>,
    /// From when on these inputs act (s): external forces, N, and the acceleration of the support, m/s2.
    since: f64,
    pushes: Vec<Forcing>,
    support: Forcing,
}

impl Tape {
    /// Whether there can be tapes of runs with these parameters.
    pub(crate) fn takes(parameters: &Parameters) -> bool {
        let cradle = Cradle::new(parameters);
        cradle.restitution.is_none() && cradle.contacts.iter().all(ContactLaw::is_elastic)
    }

    /// The run from this start with these switchings; `parameters` act at its end. Nothing if it has too many parts.
    pub(crate) fn record(
        parameters: &Parameters,
        start_time: f64,
        start: ChainState,
        stretches: &[Stretch],
        switchings: Switchings,
    ) -> Option<Self> {
        let balls = start.x.len();
        let overlap = |(overlap, mode): (&f64, &Mode)| (*mode != Mode::Open).then_some(*overlap);
        let mut recorder = Recorder {
            tunings: Vec::new(),
            parts: Vec::new(),
            numbers: 0,
            overlaps: start.overlaps.iter().zip(&start.modes).map(overlap).collect(),
            x: start.x,
            v: start.v,
            time: vec![start_time.into(); balls],
            since: start_time,
            pushes: Vec::new(),
            support: Forcing::default(),
        };
        let mut left = switchings.0.into_iter().peekable();
        for stretch in stretches {
            recorder.begin(parameters, stretch)?;
            while let Some(switching) = left.next_if(|switching| switching.time <= stretch.until.into()) {
                recorder.switch(switching)?;
            }
            recorder.advance_all(stretch.until.into())?;
        }
        let Recorder { tunings, parts, x, v, overlaps, .. } = recorder;
        let finite = x.iter().chain(&v).all(|value| value.is_finite());
        finite.then_some(Self { tunings, parts, end: End { x, v, overlaps } })
    }
}

impl Recorder {
    /// What acts from now on.
    fn begin(&mut self, parameters: &Parameters, stretch: &Stretch) -> Option<()> {
        let mut parameters = parameters.clone();
        parameters.tune(stretch.tunables);
        if self.tunings.last().is_none_or(|tuning| tuning.parameters != parameters) {
            let cradle = Cradle::new(&parameters);
            let oscillators = cradle.balls.iter().map(|ball| Oscillator::new(ball.omega2, ball.gamma)).collect();
            self.tunings.push(Tuning { parameters, cradle, oscillators });
        }
        self.since = self.time.first().map_or(self.since, |time| time.value());
        let inputs = stretch.inputs.at(self.since);
        let polynomial = |of: &dyn Fn(&Inputs) -> f64| derivatives(&inputs, of);
        self.pushes = (0..self.x.len()).map(|i| polynomial(&|inputs| inputs.force[i])).collect();
        self.support = polynomial(&|inputs| inputs.support_acceleration);
        Some(())
    }

    fn switch(&mut self, Switching { time, contact, closes }: Switching) -> Option<()> {
        if self.overlaps[contact].is_some() == closes {
            return Some(());
        }
        for ball in [contact, contact + 1] {
            self.advance(ball, time)?;
        }
        self.overlaps[contact] = closes.then_some(0.0);
        Some(())
    }

    fn advance_all(&mut self, until: DoubleDouble) -> Option<()> {
        (0..self.x.len()).try_for_each(|ball| self.advance(ball, until))
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
        if end - first == 1 {
            self.fly(ball, length)?;
        } else if let Some(oscillators) = self.oscillators_of_pair(first..end) {
            self.press_pair(first, length, oscillators)?;
        } else {
            // The forces of contacts that close at the start or open at the end grow from there with any power of the time.
            let half = 0.5 * length;
            self.press(first..end, half, Stretching::AtStart(2), HALVINGS)?;
            self.press(first..end, half, Stretching::AtEnd, HALVINGS)?;
        }
        self.time[first..end].fill(until);
        Some(())
    }

    fn fly(&mut self, ball: usize, length: f64) -> Option<()> {
        let tuning = self.tunings.len() - 1;
        let o = self.tunings[tuning].oscillators[ball];
        let mass = self.tunings[tuning].cradle.balls[ball].mass;
        let pieces = ((o.omega() + 2.0 * o.gamma()) * length / REACH).ceil().max(1.0);
        self.hold((pieces * FLIGHT as f64) as usize)?;
        let (pieces, length) = (pieces as usize, length / pieces);
        let mut after = self.after(ball);
        for _ in 0..pieces {
            let (flight, push) = self.flight(ball, mass, after);
            let basis = o.basis(length.into());
            let (displacement, v) = moved(&flight, &o, &basis, length);
            self.x[ball] += displacement;
            self.v[ball] = v;
            after += length;
            self.parts.push(Part::Flown(Flown { ball, tuning, flight, push, length, basis }));
        }
        Some(())
    }

    /// Time since these inputs act, s.
    fn after(&self, ball: usize) -> f64 {
        (self.time[ball] - self.since.into()).value()
    }

    /// The flight of a ball of this mass (kg) `after` these inputs began to act (s), and the external force (N).
    fn flight(&self, ball: usize, mass: f64, after: f64) -> (Flight, Forcing) {
        let push = shifted(&self.pushes[ball], after);
        let support = shifted(&self.support, after);
        let forcing = std::array::from_fn(|k| push[k] / mass - support[k]);
        (Flight { x: self.x[ball], v: self.v[ball], forcing }, push)
    }

    /// The oscillators of the centre and of the overlap of these balls, if they are a pair that has them.
    fn oscillators_of_pair(&self, balls: Range<usize>) -> Option<[Oscillator; 2]> {
        let Tuning { cradle, .. } = self.tunings.last()?;
        let contact = &cradle.contacts[balls.start];
        (balls.len() == 2).then(|| Pair::oscillators(&cradle.balls[balls], contact)).flatten()
    }

    /// Moves two balls, the left one of which is `first`, on by `length` (s).
    fn press_pair(&mut self, first: usize, length: f64, oscillators: [Oscillator; 2]) -> Option<()> {
        let tuning = self.tunings.len() - 1;
        let contact = &oscillators[1];
        let pieces = ((contact.omega() + 2.0 * contact.gamma()) * length / REACH).ceil().max(1.0);
        self.hold((pieces * (4 * FLIGHT) as f64) as usize)?;
        let (pieces, length) = (pieces as usize, length / pieces);
        let mut after = self.after(first);
        for _ in 0..pieces {
            let cradle = &self.tunings[tuning].cradle;
            let [left, right] = [first, first + 1].map(|ball| self.flight(ball, cradle.balls[ball].mass, after));
            let overlap = self.overlaps[first].unwrap_or_default();
            let (flights, pushes) = ([left.0, right.0], [left.1, right.1]);
            let (pair, ends, closer) =
                Pair::new((first, tuning), cradle, oscillators, flights, pushes, overlap, length);
            for (side, (displacement, v)) in ends.into_iter().enumerate() {
                self.x[first + side] += displacement;
                self.v[first + side] = v;
            }
            self.overlaps[first] = Some(overlap + closer);
            after += length;
            self.parts.push(Part::Pair(Box::new(pair)));
        }
        Some(())
    }

    /// Moves `balls`, which press on each other, on by `length` (s), in as many parts as that takes.
    fn press(&mut self, balls: Range<usize>, length: f64, stretching: Stretching, halvings: u32) -> Option<()> {
        let tuning = self.tunings.len() - 1;
        let cradle = &self.tunings[tuning].cradle;
        let after = self.after(balls.start);
        let pushes: Vec<Forcing> = self.pushes[balls.clone()].iter().map(|push| shifted(push, after)).collect();
        let support = shifted(&self.support, after);
        let contacts = balls.start..balls.end - 1;
        let overlaps: Vec<f64> =
            self.overlaps[contacts.clone()].iter().map(|overlap| overlap.unwrap_or_default()).collect();
        let group = Group {
            first: balls.start,
            models: &cradle.balls[balls.clone()],
            laws: &cradle.contacts[contacts.clone()],
            x: &self.x[balls.clone()],
            v: &self.v[balls.clone()],
            overlaps: &overlaps,
            pushes: &pushes,
            support: &support,
        };
        let Some((segment, end)) = Segment::new(&group, tuning, length, stretching) else {
            let halvings = halvings.checked_sub(1)?;
            let (first, second) = match stretching {
                Stretching::None => (Stretching::None, Stretching::None),
                Stretching::AtStart(_) => (stretching, Stretching::None),
                Stretching::AtEnd => (Stretching::None, stretching),
            };
            self.press(balls.clone(), 0.5 * length, first, halvings)?;
            return self.press(balls, 0.5 * length, second, halvings);
        };
        self.hold(segment.numbers())?;
        for (i, (moved, faster)) in balls.clone().zip(&end) {
            self.x[i] += moved;
            self.v[i] += faster;
            self.time[i] += length;
        }
        for (j, pair) in contacts.zip(end.windows(2)) {
            self.overlaps[j] = self.overlaps[j].map(|overlap| overlap + (pair[0].0 - pair[1].0));
        }
        self.parts.push(Part::Segment(segment));
        Some(())
    }

    /// Makes room for so many numbers, if there is.
    fn hold(&mut self, numbers: usize) -> Option<()> {
        self.numbers = self.numbers.saturating_add(numbers);
        (self.numbers <= MOST_NUMBERS).then_some(())
    }
}

/// An input with its derivatives by time.
fn derivatives(inputs: &HeldInputs, of: &dyn Fn(&Inputs) -> f64) -> Forcing {
    let mut found = Forcing::default();
    found.iter_mut().zip(inputs.orders()).for_each(|(to, inputs)| *to = of(inputs));
    found
}
