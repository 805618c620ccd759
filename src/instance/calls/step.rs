//! Communication steps.

use super::report::Reporter;
use crate::instance::legality::Phase;
use crate::instance::lifecycle::Instance;
use crate::instance::refusal::Refusal;
use crate::model::Inputs;

/// How far the host's clock may be off from ours, relative to the larger of 1 s and the time.
pub(crate) const CLOCK_TOLERANCE: f64 = 1e-12;

impl Instance {
    /// Time that the last step reached, or that the host has set, s.
    pub fn time(&self) -> f64 {
        match (&self.run.simulation, &self.run.exchange) {
            (Some(simulation), _) => simulation.time(),
            (None, Some(exchange)) => exchange.time(),
            (None, None) => self.run.experiment.unwrap_or_default().start,
        }
    }

    /// Steps from `current`, the host's time in s, by `step` > 0 s. The new time is exactly `current + step`.
    ///
    /// # Errors
    /// Refused, with nothing changed, if a time is invalid or `current` is not where the instance is. If the
    /// simulation cannot go on the instance enters the error state.
    #[inline]
    pub fn step(&mut self, current: f64, step: f64) -> Result<(), Refusal> {
        let own = self.time();
        let Some(next) = self.begin(current, step)? else { return Ok(()) };
        let advanced = match &mut self.run.simulation {
            Some(simulation) => simulation.advance(next, &mut Reporter::new(&self.log, next)),
            None => return Err(Refusal::Missing("nothing is calculated yet")),
        };
        advanced.map_err(|error| self.fail(error))?;
        let reached = self.inputs_reached(next - own)?;
        self.keep_inputs(reached);
        Ok(())
    }

    /// Makes everything ready for a step, and says where it ends, s; nothing if it is there already.
    pub(in crate::instance) fn begin(&mut self, current: f64, step: f64) -> Result<Option<f64>, Refusal> {
        let own = self.time();
        // Comparisons that are false for NaN, so that NaN is refused.
        let in_time = (current - own).abs() <= CLOCK_TOLERANCE * own.abs().max(1.0);
        let next = current + step;
        if !(in_time && step > 0.0 && next.is_finite()) {
            return Err(refuse_times(own, current, step));
        }
        let reached = self.inputs_reached((next - own).max(0.0))?;
        if next <= own {
            // A step below the resolution of the clock, from a host whose clock lags by some ulps: it is there already.
            self.keep_inputs(reached);
            return Ok(None);
        }
        if self.run.inputs_changed || self.run.tuned_from.is_some() {
            self.update_simulation()?;
        }
        if let Some(hybrid) = &mut self.run.hybrid {
            hybrid.history.forget_tape();
        }
        if let Some(stop) = self.run.experiment.and_then(|experiment| experiment.stop)
            && next > stop
            && !self.run.past_stop_logged
        {
            self.log_past_stop(next, stop);
        }
        Ok(Some(next))
    }

    /// What the inputs with derivatives are after a step of `length` (s); nothing if all stay as they are.
    pub(in crate::instance) fn inputs_reached(&self, length: f64) -> Result<Option<Inputs>, Refusal> {
        if self.run.input_derivatives.is_empty() {
            return Ok(None);
        }
        let reached = self.run.settings.inputs.continued(&self.run.input_derivatives, length);
        if reached.is_finite() {
            Ok(Some(reached))
        } else {
            let allowed = "a step over which the inputs, with their given derivatives, stay finite";
            Err(Refusal::number("communicationStepSize", length, "s", allowed))
        }
    }

    /// After a step with input derivatives the inputs stay at what they reached.
    pub(in crate::instance) fn keep_inputs(&mut self, reached: Option<Inputs>) {
        if let Some(reached) = reached {
            self.run.settings.inputs = reached;
            self.run.input_derivatives.clear();
            self.run.inputs_changed = true;
        }
    }

    #[cold]
    pub(in crate::instance) fn fail(&mut self, error: crate::engine::EngineError) -> Refusal {
        self.run.phase = Phase::Error;
        Refusal::Step(error)
    }

    /// Hands changed inputs and tunable parameters to the simulation.
    pub(in crate::instance) fn update_simulation(&mut self) -> Result<(), Refusal> {
        let run = &mut self.run;
        let Some(simulation) = &mut run.simulation else { return Ok(()) };
        if let Some(hybrid) = &mut run.hybrid
            && (run.inputs_changed || run.tuned_from.is_some())
        {
            hybrid.before_change(simulation, run.tuned_from.unwrap_or(run.settings.parameters.tunables()));
        }
        let mut updated = Ok(());
        if std::mem::take(&mut run.inputs_changed) {
            updated = simulation.hold(&run.settings.inputs, &run.input_derivatives);
        }
        let retuned = run.tuned_from.take().is_some();
        if retuned && updated.is_ok() {
            updated = simulation.retune(&run.settings.parameters);
        }
        if retuned {
            self.log_ignored_parameters();
        }
        updated.map_err(|error| self.fail(error))
    }

    #[cold]
    fn log_past_stop(&mut self, next: f64, stop: f64) {
        self.run.past_stop_logged = true;
        self.log.solver(format_args!("the step to t = {next} s goes past stopTime = {stop} s; it is computed anyway"));
    }
}

#[cold]
fn refuse_times(own: f64, current: f64, step: f64) -> Refusal {
    if !(step > 0.0 && step.is_finite()) {
        Refusal::number("communicationStepSize", step, "s", "finite and > 0 s")
    } else {
        let allowed = format!("the time reached, {own} s, to within 1e-12 of max(1 s, |t|)");
        Refusal::number("currentCommunicationPoint", current, "s", allowed)
    }
}
