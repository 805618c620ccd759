//! Which call is legal in which phase: the state machine of co-simulation as one table (FMI 2.0.4, section 4.2.4).

use serde::{Deserialize, Serialize};

/// Phases of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Phase {
    /// Start values can be set, nothing is calculated.
    Instantiated,
    /// Start values can be set and calculated values be read.
    InitializationMode,
    /// The host steps.
    StepMode,
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
    /// Setting values of any type; which variables may be set is the table of variables' business.
    Set,
    /// Saving, restoring, freeing and serializing the whole state.
    State,
    /// Derivatives by inputs held over the last step, or by what is known in Initialization Mode.
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
}

impl Call {
    /// The phases it is legal in. Steps are synchronous, so "step in progress" and "canceled" do not occur and nothing can be
    /// cancelled.
    #[inline]
    pub fn legal_phases(self) -> &'static [Phase] {
        use Phase::{Error, InitializationMode, Instantiated, StepMode, Terminated};
        match self {
            Self::SetDebugLogging | Self::Reset | Self::State => {
                &[Instantiated, InitializationMode, StepMode, Terminated, Error]
            }
            Self::SetupExperiment | Self::EnterInitializationMode => &[Instantiated],
            Self::ExitInitializationMode => &[InitializationMode],
            Self::Set | Self::SetInputDerivatives => &[Instantiated, InitializationMode, StepMode],
            Self::Get | Self::DirectionalDerivative => &[InitializationMode, StepMode, Terminated, Error],
            Self::GetOutputDerivatives => &[StepMode, Terminated, Error],
            Self::DoStep | Self::Terminate => &[StepMode],
            Self::Status => &[StepMode, Terminated],
            Self::CancelStep => &[],
        }
    }
}
