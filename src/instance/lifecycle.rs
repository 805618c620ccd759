//! An instance, its state and its phases, from start values to the end of the run.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::clocks::Clocks;
use super::legality::{Call, Kind, PHASES, Phase, Purpose};
use super::log::{Log, Severity};
use crate::engine::{EngineError, Exchange, History, InvalidState, MAX_INPUT_DERIVATIVE, Results, Simulation, require};
use crate::model::{Inputs, Parameters, SolverMethod};
use crate::variables::{DerivativesOf, LogCategory, Number, Refusal, Settings, ensure};

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
        let Self { start, stop, .. } = *self;
        ensure(start.is_finite(), || Refusal::number("startTime", start, "s", "any finite value"))?;
        let stop = stop.unwrap_or(start);
        let allowed = format_args!("not before startTime = {} s", Number(start));
        ensure(stop >= start, || Refusal::number("stopTime", stop, "s", allowed))
    }

    /// `own`, the tolerance parameter, or the host's tolerance if that is smaller, but not below 1e-14.
    pub(super) fn tighten(&self, own: f64) -> f64 {
        match self.tolerance {
            Some(host) if host > 0.0 => own.min(host.max(MIN_TOLERANCE)),
            _ => own,
        }
    }
}

/// Everything that changes while an instance runs: all that a saved state has to hold.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct InstanceState {
    pub(super) purpose: Purpose,
    pub(super) phase: Phase,
    pub(super) settings: Settings,
    pub(super) experiment: Option<Experiment>,
    /// The simulation. In Initialization Mode it is built when a calculated value is asked for, and dropped when a
    /// setting changes.
    #[serde(skip)]
    pub(super) simulation: Option<Simulation>,
    /// The run in model exchange, built and dropped like `simulation`.
    #[serde(skip)]
    pub(super) exchange: Option<Exchange>,
    /// Derivatives of the inputs by time over the next step, from the first on; those beyond are zero.
    pub(super) input_derivatives: Vec<Inputs>,
    /// Whether inputs or their derivatives have yet to be passed to the simulation.
    pub(super) inputs_changed: bool,
    /// The history of inputs for derivatives of the run, in FMI 3.0.
    pub(super) history: History,
    /// Values of the last elements of arrays over contacts, by the row's position. They have no effect.
    pub(super) padding: BTreeMap<usize, f64>,
    pub(super) clocks: Clocks,
    /// Whether events of model exchange have changed states and not all of them have been reported.
    pub(super) states_changed: bool,
    /// Time at which the host of model exchange last entered Event Mode with clocks, s.
    pub(super) last_event: Option<f64>,
    /// Whether a step past the host's stop time has been logged.
    pub(super) past_stop_logged: bool,
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
    /// The end that the host asked for, and the current end, s.
    pub(super) asked: f64,
    pub(super) end: f64,
}

impl InstanceState {
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

    /// The parameters for a simulation: with the host's tolerance. In model exchange there is no method to select.
    pub(super) fn effective_parameters(&self) -> Parameters {
        let mut parameters = self.settings.parameters.clone();
        parameters.tolerance = self.experiment.unwrap_or_default().tighten(parameters.tolerance);
        if self.purpose.kind == Kind::ModelExchange {
            parameters.method = SolverMethod::EventDriven;
        }
        parameters
    }

    pub(super) fn derives_over_run(&self) -> bool {
        self.settings.derivatives_of == DerivativesOf::Run
    }

    /// Refuses states that no instance can have saved; the simulation has checks of its own.
    pub(super) fn check(&self, balls: usize) -> Result<(), InvalidState> {
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
        let history = self.history.is_sound(&self.settings.parameters, |parameters| self.allows(parameters));
        require(history, "what it has been given before is out of range")?;
        let derivatives = &self.input_derivatives;
        let known = derivatives.len() <= MAX_INPUT_DERIVATIVE
            && derivatives.iter().all(|inputs| inputs.force.len() == balls && inputs.is_finite());
        require(known, "an input derivative is out of range")
    }

