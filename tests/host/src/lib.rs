//! A small host for tests, benches and fuzzing: it drives the exported C functions as a C program would, and keeps the
//! log.

#![expect(unsafe_code, reason = "hosts call C functions")]
#![expect(clippy::unwrap_used, reason = "a host that does not get on fails the test")]

pub mod exchange;
pub mod extremes;
pub mod fmi3;
mod given;
mod log;
pub mod scenes;

use std::ffi::CString;
use std::ptr::{null, null_mut};
use std::sync::LazyLock;

use newtons_cradle::fmi2::*;
use newtons_cradle::variables::{Description, Settings, Type, Variable, variables};

pub use given::{assignments, resources};
pub use log::{Line, Lines, callbacks};
/// The two answers that tests expect.
pub use newtons_cradle::fmi2::fmi2Status::{fmi2Error, fmi2OK};

/// A row of a table of functions: the name, the states in which it is legal, and a call of it by the host `$host`.
#[macro_export]
macro_rules! call {
    ($host:ident, $states:expr, $function:ident($($argument:expr),*)) => {
        (stringify!($function), $states, |$host| unsafe { $function($host.c, $($argument),*) })
    };
}

/// A component and its log.
pub struct Host {
    /// The component, for calls that the host has no function for.
    pub c: fmi2Component,
    /// Number of balls n.
    pub balls: usize,
    lines: Box<Lines>,
}

impl Drop for Host {
    fn drop(&mut self) {
        unsafe { fmi2FreeInstance(self.c) }
    }
}

/// Arguments of fmi2Instantiate; the defaults are those of a well-behaved host of the default FMU.
pub struct Instantiate<'a> {
    /// Name of the instance; `None` is a null pointer.
    pub name: Option<&'a str>,
    /// Co-simulation or model exchange.
    pub kind: fmi2Type,
    /// GUID of the description; `None` is a null pointer.
    pub guid: Option<String>,
    /// URI of the resources; `None` is a null pointer.
    pub location: Option<String>,
    /// Whether all categories are logged from the start.
    pub logging: bool,
    /// Number of balls that the resources ask for.
    pub balls: usize,
}

impl Default for Instantiate<'_> {
    fn default() -> Self {
        let (name, kind, guid) = (Some("cradle"), fmi2CoSimulation, Some(guid(5)));
        Self { name, kind, guid, location: None, logging: false, balls: 5 }
    }
}

/// The GUID of the FMU with default start values.
pub fn guid(balls: usize) -> String {
    // Cached for five balls, because most hosts have five.
    static OF_FIVE: LazyLock<String> = LazyLock::new(|| Description::of(&Settings::default_for(5)).guid());
    if balls == 5 { OF_FIVE.clone() } else { Description::of(&Settings::default_for(balls)).guid() }
}

impl Instantiate<'_> {
    /// The component in a host, or the log if it is refused.
    pub fn host(self) -> Result<Host, Vec<Line>> {
        let lines = Box::<Lines>::default();
        let functions = callbacks(&lines);
        let texts = [self.name.map(str::to_owned), self.guid, self.location]
            .map(|text| text.map(|text| CString::new(text).unwrap()));
        let [name, guid, location] = texts.each_ref().map(|text| text.as_ref().map_or(null(), |text| text.as_ptr()));
        let logging = self.logging.into();
        let c = unsafe { fmi2Instantiate(name, self.kind, guid, location, &functions, 0, logging) };
        if c.is_null() { Err(lines.take()) } else { Ok(Host { c, balls: self.balls, lines }) }
    }
}

/// A component of the default FMU.
impl Default for Host {
    fn default() -> Self {
        Instantiate::default().host().unwrap()
    }
}

impl Host {
    /// A component of the default FMU that logs all categories from the start.
    pub fn logging() -> Self {
        Instantiate { logging: true, ..Default::default() }.host().unwrap()
    }

    /// A component of the FMU with this many balls.
    pub fn with_balls(balls: usize) -> Self {
        Self::of_kind(fmi2CoSimulation, balls)
    }

    /// A component of this kind, of the FMU with this many balls.
    pub(crate) fn of_kind(kind: fmi2Type, balls: usize) -> Self {
        let recipe = format!("{{\"format\":1,\"balls\":{balls}}}");
        let (_, location) = resources(&format!("balls-{balls}"), recipe.as_bytes());
        let (guid, location) = (Some(guid(balls)), Some(location));
        Instantiate { kind, guid, location, balls, ..Default::default() }.host().unwrap()
    }

    /// A component of the default FMU, initialized at t = 0.
    pub fn started() -> Self {
        Self::started_with("")
    }

    /// A component of the default FMU with these settings, initialized at t = 0; see [`assignments`].
    pub fn started_with(settings: &str) -> Self {
        let host = Self::default();
        host.give(settings);
        host.start();
        host
    }

    /// Sets up, enters and exits Initialization Mode.
    pub fn start(&self) {
        assert_eq!((self.set_up(0.0), self.enter(), self.exit()), (fmi2OK, fmi2OK, fmi2OK), "{:?}", self.log());
    }

