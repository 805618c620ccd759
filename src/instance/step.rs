//! Communication steps, which may end or be interrupted at onsets and releases, and events.

use std::slice;

use super::legality::{Kind, Phase, Purpose};
use super::lifecycle::{Instance, StepUnderWay};
use super::report::StepLogger;
use crate::engine::{EngineError, Results};
use crate::model::{ContactModel, Inputs};
use crate::variables::{Number, Refusal, ensure};

/// Allowed difference between the host's time and the instance's, relative to the larger of 1 s and the time.
const CLOCK_TOLERANCE: f64 = 1e-12;

/// How a step, or a part of it, has ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepEnd {
    pub time: f64,
    /// Whether it ended before the end asked for.
    pub early: bool,
    /// Whether the host must enter Event Mode.
    pub events: bool,
    /// Whether the host must be called before the step goes on.
    pub interrupted: bool,
}

/// What follows from an event that has been handled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Handled {
    /// Whether another event is due at once.
    pub again: bool,
    /// Whether continuous states have changed.
    pub changed: bool,
    /// When the next event is due, s, if known.
    pub next: Option<f64>,
}

impl Instance {
    /// Time reached by the last step or set by the host, s.
    pub fn time(&self) -> f64 {
        match (&self.run.simulation, &self.run.exchange) {
            (Some(simulation), _) => simulation.time(),
            (None, Some(exchange)) => exchange.time,
            (None, None) => self.run.start_time(),
        }
    }

    /// Steps from `current`, the host's time in s, by `step` > 0 s. The new time is exactly `current + step`, unless
    /// the step is interrupted at an onset or a release, where the host is called, or may end early there.
    ///
    /// # Errors
    /// Refused, with nothing changed, if a time is invalid or `current` does not match the instance's time. If the
    /// simulation fails, the instance enters the error state.
    pub fn step(&mut self, current: f64, step: f64, interruptible: bool) -> Result<StepEnd, Refusal> {
        let own = self.time();
        // Comparisons that are false for NaN, so that NaN is refused.
        let in_time = (current - own).abs() <= CLOCK_TOLERANCE * own.abs().max(1.0);
        let end = current + step;
        ensure(in_time && step > 0.0 && end.is_finite(), || refuse_times(own, current, step))?;
        self.check_inputs_after("communicationStepSize", end - own)?;
        self.apply_slopes();
        if end <= own {
            // A step below the resolution of doubles, by a host whose clock lags by some ulps: the end is reached
            // already.
            self.run.input_derivatives.clear();
            return Ok(self.reached(own, false));
        }
        if let Some(simulation) = &mut self.run.simulation {
            // Before new inputs act, so that their effect belongs to this step.
            simulation.begin_step();
            self.run.history.begin_step();
        }
        self.update_simulation()?;
        if let Some(stop) = self.run.experiment.and_then(|experiment| experiment.stop)
            && end > stop
            && !self.run.past_stop_logged
        {
            self.run.past_stop_logged = true;
            let [end, stop] = [end, stop].map(Number);
            let text = format_args!("the step to t = {end} s passes stopTime = {stop} s; it is computed as usual");
            self.log.solver(text);
        }
        self.catch_up_rigid();
        self.advance(StepUnderWay { asked: end, end }, interruptible)
    }

    /// Continues an interrupted step, which the host may end at the time `end` (s).
    pub fn continue_step(&mut self, end: Option<f64>) -> Result<StepEnd, Refusal> {
        let Some(mut step) = self.run.under_way else { return Err(Refusal::new("no step is under way")) };
        self.run.phase = Phase::StepMode;
        let now = self.time();
        if let Some(end) = end.filter(|end| !end.is_nan()) {
            step.end = step.end.min(end.max(now));
        }
        if self.run.inputs_changed {
            self.check_inputs_after("the rest of the step", step.end - now)?;
            self.apply_slopes();
            self.update_simulation()?;
            self.catch_up_rigid();
        }
        if step.end == now || self.may_end_early() && self.run.clocks.are_due() {
            return Ok(self.end_step(step));
        }
        self.advance(step, true)
    }