    /// Whether these parameters and the coefficients that follow from them are in their ranges.
    pub(super) fn allows(&self, parameters: &Parameters) -> bool {
        let settings = Settings { parameters: parameters.clone(), ..self.settings.clone() };
        settings.are_sound(parameters.balls()) && parameters.check_coefficients().is_ok()
    }
}

/// What an instance is created from.
pub struct Start {
    pub purpose: Purpose,
    /// Start values of the description, which a reset returns to.
    pub settings: Settings,
    /// Whether the host sees scalars, with the value references of FMI 2.0, instead of arrays: always in FMI 2.0.
    pub scalars: bool,
    /// GUID of the description.
    pub guid: String,
}

pub struct Instance {
    pub(super) start: Start,
    pub(super) run: InstanceState,
    pub log: Log,
    /// Parameters of this run of which it has been logged that they have no effect.
    without_effect: Vec<&'static str>,
}

impl Instance {
    pub fn new(mut start: Start, log: Log) -> Self {
        if !start.purpose.fmi3 {
            start.settings.derivatives_of = DerivativesOf::LastStep;
        }
        let run = InstanceState::new(start.purpose, &start.settings);
        Self { start, run, log, without_effect: Vec::new() }
    }

    #[inline]
    pub fn balls(&self) -> usize {
        self.run.settings.balls()
    }

    /// Refuses a call that is not legal in the current phase. Every call has to ask this first.
    #[inline]
    pub fn require(&self, call: Call) -> Result<(), Refusal> {
        let InstanceState { phase, purpose, .. } = self.run;
        if call.is_of(purpose.kind) && call.is_legal_in(phase) { Ok(()) } else { Err(self.illegal(call)) }
    }

    #[cold]
    fn illegal(&self, call: Call) -> Refusal {
        let InstanceState { phase, purpose, ended_by, .. } = &self.run;
        if !call.is_of(purpose.kind) {
            return Refusal::new(format_args!("not allowed in {}, which the instance was created for", purpose.kind));
        }
        if let Some(function) = ended_by {
            let text = format_args!("the refused call of {function} ended the run; allowed: a reset");
            return Refusal::new(format_args!("not allowed in {phase}: {text}"));
        }
        let allowed = PHASES.iter().filter(|phase| call.is_legal_in(**phase) && phase.exists(*purpose));
        let allowed: Vec<String> = allowed.map(Phase::to_string).collect();
        let separator = if allowed.is_empty() { "" } else { "; allowed: in " };
        Refusal::new(format_args!("not allowed in {phase}{separator}{}", allowed.join(", ")))
    }

    /// Ends the run after a refused call of `function`: only the last values, if any, and a reset remain.
    pub fn give_up(&mut self, function: &str) {
        self.run.phase = match self.run.phase {
            Phase::Error => Phase::Error,
            phase if phase <= Phase::InitializationMode => Phase::Abandoned,
            _ => Phase::Terminated,
        };
        self.run.under_way = None;
        self.run.ended_by.get_or_insert_with(|| function.to_owned());
    }

    /// Enters a phase that needs no further work. Never refused.
    pub fn enter(&mut self, phase: Phase) -> Result<(), Refusal> {
        self.run.phase = phase;
        Ok(())
    }

    /// Takes start time, stop time and tolerance; the last call before initialization counts.
    pub fn set_up(&mut self, experiment: Experiment) -> Result<(), Refusal> {
        experiment.check()?;
        // Only in FMI 3.0 may a run end where it starts.
        let start = experiment.start;
        let lasts = self.run.purpose.fmi3 || experiment.stop != Some(start);
        let allowed = format_args!("later than startTime = {} s", Number(start));
        ensure(lasts, || Refusal::number("stopTime", start, "s", allowed))?;
        self.run.experiment = Some(experiment);
        self.run.exchange = None;
        Ok(())
    }

    pub fn enter_initialization(&mut self) -> Result<(), Refusal> {
        let unknown = "the experiment must be set up first, so that the start time is known";
        ensure(self.run.experiment.is_some(), || Refusal::new(unknown))?;
        self.run.phase = Phase::InitializationMode;
        Ok(())
    }

