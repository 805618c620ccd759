//! One run of the cradle, by the method that was selected.

use std::ops::Deref;

use serde::{Deserialize, Serialize};

use super::chain_state::ChainState;
use super::continuous::Continuous;
use super::derivatives::{History, LastStep, Stretch};
use super::error::EngineError;
use super::inputs::HeldInputs;
use super::observer::Observer;
use super::run::{Engine, InvalidState, Snapshot, require};
use super::tape::{Tape, Unfollowed};
use crate::model::{ContactModel, Differential, Inputs, Parameters, PendulumModel, Results, SolverMethod, Tunables};

/// A run by the selected method, with its parameters. Its functions mean what those of [`Engine`] mean.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// With the present values of those that may change.
    parameters: Parameters,
    /// Start time, s.
    start: f64,
    run: ByMethod,
}

/// The run by each method; as plain data with a [`Snapshot`] in place of the engine.
#[expect(clippy::large_enum_variant, reason = "a simulation has one")]
#[derive(Clone, Debug, Serialize, Deserialize)]
enum ByMethod<Run = Engine> {
    /// `eventDriven`.
    EventDriven(Run),
    /// `bdf`, `adams` and `rk4`.
    Continuous(Continuous),
}

/// A simulation as plain data, without the parameters that never change.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SimulationSnapshot {
    tunables: Tunables,
    run: ByMethod<Snapshot>,
}

/// Declares functions that are those of the selected method.
macro_rules! of_method {
    ($(fn $name:ident($self:ident: $by:ty $(, $argument:ident: $type:ty)*) -> $result:ty;)*) => {
        impl Simulation {$(
            #[doc = concat!("See [`Engine::", stringify!($name), "`].")]
            #[inline]
            pub fn $name($self: $by, $($argument: $type),*) -> $result {
                use ByMethod::{Continuous, EventDriven};
                match $self {
                    Self { run: EventDriven(engine), .. } => engine.$name($($argument),*),
                    Self { run: Continuous(run), .. } => run.$name($($argument),*),
                }
            }
        )*}
    };
}

of_method! {
    fn time(self: &Self) -> f64;
    fn next_event(self: &Self) -> Option<f64>;
    fn time_derivative(self: &Self, order: usize) -> Differential;
    fn hold(self: &mut Self, inputs: &Inputs, derivatives: &[Inputs]) -> Result<(), EngineError>;
    fn begin_step(self: &mut Self) -> ();
    fn advance(self: &mut Self, time: f64, observer: &mut dyn Observer) -> Result<(), EngineError>;
    fn continue_step(self: &mut Self, time: f64, observer: &mut dyn Observer) -> Result<(), EngineError>;
}

impl Deref for Simulation {
    type Target = dyn Results;

    fn deref(&self) -> &Self::Target {
        match &self.run {
            ByMethod::EventDriven(engine) => engine,
            ByMethod::Continuous(run) => run,
        }
    }
}

impl Simulation {
    /// Starts a run by the method that `parameters` select; see [`Engine::new`].
    pub fn new(parameters: &Parameters, inputs: &Inputs, start_time: f64) -> Result<Self, EngineError> {
        let begun = |run| Self { parameters: parameters.clone(), start: start_time, run };
        if parameters.method == SolverMethod::EventDriven {
            return Engine::new(parameters, inputs, start_time).map(|engine| begun(ByMethod::EventDriven(engine)));
        }
        if parameters.contact_model == ContactModel::Rigid {
            let text = "contact.model = rigid has no contact force that solver.method could integrate; allowed with \
                        it: eventDriven (1)";
            return Err(EngineError::NotRigid(text.to_owned()));
        }
        if parameters.pendulum == PendulumModel::Circular {
            return Err(EngineError::NoArc("solver.method must be eventDriven (1)".to_owned()));
        }
        Continuous::new(parameters, inputs, start_time).map(|run| begun(ByMethod::Continuous(run)))
    }

    /// The parameters, of which the tunable ones may have changed since the start.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Sets the tunable parameters from now on; see [`Engine::retune`].
    pub fn retune(&mut self, tunables: &Tunables) -> Result<(), EngineError> {
        let mut tuned = self.parameters.clone();
        tuned.tune(tunables);
        let retuned = match &mut self.run {
            ByMethod::EventDriven(engine) => engine.retune(&tuned),
            ByMethod::Continuous(run) => run.retune(&tuned),
        };
        // If no coefficients follow from the new parameters, the run has kept its old ones.
        if !matches!(retuned, Err(EngineError::NoCoefficient(_))) {
            self.parameters = tuned;
        }
        retuned
    }

    /// Sets whether the run has yet to begin; until then rigid contacts transmit nothing.
    pub fn set_initializing(&mut self, initializing: bool) {
        if let ByMethod::EventDriven(engine) = &mut self.run {
            engine.initializing = initializing;
        }
    }

    /// The history to the current time, and the state at the start of the run.
    fn stretches_and_start(&self, history: &History) -> Option<(Vec<Stretch>, ChainState)> {
        let stretches = history.of_run(self.stretch())?;
        let (first, mut at_start) = (stretches.first()?, self.parameters.clone());
        at_start.tune(&first.tunables);
        let begun = Self::new(&at_start, &first.inputs.values(self.start), self.start).ok()?;
        let start = begun.last_step().end;
        Some((stretches, start))
    }

