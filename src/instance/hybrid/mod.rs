//! What FMI 3.0 adds to an instance: variables as arrays sized by the host, and co-simulation whose host takes part in
//! events.
//!
//! A step may end at an onset or a release, or pause there for the host (`steps`). What has happened is told by clocks,
//! one tick for each instant (`ticks`). Values are set and read as arrays (`values`), and so are derivatives
//! (`derivatives`). In model exchange the same clocks tell of the events that the host asks for (`exchange`).

mod derivatives;
mod exchange;
mod pulses;
mod state;
mod steps;
mod ticks;
mod values;

use super::legality::{Kind, Phase};
use super::lifecycle::Instance;
use super::log::Log;
use crate::variables::Settings;
pub(super) use state::Hybrid;
pub use steps::{Handled, StepEnd, UpdateAnswer};
pub use values::Value;

impl Instance {
    /// An instance for a host of FMI 3.0, which takes part in events, and lets steps end early, or not.
    pub fn with_arrays(
        kind: Kind,
        start: Settings,
        token: String,
        log: Log,
        event_mode: bool,
        early_return: bool,
    ) -> Self {
        let hybrid = Hybrid::new(start.balls(), event_mode, early_return);
        let mut instance = Self::new(kind, start, token, log);
        instance.run.hybrid = Some(hybrid);
        instance
    }

    /// After a refused call of `function` there is nothing left but the last values, if there are any, and a new start.
    pub fn give_up(&mut self, function: &str) {
        self.run.phase = match self.run.phase {
            Phase::Error => Phase::Error,
            phase if phase <= Phase::InitializationMode => Phase::Abandoned,
            _ => Phase::Terminated,
        };
        if let Some(hybrid) = &mut self.run.hybrid {
            hybrid.under_way = None;
            hybrid.ended_by.get_or_insert_with(|| function.to_owned());
        }
    }

    /// Enters Configuration Mode.
    pub fn enter_configuration(&mut self) {
        self.run.phase = Phase::ConfigurationMode;
    }

    /// Leaves it.
    pub fn exit_configuration(&mut self) {
        self.run.phase = Phase::Instantiated;
    }
}