    /// Sets up an experiment that starts at `start` (s), without tolerance and stop time.
    pub fn set_up(&self, start: f64) -> fmi2Status {
        unsafe { fmi2SetupExperiment(self.c, 0, f64::NAN, start, 0, f64::NAN) }
    }

    /// Enters Initialization Mode.
    pub fn enter(&self) -> fmi2Status {
        unsafe { fmi2EnterInitializationMode(self.c) }
    }

    /// Leaves Initialization Mode.
    pub fn exit(&self) -> fmi2Status {
        unsafe { fmi2ExitInitializationMode(self.c) }
    }

    /// A step of the length `step` (s) from the communication point `time` (s).
    pub fn step(&self, time: f64, step: f64) -> fmi2Status {
        unsafe { fmi2DoStep(self.c, time, step, 1) }
    }

    /// Brings an instantiated component into the error state: a force on free balls takes the first out of the range of
    /// doubles.
    pub fn fail(&self) {
        self.give("gravity=0 F_ext[1]=-1e300");
        self.start();
        if self.step(0.0, 1e9) == fmi2OK {
            // A flight is evaluated on demand; a changed input makes the FMU evaluate the state.
            assert_eq!((self.set("F_ext[1]", 0.0), self.step(1e9, 1.0)), (fmi2OK, fmi2Error));
        }
        assert!(self.error().contains("the run cannot go on"));
    }

    /// Resets the component to the instantiated state.
    pub fn reset(&self) -> fmi2Status {
        unsafe { fmi2Reset(self.c) }
    }

    /// Ends the run.
    pub fn terminate(&self) -> fmi2Status {
        unsafe { fmi2Terminate(self.c) }
    }

    /// The variable of this name.
    pub fn variable(&self, name: &str) -> Variable {
        Variable::named(name, self.balls).unwrap_or_else(|| panic!("no {name}"))
    }

    /// The time that the last step has reached, s; none if there was no step.
    pub fn time(&self) -> Option<f64> {
        let mut time = f64::NAN;
        let status = unsafe { fmi2GetRealStatus(self.c, fmi2LastSuccessfulTime, &mut time) };
        (status == fmi2OK).then_some(time)
    }

    /// Value reference of a variable.
    pub fn vr(&self, name: &str) -> u32 {
        self.variable(name).reference()
    }

    /// Sets a real variable, in its unit, or an enumeration, by the integer of an item.
    pub fn set(&self, name: &str, value: f64) -> fmi2Status {
        let (variable, item) = (self.variable(name), value as i32);
        match variable.row.access.data_type() {
            Type::Enumeration => unsafe { fmi2SetInteger(self.c, &variable.reference(), 1, &item) },
            _ => unsafe { fmi2SetReal(self.c, &variable.reference(), 1, &value) },
        }
    }

    /// Sets variables, which must be accepted; see [`assignments`].
    pub fn give(&self, settings: &str) {
        for (variable, value) in assignments(self.balls, settings) {
            assert_eq!(self.set(&variable.to_string(), value), fmi2OK, "{variable} = {value}: {:?}", self.log());
        }
    }

    /// Sets the time derivative of an input of this order, in the input's unit over s^order.
    pub fn set_derivative(&self, name: &str, order: i32, value: f64) -> fmi2Status {
        unsafe { fmi2SetRealInputDerivatives(self.c, &self.vr(name), 1, &order, &value) }
    }

    /// The time derivative of an output, of this order.
    pub fn derivative(&self, name: &str, order: i32) -> f64 {
        self.derivatives(&[self.variable(name)], order)[0]
    }

    /// The time derivatives of outputs, of this order.
    pub fn derivatives(&self, outputs: &[Variable], order: i32) -> Vec<f64> {
        let references: Vec<u32> = outputs.iter().map(Variable::reference).collect();
        let (orders, mut values) = (vec![order; outputs.len()], vec![f64::NAN; outputs.len()]);
        let (count, into) = (outputs.len(), values.as_mut_ptr());
        let status = unsafe { fmi2GetRealOutputDerivatives(self.c, references.as_ptr(), count, orders.as_ptr(), into) };
        assert_eq!(status, fmi2OK, "{references:?}: {:?}", self.log());
        values
    }

    /// The derivative of `unknown` along `known`.
    pub fn sensitivity(&self, unknown: &str, known: &str) -> f64 {
        self.along(&[self.variable(unknown)], &[self.variable(known)], &[1.0])[0]
    }

    /// The derivatives of unknowns along a direction in the space of knowns.
    pub fn along(&self, unknowns: &[Variable], knowns: &[Variable], direction: &[f64]) -> Vec<f64> {
        let mut values = vec![f64::NAN; unknowns.len()];
        let [unknowns, knowns] = [unknowns, knowns].map(|of| of.iter().map(Variable::reference).collect::<Vec<u32>>());
        let (unknowns, count) = (unknowns.as_ptr(), unknowns.len());
        let (knowns, of, along) = (knowns.as_ptr(), knowns.len(), direction.as_ptr());
        let status =
            unsafe { fmi2GetDirectionalDerivative(self.c, unknowns, count, knowns, of, along, values.as_mut_ptr()) };
        assert_eq!(status, fmi2OK, "{:?}", self.log());
        values
    }

