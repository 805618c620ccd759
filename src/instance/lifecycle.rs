//! An instance and its way through the phases, from start values to the end of the run.

use super::legality::{Call, Kind, Phase};
use super::log::Log;
use super::refusal::Refusal;
use super::run::{Experiment, Run};
use crate::engine::{Exchange, Results, Simulation};
use crate::variables::{Access, LogCategory, Number, Settings, Variable, variables};

/// One instance.
pub struct Instance {
    /// GUID of its description.
    pub(super) guid: String,
    /// Start values of the description, which a reset returns to.
    start: Settings,
    pub(super) run: Run,
    /// Where it writes its log lines.
    pub log: Log,
}

impl Instance {
    /// An instance of this kind with the start values of its description, which has this GUID.
    pub fn new(kind: Kind, start: Settings, guid: String, log: Log) -> Self {
        let run = Run::new(kind, &start);
        Self { guid, start, run, log }
    }

    /// Number of balls n.
    #[inline]
    pub fn balls(&self) -> usize {
        self.run.settings.balls()
    }

    /// Refuses a call that is not legal in the current phase. To be asked before every call.
    #[inline]
    pub fn require(&self, call: Call) -> Result<(), Refusal> {
        let (phase, kind) = (self.run.phase, self.run.kind);
        let of_kind = call.kind().is_none_or(|own| own == kind);
        if of_kind && call.legal_phases().contains(&phase) { Ok(()) } else { Err(self.illegal(call)) }
    }

    #[cold]
    fn illegal(&self, call: Call) -> Refusal {
        let (phase, kind, hybrid) = (self.run.phase, self.run.kind, self.run.hybrid.as_ref());
        let exists =
            |phase: &Phase| phase.exists(kind, hybrid.is_some(), hybrid.is_some_and(|hybrid| hybrid.event_mode));
        let allowed = call.legal_phases().iter().copied().filter(exists).collect();
        let ended_by = hybrid.and_then(|hybrid| hybrid.ended_by.clone());
        Refusal::Phase { call, phase, kind, allowed, ended_by }
    }

    /// Takes start time, stop time and tolerance; the last call before initialization counts.
    pub fn set_up(&mut self, experiment: Experiment) -> Result<(), Refusal> {
        experiment.check()?;
        // Only in FMI 3.0 a run may end where it starts.
        if let (None, Some(stop)) = (&self.run.hybrid, experiment.stop.filter(|stop| *stop == experiment.start)) {
            return Err(Refusal::number("stopTime", stop, "s", format!("later than startTime = {stop} s")));
        }
        self.run.experiment = Some(experiment);
        self.run.exchange = None;
        Ok(())
    }

    /// Enters Initialization Mode.
    pub fn enter_initialization(&mut self) -> Result<(), Refusal> {
        if self.run.experiment.is_none() {
            return Err(Refusal::Missing("the experiment must be set up first, so that the start time is known"));
        }
        self.run.phase = Phase::InitializationMode;
        Ok(())
    }

    /// Builds the simulation and enters step mode, or Event Mode in model exchange. Fails, staying in Initialization
    /// Mode, if no run can start like this.
    pub fn exit_initialization(&mut self) -> Result<(), Refusal> {
        if self.run.kind == Kind::ModelExchange {
            self.exchange()?;
            self.run.simulation = None;
            self.run.phase = Phase::EventMode;
            self.log_ignored_parameters();
            return if self.run.tells_of_events() { self.enter_events() } else { Ok(()) };
        }
        self.simulation()?.set_initializing(false);
        let next = if self.run.takes_part_in_events() { Phase::EventMode } else { Phase::StepMode };
        self.run.inputs_changed = !self.run.input_derivatives.is_empty();
        self.run.tuned_from = None;
        self.run.phase = next;
        self.begin_events()?;
        self.log_ignored_parameters();
        Ok(())
    }

    /// Ends the run; its last values can still be read.
    pub fn terminate(&mut self) -> Result<(), Refusal> {
        self.run.phase = Phase::Terminated;
        Ok(())
    }

    /// Back to where it was after it was created; which log categories are on is kept.
    pub fn reset(&mut self) -> Result<(), Refusal> {
        let hybrid = self.run.hybrid.as_ref().map(|hybrid| hybrid.anew(self.start.balls()));
        self.run = Run { hybrid, ..Run::new(self.run.kind, &self.start) };
        Ok(())
    }

    /// The simulation, built first where that has not happened yet.
    #[inline]
    pub(super) fn simulation(&mut self) -> Result<&mut Simulation, Refusal> {
        if self.run.simulation.is_none() {
            self.run.simulation = Some(self.build()?);
        }
        self.run.simulation.as_mut().ok_or(Refusal::Missing("nothing is calculated yet"))
    }

    /// The run in the host's hands, built first where that has not happened yet.
    #[inline]
    pub(super) fn exchange(&mut self) -> Result<&mut Exchange, Refusal> {
        if self.run.exchange.is_none() {
            let start = self.run.experiment.unwrap_or_default().start;
            let built = Exchange::new(&self.run.effective_parameters(), &self.run.settings.inputs, start);
            self.run.exchange = Some(built.map_err(Refusal::Start)?);
        }
        self.run.exchange.as_mut().ok_or(Refusal::Missing("nothing is calculated yet"))
    }

    /// What can be read, of whichever kind of run it is.
    #[inline]
    pub(super) fn results(&mut self) -> Result<&dyn Results, Refusal> {
        match self.run.kind {
            Kind::CoSimulation => Ok(&**self.simulation()?),
            Kind::ModelExchange => Ok(self.exchange()?),
        }
    }

    #[cold]
    fn build(&self) -> Result<Simulation, Refusal> {
        let start = self.run.experiment.unwrap_or_default().start;
        let built = Simulation::new(&self.run.effective_parameters(), &self.run.settings.inputs, start);
        let mut simulation = built.map_err(Refusal::Start)?;
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
        // What only the other kind of instances makes use of.
        let other = match self.run.kind {
            Kind::CoSimulation => "exchange.contacts",
            Kind::ModelExchange => "solver.method",
        };
        let unused = |variable: &Variable| variable.row.name == other || !(variable.row.used)(&settings.parameters);
        for variable in variables(settings.balls()).filter(unused) {
            let value = |of: &Settings| match variable.row.access {
                Access::Enumeration(enumeration) => {
                    enumeration.item((enumeration.get)(&of.parameters)).map(|item| item.name.to_owned())
                }
                _ => variable.real(of).map(|value| variable.row.quantified(Number(value))),
            };
            let (value, default) = (value(settings), value(&defaults));
            if let Some(value) = value.filter(|value| Some(value) != default.as_ref()) {
                self.log.solver(format_args!("{variable} = {value} has no effect: its law or method is not selected"));
            }
        }
    }
}
