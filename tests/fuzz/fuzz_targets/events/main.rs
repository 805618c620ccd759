//! FMI 3.0: drives the C functions with random sequences of calls, for model exchange, and for co-simulation with and
//! without event mode, early return and calls within the step, and compares the answers with a picture of what is
//! legal. A legal call succeeds, a value out of range is discarded and changes nothing, any other call ends the run.
//! Forged states are refused, or can be looked at, written and gone on from.
#![no_main]

mod forgery;
mod hybrid;
mod inspection;
mod time;
mod values;

use std::fmt::Arguments;
use std::ptr::null_mut;
use std::sync::LazyLock;

use arbitrary::Arbitrary;
use cradle_host::fmi3::{Host, vr};
use libfuzzer_sys::fuzz_target;
use newtons_cradle::fmi3::fmi3Status::{self, fmi3Discard, fmi3Error, fmi3OK};
use newtons_cradle::fmi3::*;
use newtons_cradle::variables::{Type, Variable};

use hybrid::{Operation, Phase, Picture, Vector, few, of_type};
use inspection::{FLOATS, floats, forge, look};
use values::{Step, Value};

use Phase::{Configuration, ContinuousTime, Event, Initialization, Instantiated, Terminated};

/// All enumerations.
static ITEMS: LazyLock<Vec<Variable>> = LazyLock::new(|| of_type(Type::Enumeration));

/// Calls after which a sequence ends, so that none takes long.
const LONGEST: usize = 60;
const PLACES: usize = 2;
/// The most balls: those whose values have everyday ranges.
const BALLS: usize = 5;

/// Set-ups whose runs differ in kind: the default one, a wave, unequal balls, balls that stay pressed together. The
/// first impacts are near.
const SETUPS: [&[(&str, &[f64])]; 4] = [
    &[],
    &[HIT, ("contact.deadBand", &[0.0]), ("pendulum.drag", &[0.1])],
    &[HIT, ("contact.exponent", &[3.0]), ("ball.massRatio", &[1.0, 1.0, 2.0, 1.0, 1.0])],
    &[("x_start", &[0.0; 5]), ("contact.gap", &[-1e-5; 5]), ("contact.damping", &[2e4]), ("contact.deadBand", &[0.0])],
];

const HIT: (&str, &[f64]) = ("v_start", &[5.0, 5.0, 0.0, 0.0, 0.0]);

#[derive(Debug, Arbitrary)]
struct Sequence {
    kind: Kind,
    /// Its set-up; an odd one is started.
    start: u8,
    operations: Vec<Operation>,
}

#[derive(Clone, Copy, Debug, Arbitrary)]
enum Kind {
    CoSimulation { events: bool, early: bool },
    ModelExchange,
}

thread_local! {
    /// Reset before each sequence: without event mode and with it, in both cases without early return and with it.
    static HOSTS: [Host; 4] =
        [(false, false), (false, true), (true, false), (true, true)].map(|(events, early)| Host::new(events, early));
    static EXCHANGING: Host = Host::exchanging();
}

fuzz_target!(|sequence: Sequence| match sequence.kind {
    Kind::ModelExchange => EXCHANGING.with(|host| run(host, &sequence, Picture::new(true, true), false)),
    Kind::CoSimulation { events, early } => HOSTS.with(|hosts| {
        let host = &hosts[2 * usize::from(events) + usize::from(early)];
        run(host, &sequence, Picture::new(events, false), early);
    }),
});

fn run(host: &Host, sequence: &Sequence, picture: Picture, early: bool) {
    host.log(); // Or it would grow over all sequences.
    assert_eq!(unsafe { fmi3Reset(host.c) }, fmi3OK);
    let mut driver = Driver { host, early, picture, saved: [const { (null_mut(), None) }; PLACES], ended: false };
    for (name, values) in SETUPS[usize::from(sequence.start / 2) % SETUPS.len()] {
        assert_eq!(host.set(name, values), fmi3OK);
    }
    if sequence.start % 2 == 1 {
        driver.make(&Operation::EnterInitialization);
        driver.make(&Operation::ExitInitialization);
        if driver.picture.events {
            driver.make(&Operation::TakePart);
        }
    }
    for operation in sequence.operations.iter().take(LONGEST) {
        if !driver.ended {
            driver.make(operation);
        }
    }
    for (mut state, _) in driver.saved {
        assert_ne!(unsafe { fmi3FreeFMUState(host.c, &mut state) }, fmi3Status::fmi3Fatal);
    }
}

