//! A run by a general-purpose solver: its state, and the calls that advance it.

use std::cell::{Cell, RefCell};

use serde::{Deserialize, Serialize};

use super::dynamics::{Dynamics, forcings};
use super::trajectory::{ContactEvent, Event, Trajectory};
use crate::engine::run::{InvalidState, require};
use crate::engine::{Activity, EngineError, Forecast, HeldInputs, Ledger, Observer, Peak, Watchdog};
use crate::model::{Chain, Cradle, Inputs, Parameters, Results, WorkCounters};
use crate::solver::DoubleDouble;

/// Number of balls for which an evaluation of the rates, with its part of a step, counts as one unit of effort: see
/// [`Watchdog`].
const BALLS: usize = 4;

/// A cradle and its trajectory up to the current time.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Continuous {
    pub(in crate::engine) inputs: HeldInputs,
    pub(super) trajectory: Trajectory,
    /// Ledgers of the contacts; the impulse in a ledger is that at the last onset.
    pub(super) ledgers: Vec<Ledger>,
    pub(super) time: f64,
    /// Number of the current step; 0 before the first.
    pub(super) step: u64,
    /// Start of the last step, s, with the state of the equations then.
    pub(super) step_start: f64,
    /// Time up to which the ledgers hold the largest forces of the step, s; see
    /// [`StepStart`](crate::engine::StepStart).
    pub(super) entered: f64,
    pub(super) y_at_step: Vec<f64>,
    pub(super) energy_at_start: f64,
    /// A copy of the motion that looks ahead for the next onset.
    pub(super) ahead: RefCell<Option<Box<Trajectory>>>,
    /// The last result of a look ahead, and the time of the request, s.
    pub(super) foreseen: Cell<Option<(f64, Forecast)>>,
}

impl Continuous {
    /// Starts a run at `start_time` (s) with the start values of `parameters`, which must be in their ranges.
    pub(crate) fn new(parameters: &Parameters, inputs: &Inputs, start_time: f64) -> Result<Self, EngineError> {
        Cradle::new(parameters).check(parameters).map_err(EngineError::NoCoefficient)?;
        let since = DoubleDouble::from(start_time);
        let y = Dynamics::start(&Cradle::new(parameters), &parameters.x_start, &parameters.v_start);
        let inputs = HeldInputs::constant(inputs.clone(), start_time);
        let dynamics = Dynamics::new(Cradle::new(parameters), &inputs, start_time, &y, parameters.tolerance);
        if let Some(component) = dynamics.beyond_range(&y) {
            return Err(dynamics.lost(component, since));
        }
        let mut run = Self {
            inputs,
            trajectory: Trajectory::new(
                parameters.method,
                parameters.fixed_step,
                dynamics,
                &y,
                WorkCounters::default(),
            ),
            ledgers: vec![Ledger::default(); parameters.contacts()],
            time: start_time,
            step: 0,
            step_start: start_time,
            entered: start_time,
            y_at_step: y,
            energy_at_start: 0.0,
            ahead: RefCell::new(None),
            foreseen: Cell::new(None),
        };
        for i in 0..run.ledgers.len() {
            if run.trajectory.closed[i] {
                run.ledgers[i].open_pulse(since, 0);
                run.trajectory.work.events += 1;
            }
        }
        run.energy_at_start = run.total_energy();
        if !run.energy_at_start.is_finite() {
            return Err(EngineError::EnergyNotFinite { time: start_time });
        }
        Ok(run)
    }

    /// See [`Engine::restore`](crate::engine::Engine::restore).
    pub(crate) fn restored(mut self, parameters: &Parameters, start: f64, failed: bool) -> Result<Self, InvalidState> {
        let of = |run: &Trajectory| (run.method, run.fixed_step, run.dynamics.tolerance);
        let same = |run: &Trajectory| of(run) == (parameters.method, parameters.fixed_step, parameters.tolerance);
        let all_same = same(&self.trajectory) && self.ahead.borrow().as_deref().is_none_or(same);
        require(all_same, "it belongs to another method")?;
        let cradle = Cradle::new(parameters);
        let fits = self.inputs.fit(parameters.balls())
            && self.ledgers.len() == parameters.contacts()
            && self.y_at_step.len() == 4 * parameters.balls() + 1;
        require(fits, "its size does not match the cradle")?;
        let finite = self.inputs.are_finite() && self.y_at_step.iter().all(|y| y.is_finite());
        require(failed || finite, "an input or a state is not finite")?;
        let forcings = forcings(&cradle, &self.inputs, self.trajectory.dynamics.since.value());
        let trajectory = self.trajectory.restored(cradle, forcings, failed);
        self.trajectory = trajectory.ok_or(InvalidState("its solver has not reached its time"))?;
        if let Some(ahead) = self.ahead.take() {
            let forcings = self.trajectory.dynamics.forcings.clone();
            let ahead = ahead.restored(self.trajectory.dynamics.cradle.clone(), forcings, failed);
            self.ahead.replace(Some(Box::new(ahead.ok_or(InvalidState("its look ahead has not reached its time"))?)));
        }
        let path = &self.trajectory.path;
        let on_path = path.end >= self.now() && path.start() <= self.now();
        let times =
            [self.inputs.since, self.step_start, self.entered].iter().all(|time| (start..=self.time).contains(time));
        require(failed || (on_path && times), "its time is not that of its solver")?;
        let found = self.foreseen.get().is_none_or(|(asked, found)| asked != self.time || found.time() > self.time);
        require(failed || found, "the onset that it found ahead lies in the past")?;
        require(
            failed || (self.energy_at_start.is_finite() && self.ledgers.iter().all(Ledger::is_sound)),
            "a sum is not finite",
        )?;
        Ok(self)
    }

