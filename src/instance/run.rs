//! Everything of an instance that changes.

use serde::{Deserialize, Serialize};

use super::experiment::Experiment;
use super::legality::Phase;
use crate::engine::{MAX_INPUT_DERIVATIVE, Simulation, Unsound, require};
use crate::model::{Inputs, Parameters, Tunables};
use crate::variables::Settings;

/// Everything that changes while an instance runs: all that a saved state has to hold.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct Run {
    pub(super) phase: Phase,
    pub(super) settings: Settings,
    pub(super) experiment: Option<Experiment>,
    /// What calculates the run. In Initialization Mode it is built when a calculated value is asked for, and dropped when a
    /// setting changes.
    #[serde(skip)]
    pub(super) simulation: Option<Simulation>,
    /// Derivatives of the inputs by time over the next step, from the first on; those beyond are zero.
    pub(super) input_derivatives: Vec<Inputs>,
    /// The simulation does not yet know of the inputs or of their derivatives.
    pub(super) inputs_changed: bool,
    /// The tunable parameters that the simulation runs with, if they have been changed since.
    pub(super) tuned_from: Option<Tunables>,
    /// It was logged that the host steps past its own stop time.
    pub(super) past_stop_logged: bool,
}

impl Run {
    /// Before the host has said anything, with these start values.
    pub(super) fn new(start: &Settings) -> Self {
        Self {
            phase: Phase::Instantiated,
            settings: start.clone(),
            experiment: None,
            simulation: None,
            input_derivatives: Vec::new(),
            inputs_changed: false,
            tuned_from: None,
            past_stop_logged: false,
        }
    }

    /// The parameters that the simulation runs with: the host's tolerance counts, changes that it does not yet know of do not.
    pub(super) fn effective_parameters(&self) -> Parameters {
        let mut parameters = self.settings.parameters.clone();
        parameters.tolerance = self.experiment.unwrap_or_default().tighten(parameters.tolerance);
        if let Some(tunables) = self.tuned_from {
            parameters.tune(tunables);
        }
        parameters
    }

    /// Refuses what no instance can have saved; the simulation has checks of its own.
    pub(super) fn check(&self, balls: usize) -> Result<(), Unsound> {
        require(self.settings.are_sound(balls), "a setting is out of range")?;
        let experiment = self.experiment.is_none_or(|experiment| experiment.check().is_ok());
        require(
            experiment && (self.experiment.is_some() || self.phase == Phase::Instantiated),
            "its times are no times",
        )?;
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
