//! One run of the cradle, by the method that was selected.

use std::ops::Deref;

use serde::{Deserialize, Serialize};

use super::continuous::Continuous;
use super::derivatives::{History, LastStep, Recorder, Stretch, Tape};
use super::error::EngineError;
use super::inputs::HeldInputs;
use super::observer::Observer;
use super::run::{Engine, Snapshot, Unsound};
use crate::model::{ContactModel, Differential, Inputs, Parameters, PendulumModel, Results, SolverMethod, Tunables};

/// A run by the selected method, whose functions have the meaning of those of [`Engine`]. As plain data it has a
/// [`Snapshot`] in place of the engine.
#[expect(clippy::large_enum_variant, reason = "an instance has one")]
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Simulation<Run = Engine> {
    /// `eventDriven`.
    EventDriven(Run),
    /// `bdf`, `adams` and `rk4`.
    Continuous(Continuous),
}

/// Functions that are those of the selected method.
macro_rules! of_method {
    ($(fn $name:ident($self:ident: $by:ty $(, $argument:ident: $type:ty)*) -> $result:ty;)*) => {
        impl Simulation {$(
            #[doc = concat!("See [`Engine::", stringify!($name), "`].")]
            #[inline]
            pub fn $name($self: $by, $($argument: $type),*) -> $result {
                match $self {
                    Self::EventDriven(engine) => engine.$name($($argument),*),
                    Self::Continuous(run) => run.$name($($argument),*),
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
    fn retune(self: &mut Self, parameters: &Parameters) -> Result<(), EngineError>;
    fn begin_step(self: &mut Self) -> ();
    fn advance(self: &mut Self, time: f64, observer: &mut dyn Observer) -> Result<(), EngineError>;
    fn continue_step(self: &mut Self, time: f64, observer: &mut dyn Observer) -> Result<(), EngineError>;
}

/// Results come from the selected method.
impl Deref for Simulation {
    type Target = dyn Results;

    fn deref(&self) -> &Self::Target {
        match self {
            Self::EventDriven(engine) => engine,
            Self::Continuous(run) => run,
        }
    }
}

impl Simulation {
    /// Starts a run by the method that `parameters` select; see [`Engine::new`].
    pub fn new(parameters: &Parameters, inputs: &Inputs, start_time: f64) -> Result<Self, EngineError> {
        if parameters.method == SolverMethod::EventDriven {
            return Engine::new(parameters, inputs, start_time).map(Self::EventDriven);
        }
        if parameters.contact_model == ContactModel::Rigid {
            let text = "contact.model = rigid has no contact force that solver.method could integrate; allowed with \
                        it: eventDriven (1)";
            return Err(EngineError::NotRigid(text.to_owned()));
        }
        if parameters.pendulum == PendulumModel::Circular {
            return Err(EngineError::NoArc("solver.method must be eventDriven (1)".to_owned()));
        }
        Continuous::new(parameters, inputs, start_time).map(Self::Continuous)
    }

    /// Whether the run has yet to begin; until then rigid contacts transmit nothing.
    pub fn set_initializing(&mut self, initializing: bool) {
        if let Self::EventDriven(engine) = self {
            engine.initializing = initializing;
        }
    }

    /// The history from `start` (s) to the current time, and the run at its start; `parameters` are the current ones.
    fn begun_again(&self, parameters: &Parameters, start: f64, history: &History) -> Option<(Vec<Stretch>, Self)> {
        let stretches = history.of_run(self.stretch(parameters.tunables()))?;
        let (first, mut at_start) = (stretches.first()?, parameters.clone());
        at_start.tune(first.tunables);
        let begun = Self::new(&at_start, &first.inputs.values(start), start).ok()?;
        Some((stretches, begun))
    }

    /// What has acted until now, since the last change; `tunables` are the current parameters.
    fn stretch(&self, tunables: Tunables) -> Stretch {
        Stretch { until: self.time(), inputs: self.inputs().clone(), tunables }
    }

    /// Derivatives of the outputs along inputs that were held over the last step; `None` if it cannot be followed.
    /// `parameters` are the current ones.
    pub fn sensitivity_of_step(
        &self,
        parameters: &Parameters,
        history: &History,
        inputs: &Inputs,
    ) -> Option<Differential> {
        let stretches = history.of_step(self.stretch(parameters.tunables()))?;
        self.last_step().along_inputs(parameters, &stretches, inputs)
    }

    /// Derivatives of the outputs along a direction of parameters and inputs over the whole run, which began at `start`
    /// (s) and has this history; `None` if it cannot be followed. `parameters` are the current ones.
    pub fn sensitivity_of_run(
        &self,
        parameters: &Parameters,
        start: f64,
        history: &History,
        tangent: &Parameters,
        inputs: &Inputs,
    ) -> Option<Differential> {
        if self.time() == start {
            return Some(self.last_step().along_parameters(parameters, tangent, inputs));
        }
        let (stretches, begun) = self.begun_again(parameters, start, history)?;
        self.last_step().along_run(parameters, (start, &begun.last_step().end), &stretches, (tangent, inputs))
    }

    /// The run from `start` (s) to now in parts, for derivatives both ways; only elastic event-driven runs have one.
    pub fn tape(&self, parameters: &Parameters, start: f64, history: &History) -> Option<Tape> {
        if self.time() <= start {
            return None;
        }
        // The same run again; where its steps end makes no difference.
        let (stretches, Self::EventDriven(mut run)) = self.begun_again(parameters, start, history)? else {
            return None;
        };
        let (mut then, mut recorder) = (parameters.clone(), Recorder::new(start, &run.last_step().end));
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

    /// Before inputs or tunable parameters (now `tunables`) change: keeps the history so far, that of the run if it is
    /// `wanted`.
    pub fn keep_history(&self, wanted: bool, tunables: Tunables, history: &mut History) {
        history.keep(wanted, self.step_length() > 0.0, &self.stretch(tunables));
    }

    pub(crate) fn inputs(&self) -> &HeldInputs {
        match self {
            Self::EventDriven(engine) => &engine.inputs,
            Self::Continuous(run) => &run.inputs,
        }
    }

    /// The run as it is now, as plain data.
    pub fn snapshot(&self) -> Simulation<Snapshot> {
        match self {
            Self::EventDriven(engine) => Simulation::EventDriven(engine.snapshot()),
            Self::Continuous(run) => Simulation::Continuous(run.clone()),
        }
    }

    /// See [`Engine::restore`].
    pub fn restore(
        parameters: &Parameters,
        start: f64,
        snapshot: Simulation<Snapshot>,
        failed: bool,
    ) -> Result<Self, Unsound> {
        match (parameters.method == SolverMethod::EventDriven, snapshot) {
            (true, Simulation::EventDriven(snapshot)) => {
                Engine::restore(parameters, start, snapshot, failed).map(Self::EventDriven)
            }
            (false, Simulation::Continuous(run)) => run.restored(parameters, start, failed).map(Self::Continuous),
            _ => Err(Unsound("it belongs to another method")),
        }
    }
}
