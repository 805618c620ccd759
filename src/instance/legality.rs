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

/// Every phase, in the order of the columns of the table.
pub const PHASES: [Phase; 5] =
    [Phase::Instantiated, Phase::InitializationMode, Phase::StepMode, Phase::Terminated, Phase::Error];

/// A row for each call, a column for each of [`PHASES`]. Steps are synchronous, so "step in progress" and "canceled"
/// do not occur and nothing can be cancelled.
#[rustfmt::skip]
const LEGAL: [(Call, [bool; 5]); 15] = {
    const Y: bool = true;
    const N: bool = false;
    [
        //                               Inst Init Step Term Error
        (Call::SetDebugLogging,         [Y,   Y,   Y,   Y,   Y]),
        (Call::SetupExperiment,         [Y,   N,   N,   N,   N]),
        (Call::EnterInitializationMode, [Y,   N,   N,   N,   N]),
        (Call::ExitInitializationMode,  [N,   Y,   N,   N,   N]),
        (Call::Terminate,               [N,   N,   Y,   N,   N]),
        (Call::Reset,                   [Y,   Y,   Y,   Y,   Y]),
        (Call::Get,                     [N,   Y,   Y,   Y,   Y]),
        (Call::Set,                     [Y,   Y,   Y,   N,   N]),
        (Call::State,                   [Y,   Y,   Y,   Y,   Y]),
        (Call::DirectionalDerivative,   [N,   Y,   Y,   Y,   Y]),
        (Call::SetInputDerivatives,     [Y,   Y,   Y,   N,   N]),
        (Call::GetOutputDerivatives,    [N,   N,   Y,   Y,   Y]),
        (Call::DoStep,                  [N,   N,   Y,   N,   N]),
        (Call::CancelStep,              [N,   N,   N,   N,   N]),
        (Call::Status,                  [N,   N,   Y,   Y,   N]),
    ]
};

impl Call {
    /// Every call.
    pub fn all() -> impl Iterator<Item = Self> {
        LEGAL.iter().map(|(call, _)| *call)
    }

    /// Whether it is legal in `phase`.
    #[inline]
    pub fn is_legal_in(self, phase: Phase) -> bool {
        // Both enumerations number their items in the order of the table (a test checks it).
        LEGAL.get(self as usize).and_then(|(_, legal)| legal.get(phase as usize)).is_some_and(|legal| *legal)
    }

    /// The phases it is legal in, for messages.
    pub fn legal_phases(self) -> impl Iterator<Item = Phase> {
        PHASES.into_iter().filter(move |phase| self.is_legal_in(*phase))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_the_order_of_the_enumerations() {
        for (position, (call, _)) in LEGAL.iter().enumerate() {
            assert_eq!(*call as usize, position);
        }
        for (position, phase) in PHASES.into_iter().enumerate() {
            assert_eq!(phase as usize, position);
        }
    }
}
