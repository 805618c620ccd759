//! What is legal, and what an instance must answer: the standard (FMI 2.0.4, sections 3.2.3 and 4.2.4) and the
//! description, and nothing of how the FMU does it.

use std::collections::BTreeMap;

use crate::interface::{Interface, Kind, Variable};

/// Largest order of derivatives by time, of inputs and of outputs.
const MAX_ORDER: i32 = 3;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phase {
    Instantiated,
    Initialization,
    StepComplete,
    EventMode,
    ContinuousTime,
    Terminated,
    Error,
}
use Phase::{ContinuousTime, Error, EventMode, Initialization, Instantiated, StepComplete, Terminated};

/// Which getter or setter.
#[derive(Clone, Copy, Debug, PartialEq, arbitrary::Arbitrary)]
pub enum Type {
    Real,
    Integer,
    Boolean,
    String,
}

/// What there is a value of for each continuous state, or for each event indicator.
#[derive(Clone, Copy, Debug, PartialEq, arbitrary::Arbitrary)]
pub enum Vector {
    ContinuousStates,
    Derivatives,
    NominalsOfContinuousStates,
    EventIndicators,
}

/// A call with all its arguments. States are numbered places of the host, bytes likewise.
#[derive(Clone, Debug)]
pub enum Call {
    SetDebugLogging {
        on: bool,
        categories: Vec<String>,
    },
    SetupExperiment {
        tolerance: Option<f64>,
        start: f64,
        stop: Option<f64>,
    },
    EnterInitializationMode,
    ExitInitializationMode,
    Terminate,
    Reset,
    Get {
        of: Type,
        references: Vec<u32>,
        null: bool,
    },
    Set {
        of: Type,
        values: Vec<(u32, f64)>,
        null: bool,
    },
    GetFMUstate(usize),
    SetFMUstate(usize),
    FreeFMUstate(usize),
    SerializeFMUstate {
        from: usize,
        to: usize,
        excess: usize,
    },
    DeSerializeFMUstate {
        from: usize,
        to: usize,
        missing: usize,
    },
    SetRealInputDerivatives(Vec<(u32, i32, f64)>),
    GetRealOutputDerivatives(Vec<(u32, i32)>),
    GetDirectionalDerivative {
        unknowns: Vec<u32>,
        knowns: Vec<(u32, f64)>,
    },
    DoStep {
        current: f64,
        step: f64,
    },
    CancelStep,
    GetStatus {
        of: Option<Type>,
        kind: i32,
    },
    EnterEventMode,
    NewDiscreteStates,
    EnterContinuousTimeMode,
    CompletedIntegratorStep,
    SetTime(f64),
    /// The states as they would be after a step of Euler's method of this length (s); so many of them too few.
    SetContinuousStates {
        step: f64,
        missing: usize,
    },
    GetVector {
        of: Vector,
        missing: usize,
    },
}

/// What the model says of a call.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    Legal,
    Illegal,
    /// Legal, but there may be no such derivative.
    MayLack,
}

/// An instance as a host pictures it.
#[derive(Clone)]
pub struct Model<'a> {
    interface: &'a Interface,
    /// For model exchange, not for co-simulation.
    exchange: bool,
    pub phase: Phase,
    /// Start time, s, once the experiment has been set up.
    start: Option<f64>,
    /// s.
    pub time: f64,
    /// What the host set last, by value reference, and how far off it may be read: inputs that followed derivatives are
    /// rounded.
    settings: BTreeMap<u32, (f64, f64)>,
    /// Derivatives of inputs for the next step, by value reference and order.
    rates: BTreeMap<(u32, i32), f64>,
}

impl<'a> Model<'a> {
    /// A new instance, for model exchange or for co-simulation.
    pub fn new(interface: &'a Interface, exchange: bool) -> Self {
        let settable = interface.variables.iter().filter(|variable| variable.settable());
        let settings = settable.map(|variable| (variable.reference, (variable.start.unwrap(), 0.0))).collect();
        Self { interface, exchange, phase: Instantiated, start: None, time: 0.0, settings, rates: BTreeMap::new() }
    }