    /// Advances to the end of the step, or to the first onset or release.
    fn advance(&mut self, step: StepUnderWay, interruptible: bool) -> Result<StepEnd, Refusal> {
        self.run.history.forget_tapes();
        let (end, purpose) = (step.end, self.run.purpose);
        let stops = interruptible || self.may_end_early();
        let mut logger = StepLogger::new(&self.log, &mut self.run.clocks, purpose, end, stops);
        let moved = match &mut self.run.simulation {
            Some(simulation) => simulation.continue_step(end, &mut logger),
            None => return Err(Refusal::new("nothing is calculated yet")),
        };
        let interrupted = interruptible && logger.stopped.is_some_and(|stopped| stopped <= end);
        moved.map_err(|error| self.fail(error))?;
        if !interrupted {
            return Ok(self.end_step(step));
        }
        self.run.phase = Phase::IntermediateUpdate;
        self.run.under_way = Some(step);
        Ok(self.reached(step.asked, true))
    }

    /// The result of a step to the time `asked` (s), or of a part of it.
    #[inline]
    fn reached(&self, asked: f64, interrupted: bool) -> StepEnd {
        let time = self.time();
        StepEnd { time, early: time < asked, events: self.run.clocks.are_due(), interrupted }
    }

    /// Ends the step; the inputs keep the values they reached.
    #[inline]
    fn end_step(&mut self, step: StepUnderWay) -> StepEnd {
        self.run.under_way = None;
        self.keep_inputs();
        self.reached(step.asked, false)
    }

    /// Slopes, if any is not 0. They act over each step, like derivatives that are set for each step.
    fn slopes(&self) -> Option<&Inputs> {
        let slopes = &self.run.settings.slopes;
        let act = || slopes.support_acceleration != 0.0 || slopes.force.iter().any(|slope| *slope != 0.0);
        (self.run.purpose.fmi3 && act()).then_some(slopes)
    }

    fn apply_slopes(&mut self) {
        if let Some(slopes) = self.slopes() {
            self.run.input_derivatives = vec![slopes.clone()];
            self.run.inputs_changed = true;
        }
    }

    /// Checks that inputs with derivatives are finite after a step of `length` (s), which messages call `name`.
    fn check_inputs_after(&self, name: &str, length: f64) -> Result<(), Refusal> {
        let derivatives = self.slopes().map_or(&*self.run.input_derivatives, slice::from_ref);
        if derivatives.is_empty() {
            return Ok(());
        }
        let length = length.max(0.0); // A host's clock may lag by some ulps.
        let reached = self.run.settings.inputs.continued(derivatives, length);
        let allowed = "a length over which the inputs, with their given derivatives, stay finite";
        ensure(reached.is_finite(), || Refusal::number(name, length, "s", allowed))
    }

    /// Inputs with derivatives keep the values that they have reached.
    pub(super) fn keep_inputs(&mut self) {
        if let Some(simulation) = self.run.simulation.as_ref().filter(|_| !self.run.input_derivatives.is_empty()) {
            self.run.settings.inputs = simulation.inputs().values(simulation.time());
            self.run.input_derivatives.clear();
            self.run.inputs_changed = true;
        }
    }

    #[cold]
    pub(super) fn fail(&mut self, error: EngineError) -> Refusal {
        self.run.phase = Phase::Error;
        Refusal::new(format_args!("the run cannot go on: {error}"))
    }

    /// Passes changed inputs and tunable parameters to the simulation.
    pub(super) fn update_simulation(&mut self) -> Result<(), Refusal> {
        let run = &mut self.run;
        let over_run = run.derives_over_run();
        let Some(simulation) = &mut run.simulation else { return Ok(()) };
        let retuned = !simulation.parameters().is_tuned_as(&run.settings.parameters);
        if run.purpose.fmi3 && (run.inputs_changed || retuned) {
            simulation.keep_history(over_run, &mut run.history);
        }
        let mut updated = Ok(());
        if std::mem::take(&mut run.inputs_changed) {
            updated = simulation.hold(&run.settings.inputs, &run.input_derivatives);
        }
        if retuned && updated.is_ok() {
            updated = simulation.retune(&run.settings.parameters.tunables());
        }
        if retuned {
            self.log_without_effect();
        }
        updated.map_err(|error| self.fail(error))
    }

