//! Everything of an instance that changes, with what the host says about the run as a whole.

use serde::{Deserialize, Serialize};

use super::hybrid::Hybrid;
use super::legality::{Kind, Phase};
use super::refusal::Refusal;
use crate::engine::{Exchange, MAX_INPUT_DERIVATIVE, Simulation, Unsound, require};
use crate::model::{Inputs, Parameters, SolverMethod, Tunables};
use crate::variables::Settings;

/// Tightest relative tolerance.
const MIN_TOLERANCE: f64 = 1e-14;

/// Start, stop and tolerance of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Experiment {
    /// Start time, s, finite.
    pub start: f64,
    /// Stop time, s, not before the start, if the host gave one.
    pub stop: Option<f64>,
    /// Relative tolerance, if the host gave one; nonsense is ignored.
    pub tolerance: Option<f64>,
}

impl Experiment {
    /// Refuses invalid times.
    pub(super) fn check(&self) -> Result<(), Refusal> {
        if !self.start.is_finite() {
            return Err(Refusal::number("startTime", self.start, "s", "any finite value"));
        }
        match self.stop {
            Some(stop) if stop.is_nan() || stop < self.start => {
                Err(Refusal::number("stopTime", stop, "s", format!("not before startTime = {} s", self.start)))
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
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct Run {
    pub(super) kind: Kind,
    pub(super) phase: Phase,
    pub(super) settings: Settings,
    pub(super) experiment: Option<Experiment>,
    /// What calculates the run. In Initialization Mode it is built when a calculated value is asked for, and dropped
    /// when a setting changes.
    #[serde(skip)]
    pub(super) simulation: Option<Simulation>,
    /// The same in model exchange.
    #[serde(skip)]
    pub(super) exchange: Option<Exchange>,
    /// Derivatives of the inputs by time over the next step, from the first on; those beyond are zero.
    pub(super) input_derivatives: Vec<Inputs>,
    /// The simulation does not yet know of the inputs or of their derivatives.
    pub(super) inputs_changed: bool,
    /// The tunable parameters that the simulation runs with, if they have been changed since.
    pub(super) tuned_from: Option<Tunables>,
    /// What FMI 3.0 adds.
    pub(super) hybrid: Option<Hybrid>,
    /// It was logged that the host steps past its own stop time.
    pub(super) past_stop_logged: bool,
}

impl Run {
    /// Before the host has said anything, with these start values.
    pub(super) fn new(kind: Kind, start: &Settings) -> Self {
        Self {
            kind,
            phase: Phase::Instantiated,
            settings: start.clone(),
            experiment: None,
            simulation: None,
            exchange: None,
            input_derivatives: Vec::new(),
            inputs_changed: false,
            tuned_from: None,
            hybrid: None,
            past_stop_logged: false,
        }
    }

    /// The parameters that the simulation runs with: the host's tolerance counts, changes that it does not yet know of
    /// do not. In model exchange there is no method to select.
    pub(super) fn effective_parameters(&self) -> Parameters {
        let mut parameters = self.settings.parameters.clone();
        parameters.tolerance = self.experiment.unwrap_or_default().tighten(parameters.tolerance);
        if self.kind == Kind::ModelExchange {
            parameters.method = SolverMethod::EventDriven;
        }
        if let Some(tunables) = self.tuned_from {
            parameters.tune(tunables);
        }
        parameters
    }

    /// Whether the host of co-simulation takes part in events.
    pub(super) fn takes_part_in_events(&self) -> bool {
        self.kind == Kind::CoSimulation && self.tells_of_events()
    }

    /// Whether clocks tell the host of events.
    pub(super) fn tells_of_events(&self) -> bool {
        self.hybrid.as_ref().is_some_and(|hybrid| hybrid.event_mode)
    }

    /// Refuses what no instance can have saved; the simulation has checks of its own.
    pub(super) fn check(&self, balls: usize) -> Result<(), Unsound> {
        require(self.settings.are_sound(balls), "a setting is out of range")?;
        let possible = self.phase.exists(self.kind, self.hybrid.is_some(), self.takes_part_in_events());
        require(possible, "its phase is not one of its kind")?;
        require(
            self.hybrid.as_ref().is_none_or(|hybrid| hybrid.is_sound(balls)),
            "an event or a slope is out of range",
        )?;
        let experiment = self.experiment.is_none_or(|experiment| experiment.check().is_ok());
        require(
            experiment && (self.experiment.is_some() || self.phase < Phase::InitializationMode),
            "its start time or stop time is invalid",
        )?;
        let allowed = |parameters: &Parameters| {
            let settings = Settings { parameters: parameters.clone(), ..self.settings.clone() };
            settings.are_sound(balls)
        };
        let history =
            self.hybrid.as_ref().is_none_or(|hybrid| hybrid.history.is_sound(&self.settings.parameters, allowed));
        require(history, "what it has been given before is out of range")?;
        let derivatives = &self.input_derivatives;
        let known = derivatives.len() <= MAX_INPUT_DERIVATIVE
            && derivatives.iter().all(|inputs| inputs.force.len() == balls && inputs.is_finite());
        require(known, "an input derivative is out of range")?;
        let tunables = self.tuned_from.is_none_or(|tunables| {
            let mut before = self.settings.clone();
            before.parameters.tune(tunables);
            before.are_sound(balls)
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

    #[test]
    fn times_must_be_times() {
        let times = |start, stop| Experiment { start, stop, tolerance: None }.check();
        assert!(times(0.0, None).is_ok() && times(-5.0, Some(-4.0)).is_ok() && times(0.0, Some(0.0)).is_ok());
        for (start, stop) in
            [(f64::NAN, None), (f64::INFINITY, None), (0.0, Some(-1e-9)), (0.0, Some(f64::NAN)), (1.0, Some(0.5))]
        {
            assert!(times(start, stop).is_err(), "{start} {stop:?}");
        }
    }
}
