//! Model exchange: the host integrates the states.
//!
//! For hosts of FMI 3.0, arrays over contacts have one element more than there are contacts: the last impulse is a
//! state that is always zero, and the last indicators are always 1. Clocks tell such hosts of events.

use super::legality::{Kind, Phase};
use super::lifecycle::Instance;
use super::step::Handled;
use crate::engine::state_count;
use crate::variables::{Extra, Number, Refusal, ensure};

/// Values for the host, and a refusal if one of them is not finite or a ball has no place. The host gets the values
/// even so: one that ignores the status should see NaN there, and not values of an earlier state.
type Found = (Vec<f64>, Result<(), Refusal>);

impl Instance {
    pub fn count_states(&self) -> usize {
        state_count(self.balls()) + usize::from(!self.start.scalars)
    }

    pub fn count_indicators(&self) -> usize {
        2 * (self.balls() - 1) + 2 * usize::from(!self.start.scalars)
    }

    /// Index among the states of the impulse that belongs to no contact, where variables are arrays.
    fn padding_state(&self) -> usize {
        3 * self.balls() - 1
    }

    /// Ends a step of the host's solver. Returns whether an event is due.
    pub fn completed_integrator_step(&mut self) -> Result<bool, Refusal> {
        let exchange = self.exchange()?;
        let due = exchange.complete_step();
        let checked = exchange.check_finite();
        checked.map(|()| due).map_err(|error| self.fail(error))
    }

    /// Sets the time, s, which must be finite and not before the start; with clocks it cannot go back behind the last
    /// event.
    pub fn set_time(&mut self, time: f64) -> Result<(), Refusal> {
        if let Some(event) = self.run.last_event.filter(|event| time < *event) {
            let allowed = format_args!("at least {} s, the time of the last event", Number(event));
            return Err(Refusal::number("time", time, "s", allowed));
        }
        let start = self.run.start_time();
        let allowed = format_args!("finite and at least startTime = {} s", Number(start));
        ensure(time.is_finite() && time >= start, || Refusal::number("time", time, "s", allowed))?;
        self.exchange()?.time = time;
        Ok(())
    }

    /// Sets the continuous states, [`Self::count_states`] many, all finite.
    pub fn set_continuous_states(&mut self, states: &[f64]) -> Result<(), Refusal> {
        if let Some(i) = states.iter().position(|state| !state.is_finite()) {
            return Err(Refusal::argument("x", format_args!("{} in place {i}", states[i]), "finite values"));
        }
        let mut own = states.to_vec();
        if !self.start.scalars {
            own.remove(self.padding_state());
        }
        self.exchange()?.set_states(&own);
        Ok(())
    }

    /// The values, with `padding` inserted at the places of elements that belong to no contact.
    fn padded(&self, mut values: Vec<f64>, places: &[usize], padding: f64) -> Vec<f64> {
        if !self.start.scalars {
            places.iter().for_each(|place| values.insert(*place, padding));
        }
        values
    }

    pub fn continuous_states(&mut self) -> Result<Vec<f64>, Refusal> {
        let states = self.exchange()?.states().to_vec();
        Ok(self.padded(states, &[self.padding_state()], 0.0))
    }

    pub fn state_derivatives(&mut self) -> Result<Found, Refusal> {
        let derivatives = self.exchange()?.derivatives();
        Ok(self.checked("the derivative of state", self.padded(derivatives, &[self.padding_state()], 0.0)))
    }

    pub fn nominals(&mut self) -> Result<Vec<f64>, Refusal> {
        let nominals = self.exchange()?.nominals().to_vec();
        Ok(self.padded(nominals, &[self.padding_state()], 1.0))
    }

    /// The event indicators: of all contacts, then of their laws.
    pub fn event_indicators(&mut self) -> Result<Found, Refusal> {
        let (balls, indicators) = (self.balls(), self.exchange()?.indicators());
        Ok(self.checked("event indicator", self.padded(indicators, &[balls - 1, 2 * balls - 1], 1.0)))
    }

    fn checked(&self, name: &str, values: Vec<f64>) -> Found {
        let exist = self.require_numbers(name, 0, &values);
        (values, exist)
    }

    /// An element of `z.contact` or `z.clip`, counted from 0. In co-simulation all are 1.
    pub(super) fn indicator(&mut self, of: Extra, index: usize) -> Result<f64, Refusal> {
        if self.run.purpose.kind == Kind::CoSimulation || index + 1 == self.balls() {
            return Ok(1.0);
        }
        let exchange = self.exchange()?;
        let of_contact = of == Extra::ContactIndicator;
        let found = if of_contact { exchange.contact_indicator(index) } else { exchange.clip_indicator(index) };
        self.require_numbers(if of_contact { "z.contact" } else { "z.clip" }, index, &[found])?;
        Ok(found)
    }

    /// Goes from integration to events. With clocks, handles all that is due and activates the clocks of the first
    /// event.
    pub(super) fn enter_events_of_exchange(&mut self) -> Result<(), Refusal> {
        self.run.phase = Phase::EventMode;
        if self.run.purpose.events {
            self.run.last_event = Some(self.time());
            self.handle_events()?;
            self.tick();
        }
        Ok(())
    }

    /// Handles what is due and, with clocks, activates the clocks of the next pending event.
    pub(super) fn next_event_of_exchange(&mut self) -> Result<Handled, Refusal> {
        let next = self.handle_events()?;
        let again = self.run.purpose.events && self.tick();
        let changed = self.run.states_changed;
        self.run.states_changed &= again;
        Ok(Handled { again, changed, next: next.filter(|_| !again) })
    }

    /// Handles what is due now. Returns when the next event is. On failure the instance enters the error state.
    fn handle_events(&mut self) -> Result<Option<f64>, Refusal> {
        let mut pulses = Vec::new();
        let updated = self.exchange()?.update(&mut pulses);
        pulses.iter().for_each(|pulse| self.log.pulse(*pulse));
        let update = updated.map_err(|error| self.fail(error))?;
        self.run.states_changed |= update.changed;
        if let Some(exchange) = self.run.exchange.as_ref().filter(|_| self.run.purpose.events) {
            self.run.clocks.catch_up(&pulses, exchange);
        }
        Ok(update.next)
    }
}
