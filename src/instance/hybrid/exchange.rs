//! Model exchange of FMI 3.0: states and indicators as arrays, and events that the clocks tell of.
//!
//! Arrays over contacts have one element more than there are contacts: the last impulse is a state that is always zero,
//! the last indicators are always 1.

use super::derivatives::require_length;
use super::steps::Handled;
use crate::instance::legality::{Kind, Phase};
use crate::instance::lifecycle::Instance;
use crate::instance::refusal::Refusal;
use crate::variables::{Array, Causality, Extra};

const STATES: &str = "nContinuousStates";

impl Instance {
    /// Number of continuous states.
    pub fn count_states(&self) -> usize {
        3 * self.balls() + 2
    }

    /// Number of event indicators.
    pub fn count_indicators(&self) -> usize {
        2 * self.balls()
    }

    /// Where the states have the impulse that belongs to no contact.
    fn padding_state(&self) -> usize {
        3 * self.balls() - 1
    }

    /// Where the states have the elements of a variable that can be set now as one of them.
    pub(super) fn place_of_state(&self, array: Array) -> Option<usize> {
        if self.run.phase != Phase::ContinuousTimeMode || array.causality() == Some(Causality::Input) {
            return None;
        }
        let states: Vec<Array> = Array::states().map(|(state, _)| state).collect();
        let place = states.iter().position(|state| *state == array)?;
        Some(states[..place].iter().map(|state| state.len(self.balls())).sum())
    }

    /// Sets the time, s, which cannot go back behind the last event.
    pub fn set_time_of_exchange(&mut self, time: f64) -> Result<(), Refusal> {
        match self.hybrid()?.last_event {
            Some(event) if time < event => {
                Err(Refusal::number("time", time, "s", format!("at least {event} s, the time of the last event")))
            }
            _ => self.set_time(time),
        }
    }

    fn with_padding(&self, length: usize, mut values: Vec<f64>, padding: f64) -> Result<Vec<f64>, Refusal> {
        require_length(STATES, length, self.count_states())?;
        values.insert(self.padding_state(), padding);
        Ok(values)
    }

    /// The states, which must be `length` many.
    pub fn array_states(&mut self, length: usize) -> Result<Vec<f64>, Refusal> {
        let states = self.exchange()?.states().to_vec();
        self.with_padding(length, states, 0.0)
    }

    /// Their derivatives by time.
    pub fn array_derivatives(&mut self, length: usize) -> Result<Vec<f64>, Refusal> {
        let derivatives = self.exchange()?.derivatives();
        self.with_padding(length, derivatives, 0.0)
    }

    /// Their orders of magnitude.
    pub fn array_nominals(&mut self, length: usize) -> Result<Vec<f64>, Refusal> {
        let nominals = self.exchange()?.nominals().to_vec();
        self.with_padding(length, nominals, 1.0)
    }

    /// Sets the states, all of them finite.
    pub fn set_array_states(&mut self, states: &[f64]) -> Result<(), Refusal> {
        require_length(STATES, states.len(), self.count_states())?;
        let mut own = states.to_vec();
        own.remove(self.padding_state());
        self.set_continuous_states(&own)
    }

    /// The event indicators, which must be `length` many: `z.contact`, then `z.clip`.
    pub fn array_indicators(&mut self, length: usize) -> Result<Vec<f64>, Refusal> {
        require_length("nEventIndicators", length, self.count_indicators())?;
        let contacts = self.balls() - 1;
        let mut indicators = self.exchange()?.indicators();
        indicators.insert(contacts, 1.0);
        indicators.push(1.0);
        Ok(indicators)
    }

    /// An element of a variable of model exchange, counted from 0. In co-simulation, which has no events of the host's,
    /// the indicators are 1.
    pub(super) fn exchanged(&mut self, of: Extra, index: usize) -> Result<f64, Refusal> {
        let place = match of {
            Extra::ContactIndicators => index,
            Extra::ClipIndicators => self.balls() + index,
            _ => {
                let variable = Array::Extra(of).element(index, self.balls());
                return variable.map_or(Ok(0.0), |variable| self.real(variable.reference()));
            }
        };
        if self.run.kind == Kind::CoSimulation {
            return Ok(1.0);
        }
        let indicators = self.array_indicators(self.count_indicators())?;
        Ok(indicators.get(place).copied().unwrap_or(1.0))
    }

    /// From integration to events: what is due is handled, and the clocks of the first that has happened are active.
    pub(super) fn enter_events_of_exchange(&mut self) -> Result<(), Refusal> {
        self.run.phase = Phase::EventMode;
        let now = self.time();
        self.hybrid_mut()?.last_event = Some(now);
        self.handle_events()?;
        self.tick();
        Ok(())
    }

    /// The host has taken part in the event of the active clocks, and may have set something that makes another one
    /// due.
    pub(super) fn next_event_of_exchange(&mut self) -> Result<Handled, Refusal> {
        let next = self.handle_events()?;
        let again = self.tick();
        let hybrid = self.hybrid_mut()?;
        let changed = hybrid.changed;
        hybrid.changed &= again;
        Ok(Handled { again, changed, next: next.filter(|_| !again) })
    }

    /// Handles what is due now, and says when the next event is.
    fn handle_events(&mut self) -> Result<Option<f64>, Refusal> {
        let mut pulses = Vec::new();
        let update = self.handle(&mut pulses)?;
        if let (Some(exchange), Some(hybrid)) = (&self.run.exchange, &mut self.run.hybrid) {
            hybrid.ticks.take_down(&pulses, exchange);
            hybrid.changed |= update.changed;
        }
        Ok(update.next)
    }
}
