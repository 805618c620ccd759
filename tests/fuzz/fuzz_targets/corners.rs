//! Runs at the corners of what is legal: parameters at their least, tiny, default, huge and largest values, and at
//! extremes of any magnitude; inputs with derivatives, steps to a million seconds. Every variable is read after every
//! step, the state is written and read, and derivatives are asked for, also before the run. No call may end the
//! process, answer what is not finite with fmi2OK, write a state that is refused, or, but for steps and their
//! derivatives, take more than a fixed amount of work; memory, and the time of these, are bounded by the options of
//! libFuzzer.
//!
//! Steps grow as long as little happens in them, by the FMU's own counters and by the clock: how many events a step has
//! to follow, and how many swings it has to search for one, is up to the cradle and to the host.
#![no_main]

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::time::{Duration, Instant};

use arbitrary::Arbitrary;
use cradle_host::extremes::extreme;
use cradle_host::{Host, fmi2Error, fmi2OK};
use libfuzzer_sys::fuzz_target;
use newtons_cradle::fmi2::fmi2GetDirectionalDerivative;
use newtons_cradle::variables::{Access, Causality, Settings, Type, Variability, Variable, variables};

/// Numbers of balls.
const BALLS: [usize; 5] = [1, 2, 3, 5, 13];

/// What any call but a step or a derivative may take here, where it is instrumented and others may be at work:
/// thousands of times what it should.
const LONGEST: Duration = Duration::from_secs(10);

/// The first step, s, unless the next onset is nearer. Derivatives are asked for after it only: they follow the whole
/// chain by series once more, however little happens, and give up after 100,000 of them.
const FIRST: f64 = 1e-9;

/// A step is followed by one `LONGER` times as long if the counters of work grew by less than this, and it took less
/// time than that.
const LITTLE: f64 = 200.0;
const SHORT: Duration = Duration::from_millis(20);

/// Under a force that grows with the cube of time, events become more numerous with its fifth power: 32 times by this
/// factor.
const LONGER: f64 = 2.0;

#[derive(Debug, Arbitrary)]
struct Run {
    balls: u8,
    /// Parameters, start values and inputs away from their defaults.
    settings: Vec<Setting>,
    start: Start,
    /// An output, and what it is derived by.
    along: (u8, u8),
    steps: Vec<Step>,
}

#[derive(Debug, Arbitrary)]
struct Setting {
    variable: u8,
    corner: Corner,
}

#[derive(Clone, Copy, Debug, Arbitrary)]
enum Corner {
    Least,
    Tiny,
    Small,
    Default,
    Large,
    Huge,
    Largest,
    Negative,
    /// This many thirds of the default, or of one where that is 0.
    Ordinary(u8),
    /// One of the [extremes](extreme).
    Extreme(u8),
}

/// What makes a run out of it.
#[derive(Debug, Arbitrary)]
enum Start {
    /// As the parameters say.
    Default,
    /// All at rest side by side.
    Touching,
    /// Pressed together by their gaps.
    Pressed(Corner),
    /// The first one comes, at this speed.
    Hit(Corner),
}

#[derive(Debug, Arbitrary)]
struct Step {
    /// Exponent of its greatest length: 0 is 1e-9 s, 1 is 1e-8 s.
    decade: u8,
    /// An input, and the order of its derivative; order 0 is its value.
    input: Option<(u8, u8, Corner)>,
    /// A parameter that may change during a run.
    tuned: Option<(u8, Corner)>,
}

thread_local! {
    static HOSTS: RefCell<BTreeMap<usize, Host>> = const { RefCell::new(BTreeMap::new()) };
}

fuzz_target!(|run: Run| HOSTS.with_borrow_mut(|hosts| {
    let balls = BALLS[usize::from(run.balls) % BALLS.len()];
    let host = hosts.entry(balls).or_insert_with(|| Host::with_balls(balls));
    let extreme = ["Least", "Largest", "Extreme"].iter().any(|corner| format!("{run:?}").contains(corner));
    let (variables, defaults) = (variables(balls).collect(), Settings::default_for(balls));
    Driver { host, variables, defaults, run: &run, extreme }.make();
}));

