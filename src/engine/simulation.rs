//! One run of the cradle, by the method that was selected.

use std::ops::Deref;

use serde::{Deserialize, Serialize};

use super::continuous::Continuous;
use super::derivatives::{History, LastStep, Recorder, Stretch, Tape};
use super::error::EngineError;
use super::inputs::HeldInputs;
use super::observer::Observer;
use super::run::{Engine, InvalidState, Snapshot, require};
use crate::model::{ContactModel, Differential, Inputs, Parameters, PendulumModel, Results, SolverMethod, Tunables};

/// A run by the selected method, whose functions have the meaning of those of [`Engine`], with its parameters.
#[derive(Clone, Debug)]
pub struct Simulation {
    /// As they act now.
    parameters: Parameters,
    /// The time at which it began, s.
    start: f64,
    run: ByMethod,
}

/// As plain data it has a [`Snapshot`] in place of the engine.
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

/// Functions that are those of the selected method.
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
    fn last_step(self: &Self) -> LastStep<'_>;
    fn hold(self: &mut Self, inputs: &Inputs, derivatives: &[Inputs]) -> Result<(), EngineError>;
    fn begin_step(self: &mut Self) -> ();
    fn advance(self: &mut Self, time: f64, observer: &mut dyn Observer) -> Result<(), EngineError>;
    fn continue_step(self: &mut Self, time: f64, observer: &mut dyn Observer) -> Result<(), EngineError>;
}

/// Results come from the selected method.
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

    /// From now on these are the tunable parameters; see [`Engine::retune`].
    pub fn retune(&mut self, tunables: Tunables) -> Result<(), EngineError> {
        let mut tuned = self.parameters.clone();
        tuned.tune(tunables);
        let retuned = match &mut self.run {
            ByMethod::EventDriven(engine) => engine.retune(&tuned),
            ByMethod::Continuous(run) => run.retune(&tuned),
        };
        // The run has kept its coefficients if it cannot have new ones.
        if !matches!(retuned, Err(EngineError::NoCoefficient(_))) {
            self.parameters = tuned;
        }
        retuned
    }

    /// Whether the run has yet to begin; until then rigid contacts transmit nothing.
    pub fn set_initializing(&mut self, initializing: bool) {
        if let ByMethod::EventDriven(engine) = &mut self.run {
            engine.initializing = initializing;
        }
    }

    /// The history to the current time, and the run at its start.
    fn begun_again(&self, history: &History) -> Option<(Vec<Stretch>, Self)> {
        let stretches = history.of_run(self.stretch())?;
        let (first, mut at_start) = (stretches.first()?, self.parameters.clone());
        at_start.tune(first.tunables);
        let begun = Self::new(&at_start, &first.inputs.values(self.start), self.start).ok()?;
        Some((stretches, begun))
    }

    /// What has acted until now, since the last change.
    fn stretch(&self) -> Stretch {
        Stretch { until: self.time(), inputs: self.inputs().clone(), tunables: self.parameters.tunables() }
    }

    /// Derivatives of the outputs at the start along a direction of parameters and inputs; that of the next onset is
    /// NaN unless it is wanted ([`LastStep::with_next_onset`]).
    pub fn sensitivity_at_start(
        &self,
        (tangent, inputs): (&Parameters, &Inputs),
        next_onset_wanted: bool,
    ) -> Differential {
        let last_step = self.last_step().with_next_onset(next_onset_wanted);
        last_step.along_parameters(&self.parameters, tangent, inputs)
    }

    /// Derivatives of the outputs along inputs that were held over the last step; `None` if it cannot be followed. That
    /// of the next onset is NaN unless it is wanted ([`LastStep::with_next_onset`]).
    pub fn sensitivity_of_step(
        &self,
        history: &History,
        inputs: &Inputs,
        next_onset_wanted: bool,
    ) -> Option<Differential> {
        let stretches = history.of_step(self.stretch())?;
        let last_step = self.last_step().with_next_onset(next_onset_wanted);
        last_step.along_inputs(&self.parameters, &stretches, inputs)
    }

    /// Derivatives of the outputs along a direction of parameters and inputs over the whole run, which has this
    /// history; `None` if it cannot be followed. That of the next onset is NaN unless it is wanted
    /// ([`LastStep::with_next_onset`]).
    pub fn sensitivity_of_run(
        &self,
        history: &History,
        (tangent, inputs): (&Parameters, &Inputs),
        next_onset_wanted: bool,
    ) -> Option<Differential> {
        if self.time() == self.start {
            return Some(self.sensitivity_at_start((tangent, inputs), next_onset_wanted));
        }
        let (stretches, begun) = self.begun_again(history)?;
        let last_step = self.last_step().with_next_onset(next_onset_wanted);
        let start = (self.start, &begun.last_step().end);
        last_step.along_run(&self.parameters, start, &stretches, (tangent, inputs))
    }

    /// The run up to now in parts, for derivatives both ways; only elastic event-driven runs have one.
    pub fn tape(&self, history: &History) -> Option<Tape> {
        if self.time() <= self.start {
            return None;
        }
        // The same run again; where its steps end makes no difference.
        let (stretches, Self { run: ByMethod::EventDriven(mut run), .. }) = self.begun_again(history)? else {
            return None;
        };
        let (mut then, mut recorder) = (self.parameters.clone(), Recorder::new(self.start, &run.last_step().end));
        for stretch in &stretches {
            then.tune(stretch.tunables);
            let inputs = stretch.inputs.at(run.time);
            run.retune(&then).and_then(|()| run.hold(&inputs.orders[0], &inputs.orders[1..])).ok()?;
            recorder.begin(&then, &inputs)?;
            run.advance(stretch.until, &mut recorder).ok()?;
            recorder.end(stretch.until)?;
        }
        recorder.tape(&self.last_step().end)
    }

    /// Before inputs or tunable parameters change: keeps the history so far, that of the run if it is `wanted`.
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

    /// The run of `snapshot`, with its tunable parameters, if they are `allowed`; the others are those of `parameters`.
    /// See [`Engine::restore`].
    pub fn restore(
        mut parameters: Parameters,
        start: f64,
        snapshot: SimulationSnapshot,
        failed: bool,
        allowed: impl Fn(&Parameters) -> bool,
    ) -> Result<Self, InvalidState> {
        parameters.tune(snapshot.tunables);
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