struct Driver<'a> {
    host: &'a Host,
    early: bool,
    picture: Picture,
    saved: [(fmi3FMUState, Option<Picture>); PLACES],
    ended: bool,
}

impl Driver<'_> {
    /// Takes an answer: success where the call is legal and its arguments are `possible`, else the end of the run. Says
    /// whether it succeeded.
    fn take(&mut self, what: &Operation, possible: bool, status: fmi3Status) -> bool {
        self.take_of_setter(format_args!("{what:?}"), possible && self.picture.allows(what), true, status)
    }

    /// The same of a setter, which discards values that are not `valid`.
    fn take_of_setter(&mut self, what: Arguments, legal: bool, valid: bool, status: fmi3Status) -> bool {
        let expected = match (legal, valid) {
            (false, _) => fmi3Error,
            (true, false) => fmi3Discard,
            (true, true) => fmi3OK,
        };
        let beyond_range = self.picture.extreme && expected == fmi3OK && [fmi3Error, fmi3Discard].contains(&status);
        assert!(status == expected || beyond_range, "{what} in {:?}: {status:?}, not {expected:?}", self.picture);
        self.given_up(status)
    }

    fn given_up(&mut self, status: fmi3Status) -> bool {
        assert!(status <= fmi3Error, "{status:?}");
        if status == fmi3Error {
            self.picture.give_up();
        }
        status == fmi3OK
    }

    /// A call that only goes to another phase.
    fn go(&mut self, what: &Operation, status: fmi3Status, phase: Phase) {
        if self.take(what, true, status) {
            self.picture.phase = phase;
        }
    }

    fn make(&mut self, operation: &Operation) {
        let c = self.host.c;
        let before = self.picture.phase;
        unsafe {
            match operation {
                Operation::EnterConfiguration => self.go(operation, fmi3EnterConfigurationMode(c), Configuration),
                Operation::ExitConfiguration => self.go(operation, fmi3ExitConfigurationMode(c), Instantiated),
                Operation::EnterInitialization => self.go(operation, self.host.enter(), Initialization),
                Operation::ExitInitialization => {
                    let next = if self.picture.events { Event } else { Phase::Step };
                    self.go(operation, fmi3ExitInitializationMode(c), next);
                }
                Operation::EnterEvents => {
                    self.go(operation, fmi3EnterEventMode(c), Event);
                    if self.picture.phase == Event && before != Event {
                        self.reach_event();
                    }
                }
                Operation::EnterStepMode => self.go(operation, fmi3EnterStepMode(c), Phase::Step),
                Operation::EnterContinuousTime => self.go(operation, fmi3EnterContinuousTimeMode(c), ContinuousTime),
                Operation::Terminate => self.go(operation, fmi3Terminate(c), Terminated),
                Operation::Reset => {
                    self.take(operation, true, fmi3Reset(c));
                    self.picture = Picture::new(self.picture.events, self.picture.exchange);
                }
                Operation::Update => _ = self.update(),
                Operation::TakePart => {
                    if self.picture.allows(&Operation::EnterEvents) {
                        self.make(&Operation::EnterEvents);
                    }
                    while self.picture.phase == Event && self.update() {}
                    match (self.picture.phase, self.picture.exchange) {
                        (Event, true) => self.make(&Operation::EnterContinuousTime),
                        (Event, false) => self.make(&Operation::EnterStepMode),
                        _ => {}
                    }
                }
                Operation::DoStep { current, step, within } => self.step(operation, current, step, within),
                Operation::SetBalls(balls) => {
                    let balls = u64::from(*balls) % (BALLS as u64 + 1);
                    let status = fmi3SetUInt64(c, &vr("n"), 1, &balls, 1);
                    let legal = self.picture.phase == Configuration;
                    if self.take_of_setter(format_args!("{operation:?}"), legal, balls > 0, status) {
                        self.picture.balls = balls as usize;
                    }
                }
                Operation::Set { which, values, excess } => self.set(operation, *which, values, *excess),
                Operation::SetItem { which, value } => {
                    let array = ITEMS[usize::from(*which) % ITEMS.len()];
                    let value = i64::from(*value);
                    let status = fmi3SetInt64(c, &array.reference(), 1, &value, 1);
                    let (legal, valid) = (self.picture.may_set(array), array.element(0).check(value as f64).is_ok());
                    self.take_of_setter(format_args!("{operation:?} of {array}"), legal, valid, status);
                }
                Operation::Get { which, excess } => {
                    let array = FLOATS[usize::from(*which) % FLOATS.len()];
                    let mut values = vec![f64::NAN; few(array.len(self.picture.balls), *excess)];
                    let status = fmi3GetFloat64(c, &array.reference(), 1, values.as_mut_ptr(), values.len());
                    let legal = self.picture.may_get(array) && values.len() == array.len(self.picture.balls);
                    if self.take(operation, legal, status) {
                        assert!(values.iter().all(|value| value.is_finite()), "{array} = {values:?}");
                    }
                }
                Operation::Derivative { adjoint, unknown, known, seed } => {
                    let [unknown, known] = [unknown, known].map(|which| FLOATS[usize::from(*which) % FLOATS.len()]);
                    let [rows, columns] = [unknown, known].map(|array| array.len(self.picture.balls));
                    let (seeds, found) = if *adjoint { (rows, columns) } else { (columns, rows) };
                    let seed = vec![seed.number(None); seeds];
                    let mut values = vec![f64::NAN; found];
                    let references = [&[unknown.reference()][..], &[known.reference()]];
                    let status = self.host.derivatives(*adjoint, references, &seed, &mut values);
                    assert!(self.picture.allows(operation) || status == fmi3Error);
                    self.given_up(status);
                }
                Operation::OutputDerivative { which, order } => {
                    let array = FLOATS[usize::from(*which) % FLOATS.len()];
                    let mut values = vec![f64::NAN; array.len(self.picture.balls)];
                    let (reference, order, n) = (array.reference(), i32::from(*order), values.len());
                    let status = fmi3GetOutputDerivatives(c, &reference, 1, &order, values.as_mut_ptr(), n);
                    assert!(self.picture.allows(operation) || status == fmi3Error);
                    self.given_up(status);
                }
                Operation::Save(place) => {
                    let (state, saved) = &mut self.saved[usize::from(*place) % PLACES];
                    *saved = Some(self.picture.clone());
                    let status = fmi3GetFMUState(c, state);
                    self.take(operation, true, status);
                }
                Operation::Load(place) => {
                    let (state, saved) = self.saved[usize::from(*place) % PLACES].clone();
                    if self.take(operation, saved.is_some(), fmi3SetFMUState(c, state)) {
                        self.picture = saved.unwrap();
                    }
                }
                Operation::Free(place) => {
                    let (state, saved) = &mut self.saved[usize::from(*place) % PLACES];
                    *saved = None;
                    let status = fmi3FreeFMUState(c, state);
                    self.take(operation, true, status);
                }
                Operation::Through(place) => {
                    let bytes = self.host.to_bytes();
                    let (state, saved) = &mut self.saved[usize::from(*place) % PLACES];
                    *saved = Some(self.picture.clone());
                    let status = fmi3DeserializeFMUState(c, bytes.as_ptr(), bytes.len(), state);
                    assert_eq!(fmi3SetFMUState(c, *state), fmi3OK);
                    assert!(self.host.to_bytes() == bytes, "its own bytes read and written are others");
                    self.take(operation, true, status);
                }
                Operation::Forge(changes) => {
                    forge(self.host, &self.picture, changes);
                    self.ended = true;
                }
                Operation::SetTime(step) => {
                    let time = self.picture.time + self.length(operation, step);
                    let status = fmi3SetTime(c, time);
                    if self.take(operation, time.is_finite() && time >= self.picture.event, status) {
                        self.picture.time = time;
                    }
                }
                Operation::SetStates { step, excess } => self.set_states(operation, step, *excess),
                Operation::CompletedStep => {
                    let [mut events, mut ended] = [9, 9];
                    let status = fmi3CompletedIntegratorStep(c, 1, &mut events, &mut ended);
                    if self.take(operation, true, status) {
                        assert!(events <= 1 && ended == 0);
                    }
                }
                Operation::GetVector { of, excess } => {
                    let length = self.picture.length(*of);
                    let (status, values) = self.vector(*of, few(length, *excess));
                    if self.take(operation, values.len() == length, status) {
                        assert!(values.iter().all(|value| value.is_finite()), "{of:?} = {values:?}");
                    }
                }
            }
        }
        if !self.ended && (before != self.picture.phase || matches!(operation, Operation::DoStep { .. })) {
            look(self.host, &self.picture);
        }
    }

    fn floats(&self, name: &str) -> Option<Vec<f64>> {
        floats(self.host, &self.picture, FLOATS.iter().copied().find(|array| array.row.name == name)?)
    }

    fn vector(&self, of: Vector, length: usize) -> (fmi3Status, Vec<f64>) {
        let mut values = vec![f64::NAN; length];
        let read = match of {
            Vector::States => fmi3GetContinuousStates,
            Vector::Derivatives => fmi3GetContinuousStateDerivatives,
            Vector::Nominals => fmi3GetNominalsOfContinuousStates,
            Vector::Indicators => fmi3GetEventIndicators,
        };
        (unsafe { read(self.host.c, values.as_mut_ptr(), length) }, values)
    }

    fn set_states(&mut self, operation: &Operation, step: &Step, excess: i8) {
        let length = self.length(operation, step);
        let mut y = vec![0.0; self.picture.length(Vector::States)];
        if self.picture.allows(operation) {
            let [(read, states), (derived, rates)] =
                [Vector::States, Vector::Derivatives].map(|of| self.vector(of, y.len()));
            assert!((read, derived) == (fmi3OK, fmi3OK) || self.picture.extreme, "{read:?}, {derived:?}");
            y = states.iter().zip(rates).map(|(y, rate)| y + length * rate).collect();
        }
        let states = y.len();
        y.resize(few(states, excess), 0.0);
        let status = unsafe { fmi3SetContinuousStates(self.host.c, y.as_ptr(), y.len()) };
        let legal = y.len() == states && y.iter().all(|y| y.is_finite());
        self.take(operation, legal, status);
    }

    fn set(&mut self, operation: &Operation, which: u8, values: &[Value], excess: i8) {
        let array = FLOATS[usize::from(which) % FLOATS.len()];
        let n = array.len(self.picture.balls);
        let value = |index: usize| {
            let value = values.get(index % values.len().max(1)).unwrap_or(&Value::Everyday(0));
            value.number(array.element(index).of_fmi2(BALLS))
        };
        let set: Vec<f64> = (0..few(n, excess)).map(value).collect();
        let extreme = values.iter().any(|value| matches!(value, Value::Extreme(_)));
        let before = self.host.to_bytes();
        let status = self.host.set(&array.to_string(), &set);
        let admitted = |(index, value): (usize, &f64)| {
            let element = array.element(index).of_fmi2(BALLS).or(array.element(0).of_fmi2(BALLS));
            element.is_none_or(|variable| variable.row.range.contains(*value))
        };
        let legal = set.len() == n && self.picture.may_set(array);
        let valid = set.iter().all(|value| value.is_finite()) && set.iter().enumerate().all(admitted);
        let told = array.element(0).of_fmi2(BALLS).is_some_and(|own| own.row.settable());
        if self.take_of_setter(format_args!("{operation:?} of {array} to {set:?}"), legal, valid, status) {
            self.picture.extreme |= extreme;
            assert!(!told || !self.picture.may_get(array) || self.host.floats(&array.to_string(), n) == set, "{array}");
        } else if status == fmi3Discard {
            assert!(self.host.to_bytes() == before, "{operation:?} was discarded and changed something");
        }
    }
}