impl Corner {
    /// Which item of an enumeration it selects.
    fn index(self) -> usize {
        match self {
            Self::Ordinary(index) | Self::Extreme(index) => index.into(),
            Self::Least | Self::Tiny => 0,
            Self::Small | Self::Default => 1,
            Self::Large | Self::Huge => 2,
            Self::Largest | Self::Negative => 3,
        }
    }

    /// An allowed value of a real variable.
    fn value(self, variable: &Variable, defaults: &Settings) -> f64 {
        let (start, range) = (variable.value(defaults).unwrap_or_default(), variable.row.range);
        let scale = if start == 0.0 { 1.0 } else { start.abs() };
        let value = match self {
            Self::Least if range.above_min => f64::MIN_POSITIVE,
            Self::Least => range.min.unwrap_or(-f64::MAX),
            Self::Tiny => 1e-12 * scale,
            Self::Small => 1e-6 * scale,
            Self::Default => start,
            Self::Large => 1e4 * scale,
            Self::Huge => 1e12 * scale,
            Self::Largest => range.max.unwrap_or(f64::MAX),
            Self::Negative => -scale,
            Self::Ordinary(thirds) => f64::from(thirds) / 3.0 * scale,
            Self::Extreme(code) => extreme(code),
        };
        if range.contains(value) { value } else { start }
    }
}

struct Driver<'a> {
    host: &'a Host,
    variables: Vec<Variable>,
    defaults: Settings,
    run: &'a Run,
    /// It has values whose squares are beyond the range of doubles.
    extreme: bool,
}

