//! Which call is legal in which phase: the state machines of co-simulation and of model exchange as one table (FMI
//! 2.0.4, sections 3.2.3 and 4.2.4; FMI 3.0.2, sections 2.3 and 4.2).

use serde::{Deserialize, Serialize};

/// What an instance was created for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kind {
    /// It steps by itself.
    CoSimulation,
    /// The host integrates.
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

/// Phases of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Phase {
    /// Start values can be set, nothing is calculated.
    Instantiated,
    /// The number of balls can be set.
    ConfigurationMode,
    /// A refused call has ended the run before it began; it can be reset.
    Abandoned,
    /// Start values can be set and calculated values be read.
    InitializationMode,
    /// The host steps: co-simulation only.
    StepMode,
    /// Discrete variables and states may jump: model exchange, and co-simulation whose host takes part in events.
    EventMode,
    /// The host integrates: model exchange only.
    ContinuousTimeMode,
    /// The host has been called in the middle of a step.
    IntermediateUpdate,
    /// The run is over, its last values can be read.
    Terminated,
    /// A step failed numerically.
    Error,
}

impl std::fmt::Display for Phase {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Instantiated => "the instantiated state",
            Self::ConfigurationMode => "Configuration Mode",
            Self::Abandoned => "the terminated state, before any calculation",
            Self::InitializationMode => "Initialization Mode",
            Self::StepMode => "step mode",
            Self::EventMode => "Event Mode",
            Self::ContinuousTimeMode => "Continuous-Time Mode",
            Self::IntermediateUpdate => "Intermediate Update Mode",
            Self::Terminated => "the terminated state",
            Self::Error => "the error state",
        })
    }
}

/// What a host can ask of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Call {
    /// Switching log categories on and off.
    SetDebugLogging,
    /// Telling start, stop and tolerance.
    SetupExperiment,
    /// The way into Initialization Mode.
    EnterInitializationMode,
    /// The way out of it, to the first step.
    ExitInitializationMode,
    /// The end of the run.
    Terminate,
    /// Back to how it was instantiated.
    Reset,
    /// Reading values of any type.
    Get,
    /// The same in FMI 3.0, where start values can be read before initialization.
    GetArrays,
    /// Setting real values; which variables may be set is the table of variables' business.
    Set,
    /// Setting values of any other type.
    SetDiscrete,
    /// Saving, restoring, freeing and serializing the whole state.
    State,
    /// Derivatives by inputs held over the last step, by inputs and states, or by what is known in Initialization Mode.
    DirectionalDerivative,
    /// How inputs change within the next step.
    SetInputDerivatives,
    /// Derivatives of outputs by time.
    GetOutputDerivatives,
    /// A step.
    DoStep,
    /// Breaking off a step that goes on by itself, of which there are none.
    CancelStep,
    /// Asking about the last step.
    Status,
    /// The way to Configuration Mode.
    EnterConfigurationMode,
    /// The way back from it.
    ExitConfigurationMode,
    /// Setting counts: the number of balls is one.
    SetCounts,
    /// Asking about the intervals of clocks, of which there are none.
    Intervals,
    /// The way from a step, or from integration, to events.
    EnterEvents,
    /// Handling one of them after the other.
    NextEvent,
    /// The way back from events to steps.
    EnterStepMode,
    /// Going on with a step in which the host has been called.
    ContinueStep,
    /// The way to an event.
    EnterEventMode,
    /// Handling an event.
    NewDiscreteStates,
    /// The way back from an event to integration.
    EnterContinuousTimeMode,
    /// The end of a step of the host's solver.
    CompletedIntegratorStep,
    /// Setting the time.
    SetTime,
    /// The same in FMI 3.0.
    SetTimeOfExchange,
    /// Setting the continuous states.
    SetContinuousStates,
    /// Reading the derivatives of the states, the event indicators or the states.
    GetContinuous,
    /// Reading the orders of magnitude of the states.
    GetNominals,
    /// Asking how many states or event indicators there are.
    CountContinuous,
}

impl Phase {
    /// Whether an instance of this kind can be in it; `events` if its host takes part in the events of co-simulation,
    /// and `arrays` if it is one of FMI 3.0.
    pub(super) fn exists(self, kind: Kind, arrays: bool, events: bool) -> bool {
        let exchange = kind == Kind::ModelExchange;
        match self {
            Self::ConfigurationMode | Self::Abandoned => arrays,
            Self::StepMode => !exchange,
            Self::EventMode => exchange || events,
            Self::ContinuousTimeMode => exchange,
            Self::IntermediateUpdate => arrays && !exchange,
            Self::Instantiated | Self::InitializationMode | Self::Terminated | Self::Error => true,
        }
    }
}