    /// Current time, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// See [`Engine::hold`](crate::engine::Engine::hold).
    pub fn hold(&mut self, inputs: &Inputs, derivatives: &[Inputs]) -> Result<(), EngineError> {
        if let Some(inputs) = self.inputs.changed(self.time, inputs, derivatives) {
            self.inputs = inputs;
            self.restart(self.trajectory.dynamics.cradle.clone());
        }
        Ok(())
    }

    /// From the current time on, the tunable ones of these `parameters` act: drag and damping of contacts.
    pub fn retune(&mut self, parameters: &Parameters) -> Result<(), EngineError> {
        let cradle = Cradle::new(parameters);
        if cradle != self.trajectory.dynamics.cradle {
            cradle.check(parameters).map_err(EngineError::NoCoefficient)?;
            self.restart(cradle);
        }
        Ok(())
    }

    /// Restarts from the current time with the current inputs and cradle.
    fn restart(&mut self, cradle: Cradle) {
        if self.step_length() > 0.0 {
            self.enter_forces();
        }
        let y = self.y();
        let dynamics = Dynamics::new(cradle, &self.inputs, self.time, &y, self.trajectory.dynamics.tolerance);
        self.trajectory.restart(dynamics, &y);
        self.ahead.take();
        self.foreseen.take();
    }

    pub(super) fn now(&self) -> DoubleDouble {
        self.time.into()
    }

    /// See [`Engine::begin_step`](crate::engine::Engine::begin_step).
    pub fn begin_step(&mut self) {
        self.step = self.step.saturating_add(1);
        (self.step_start, self.entered) = (self.time, self.time);
        self.y_at_step = self.y();
        self.ledgers.iter_mut().for_each(|ledger| ledger.begin_step(self.step, DoubleDouble::ZERO));
    }

    /// Enters the forces at the current time in the ledgers.
    fn enter_forces(&mut self) {
        for i in 0..self.ledgers.len() {
            let force = self.force(i);
            self.ledgers[i].raise_peak_of_step(force);
        }
        self.entered = self.time;
    }

    /// See [`Engine::advance`](crate::engine::Engine::advance).
    pub fn advance(&mut self, time: f64, observer: &mut dyn Observer) -> Result<(), EngineError> {
        self.begin_step();
        self.continue_step(time, observer)
    }

    /// See [`Engine::continue_step`](crate::engine::Engine::continue_step).
    pub fn continue_step(&mut self, mut time: f64, observer: &mut dyn Observer) -> Result<(), EngineError> {
        if self.entered == self.time {
            // The forces that act from now on.
            self.enter_forces();
        }
        let before = self.effort();
        let mut watchdog = Watchdog::new(self.now(), time, self.ledgers.len(), before);
        loop {
            while let Some(&event) = self.trajectory.events.front().filter(|event| event.time <= time.into()) {
                self.trajectory.events.pop_front();
                self.enter(event, observer);
                time = observer.stop().map_or(time, |stop| stop.min(time));
            }
            if self.trajectory.path.end >= time.into() {
                break;
            }
            let Trajectory { path, closed, .. } = &self.trajectory;
            for (i, ledger) in self.ledgers.iter_mut().enumerate().filter(|(i, _)| closed[*i]) {
                raise_peak(ledger, self.trajectory.force(i, 0.0), path.end, path.start());
            }
            self.trajectory.advance()?;
            let reached = self.trajectory.path.start();
            watchdog.check(reached, (1, || Activity::Solver), self.effort(), observer)?;
        }
        self.time = time;
        if self.effort() > before { self.check_finite() } else { Ok(()) }
    }

    /// Fails if the last steps, or sums over them, have left the range of doubles. So what is saved after a step is
    /// finite.
    fn check_finite(&self) -> Result<(), EngineError> {
        self.trajectory.check_finite()?;
        if let Some(component) = self.y_at_step.iter().position(|y| !y.is_finite()) {
            return Err(self.trajectory.dynamics.lost(component, self.step_start.into()));
        }
        let contact = self.ledgers.iter().position(|ledger| !ledger.is_sound());
        contact.map_or(Ok(()), |contact| Err(EngineError::ContactNotFinite { time: self.time, contact }))
    }

    /// Work so far, as a [`Watchdog`] counts it.
    fn effort(&self) -> u64 {
        let evaluation = self.trajectory.dynamics.balls().div_ceil(BALLS);
        self.trajectory.work.evaluations.saturating_mul(evaluation as u64)
    }

    fn enter(&mut self, event: Event, observer: &mut dyn Observer) {
        let Event { time, contact: i, kind, force } = event;
        let path = &self.trajectory.path;
        let impulse = path.value(self.trajectory.dynamics.impulse(i), path.place(time));
        let ledger = &mut self.ledgers[i];
        match kind {
            ContactEvent::Onset => {
                ledger.open_pulse(time, self.step);
                raise_peak(ledger, force, time, time);
                ledger.impulse = impulse.into();
                observer.onset(i, ledger.record.onset);
            }
            ContactEvent::Peak => raise_peak(ledger, force, time, path.start()),
            ContactEvent::Release => {
                ledger.add(impulse - ledger.impulse.value());
                observer.pulse(ledger.close_pulse(i, time));
            }
        }
        if kind != ContactEvent::Peak {
            let events = &mut self.trajectory.work.events;
            *events = events.saturating_add(1);
        }
    }
}

/// Enters a `force` at a `time` of a solver's step that began at `begun`, for the pulse and for the step of the host.
fn raise_peak(ledger: &mut Ledger, force: f64, time: DoubleDouble, begun: DoubleDouble) {
    ledger.raise_peak(Peak { force, time: time.value_up() }, begun);
    ledger.raise_peak_of_step(force);
}
