//! From the bytes of the fuzzer to calls: mostly legal ones with values of everyday cradles, and some that are not.
//!
//! Values stay within magnitudes at which a step takes little time; ranges are tested elsewhere, with the extremes.

use arbitrary::Arbitrary;

use crate::interface::{Interface, Kind, Variable};
use crate::model::{Call, Model, Type, Vector};

/// How many places a host has for states, and as many for bytes.
pub const PLACES: usize = 3;

/// One call, as the fuzzer writes it.
#[derive(Clone, Debug, Arbitrary)]
pub enum Operation {
    SetDebugLogging {
        on: bool,
        categories: Vec<u8>,
    },
    SetupExperiment {
        tolerance: Option<Value>,
        start: Value,
        stop: Option<Value>,
    },
    EnterInitializationMode,
    ExitInitializationMode,
    Terminate,
    Reset,
    Get {
        of: Type,
        references: Vec<Reference>,
        null: bool,
    },
    Set {
        of: Type,
        values: Vec<(Reference, Value)>,
        null: bool,
    },
    /// One value, of the type that the variable has.
    SetOne(u8, Value),
    GetFMUstate(u8),
    SetFMUstate(u8),
    FreeFMUstate(u8),
    SerializeFMUstate {
        from: u8,
        to: u8,
        excess: bool,
    },
    DeSerializeFMUstate {
        from: u8,
        to: u8,
        missing: bool,
    },
    SetRealInputDerivatives(Vec<(Reference, Order, Value)>),
    GetRealOutputDerivatives(Vec<(Reference, Order)>),
    GetDirectionalDerivative {
        unknowns: Vec<Reference>,
        knowns: Vec<(Reference, Value)>,
    },
    DoStep {
        current: Current,
        step: Step,
    },
    CancelStep,
    GetStatus {
        of: Option<Type>,
        kind: i8,
    },
    EnterEventMode,
    NewDiscreteStates,
    EnterContinuousTimeMode,
    CompletedIntegratorStep,
    SetTime(Step),
    SetContinuousStates {
        step: Step,
        missing: bool,
    },
    GetVector {
        of: Vector,
        missing: bool,
    },
}

/// Which variable: one that can be set, any one, or none.
#[derive(Clone, Debug, Arbitrary)]
pub enum Reference {
    Settable(u8),
    Output(u8),
    Any(u8),
    Number(u32),
}

/// A number: within the everyday range of what it is for, at the limits of what is allowed, or beyond.
#[derive(Clone, Debug, Arbitrary)]
pub enum Value {
    Everyday(u16),
    Min,
    Max,
    BelowMin,
    AboveMax,
    Nan,
    Infinite,
    MinusInfinite,
}

/// An order of derivatives; from 0 to 4, so that some are not allowed.
#[derive(Clone, Debug, Arbitrary)]
pub struct Order(u8);

/// Where the host thinks it is.
#[derive(Clone, Debug, Arbitrary)]
pub enum Current {
    Exact,
    RoundedUp,
    RoundedDown,
    TooLate,
    TooEarly,
    Nan,
}

/// How far the host steps.
#[derive(Clone, Debug, Arbitrary)]
pub enum Step {
    /// Of any magnitude between the shortest and the longest.
    Length(u16),
    /// To the next onset, and a few nanoseconds beyond.
    Onset(u8),
    Zero,
    Back,
    Nan,
    Infinite,
}

/// Of steps that do not just fly, s.
const SHORTEST_STEP: f64 = 1e-9;
pub const LONGEST_STEP: f64 = 0.03;

/// The everyday ranges: family, low, high, and whether between them magnitudes rather than values are spread evenly.
const EVERYDAY: &[(&str, f64, f64, bool)] = &[
    ("gravity", 0.0, 20.0, false),
    ("ball.mass", 0.1, 10.0, true),
    ("ball.massRatio", 0.1, 10.0, true),
    ("ball.radius", 0.01, 0.1, true),
    ("ball.youngModulus", 1e8, 1e12, true),
    ("ball.poissonRatio", 0.0, 0.5, false),
    ("pendulum.length", 0.2, 3.0, true),
    ("pendulum.lengthRatio", 0.7, 1.4, false),
    ("pendulum.drag", 0.0, 2.0, false),
    ("contact.stiffness", 1e4, 1e10, true),
    ("contact.stiffnessRatio", 0.1, 10.0, true),
    ("contact.overlapRef", 1e-7, 1e-5, true),
    ("contact.exponent", 1.0, 5.0, false),
    ("contact.deadBand", 0.0, 1e-5, false),
    ("contact.gap", -1e-7, 1e-5, false),
    ("contact.damping", 0.0, 1e4, false),
    ("contact.huntCrossley", 0.0, 2.0, false),
    ("contact.relaxationTime", 1e-9, 1e-3, true),
    // No ball is put far into its neighbour, wherever that one is.
    ("x_start[1]", -0.2, -0.1, false),
    ("x_start[2]", -0.1, -0.01, false),
    ("x_start[3]", -0.01, 0.0, false),
    ("x_start[4]", 0.0, 1e-7, false),
    ("x_start[5]", 1e-7, 0.1, false),
    ("v_start", -1.0, 1.0, false),
    ("solver.tolerance", 1e-14, 1e-3, true),
    ("solver.fixedStep", 1e-6, 1e-3, true),
    ("F_ext", -1.0, 1.0, false),
    ("a_support", -1.0, 1.0, false),
];