impl Call {
    /// The kind of instance that it is for, if it is not for both.
    pub fn kind(self) -> Option<Kind> {
        match self {
            Self::SetInputDerivatives
            | Self::GetOutputDerivatives
            | Self::DoStep
            | Self::CancelStep
            | Self::Status
            | Self::EnterStepMode
            | Self::ContinueStep => Some(Kind::CoSimulation),
            Self::EnterEventMode
            | Self::NewDiscreteStates
            | Self::EnterContinuousTimeMode
            | Self::CompletedIntegratorStep
            | Self::SetTime
            | Self::SetTimeOfExchange
            | Self::SetContinuousStates
            | Self::GetContinuous
            | Self::GetNominals
            | Self::CountContinuous => Some(Kind::ModelExchange),
            _ => None,
        }
    }

    /// The phases it is legal in. Steps are synchronous, so "step in progress" and "canceled" do not occur and nothing
    /// can be cancelled.
    #[inline]
    pub fn legal_phases(self) -> &'static [Phase] {
        use Phase::{
            Abandoned, ConfigurationMode, ContinuousTimeMode, Error, EventMode, InitializationMode, Instantiated,
            IntermediateUpdate, StepMode, Terminated,
        };
        match self {
            Self::SetDebugLogging => &[
                Instantiated,
                ConfigurationMode,
                Abandoned,
                InitializationMode,
                StepMode,
                EventMode,
                ContinuousTimeMode,
                IntermediateUpdate,
                Terminated,
                Error,
            ],
            Self::Reset | Self::State | Self::CountContinuous => &[
                Instantiated,
                ConfigurationMode,
                Abandoned,
                InitializationMode,
                StepMode,
                EventMode,
                ContinuousTimeMode,
                Terminated,
                Error,
            ],
            Self::SetupExperiment | Self::EnterInitializationMode | Self::EnterConfigurationMode => &[Instantiated],
            Self::ExitConfigurationMode => &[ConfigurationMode],
            Self::SetCounts => &[Instantiated, ConfigurationMode, InitializationMode, StepMode, EventMode],
            Self::ExitInitializationMode => &[InitializationMode],
            Self::Intervals => &[InitializationMode, EventMode],
            Self::Set => {
                &[Instantiated, InitializationMode, StepMode, EventMode, ContinuousTimeMode, IntermediateUpdate]
            }
            Self::SetDiscrete => &[Instantiated, InitializationMode, StepMode, EventMode],
            Self::SetInputDerivatives => &[Instantiated, InitializationMode, StepMode],
            Self::Get => {
                &[InitializationMode, StepMode, EventMode, ContinuousTimeMode, IntermediateUpdate, Terminated, Error]
            }
            Self::GetArrays => &[
                Instantiated,
                InitializationMode,
                StepMode,
                EventMode,
                ContinuousTimeMode,
                IntermediateUpdate,
                Terminated,
                Error,
            ],
            Self::DirectionalDerivative => {
                &[InitializationMode, StepMode, EventMode, ContinuousTimeMode, Terminated, Error]
            }
            Self::GetOutputDerivatives => &[StepMode, IntermediateUpdate, Terminated, Error],
            Self::DoStep => &[StepMode],
            Self::EnterEvents => &[StepMode, ContinuousTimeMode],
            Self::NextEvent | Self::EnterStepMode => &[EventMode],
            Self::ContinueStep => &[IntermediateUpdate],
            Self::Terminate => &[StepMode, EventMode, ContinuousTimeMode],
            Self::Status => &[StepMode, Terminated],
            Self::CancelStep => &[],
            Self::EnterEventMode | Self::SetTime => &[EventMode, ContinuousTimeMode],
            Self::NewDiscreteStates | Self::EnterContinuousTimeMode => &[EventMode],
            Self::CompletedIntegratorStep | Self::SetContinuousStates | Self::SetTimeOfExchange => {
                &[ContinuousTimeMode]
            }
            Self::GetContinuous => &[InitializationMode, EventMode, ContinuousTimeMode, Terminated, Error],
            Self::GetNominals => &[Instantiated, InitializationMode, EventMode, ContinuousTimeMode, Terminated, Error],
        }
    }
}