    /// The value that must be read, and how far off it may be; nothing for what is calculated.
    pub fn setting(&self, reference: u32) -> Option<(f64, f64)> {
        self.settings.get(&reference).copied()
    }

    /// Whether `call` is legal now; `holds` tells which of the host's places hold a state or bytes.
    pub fn judge(&self, call: &Call, holds: impl Fn(usize) -> bool) -> Verdict {
        let may_lack = matches!(call, Call::GetRealOutputDerivatives(_) | Call::GetDirectionalDerivative { .. });
        match self.in_phase(call) && self.fits(call, holds) {
            true if may_lack => Verdict::MayLack,
            true => Verdict::Legal,
            false => Verdict::Illegal,
        }
    }

    fn in_phase(&self, call: &Call) -> bool {
        match call {
            Call::SetDebugLogging { .. }
            | Call::Reset
            | Call::GetFMUstate(_)
            | Call::SetFMUstate(_)
            | Call::FreeFMUstate(_)
            | Call::SerializeFMUstate { .. }
            | Call::DeSerializeFMUstate { .. } => true,
            Call::SetupExperiment { .. } | Call::EnterInitializationMode => self.phase == Instantiated,
            Call::ExitInitializationMode => self.phase == Initialization,
            Call::DoStep { .. } => self.phase == StepComplete,
            Call::Terminate => matches!(self.phase, StepComplete | EventMode | ContinuousTime),
            Call::Get { .. } | Call::GetDirectionalDerivative { .. } => self.phase != Instantiated,
            Call::Set { of, .. } => {
                let integrating = self.phase == ContinuousTime && *of == Type::Real;
                integrating || matches!(self.phase, Instantiated | Initialization | StepComplete | EventMode)
            }
            Call::SetRealInputDerivatives(_) => {
                !self.exchange && matches!(self.phase, Instantiated | Initialization | StepComplete)
            }
            Call::GetRealOutputDerivatives(_) => {
                !self.exchange && matches!(self.phase, StepComplete | Terminated | Error)
            }
            Call::GetStatus { .. } => !self.exchange && matches!(self.phase, StepComplete | Terminated),
            Call::CancelStep => false,
            Call::EnterEventMode | Call::SetTime(_) => matches!(self.phase, EventMode | ContinuousTime),
            Call::NewDiscreteStates | Call::EnterContinuousTimeMode => self.phase == EventMode,
            Call::CompletedIntegratorStep | Call::SetContinuousStates { .. } => self.phase == ContinuousTime,
            Call::GetVector { of: Vector::NominalsOfContinuousStates, .. } => self.exchange,
            Call::GetVector { .. } => self.exchange && self.phase != Instantiated,
        }
    }