impl Value {
    /// For `variable`, or for a number that has no range.
    pub fn number(&self, variable: Option<&Variable>) -> f64 {
        let (min, max) = variable.map_or((f64::NEG_INFINITY, f64::INFINITY), |variable| (variable.min, variable.max));
        match self {
            Self::Everyday(code) => everyday(*code, variable),
            // Without a limit there is nothing at it.
            Self::Min => {
                if min.is_finite() {
                    min
                } else {
                    0.0
                }
            }
            Self::Max => {
                if max.is_finite() {
                    max
                } else {
                    everyday(u16::MAX, variable)
                }
            }
            Self::BelowMin => min.next_down(),
            Self::AboveMax => max.next_up(),
            Self::Nan => f64::NAN,
            Self::Infinite => f64::INFINITY,
            Self::MinusInfinite => f64::NEG_INFINITY,
        }
    }
}

fn everyday(code: u16, variable: Option<&Variable>) -> f64 {
    let part = f64::from(code) / f64::from(u16::MAX);
    let Some(variable) = variable else { return 2.0 * part - 1.0 };
    if let Kind::Enumeration(items) = &variable.kind {
        // From one below the first to one above the last.
        return f64::from(i32::from(code) % (items.len() as i32 + 2));
    }
    let family = variable.name.split('[').next();
    let range = EVERYDAY.iter().find(|(name, ..)| *name == variable.name || family == Some(*name));
    let (_, low, high, magnitudes) = range.copied().unwrap_or(("", -1.0, 1.0, false));
    if magnitudes { low * (high / low).powf(part) } else { low + part * (high - low) }
}

impl Reference {
    fn number(&self, interface: &Interface) -> u32 {
        let nth = |n: u8, select: fn(&Variable) -> bool| {
            let selected: Vec<&Variable> = interface.variables.iter().filter(|variable| select(variable)).collect();
            selected[usize::from(n) % selected.len()].reference
        };
        match self {
            Self::Settable(n) => nth(*n, Variable::settable),
            Self::Output(n) => nth(*n, |variable| variable.is("output")),
            Self::Any(n) => nth(*n, |_| true),
            Self::Number(number) => *number,
        }
    }
}