    /// Saves the state.
    pub fn save(&self) -> fmi2FMUstate {
        let mut state = null_mut();
        assert_eq!(unsafe { fmi2GetFMUstate(self.c, &mut state) }, fmi2OK, "{:?}", self.log());
        state
    }

    /// Sets a saved state. Anything else must be refused, so that this can be called with any pointer.
    #[expect(clippy::not_unsafe_ptr_arg_deref, reason = "tests try pointers that are no states")]
    pub fn restore(&self, state: fmi2FMUstate) -> fmi2Status {
        unsafe { fmi2SetFMUstate(self.c, state) }
    }

    /// Frees a saved state; null is allowed.
    pub fn free(&self, mut state: fmi2FMUstate) {
        assert_eq!(unsafe { fmi2FreeFMUstate(self.c, &mut state) }, fmi2OK);
        assert!(state.is_null());
    }

    /// The state as bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let (state, mut size) = (self.save(), 0);
        assert_eq!(unsafe { fmi2SerializedFMUstateSize(self.c, state, &mut size) }, fmi2OK);
        let mut bytes = vec![0u8; size];
        assert_eq!(unsafe { fmi2SerializeFMUstate(self.c, state, bytes.as_mut_ptr().cast(), size) }, fmi2OK);
        self.free(state);
        bytes
    }

    /// Sets the state in these bytes, if they are accepted.
    pub fn set_bytes(&self, bytes: &[u8]) -> fmi2Status {
        let mut state = null_mut();
        let status = unsafe { fmi2DeSerializeFMUstate(self.c, bytes.as_ptr().cast(), bytes.len(), &mut state) };
        if status == fmi2OK {
            assert_eq!(self.restore(state), fmi2OK);
            self.free(state);
        } else {
            assert!(state.is_null());
        }
        status
    }

    /// The value of a variable of any type; none if the getter refuses it.
    pub fn read(&self, variable: Variable) -> Option<f64> {
        let (c, reference, mut real, mut integer) = (self.c, variable.reference(), f64::NAN, 0);
        let of_type = variable.row.access.data_type();
        let status = unsafe {
            match of_type {
                Type::Real => fmi2GetReal(c, &reference, 1, &mut real),
                Type::Boolean => fmi2GetBoolean(c, &reference, 1, &mut integer),
                _ => fmi2GetInteger(c, &reference, 1, &mut integer),
            }
        };
        (status == fmi2OK).then_some(if of_type == Type::Real { real } else { integer.into() })
    }

    /// The values of variables.
    pub fn values(&self, of: &[Variable]) -> Vec<f64> {
        let value =
            |variable: &Variable| self.read(*variable).unwrap_or_else(|| panic!("{variable}: {:?}", self.log()));
        of.iter().map(value).collect()
    }

    /// The values of all variables, as the bits of doubles.
    pub fn everything(&self) -> Vec<u64> {
        let all: Vec<Variable> = variables(self.balls).collect();
        self.values(&all).into_iter().map(f64::to_bits).collect()
    }

    /// A variable of any type; a real one in its unit, an enumeration as the integer of its item, a boolean as 0 or 1.
    pub fn get(&self, name: &str) -> f64 {
        self.values(&[self.variable(name)])[0]
    }

    /// The elements of an array, whatever their type.
    pub fn each(&self, array: &str) -> Vec<f64> {
        let elements: Vec<Variable> = variables(self.balls).filter(|variable| variable.row.name == array).collect();
        assert!(!elements.is_empty(), "there is no {array}");
        self.values(&elements)
    }

    /// The number of onsets of each contact so far.
    pub fn pulses(&self) -> Vec<i32> {
        self.each("pulses").into_iter().map(|count| count as i32).collect()
    }

    /// Takes the log so far.
    pub fn log(&self) -> Vec<Line> {
        self.lines.take()
    }

    /// Takes the log, which must be a single line, an error; returns its text.
    pub fn error(&self) -> String {
        let lines = self.log();
        let [line] = lines.as_slice() else { panic!("not one line but {lines:?}") };
        let heading = (line.instance.as_str(), line.status, line.category.as_str());
        assert_eq!(heading, ("cradle", fmi2Error, "logStatusError"), "{}", line.text);
        line.text.clone()
    }

    /// Checks that a call was refused, in a message with these words.
    #[track_caller]
    pub fn refused(&self, status: fmi2Status, words: &str) {
        let error = self.error();
        assert!(status == fmi2Error && error.contains(words), "{status:?}, {error}, not {words}");
    }

    /// Checks that the component is still usable: that it can be reset, initialized and stepped.
    pub fn assert_usable(&self) {
        assert_eq!(self.reset(), fmi2OK);
        self.start();
        assert_eq!(self.step(0.0, 0.01), fmi2OK);
        assert!((self.get("x[1]") + 0.1).abs() < 1e-3);
        self.log();
    }
}
