//! Which call is legal in which phase: the state machines of co-simulation and of model exchange as one table (FMI
//! 2.0.4, sections 3.2.3 and 4.2.4; FMI 3.0.2, sections 2.3 and 4.2).

use serde::{Deserialize, Serialize};

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kind {
    CoSimulation,
    ModelExchange,
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::CoSimulation => "co-simulation",
            Self::ModelExchange => "model exchange",
        })
    }
}

/// What a host has created an instance for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Purpose {
    pub kind: Kind,
    /// Whether the host uses FMI 3.0; otherwise FMI 2.0.
    pub fmi3: bool,
    /// Whether the host uses clocks and, in co-simulation, event mode.
    pub events: bool,
    pub early_return: bool,
}

impl Purpose {
    /// That of a host of FMI 2.0.
    pub fn fmi2(kind: Kind) -> Self {
        Self { kind, fmi3: false, events: false, early_return: false }
    }

    pub(super) fn has_event_mode(self) -> bool {
        self.kind == Kind::CoSimulation && self.events
    }
}

macro_rules! phases {
    ($($(#[$doc:meta])* $phase:ident $name:literal $exists:expr;)*) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
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

// Each with its name in messages, and the instances that have it.
phases! {
    /// Start values can be set, nothing is calculated.
    Instantiated "the instantiated state" |_| true;
    ConfigurationMode "Configuration Mode" |of| of.fmi3;
    /// A refused call ended the run before anything was calculated.
    Abandoned "the terminated state, before any calculation" |of| of.fmi3;
    /// Start values can be set and calculated values be read.
    InitializationMode "Initialization Mode" |_| true;
    StepMode "step mode" |of| of.kind == Kind::CoSimulation;
    /// Discrete variables and states may jump: model exchange, and co-simulation with event mode.
    EventMode "Event Mode" |of| of.events || of.kind == Kind::ModelExchange;
    ContinuousTimeMode "Continuous-Time Mode" |of| of.kind == Kind::ModelExchange;
    /// The host has been called within a step.
    IntermediateUpdate "Intermediate Update Mode" |of| of.fmi3 && of.kind == Kind::CoSimulation;
    /// The run is over, its last values can be read.
    Terminated "the terminated state" |_| true;
    Error "the error state" |_| true;
}

const BOTH: Option<Kind> = None;
const STEPS: Option<Kind> = Some(Kind::CoSimulation);
const EXCHANGE: Option<Kind> = Some(Kind::ModelExchange);

macro_rules! calls {
    ($($(#[$doc:meta])* $call:ident $kind:ident $phases:literal;)*) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Call {
            $($(#[$doc])* $call),*
        }

        impl Call {
            /// The kind of instance that it is for, if it is not for both.
            pub fn kind(self) -> Option<Kind> {
                match self { $(Self::$call => $kind),* }
            }

            /// A letter for each phase in which the call is legal, a dot for the others.
            #[inline]
            fn phases(self) -> &'static [u8; PHASES.len()] {
                match self { $(Self::$call => $phases),* }
            }
        }
    };
}

// Steps are synchronous, so "step in progress" and "canceled" do not occur and nothing can be cancelled. The letters
// are those of: Instantiated, Configuration Mode, Abandoned, initializatioN Mode, Step mode, Event Mode,
// continuous-Time Mode, intermediate Update, enDed, Failed.
calls! {
    SetDebugLogging BOTH b"ICANSETUDF";
    SetupExperiment BOTH b"I.........";
    EnterInitializationMode BOTH b"I.........";
    ExitInitializationMode BOTH b"...N......";
    Terminate BOTH b"....SET...";
    Reset BOTH b"ICANSET.DF";
    /// Reading values of any type.
    Get BOTH b"...NSETUDF";
    /// The same in FMI 3.0, where start values can be read before initialization.
    GetArrays BOTH b"I..NSETUDF";
    /// Setting real values; the table of variables says which.
    Set BOTH b"I..NSETU..";
    /// Setting values of any other type.
    SetDiscrete BOTH b"I..NSE....";
    State BOTH b"ICANSET.DF";
    DirectionalDerivative BOTH b"...NSET.DF";
    SetInputDerivatives STEPS b"I..NS.....";
    GetOutputDerivatives STEPS b"....S..UDF";
    DoStep STEPS b"....S.....";
    /// Cancelling an asynchronous step; there are none.
    CancelStep STEPS b"..........";
    Status STEPS b"....S...D.";
    EnterConfigurationMode BOTH b"I.........";
    ExitConfigurationMode BOTH b".C........";
    /// Setting counts: the number of balls is one.
    SetCounts BOTH b"IC.NSE....";
    /// Asking about the intervals of clocks; no clock has one.
    Intervals BOTH b"...N.E....";
    EnterEvents BOTH b"....S.T...";
    NextEvent BOTH b".....E....";
    EnterStepMode STEPS b".....E....";
    ContinueStep STEPS b".......U..";
    EnterEventMode EXCHANGE b".....ET...";
    NewDiscreteStates EXCHANGE b".....E....";
    EnterContinuousTimeMode EXCHANGE b".....E....";
    CompletedIntegratorStep EXCHANGE b"......T...";
    SetTime EXCHANGE b".....ET...";
    /// [`Self::SetTime`] in FMI 3.0.
    SetTimeOfExchange EXCHANGE b"......T...";
    SetContinuousStates EXCHANGE b"......T...";
    /// Reading the derivatives of the states, the event indicators or the states.
    GetContinuous EXCHANGE b"...N.ET.DF";
    GetNominals EXCHANGE b"I..N.ET.DF";
    CountContinuous EXCHANGE b"ICANSET.DF";
    /// A function that is not offered: refused in every phase, with its own reason.
    NotOffered BOTH b"ICANSETUDF";
}

impl Call {
    #[inline]
    pub fn is_legal_in(self, phase: Phase) -> bool {
        self.phases()[phase as usize] != b'.'
    }
}