    /// What has acted since the last change, until now.
    fn stretch(&self) -> Stretch {
        Stretch { until: self.time(), inputs: self.inputs().clone(), tunables: self.parameters.tunables() }
    }

    /// Derivatives of the outputs at the start along a direction of parameters and inputs. The derivative of the next
    /// onset is NaN unless it is wanted ([`LastStep::with_next_onset`]).
    pub fn sensitivity_at_start(
        &self,
        (tangent, inputs): (&Parameters, &Inputs),
        next_onset_wanted: bool,
    ) -> Differential {
        let last_step = self.last_step().with_next_onset(next_onset_wanted);
        last_step.along_parameters(tangent, inputs)
    }

    /// Derivatives of the outputs along a direction of the inputs held over the last step; an error if the step cannot
    /// be followed. The derivative of the next onset is NaN unless it is wanted ([`LastStep::with_next_onset`]).
    pub fn sensitivity_of_step(
        &self,
        history: &History,
        inputs: &Inputs,
        next_onset_wanted: bool,
    ) -> Result<Differential, Unfollowed> {
        let stretches = history.of_step(self.stretch()).ok_or(Unfollowed::NoHistory)?;
        let last_step = self.last_step().with_next_onset(next_onset_wanted);
        last_step.along_inputs(&stretches, inputs)
    }

    /// Derivatives of the outputs along a direction of parameters and inputs over the whole run, which has this
    /// `history`; an error if the run cannot be followed. The derivative of the next onset is NaN unless it is wanted
    /// ([`LastStep::with_next_onset`]).
    pub fn sensitivity_of_run(
        &self,
        history: &History,
        (tangent, inputs): (&Parameters, &Inputs),
        next_onset_wanted: bool,
    ) -> Result<Differential, Unfollowed> {
        if self.time() == self.start {
            return Ok(self.sensitivity_at_start((tangent, inputs), next_onset_wanted));
        }
        let (stretches, start) = self.stretches_and_start(history).ok_or(Unfollowed::NoHistory)?;
        let last_step = self.last_step().with_next_onset(next_onset_wanted);
        last_step.along((self.start, &start), &stretches, (Some(tangent), inputs))
    }

    /// The last step in parts, for derivatives by inputs forwards and in reverse; an error before the first step, or if
    /// the step cannot be followed.
    pub fn tape_of_step(&self, history: &History) -> Result<Tape, Unfollowed> {
        if self.step_length() == 0.0 {
            return Err(Unfollowed::NoHistory);
        }
        let stretches = history.of_step(self.stretch()).ok_or(Unfollowed::NoHistory)?;
        self.last_step().tape_of_step(&stretches)
    }

    /// The run so far in parts, for derivatives forwards and in reverse; an error at its start, or if it cannot be
    /// followed.
    pub fn tape(&self, history: &History) -> Result<Tape, Unfollowed> {
        if self.time() <= self.start {
            return Err(Unfollowed::NoHistory);
        }
        let (stretches, start) = self.stretches_and_start(history).ok_or(Unfollowed::NoHistory)?;
        self.last_step().tape((self.start, &start), &stretches)
    }

    /// The last step, or the start before the first, for derivatives along directions.
    pub fn last_step(&self) -> LastStep<'_> {
        match &self.run {
            ByMethod::EventDriven(run) => LastStep::new(run, &self.parameters, run.step_ends()),
            ByMethod::Continuous(run) => LastStep::new(run, &self.parameters, run.step_ends()),
        }
    }

    /// Keeps the history so far before inputs or tunable parameters change; that of the whole run only if it is
    /// `wanted`.
    pub fn keep_history(&self, wanted: bool, history: &mut History) {
        history.keep(wanted, self.step_length() > 0.0, &self.stretch());
    }

    pub(crate) fn inputs(&self) -> &HeldInputs {
        match &self.run {
            ByMethod::EventDriven(engine) => &engine.inputs,
            ByMethod::Continuous(run) => &run.inputs,
        }
    }

    /// The run as it is now, as plain data.
    pub fn snapshot(&self) -> SimulationSnapshot {
        let run = match &self.run {
            ByMethod::EventDriven(engine) => ByMethod::EventDriven(engine.snapshot()),
            ByMethod::Continuous(run) => ByMethod::Continuous(run.clone()),
        };
        SimulationSnapshot { tunables: self.parameters.tunables(), run }
    }

    /// The run of `snapshot` with its tunable parameters, if they are `allowed`; the other parameters are those of
    /// `parameters`. See [`Engine::restore`].
    pub fn restore(
        mut parameters: Parameters,
        start: f64,
        snapshot: SimulationSnapshot,
        failed: bool,
        allowed: impl Fn(&Parameters) -> bool,
    ) -> Result<Self, InvalidState> {
        parameters.tune(&snapshot.tunables);
        require(allowed(&parameters), "a tunable parameter is out of range")?;
        let run = match (parameters.method == SolverMethod::EventDriven, snapshot.run) {
            (true, ByMethod::EventDriven(snapshot)) => {
                ByMethod::EventDriven(Engine::restore(&parameters, start, snapshot, failed)?)
            }
            (false, ByMethod::Continuous(run)) => ByMethod::Continuous(run.restored(&parameters, start, failed)?),
            _ => return Err(InvalidState("it belongs to another method")),
        };
        Ok(Self { parameters, start, run })
    }
}
