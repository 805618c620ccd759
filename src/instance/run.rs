//! The state of an instance that changes, and the host's settings of the run.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::clocks::Clocks;
use super::legality::{Kind, Phase, Purpose};
use crate::engine::{Exchange, History, MAX_INPUT_DERIVATIVE, Simulation, Unsound, require};
use crate::model::{Inputs, Parameters, SolverMethod, Tunables};
use crate::variables::{DerivativesOf, Refusal, Settings};

const MIN_TOLERANCE: f64 = 1e-14;

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Experiment {
    /// Start time, s, finite.
    pub start: f64,
    /// Stop time, s, not before the start, if the host gave one.
    pub stop: Option<f64>,
    /// Relative tolerance, if the host gave one; non-positive and non-finite values are ignored.
    pub tolerance: Option<f64>,
}

impl Experiment {
    pub(super) fn check(&self) -> Result<(), Refusal> {
        if !self.start.is_finite() {
            return Err(Refusal::number("startTime", self.start, "s", "any finite value"));
        }
        match self.stop {
            Some(stop) if stop.is_nan() || stop < self.start => {
                Err(Refusal::number("stopTime", stop, "s", format_args!("not before startTime = {} s", self.start)))
            }
            _ => Ok(()),
        }
    }

    /// `own`, the tolerance parameter, tightened to the host's where that is smaller, but not below 1e-14.
    pub(super) fn tighten(&self, own: f64) -> f64 {
        match self.tolerance {
            Some(host) if host > 0.0 => own.min(host.max(MIN_TOLERANCE)),
            _ => own,
        }
    }
}

/// Everything that changes while an instance runs: all that a saved state has to hold.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct Run {
    pub(super) purpose: Purpose,
    pub(super) phase: Phase,
    pub(super) settings: Settings,
    pub(super) experiment: Option<Experiment>,
    /// The simulation. In Initialization Mode it is built when a calculated value is asked for, and dropped when a
    /// setting changes.
    #[serde(skip)]
    pub(super) simulation: Option<Simulation>,
    /// The same in model exchange.
    #[serde(skip)]
    pub(super) exchange: Option<Exchange>,
    /// Derivatives of the inputs by time over the next step, from the first on; those beyond are zero.
    pub(super) input_derivatives: Vec<Inputs>,
    /// The inputs or their derivatives have not been passed to the simulation yet.
    pub(super) inputs_changed: bool,
    /// The tunable parameters in the simulation, if newer ones have been set.
    pub(super) tuned_from: Option<Tunables>,
    /// The history of inputs for derivatives of the run, in FMI 3.0.
    pub(super) history: History,
    /// Values of the last elements of arrays over contacts, by the row's position. They have no effect.
    pub(super) padding: BTreeMap<usize, f64>,
    pub(super) clocks: Clocks,
    /// Whether events of model exchange have changed states and not all of them have been reported.
    pub(super) states_changed: bool,
    /// When the host of model exchange last entered Event Mode with clocks, s.
    pub(super) last_event: Option<f64>,
    /// Whether it has been logged that the host reads more within a step than the standard allows.
    pub(super) read_logged: bool,
    /// The refused call that ended the run.
    #[serde(skip)]
    pub(super) ended_by: Option<String>,
    /// The text of `log.pulses` that the host may read until the next call.
    #[serde(skip)]
    pub(super) csv: String,
    #[serde(skip)]
    pub(super) under_way: Option<StepUnderWay>,
}

/// A step that may be interrupted.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepUnderWay {
    /// The end first asked for, and the current one, s.
    pub(super) asked: f64,
    pub(super) end: f64,
    /// Since when the inputs have been held, s.
    pub(super) since: f64,
}

impl Run {
    pub(super) fn new(purpose: Purpose, start: &Settings) -> Self {
        let clocks = Clocks::new(Self::contacts_with_clocks(purpose, start.balls()));
        Self { purpose, settings: start.clone(), clocks, ..Self::default() }
    }

    fn contacts_with_clocks(purpose: Purpose, balls: usize) -> usize {
        if purpose.fmi3 { balls.saturating_sub(1) } else { 0 }
    }

    pub(super) fn start_time(&self) -> f64 {
        self.experiment.unwrap_or_default().start
    }

    /// The parameters of the simulation: with the host's tolerance, without changes not passed on yet. In model
    /// exchange there is no method to select.
    pub(super) fn effective_parameters(&self) -> Parameters {
        let mut parameters = self.settings.parameters.clone();
        parameters.tolerance = self.experiment.unwrap_or_default().tighten(parameters.tolerance);
        if self.purpose.kind == Kind::ModelExchange {
            parameters.method = SolverMethod::EventDriven;
        }
        if let Some(tunables) = self.tuned_from {
            parameters.tune(tunables);
        }
        parameters
    }

    pub(super) fn derives_over_run(&self) -> bool {
        self.settings.derivatives_of == DerivativesOf::Run
    }

    /// Refuses states that no instance can have saved; the simulation has checks of its own.
    pub(super) fn check(&self, balls: usize) -> Result<(), Unsound> {
        require(self.settings.are_sound(balls), "a setting is out of range")?;
        require(self.phase.exists(self.purpose), "its phase is not one of its kind")?;
        let times = self.last_event.is_none_or(f64::is_finite) && self.padding.values().all(|value| value.is_finite());
        let clocks = self.clocks.are_sound(Self::contacts_with_clocks(self.purpose, balls));
        require(times && clocks, "a clock, a time or the last element of an array over contacts is out of range")?;
        let experiment = self.experiment.is_none_or(|experiment| experiment.check().is_ok());
        require(
            experiment && (self.experiment.is_some() || self.phase < Phase::InitializationMode),
            "its start time or stop time is invalid",
        )?;
        let allowed = |parameters: &Parameters| {
            let settings = Settings { parameters: parameters.clone(), ..self.settings.clone() };
            settings.are_sound(balls)
        };
        let history = self.history.is_sound(&self.settings.parameters, allowed);
        require(history, "what it has been given before is out of range")?;
        let derivatives = &self.input_derivatives;
        let known = derivatives.len() <= MAX_INPUT_DERIVATIVE
            && derivatives.iter().all(|inputs| inputs.force.len() == balls && inputs.is_finite());
        require(known, "an input derivative is out of range")?;
        let tunables = self.tuned_from.is_none_or(|tunables| {
            let mut before = self.settings.parameters.clone();
            before.tune(tunables);
            allowed(&before)
        });
        require(tunables, "a tunable parameter is out of range")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(tolerance: f64) -> Experiment {
        Experiment { tolerance: Some(tolerance), ..Experiment::default() }
    }

    #[test]
    fn a_tolerance_only_tightens() {
        assert_eq!(with(1e-4).tighten(1e-12), 1e-12);
        assert_eq!(with(1e-13).tighten(1e-12), 1e-13);
        assert_eq!(with(1e-20).tighten(1e-12), 1e-14);
        assert_eq!(Experiment::default().tighten(1e-9), 1e-9);
        for nonsense in [f64::NAN, 0.0, -1.0, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(with(nonsense).tighten(1e-12), 1e-12);
        }
    }
}
