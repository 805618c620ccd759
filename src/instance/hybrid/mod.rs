//! What FMI 3.0 adds to an instance: variables as arrays sized by the host, and co-simulation whose host takes part in events.
//!
//! A step may end at an onset or a release, or pause there for the host (`steps`). What has happened is told by clocks, one tick for
//! each instant (`ticks`). Values are set and read as arrays (`values`), and so are derivatives (`derivatives`). In model
//! exchange the same clocks tell of the events that the host asks for (`exchange`).

mod derivatives;
mod exchange;
mod pulses;
mod steps;
mod ticks;
mod values;

use serde::{Deserialize, Serialize};

use super::legality::{Kind, Phase};
use super::lifecycle::Instance;
use super::log::Log;
use crate::engine::{History, Simulation};
use crate::model::{Inputs, Tunables};
use crate::variables::{DERIVATIVES_OF, Settings};
use steps::UnderWay;
pub use steps::{Handled, Pause, StepEnd};
use ticks::Ticks;
pub use values::Value;

/// What FMI 3.0 adds to the state of an instance.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Hybrid {
    /// Whether the host takes part in events.
    pub event_mode: bool,
    /// Whether steps may end early.
    pub early_return: bool,
    /// Slopes of the inputs over each step.
    slopes: Inputs,
    /// Integer of the item of `derivatives.of`.
    derivatives_of: i32,
    /// What derivatives of the run need of it.
    pub history: History,
    /// What was set for the last elements of arrays over contacts, by the row's position. It has no effect.
    spare: Vec<(usize, f64)>,
    ticks: Ticks,
    /// Whether events have changed continuous states of model exchange, and the host has not been told of all of them.
    changed: bool,
    /// When the host of model exchange last entered Event Mode, s.
    last_event: Option<f64>,
    /// Whether it was logged that the host reads more within a step than the standard allows.
    read_logged: bool,
    /// The refused call that ended the run.
    #[serde(skip)]
    pub ended_by: Option<String>,
    /// What the host was given of `log.pulses`; it may read it until the next call.
    #[serde(skip)]
    csv: String,
    /// The step in which the host has been called.
    #[serde(skip)]
    under_way: Option<UnderWay>,
}

impl Hybrid {
    /// Before the host has said anything, in a cradle of so many balls.
    pub fn new(balls: usize, event_mode: bool, early_return: bool) -> Self {
        Self {
            event_mode,
            early_return,
            slopes: Inputs::zero(balls),
            derivatives_of: DERIVATIVES_OF[0].value,
            history: History::default(),
            spare: Vec::new(),
            ticks: Ticks::new(balls.saturating_sub(1)),
            changed: false,
            last_event: None,
            read_logged: false,
            ended_by: None,
            csv: String::new(),
            under_way: None,
        }
    }

    /// Whether derivatives are those at the point.
    pub fn derives_at_point(&self) -> bool {
        self.derivatives_of == DERIVATIVES_OF[0].value
    }

    /// Whether derivatives are those of the whole run.
    pub fn derives_over_run(&self) -> bool {
        self.derivatives_of == DERIVATIVES_OF[2].value
    }

    /// Inputs or tunable parameters, now `tunables`, are about to change.
    pub fn before_change(&mut self, simulation: &Simulation, tunables: Tunables) {
        simulation.keep_history(self.derives_over_run(), tunables, &mut self.history);
    }

    /// The same host, from the beginning.
    pub fn anew(&self, balls: usize) -> Self {
        Self::new(balls, self.event_mode, self.early_return)
    }

    /// Whether an instance of so many balls can have this state.
    pub fn is_sound(&self, balls: usize) -> bool {
        let contacts = balls.saturating_sub(1);
        self.slopes.force.len() == balls
            && self.slopes.is_finite()
            && DERIVATIVES_OF.iter().any(|item| item.value == self.derivatives_of)
            && self.spare.iter().all(|(_, value)| value.is_finite())
            && self.last_event.is_none_or(f64::is_finite)
            && self.ticks.are_sound(contacts)
    }
}

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
