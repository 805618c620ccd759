//! An instance and its phases, from start values to the end of the run.

use super::legality::{Call, Kind, PHASES, Phase, Purpose};
use super::log::{Log, Severity};
use super::run::{Experiment, Run};
use crate::engine::{EngineError, Exchange, Results, Simulation};
use crate::variables::{DerivativesOf, LogCategory, Refusal, Settings, Variable, variables};

/// What an instance is made of.
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
    pub(super) run: Run,
    pub log: Log,
}

impl Instance {
    pub fn new(mut start: Start, log: Log) -> Self {
        if !start.purpose.fmi3 {
            start.settings.derivatives_of = DerivativesOf::LastStep;
        }
        let run = Run::new(start.purpose, &start.settings);
        Self { start, run, log }
    }

    #[inline]
    pub fn balls(&self) -> usize {
        self.run.settings.balls()
    }

    /// Refuses a call that is not legal in the current phase. To be asked before every call.
    #[inline]
    pub fn require(&self, call: Call) -> Result<(), Refusal> {
        let Run { phase, purpose, .. } = self.run;
        if call.is_of(purpose.kind) && call.is_legal_in(phase) { Ok(()) } else { Err(self.illegal(call)) }
    }

    #[cold]
    fn illegal(&self, call: Call) -> Refusal {
        let Run { phase, purpose, ended_by, .. } = &self.run;
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
        // Only in FMI 3.0 a run may end where it starts.
        let start = experiment.start;
        if !self.run.purpose.fmi3 && experiment.stop == Some(start) {
            return Err(Refusal::number("stopTime", start, "s", format_args!("later than startTime = {start} s")));
        }
        self.run.experiment = Some(experiment);
        self.run.exchange = None;
        Ok(())
    }

    pub fn enter_initialization(&mut self) -> Result<(), Refusal> {
        if self.run.experiment.is_none() {
            return Err(Refusal::new("the experiment must be set up first, so that the start time is known"));
        }
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
            self.run.tuned_from = None;
            self.run.phase = Phase::StepMode;
            if self.run.purpose.has_event_mode() {
                // The first events: contacts closed at the start.
                self.run.phase = Phase::EventMode;
                self.catch_up();
                self.tick();
            }
        }
        // Status OK: several hosts end a run at a warning.
        for doubt in self.run.settings.doubts() {
            self.log.write(Severity::Ok, LogCategory::Warning, format_args!("{doubt}"));
        }
        self.log_ignored_parameters();
        Ok(())
    }

    /// Returns to the state after creation; the log categories stay as they are.
    pub fn reset(&mut self) {
        self.run = Run::new(self.start.purpose, &self.start.settings);
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

    /// Logs parameters that are not the default and have no effect because another law or method is selected.
    pub(super) fn log_ignored_parameters(&self) {
        let settings = &self.run.settings;
        if !self.log.wants(LogCategory::Solver) {
            return;
        }
        let defaults = Settings::default_for(settings.balls());
        // Parameters that only the other kind of instance uses.
        let other = match self.run.purpose.kind {
            Kind::CoSimulation => "exchange.contacts",
            Kind::ModelExchange => "solver.method",
        };
        let unused = |variable: &Variable| variable.row.name == other || !(variable.row.used)(&settings.parameters);
        for variable in variables(settings.balls()).filter(unused) {
            let (value, default) = (variable.text(settings), variable.text(&defaults));
            if let Some(value) = value.filter(|value| Some(value) != default.as_ref()) {
                let value = variable.row.quantified(value);
                self.log.solver(format_args!("{variable} = {value} has no effect: its law or method is not selected"));
            }
        }
    }
}

fn no_start(error: EngineError) -> Refusal {
    Refusal::new(format_args!("the run cannot start: {error}"))
}
