//! Model exchange: the host integrates the states, and asks for what it needs for that.

use super::report::Reporter;
use crate::engine::{Observer, Progress, Pulse, Update, state_count};
use crate::instance::legality::Phase;
use crate::instance::lifecycle::Instance;
use crate::instance::refusal::Refusal;

impl Instance {
    /// Enters Event Mode.
    pub fn enter_event_mode(&mut self) -> Result<(), Refusal> {
        self.run.phase = Phase::EventMode;
        Ok(())
    }

    /// Enters Continuous-Time Mode.
    pub fn enter_continuous_time_mode(&mut self) -> Result<(), Refusal> {
        self.run.phase = Phase::ContinuousTimeMode;
        Ok(())
    }

    /// Handles what is due now. If it cannot be followed the instance enters the error state.
    pub fn new_discrete_states(&mut self) -> Result<Update, Refusal> {
        self.handle(&mut Vec::new())
    }

    /// The same; `pulses` takes those that have finished.
    pub(in crate::instance) fn handle(&mut self, pulses: &mut Vec<Pulse>) -> Result<Update, Refusal> {
        self.exchange()?;
        let Some(exchange) = &mut self.run.exchange else { return Err(Refusal::Missing("nothing is calculated yet")) };
        let updated = exchange.update(&mut Both { reporter: Reporter::new(&self.log, exchange.time()), pulses });
        updated.map_err(|error| {
            self.run.phase = Phase::Error;
            Refusal::Step(error)
        })
    }

    /// The end of a step of the host's solver: whether an event is due.
    pub fn completed_integrator_step(&mut self) -> Result<bool, Refusal> {
        Ok(self.exchange()?.complete_step())
    }

    /// Sets the time, s, which must be finite and not before the start.
    pub fn set_time(&mut self, time: f64) -> Result<(), Refusal> {
        let start = self.run.experiment.unwrap_or_default().start;
        if !(time.is_finite() && time >= start) {
            return Err(Refusal::number("time", time, "s", format!("finite and at least startTime = {start} s")));
        }
        self.exchange()?.set_time(time);
        Ok(())
    }

    /// Sets the continuous states, of which there must be as many as there are, all finite.
    pub fn set_continuous_states(&mut self, states: &[f64]) -> Result<(), Refusal> {
        self.require_length("nx", states.len(), self.states())?;
        if let Some(i) = states.iter().position(|state| !state.is_finite()) {
            return Err(Refusal::Argument {
                name: "x",
                value: format!("{} in place {i}", states[i]),
                allowed: "finite values".to_owned(),
            });
        }
        self.exchange()?.set_states(states);
        Ok(())
    }

    /// The continuous states, which must be `length` many.
    pub fn continuous_states(&mut self, length: usize) -> Result<Vec<f64>, Refusal> {
        self.require_length("nx", length, self.states())?;
        Ok(self.exchange()?.states().to_vec())
    }

    /// Their derivatives by time.
    pub fn state_derivatives(&mut self, length: usize) -> Result<Vec<f64>, Refusal> {
        self.require_length("nx", length, self.states())?;
        Ok(self.exchange()?.derivatives())
    }

    /// Their orders of magnitude.
    pub fn nominals(&mut self, length: usize) -> Result<Vec<f64>, Refusal> {
        self.require_length("nx", length, self.states())?;
        Ok(self.exchange()?.nominals().to_vec())
    }

    /// The event indicators, which must be `length` many.
    pub fn event_indicators(&mut self, length: usize) -> Result<Vec<f64>, Refusal> {
        self.require_length("ni", length, 2 * (self.balls() - 1))?;
        Ok(self.exchange()?.indicators())
    }

    pub(super) fn states(&self) -> usize {
        state_count(self.balls())
    }

    fn require_length(&self, name: &'static str, length: usize, allowed: usize) -> Result<(), Refusal> {
        if length == allowed {
            return Ok(());
        }
        Err(Refusal::Argument { name, value: length.to_string(), allowed: allowed.to_string() })
    }
}

/// Logs pulses and keeps them.
struct Both<'a> {
    reporter: Reporter<'a>,
    pulses: &'a mut Vec<Pulse>,
}

impl Observer for Both<'_> {
    fn pulse(&mut self, pulse: Pulse) {
        self.reporter.pulse(pulse);
        self.pulses.push(pulse);
    }

    fn progress(&mut self, progress: Progress) {
        self.reporter.progress(progress);
    }
}
