//! Which call is legal in which phase: the state machines of co-simulation and of model exchange as one table (FMI
//! 2.0.4, sections 3.2.3 and 4.2.4; FMI 3.0.2, sections 2.3 and 4.2).

use serde::{Deserialize, Serialize};

pub use crate::variables::Kind;

/// What a host has created an instance for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Purpose {
    pub kind: Kind,
    /// Whether the host uses FMI 3.0; otherwise FMI 2.0.
    pub fmi3: bool,
    /// Whether the host uses clocks and, in co-simulation, event mode.
    pub events: bool,
    pub early_return: bool,
}

impl Purpose {
    /// The purpose of a host of FMI 2.0.
    pub fn fmi2(kind: Kind) -> Self {
        Self { kind, ..Self::default() }
    }

    pub(super) fn has_event_mode(self) -> bool {
        self.kind == Kind::CoSimulation && self.events
    }
}

macro_rules! phases {
    ($($(#[$doc:meta])* $phase:ident $name:literal $exists:expr;)*) => {
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        pub enum Phase {
            $($(#[$doc])* $phase),*
        }

        pub(super) const PHASES: [Phase; 10] = [$(Phase::$phase),*];

        impl std::fmt::Display for Phase {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(match self { $(Self::$phase => $name),* })
            }
        }

        impl Phase {
            pub(super) fn exists(self, purpose: Purpose) -> bool {
                let exists: fn(Purpose) -> bool = match self { $(Self::$phase => $exists),* };
                exists(purpose)
            }
        }
    };
}

// Each phase with its name in messages, and the instances that have it.
phases! {
    /// Start values can be set, nothing is calculated.
    #[default]
    Instantiated "the instantiated state" |_| true;
    ConfigurationMode "Configuration Mode" |of| of.fmi3;
    /// A refused call ended the run before anything was calculated.
    Abandoned "the terminated state, before any calculation" |of| of.fmi3;
    /// Start values can be set, and calculated values read.
    InitializationMode "Initialization Mode" |_| true;
    StepMode "step mode" |of| of.kind == Kind::CoSimulation;
    /// Discrete variables and states may jump: model exchange, and co-simulation with event mode.
    EventMode "Event Mode" |of| of.events || of.kind == Kind::ModelExchange;
    ContinuousTimeMode "Continuous-Time Mode" |of| of.kind == Kind::ModelExchange;
    /// The instance has called the host within a step.
    IntermediateUpdate "Intermediate Update Mode" |of| of.fmi3 && of.kind == Kind::CoSimulation;
    /// The run is over; its last values can be read.
    Terminated "the terminated state" |_| true;
    Error "the error state" |_| true;
}

const BOTH: Option<Kind> = None;
const STEPS: Option<Kind> = Some(Kind::CoSimulation);
const EXCHANGE: Option<Kind> = Some(Kind::ModelExchange);

/// The kind of instance that a call is for, if not for both; and a letter for each phase in which it is legal, a dot
/// for the others.
#[derive(Clone, Copy)]
pub struct Call(Option<Kind>, &'static [u8; PHASES.len()]);

// Steps are synchronous, so "step in progress" and "canceled" do not occur and nothing can be cancelled. The letters
// are those of: Instantiated, Configuration Mode, Abandoned, initializatioN Mode, Step mode, Event Mode,
// continuous-Time Mode, intermediate Update, enDed, Failed.
impl Call {
    pub const SET_DEBUG_LOGGING: Self = Self(BOTH, b"ICANSETUDF");
    pub const SETUP_EXPERIMENT: Self = Self(BOTH, b"I.........");
    pub const ENTER_INITIALIZATION_MODE: Self = Self(BOTH, b"I.........");
    pub const EXIT_INITIALIZATION_MODE: Self = Self(BOTH, b"...N......");
    pub const TERMINATE: Self = Self(BOTH, b"....SET...");
    pub const RESET: Self = Self(BOTH, b"ICANSET.DF");
    /// Reading values of any type.
    pub const GET: Self = Self(BOTH, b"...NSETUDF");
    /// [`Self::GET`] in FMI 3.0, where start values can be read before initialization.
    pub const GET_ARRAYS: Self = Self(BOTH, b"I..NSETUDF");
    /// Setting real values; the table of variables says which.
    pub const SET: Self = Self(BOTH, b"I..NSETU..");
    /// Setting values of any other type.
    pub const SET_DISCRETE: Self = Self(BOTH, b"I..NSE....");
    pub const STATE: Self = Self(BOTH, b"ICANSET.DF");
    pub const DIRECTIONAL_DERIVATIVE: Self = Self(BOTH, b"...NSET.DF");
    pub const SET_INPUT_DERIVATIVES: Self = Self(STEPS, b"I..NS.....");
    pub const GET_OUTPUT_DERIVATIVES: Self = Self(STEPS, b"....S..UDF");
    pub const DO_STEP: Self = Self(STEPS, b"....S.....");
    /// Cancelling an asynchronous step; there are none.
    pub const CANCEL_STEP: Self = Self(STEPS, b"..........");
    pub const STATUS: Self = Self(STEPS, b"....S...D.");
    pub const ENTER_CONFIGURATION_MODE: Self = Self(BOTH, b"I.........");
    pub const EXIT_CONFIGURATION_MODE: Self = Self(BOTH, b".C........");
    /// Setting counts, such as the number of balls.
    pub const SET_COUNTS: Self = Self(BOTH, b"IC.NSE....");
    /// Asking about the intervals of clocks; no clock has one.
    pub const INTERVALS: Self = Self(BOTH, b"...N.E....");
    pub const ENTER_EVENTS: Self = Self(BOTH, b"....S.T...");
    pub const NEXT_EVENT: Self = Self(BOTH, b".....E....");
    pub const ENTER_STEP_MODE: Self = Self(STEPS, b".....E....");
    pub const CONTINUE_STEP: Self = Self(STEPS, b".......U..");
    pub const ENTER_EVENT_MODE: Self = Self(EXCHANGE, b".....ET...");
    pub const NEW_DISCRETE_STATES: Self = Self(EXCHANGE, b".....E....");
    pub const ENTER_CONTINUOUS_TIME_MODE: Self = Self(EXCHANGE, b".....E....");
    pub const COMPLETED_INTEGRATOR_STEP: Self = Self(EXCHANGE, b"......T...");
    pub const SET_TIME: Self = Self(EXCHANGE, b".....ET...");
    /// [`Self::SET_TIME`] in FMI 3.0.
    pub const SET_TIME_OF_EXCHANGE: Self = Self(EXCHANGE, b"......T...");
    pub const SET_CONTINUOUS_STATES: Self = Self(EXCHANGE, b"......T...");
    /// Reading the derivatives of the states, the event indicators or the states.
    pub const GET_CONTINUOUS: Self = Self(EXCHANGE, b"...N.ET.DF");
    pub const GET_NOMINALS: Self = Self(EXCHANGE, b"I..N.ET.DF");
    pub const COUNT_CONTINUOUS: Self = Self(EXCHANGE, b"ICANSET.DF");
    /// A function that is not offered: refused in every phase, with its own reason.
    pub const NOT_OFFERED: Self = Self(BOTH, b"ICANSETUDF");

    #[inline]
    pub fn is_of(self, kind: Kind) -> bool {
        self.0.is_none_or(|own| own == kind)
    }

    #[inline]
    pub fn is_legal_in(self, phase: Phase) -> bool {
        self.1[phase as usize] != b'.'
    }
}