impl Driver<'_> {
    fn make(&self) {
        let host = self.host;
        assert_eq!(host.reset(), fmi2OK);
        host.log();
        self.arrange();
        assert_eq!((host.set_up(0.0), host.enter()), (fmi2OK, fmi2OK));
        self.derive(self.run.along, |variable| variable.row.settable());
        if self.timed(&"fmi2ExitInitializationMode", || host.exit()) != fmi2OK {
            return self.refused();
        }
        self.read();
        let mut time = 0.0;
        for step in self.run.steps.iter().take(4) {
            if !self.change(step) {
                return self.refused();
            }
            let longest = 10f64.powi(i32::from(step.decade % 16) - 9);
            let ahead = host.read(host.variable("t_next")).map_or(FIRST, |next| next - time);
            host.log();
            let mut length = FIRST.min(ahead);
            while length <= longest {
                let (before, begin) = (self.work(), Instant::now());
                let (status, taken) = (host.step(time, length), begin.elapsed());
                if status != fmi2OK {
                    return self.refused();
                }
                time += length;
                self.read();
                let (bytes, read) = (host.to_bytes(), |bytes: Vec<u8>| host.set_bytes(&bytes));
                assert_eq!(read(bytes), fmi2OK, "{:?}: {:?}", host.log(), self.run);
                if length <= FIRST {
                    self.derive(self.run.along, |variable| variable.row.causality == Causality::Input);
                }
                if self.work() - before > LITTLE || taken > SHORT {
                    break;
                }
                length *= LONGER;
            }
        }
    }

    /// Sets what the run says, all of it legal.
    fn arrange(&self) {
        let settable: Vec<&Variable> = self.variables.iter().filter(|variable| variable.row.settable()).collect();
        for Setting { variable, corner } in self.run.settings.iter().take(6) {
            let variable = settable[usize::from(*variable) % settable.len()];
            self.set(variable, *corner);
        }
        let size = |name: &str, corner: Corner| {
            let variable = Variable::named(name, self.host.balls)?;
            Some(corner.value(&variable, &self.defaults).abs())
        };
        let moved = match self.run.start {
            Start::Default => return,
            Start::Touching => None,
            Start::Pressed(corner) => size("contact.gap[1]", corner).map(|overlap| format!("contact.gap={}", -overlap)),
            Start::Hit(corner) => size("v_start[1]", corner).map(|speed| format!("v_start[1]={speed}")),
        };
        self.host.give(&format!("x_start=0 {}", moved.unwrap_or_default()));
    }

    fn set(&self, variable: &Variable, corner: Corner) {
        let name = &variable.to_string();
        let value = match variable.row.access {
            Access::Enumeration(enumeration) => {
                // The general-purpose methods have steps of their own choice: they are not what is looked at here.
                let items = if name == "solver.method" { &enumeration.items[..1] } else { enumeration.items };
                items[corner.index() % items.len()].value.into()
            }
            _ => corner.value(variable, &self.defaults),
        };
        assert_eq!(self.host.set(name, value), fmi2OK, "{name} = {value}: {:?}", self.host.log());
    }

    /// Changes an input or a tunable parameter before a step; `false` if it was refused.
    fn change(&self, step: &Step) -> bool {
        let of = |kind: fn(&&Variable) -> bool, index: u8| {
            let all: Vec<&Variable> = self.variables.iter().filter(kind).collect();
            all[usize::from(index) % all.len()]
        };
        let mut accepted = true;
        if let Some((index, order, corner)) = &step.input {
            let input = of(|variable| variable.row.causality == Causality::Input, *index);
            let (name, value) = (input.to_string(), corner.value(input, &self.defaults));
            let status = match i32::from(order % 4) {
                // A step can take a minute under a force that grows to the largest doubles within a nanosecond.
                order if order == 0 || matches!(corner, Corner::Least | Corner::Largest | Corner::Extreme(_)) => {
                    self.host.set(&name, value)
                }
                order => self.host.set_derivative(&name, order, value),
            };
            accepted &= status == fmi2OK;
        }
        if let Some((index, corner)) = &step.tuned {
            let tunable = of(|variable| variable.row.variability == Variability::Tunable, *index);
            accepted &= self.host.set(&tunable.to_string(), corner.value(tunable, &self.defaults)) == fmi2OK;
        }
        accepted
    }

    /// Reads every variable: none is a NaN, and where values are no extremes, all of them exist.
    fn read(&self) {
        for variable in &self.variables {
            let value = self.timed(variable, || self.host.read(*variable));
            let log = self.host.log();
            let lacks = log.iter().any(|line| line.text.contains("beyond the range of doubles"));
            assert!(value.is_none_or(f64::is_finite), "{variable} = {value:?}: {:?}", self.run);
            assert!(value.is_some() || lacks && self.extreme, "{variable}: {log:?}: {:?}", self.run);
        }
        let (time, next) = (self.host.time(), self.host.read(self.host.variable("t_next")));
        assert!(time.is_some() && next > time, "t_next = {next:?} at {time:?}");
        // A step may have told that it took long.
        self.host.log();
    }

    /// Asks for a derivative of a real output by one of the variables `known`; it is finite or does not exist. That of
    /// `t_next`, and those over long steps, may take 100,000 segments.
    fn derive(&self, (unknown, known): (u8, u8), is_known: fn(&Variable) -> bool) {
        let real = |variable: &&Variable| variable.row.derivative.is_some() && variable.row.name != "t_next";
        let outputs = self.variables.iter().filter(real).filter(|output| output.row.causality == Causality::Output);
        let knowns =
            self.variables.iter().filter(|known| is_known(known) && known.row.access.data_type() == Type::Real);
        let of = |all: Vec<&Variable>, index: u8| *all[usize::from(index) % all.len()];
        let (unknown, known) = (of(outputs.collect(), unknown), of(knowns.collect(), known));
        let (c, seed, mut found) = (self.host.c, 1.0, f64::NAN);
        let of = [unknown, known].map(|variable| variable.reference());
        let status = unsafe { fmi2GetDirectionalDerivative(c, &of[0], 1, &of[1], 1, &seed, &mut found) };
        assert!(status != fmi2OK || found.is_finite(), "d {unknown} / d {known} = {found}: {:?}", self.run);
        self.host.log();
    }

    /// The FMU's counters of work, together.
    fn work(&self) -> f64 {
        self.host.get("solver.steps") + self.host.get("solver.events")
    }

    /// A refused call says why, in one line that names what was wrong.
    fn refused(&self) {
        let log = self.host.log();
        let errors: Vec<_> = log.iter().filter(|line| line.status == fmi2Error).collect();
        assert!(errors.len() == 1 && errors[0].text.contains(": "), "{log:?}");
    }

    /// Makes a call, which ends before long.
    fn timed<T>(&self, what: &dyn Display, call: impl FnOnce() -> T) -> T {
        let begin = Instant::now();
        let answer = call();
        let taken = begin.elapsed();
        assert!(taken < LONGEST, "{what} took {taken:?}: {:?}", self.run);
        answer
    }
}