impl Operation {
    /// The call it stands for; `next_onset` (s) is what the instance says of the future.
    pub fn call(&self, interface: &Interface, model: &Model, next_onset: f64) -> Call {
        let number = |reference: &Reference| reference.number(interface);
        let valued = |(reference, value): &(Reference, Value)| {
            let reference = reference.number(interface);
            (reference, value.number(interface.at(reference)))
        };
        let numbers = |references: &[Reference]| references.iter().map(number).collect();
        let place = |n: u8| usize::from(n) % PLACES;
        match self {
            Self::SetDebugLogging { on, categories } => {
                let known = interface.categories.iter().map(String::as_str);
                let names: Vec<&str> = known.chain(["logNothing"]).collect();
                let name = |n: &u8| names[usize::from(*n) % names.len()].to_owned();
                Call::SetDebugLogging { on: *on, categories: categories.iter().map(name).collect() }
            }
            Self::SetupExperiment { tolerance, start, stop } => {
                let [tolerance, stop] = [tolerance, stop].map(|value| value.as_ref().map(|value| value.number(None)));
                Call::SetupExperiment { tolerance, start: start.number(None), stop }
            }
            Self::EnterInitializationMode => Call::EnterInitializationMode,
            Self::ExitInitializationMode => Call::ExitInitializationMode,
            Self::Terminate => Call::Terminate,
            Self::Reset => Call::Reset,
            Self::Get { of, references, null } => Call::Get { of: *of, references: numbers(references), null: *null },
            Self::Set { of, values, null } => {
                Call::Set { of: *of, values: values.iter().map(valued).collect(), null: *null }
            }
            Self::SetOne(n, value) => {
                let (reference, value) = valued(&(Reference::Settable(*n), value.clone()));
                let real = interface.at(reference).is_some_and(|variable| variable.kind == Kind::Real);
                let of = if real { Type::Real } else { Type::Integer };
                Call::Set { of, values: vec![(reference, value)], null: false }
            }
            Self::GetFMUstate(n) => Call::GetFMUstate(place(*n)),
            Self::SetFMUstate(n) => Call::SetFMUstate(place(*n)),
            Self::FreeFMUstate(n) => Call::FreeFMUstate(place(*n)),
            Self::SerializeFMUstate { from, to, excess } => {
                Call::SerializeFMUstate { from: place(*from), to: place(*to), excess: (*excess).into() }
            }
            Self::DeSerializeFMUstate { from, to, missing } => {
                Call::DeSerializeFMUstate { from: place(*from), to: place(*to), missing: (*missing).into() }
            }
            Self::SetRealInputDerivatives(values) => {
                let derivative = |(reference, order, value): &(Reference, Order, Value)| {
                    (reference.number(interface), order.number(), value.number(None))
                };
                Call::SetRealInputDerivatives(values.iter().map(derivative).collect())
            }
            Self::GetRealOutputDerivatives(wanted) => {
                let derivative =
                    |(reference, order): &(Reference, Order)| (reference.number(interface), order.number());
                Call::GetRealOutputDerivatives(wanted.iter().map(derivative).collect())
            }
            Self::GetDirectionalDerivative { unknowns, knowns } => {
                let known = |(reference, value): &(Reference, Value)| (reference.number(interface), value.number(None));
                Call::GetDirectionalDerivative {
                    unknowns: numbers(unknowns),
                    knowns: knowns.iter().map(known).collect(),
                }
            }
            Self::DoStep { current, step } => {
                let current = current.time(model.time);
                // Flight is exact by the event-driven method, and takes no time.
                let event_driven = model.setting(interface.named("solver.method")) == Some((1.0, 0.0));
                let longest = if event_driven { 100.0 } else { LONGEST_STEP };
                Call::DoStep { current, step: step.length(next_onset - current, longest) }
            }
            Self::CancelStep => Call::CancelStep,
            Self::GetStatus { of, kind } => Call::GetStatus { of: *of, kind: (*kind % 6).into() },
            Self::EnterEventMode => Call::EnterEventMode,
            Self::NewDiscreteStates => Call::NewDiscreteStates,
            Self::EnterContinuousTimeMode => Call::EnterContinuousTimeMode,
            Self::CompletedIntegratorStep => Call::CompletedIntegratorStep,
            Self::SetTime(step) => Call::SetTime(model.time + step.length(next_onset - model.time, LONGEST_STEP)),
            Self::SetContinuousStates { step, missing } => Call::SetContinuousStates {
                step: step.length(next_onset - model.time, LONGEST_STEP),
                missing: (*missing).into(),
            },
            Self::GetVector { of, missing } => Call::GetVector { of: *of, missing: (*missing).into() },
        }
    }
}

impl Order {
    fn number(&self) -> i32 {
        i32::from(self.0 % 6) - 1
    }
}

impl Current {
    pub fn time(&self, own: f64) -> f64 {
        let allowed = 1e-12 * own.abs().max(1.0);
        match self {
            Self::Exact => own,
            Self::RoundedUp => own + 0.5 * allowed,
            Self::RoundedDown => own - 0.5 * allowed,
            Self::TooLate => own + 2.0 * allowed,
            Self::TooEarly => own - 2.0 * allowed,
            Self::Nan => f64::NAN,
        }
    }
}

impl Step {
    pub fn length(&self, ahead: f64, longest: f64) -> f64 {
        match self {
            Self::Length(code) => {
                SHORTEST_STEP * (LONGEST_STEP / SHORTEST_STEP).powf(f64::from(*code) / f64::from(u16::MAX))
            }
            Self::Onset(beyond) if ahead > 0.0 && ahead < longest => ahead + 1e-9 * f64::from(*beyond),
            Self::Onset(_) => 1e-6,
            Self::Zero => 0.0,
            Self::Back => -1e-3,
            Self::Nan => f64::NAN,
            Self::Infinite => f64::INFINITY,
        }
    }
}
