//! What FMI 3.0 adds to the state of an instance.

use serde::{Deserialize, Serialize};

use super::ticks::Ticks;
use crate::engine::{History, Simulation};
use crate::model::{Inputs, Tunables};
use crate::variables::DERIVATIVES_OF;

/// What FMI 3.0 adds to the state of an instance.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(in crate::instance) struct Hybrid {
    /// Whether the host takes part in events.
    pub event_mode: bool,
    /// Whether steps may end early.
    pub early_return: bool,
    /// Slopes of the inputs over each step.
    pub(super) slopes: Inputs,
    /// Integer of the item of `derivatives.of`.
    pub(super) derivatives_of: i32,
    /// What derivatives of the run need of it.
    pub history: History,
    /// What was set for the last elements of arrays over contacts, by the row's position. It has no effect.
    pub(super) padding: Vec<(usize, f64)>,
    pub(super) ticks: Ticks,
    /// Whether events have changed continuous states of model exchange, and the host has not been told of all of them.
    pub(super) changed: bool,
    /// When the host of model exchange last entered Event Mode, s.
    pub(super) last_event: Option<f64>,
    /// Whether it was logged that the host reads more within a step than the standard allows.
    pub(super) read_logged: bool,
    /// The refused call that ended the run.
    #[serde(skip)]
    pub ended_by: Option<String>,
    /// What the host was given of `log.pulses`; it may read it until the next call.
    #[serde(skip)]
    pub(super) csv: String,
    /// The step in which the host has been called.
    #[serde(skip)]
    pub(super) under_way: Option<UnderWay>,
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
            padding: Vec::new(),
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
            && self.padding.iter().all(|(_, value)| value.is_finite())
            && self.last_event.is_none_or(f64::is_finite)
            && self.ticks.are_sound(contacts)
    }
}

/// A step in which the host has been called.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnderWay {
    /// The end that was asked for first, and the one that it has now, s.
    pub asked: f64,
    pub end: f64,
    /// Since when the inputs have been held, s.
    pub since: f64,
}