    /// Builds the simulation and enters step mode, or Event Mode in model exchange. Fails, staying in Initialization
    /// Mode, if no run can start like this.
    pub fn exit_initialization(&mut self) -> Result<(), Refusal> {
        if self.run.purpose.kind == Kind::ModelExchange {
            self.exchange()?;
            self.run.simulation = None;
            self.enter_events_of_exchange()?;
        } else {
            self.simulation()?.set_initializing(false);
            self.run.inputs_changed = !self.run.input_derivatives.is_empty();
            self.run.phase = Phase::StepMode;
            if self.run.purpose.has_event_mode() {
                // The first events: contacts closed at the start.
                self.run.phase = Phase::EventMode;
                self.catch_up();
                self.tick();
            }
        }
        // With status OK, because several hosts end a run at a warning.
        for warning in self.run.settings.doubtful() {
            self.log.write(Severity::Ok, LogCategory::Warning, format_args!("{warning}"));
        }
        self.without_effect.clear();
        self.log_without_effect();
        Ok(())
    }

    /// Returns to the state after creation; the log categories stay as they are.
    pub fn reset(&mut self) {
        self.run = InstanceState::new(self.start.purpose, &self.start.settings);
    }

    /// The simulation, built on first use.
    #[inline]
    pub(super) fn simulation(&mut self) -> Result<&mut Simulation, Refusal> {
        if self.run.simulation.is_none() {
            self.run.simulation = Some(self.build()?);
        }
        self.run.simulation.as_mut().ok_or_else(|| Refusal::new("nothing is calculated yet"))
    }

    /// The run that the host integrates, built on first use.
    #[inline]
    pub(super) fn exchange(&mut self) -> Result<&mut Exchange, Refusal> {
        if self.run.exchange.is_none() {
            let start = self.run.start_time();
            let built = Exchange::new(&self.run.effective_parameters(), &self.run.settings.inputs, start);
            self.run.exchange = Some(built.map_err(no_start)?);
        }
        self.run.exchange.as_mut().ok_or_else(|| Refusal::new("nothing is calculated yet"))
    }

    /// The results of the run, of either kind.
    #[inline]
    pub(super) fn results(&mut self) -> Result<&dyn Results, Refusal> {
        match self.run.purpose.kind {
            Kind::CoSimulation => Ok(&**self.simulation()?),
            Kind::ModelExchange => Ok(self.exchange()?),
        }
    }

    #[cold]
    fn build(&self) -> Result<Simulation, Refusal> {
        let start = self.run.start_time();
        let built = Simulation::new(&self.run.effective_parameters(), &self.run.settings.inputs, start);
        let mut simulation = built.map_err(no_start)?;
        simulation.set_initializing(true);
        Ok(simulation)
    }

    /// Logs parameters that have no effect in an instance of this kind, each once in a run.
    pub(super) fn log_without_effect(&mut self) {
        if !self.log.wants(LogCategory::Warning) {
            return;
        }
        for (row, warning) in self.run.settings.without_effect(Some(self.run.purpose.kind)) {
            if !self.without_effect.contains(&row.name) {
                self.without_effect.push(row.name);
                self.log.write(Severity::Ok, LogCategory::Warning, format_args!("{warning}"));
            }
        }
    }
}

fn no_start(error: EngineError) -> Refusal {
    Refusal::new(format_args!("the run cannot start: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(tolerance: f64) -> Experiment {
        Experiment { tolerance: Some(tolerance), ..Experiment::default() }
    }

    #[test]
    fn tolerance_only_tightens() {
        assert_eq!(with(1e-4).tighten(1e-12), 1e-12);
        assert_eq!(with(1e-13).tighten(1e-12), 1e-13);
        assert_eq!(with(1e-20).tighten(1e-12), 1e-14);
        assert_eq!(Experiment::default().tighten(1e-9), 1e-9);
        for nonsense in [f64::NAN, 0.0, -1.0, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(with(nonsense).tighten(1e-12), 1e-12);
        }
    }
}
