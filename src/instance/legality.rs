//! Which call is legal in which phase: the state machines of co-simulation and of model exchange as one table (FMI 2.0.4, sections
//! 3.2.3 and 4.2.4).

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
    /// Start values can be set and calculated values be read.
    InitializationMode,
    /// The host steps: co-simulation only.
    StepMode,
    /// Discrete variables and states may jump: model exchange only.
    EventMode,
    /// The host integrates: model exchange only.
    ContinuousTimeMode,
    /// The run is over, its last values can be read.
    Terminated,
    /// A step failed numerically.
    Error,
}

impl std::fmt::Display for Phase {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Instantiated => "the instantiated state",
            Self::InitializationMode => "Initialization Mode",
            Self::StepMode => "step mode",
            Self::EventMode => "Event Mode",
            Self::ContinuousTimeMode => "Continuous-Time Mode",
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
    /// Setting the continuous states.
    SetContinuousStates,
    /// Reading the derivatives of the states, the event indicators or the states.
    GetContinuous,
    /// Reading the orders of magnitude of the states.
    GetNominals,
}

impl Call {
    /// The kind of instance that it is for, if it is not for both.
    pub fn kind(self) -> Option<Kind> {
        match self {
            Self::SetInputDerivatives | Self::GetOutputDerivatives | Self::DoStep | Self::CancelStep | Self::Status => {
                Some(Kind::CoSimulation)
            }
            Self::EnterEventMode
            | Self::NewDiscreteStates
            | Self::EnterContinuousTimeMode
            | Self::CompletedIntegratorStep
            | Self::SetTime
            | Self::SetContinuousStates
            | Self::GetContinuous
            | Self::GetNominals => Some(Kind::ModelExchange),
            _ => None,
        }
    }

    /// The phases it is legal in. Steps are synchronous, so "step in progress" and "canceled" do not occur and nothing can be
    /// cancelled.
    #[inline]
    pub fn legal_phases(self) -> &'static [Phase] {
        use Phase::{ContinuousTimeMode, Error, EventMode, InitializationMode, Instantiated, StepMode, Terminated};
        match self {
            Self::SetDebugLogging | Self::Reset | Self::State => {
                &[Instantiated, InitializationMode, StepMode, EventMode, ContinuousTimeMode, Terminated, Error]
            }
            Self::SetupExperiment | Self::EnterInitializationMode => &[Instantiated],
            Self::ExitInitializationMode => &[InitializationMode],
            Self::Set => &[Instantiated, InitializationMode, StepMode, EventMode, ContinuousTimeMode],
            Self::SetDiscrete => &[Instantiated, InitializationMode, StepMode, EventMode],
            Self::SetInputDerivatives => &[Instantiated, InitializationMode, StepMode],
            Self::Get | Self::DirectionalDerivative => {
                &[InitializationMode, StepMode, EventMode, ContinuousTimeMode, Terminated, Error]
            }
            Self::GetOutputDerivatives => &[StepMode, Terminated, Error],
            Self::DoStep => &[StepMode],
            Self::Terminate => &[StepMode, EventMode, ContinuousTimeMode],
            Self::Status => &[StepMode, Terminated],
            Self::CancelStep => &[],
            Self::EnterEventMode | Self::SetTime => &[EventMode, ContinuousTimeMode],
            Self::NewDiscreteStates | Self::EnterContinuousTimeMode => &[EventMode],
            Self::CompletedIntegratorStep | Self::SetContinuousStates => &[ContinuousTimeMode],
            Self::GetContinuous => &[InitializationMode, EventMode, ContinuousTimeMode, Terminated, Error],
            Self::GetNominals => &[Instantiated, InitializationMode, EventMode, ContinuousTimeMode, Terminated, Error],
        }
    }
}