    pub fn enter_event_mode(&mut self) -> Result<(), Refusal> {
        let Purpose { kind, events, .. } = self.run.purpose;
        if kind == Kind::ModelExchange {
            return self.enter_events_of_exchange();
        }
        ensure(events, || Refusal::new("the instance was created without event mode"))?;
        self.run.phase = Phase::EventMode;
        self.update_simulation()?;
        self.catch_up_rigid();
        // An event within rounding of the host's clock is due.
        let (own, margin) = (self.time(), CLOCK_TOLERANCE * self.time().abs().max(1.0));
        let next = self.simulation()?.next_event().filter(|next| *next - own <= margin);
        if let Some(next) = next.filter(|_| !self.run.clocks.are_due()) {
            self.advance(StepUnderWay { asked: next, end: next }, false)?;
        }
        self.tick();
        Ok(())
    }

    /// Ends the event of the active clocks, and activates the clocks of the next event; in model exchange, handles what
    /// is due.
    pub fn update_discrete_states(&mut self) -> Result<Handled, Refusal> {
        if self.run.purpose.kind == Kind::ModelExchange {
            return self.next_event_of_exchange();
        }
        self.update_simulation()?;
        self.catch_up();
        let again = self.tick();
        let next = if again { None } else { self.simulation()?.next_event() };
        Ok(Handled { again, changed: false, next })
    }

    /// Inputs that press rigid balls together close contacts at once: the clocks tick when the inputs take effect.
    fn catch_up_rigid(&mut self) {
        if self.run.settings.parameters.contact_model == ContactModel::Rigid && self.run.purpose.has_event_mode() {
            self.catch_up();
        }
    }

    pub(super) fn catch_up(&mut self) {
        if let Some(simulation) = &self.run.simulation {
            self.run.clocks.catch_up(&[], &**simulation);
        }
    }

    pub(super) fn tick(&mut self) -> bool {
        let Ok(work) = self.results().map(Results::work) else { return false };
        self.run.clocks.work = work;
        self.run.clocks.tick()
    }

    fn may_end_early(&self) -> bool {
        self.run.purpose.has_event_mode() && self.run.purpose.early_return
    }
}

#[cold]
fn refuse_times(own: f64, current: f64, step: f64) -> Refusal {
    if !(step > 0.0 && step.is_finite()) {
        Refusal::number("communicationStepSize", step, "s", "finite and > 0 s")
    } else {
        let allowed = format_args!("the time reached, {} s, to within 1e-12 of max(1 s, |t|)", Number(own));
        Refusal::number("currentCommunicationPoint", current, "s", allowed)
    }
}

#[cfg(test)]
mod tests {
    use super::super::lifecycle::{Experiment, Start};
    use super::super::log::Log;
    use super::*;
    use crate::variables::Settings;

    #[test]
    fn refused_step_changes_nothing() {
        let mut settings = Settings::default_for(2);
        settings.slopes.support_acceleration = 1e308;
        let purpose = Purpose { fmi3: true, ..Purpose::default() };
        let start = Start { purpose, settings, scalars: false, guid: String::new() };
        let mut instance = Instance::new(start, Log::new(None, false, false));
        instance.set_up(Experiment::default()).unwrap();
        instance.enter_initialization().unwrap();
        instance.exit_initialization().unwrap();
        // Backwards, later than now, and so long that an input is no longer finite.
        for (current, step) in [(0.0, -1.0), (3.0, 0.1), (0.0, 100.0)] {
            instance.step(current, step, false).unwrap_err();
            assert!(instance.run.input_derivatives.is_empty() && !instance.run.inputs_changed, "{current}, {step}");
        }
        instance.step(0.0, 1e-3, false).unwrap();
        assert_eq!(instance.run.settings.inputs.support_acceleration, 1e305);
    }
}