    fn fits(&self, call: &Call, holds: impl Fn(usize) -> bool) -> bool {
        let at = |reference: &u32| self.interface.at(*reference);
        match call {
            Call::SetDebugLogging { categories, .. } => {
                categories.iter().all(|name| self.interface.categories.contains(name))
            }
            Call::SetupExperiment { start, stop, .. } => start.is_finite() && stop.is_none_or(|stop| stop > *start),
            Call::EnterInitializationMode => self.start.is_some(),
            Call::Get { of, references, null } => {
                references.is_empty() || !null && references.iter().all(|one| at(one).is_some_and(|v| is_of(v, *of)))
            }
            Call::Set { of, values, null } => {
                let allowed = |(reference, value): &(u32, f64)| {
                    at(reference).is_some_and(|v| self.may_set(v) && is_of(v, *of) && v.admits(*value))
                };
                values.is_empty() || !null && values.iter().all(allowed)
            }
            Call::SetFMUstate(place) => holds(*place),
            Call::SerializeFMUstate { from, excess, .. } => holds(*from) && *excess == 0,
            Call::DeSerializeFMUstate { from, missing, .. } => holds(*from) && *missing == 0,
            Call::SetRealInputDerivatives(values) => values.iter().all(|(reference, order, value)| {
                at(reference).is_some_and(|v| v.is("input")) && (1..=MAX_ORDER).contains(order) && value.is_finite()
            }),
            Call::GetRealOutputDerivatives(wanted) => wanted.iter().all(|(reference, order)| {
                at(reference).is_some_and(|v| v.is("output") && v.kind == Kind::Real) && (1..=MAX_ORDER).contains(order)
            }),
            Call::GetDirectionalDerivative { unknowns, knowns } => {
                let initializing = self.phase == Initialization;
                let unknown = |v: &Variable| {
                    let exchanged = (v.state || v.rate) && (initializing || self.exchange);
                    let calculated = initializing && v.is("calculatedParameter");
                    v.kind == Kind::Real && (v.is("output") || exchanged || calculated)
                };
                let known = |v: &Variable| {
                    let state = v.state && self.exchange && !initializing;
                    v.kind == Kind::Real && (v.is("input") || state || initializing && v.is("parameter"))
                };
                unknowns.iter().all(|one| at(one).is_some_and(unknown))
                    && knowns.iter().all(|(one, change)| at(one).is_some_and(known) && change.is_finite())
            }
            Call::DoStep { current, step } => {
                let off = (current - self.time).abs();
                off <= 1e-12 * self.time.abs().max(1.0) && *step > 0.0 && (current + step).is_finite()
            }
            Call::SetTime(time) => time.is_finite() && self.start.is_some_and(|start| *time >= start),
            Call::SetContinuousStates { step, missing } => *missing == 0 && step.is_finite(),
            Call::GetVector { missing, .. } => *missing == 0,
            // fmi2DoStepStatus, fmi2LastSuccessfulTime, none, fmi2Terminated, fmi2PendingStatus.
            Call::GetStatus { of, kind } => match of {
                None => *kind == 0,
                Some(Type::Real) => *kind == 2,
                Some(Type::Integer) => false,
                Some(Type::Boolean) => *kind == 3,
                Some(Type::String) => *kind == 1,
            },
            _ => true,
        }
    }

    fn may_set(&self, variable: &Variable) -> bool {
        let tunable = variable.is("input") || variable.variability == "tunable";
        variable.settable()
            && match self.phase {
                StepComplete | EventMode => tunable,
                ContinuousTime => variable.is("input"),
                _ => true,
            }
    }

    /// Goes along with a call that was accepted; what concerns saved states is the host's business.
    pub fn accept(&mut self, call: &Call) {
        match call {
            Call::SetupExperiment { start, .. } => (self.start, self.time) = (Some(*start), *start),
            Call::EnterInitializationMode => self.phase = Initialization,
            Call::ExitInitializationMode => self.phase = if self.exchange { EventMode } else { StepComplete },
            Call::EnterEventMode => self.phase = EventMode,
            Call::EnterContinuousTimeMode => self.phase = ContinuousTime,
            Call::SetTime(time) => self.time = *time,
            Call::Terminate => self.phase = Terminated,
            Call::Reset => *self = Self::new(self.interface, self.exchange),
            Call::Set { values, .. } => {
                for (reference, value) in values {
                    self.settings.insert(*reference, (*value, 0.0));
                }
            }
            Call::SetRealInputDerivatives(values) => {
                for (reference, order, value) in values {
                    self.rates.insert((*reference, *order), *value);
                }
            }
            Call::DoStep { current, step } => {
                let next = self.time.max(current + step);
                self.follow_inputs(next - self.time);
                self.time = next;
            }
            _ => {}
        }
    }

    /// Inputs with derivatives keep the value they reach after `length` (s).
    fn follow_inputs(&mut self, length: f64) {
        for ((reference, order), rate) in std::mem::take(&mut self.rates) {
            let factorial = f64::from((1..=order).product::<i32>());
            let term = rate * length.powi(order) / factorial;
            let (value, off) = self.settings[&reference];
            let rounding = 4.0 * f64::EPSILON * (value.abs() + term.abs());
            self.settings.insert(reference, (value + term, off + rounding));
        }
    }
}

fn is_of(variable: &Variable, of: Type) -> bool {
    match variable.kind {
        Kind::Real => of == Type::Real,
        Kind::Integer | Kind::Enumeration(_) => of == Type::Integer,
        Kind::Boolean => of == Type::Boolean,
    }
}
