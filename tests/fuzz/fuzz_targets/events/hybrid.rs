//! What is legal in FMI 3.0 (FMI 3.0.2, sections 2.3, 3.2 and 4.2), and an instance as its host pictures it.

use arbitrary::Arbitrary;
use newtons_cradle::variables::{Causality, Type, Variability, Variable};

use crate::forgery::Change;
use crate::values::{Current, Step as Length, Value};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    Instantiated,
    Configuration,
    Initialization,
    Event,
    Step,
    ContinuousTime,
    Terminated,
    /// A refused call has ended the run before it began.
    Abandoned,
}
use Phase::{Abandoned, Configuration, ContinuousTime, Event, Initialization, Instantiated, Step, Terminated};

/// What the host of model exchange reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Arbitrary)]
pub enum Vector {
    States,
    Derivatives,
    Nominals,
    Indicators,
}

/// What the host does within a step.
#[derive(Clone, Debug, Arbitrary)]
pub struct Within {
    pub force: Option<u8>,
    pub end_after: Option<u8>,
    pub asks: bool,
}

/// One call, as the fuzzer writes it.
#[derive(Debug, Arbitrary)]
pub enum Operation {
    EnterConfiguration,
    ExitConfiguration,
    SetBalls(u8),
    EnterInitialization,
    ExitInitialization,
    EnterEvents,
    Update,
    EnterStepMode,
    /// All events there are, as a well-behaved host does.
    TakePart,
    DoStep {
        current: Current,
        step: Length,
        within: Within,
    },
    Terminate,
    Reset,
    /// All elements of a variable, one too many or too few.
    Set {
        which: u8,
        values: Vec<Value>,
        excess: i8,
    },
    SetItem {
        which: u8,
        value: i8,
    },
    Get {
        which: u8,
        excess: i8,
    },
    Derivative {
        adjoint: bool,
        unknown: u8,
        known: u8,
        seed: Value,
    },
    OutputDerivative {
        which: u8,
        order: i8,
    },
    Save(u8),
    Load(u8),
    Free(u8),
    /// The state as bytes and back.
    Through(u8),
    Forge(Vec<Change>),
    EnterContinuousTime,
    SetTime(Length),
    /// A step of Euler's method, of all states, one too many or too few.
    SetStates {
        step: Length,
        excess: i8,
    },
    CompletedStep,
    GetVector {
        of: Vector,
        excess: i8,
    },
}

/// An instance as its host pictures it.
#[derive(Clone, Debug)]
pub struct Picture {
    pub phase: Phase,
    /// Whether it takes part in events.
    pub events: bool,
    /// Whether it is for model exchange, with all events.
    pub exchange: bool,
    pub balls: usize,
    /// s.
    pub time: f64,
    /// When it last went from integration to events, s.
    pub event: f64,
    /// Whether extreme values have been set: what is legal may then be refused, where values leave the range of
    /// doubles.
    pub extreme: bool,
}

impl Picture {
    /// A new instance of five balls.
    pub fn new(events: bool, exchange: bool) -> Self {
        Self { phase: Instantiated, events, exchange, balls: 5, time: 0.0, event: 0.0, extreme: false }
    }

    /// Whether a call is legal now, as far as its arguments do not decide.
    pub fn allows(&self, operation: &Operation) -> bool {
        match operation {
            Operation::EnterConfiguration | Operation::EnterInitialization => self.phase == Instantiated,
            Operation::ExitConfiguration => self.phase == Configuration,
            Operation::ExitInitialization => self.phase == Initialization,
            Operation::EnterEvents => self.phase == Step && self.events || self.phase == ContinuousTime,
            Operation::Update => self.phase == Event,
            Operation::EnterStepMode => self.phase == Event && !self.exchange,
            Operation::EnterContinuousTime => self.phase == Event && self.exchange,
            Operation::SetTime(_) | Operation::SetStates { .. } | Operation::CompletedStep => {
                self.phase == ContinuousTime
            }
            Operation::GetVector { of, .. } => {
                let early = *of == Vector::Nominals && self.phase == Instantiated;
                self.exchange && (early || self.may_read())
            }
            Operation::DoStep { .. } => self.phase == Step,
            Operation::Terminate => matches!(self.phase, Step | Event | ContinuousTime),
            Operation::Derivative { .. } => self.may_read(),
            Operation::OutputDerivative { .. } => matches!(self.phase, Step | Terminated) && !self.exchange,
            _ => true,
        }
    }

    /// Whether calculated values may be read now.
    pub fn may_read(&self) -> bool {
        matches!(self.phase, Initialization | Event | Step | ContinuousTime | Terminated)
    }

    /// Whether a variable may be read now.
    pub fn may_get(&self, array: Variable) -> bool {
        self.may_read() || self.phase == Instantiated && array.has_start()
    }

    /// How many numbers a vector of model exchange has.
    pub fn length(&self, of: Vector) -> usize {
        if of == Vector::Indicators { 2 * self.balls } else { 3 * self.balls + 2 }
    }

    /// Whether a variable may be set now.
    pub fn may_set(&self, array: Variable) -> bool {
        if self.phase == ContinuousTime && Variable::states().any(|(state, _)| state.position == array.position) {
            return true;
        }
        let row = array.row;
        match self.phase {
            Instantiated | Initialization => matches!(row.causality, Causality::Parameter | Causality::Input),
            Step | Event => {
                row.causality == Causality::Input
                    || row.causality == Causality::Parameter && row.variability == Variability::Tunable
            }
            ContinuousTime => row.causality == Causality::Input,
            _ => false,
        }
    }

    /// A refused call ends the run.
    pub fn give_up(&mut self) {
        self.phase = match self.phase {
            Instantiated | Configuration | Initialization | Abandoned => Abandoned,
            Event | Step | ContinuousTime | Terminated => Terminated,
        };
    }
}

/// All variables of a type.
pub fn of_type(wanted: Type) -> Vec<Variable> {
    Variable::arrays().filter(|array| array.row.access.data_type() == wanted).collect()
}

/// This many, one more, or one fewer.
pub fn few(count: usize, excess: i8) -> usize {
    match excess {
        100.. => count + 1,
        ..=-100 => count.saturating_sub(1),
        _ => count,
    }
}
