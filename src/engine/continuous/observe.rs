//! The results at the current time, with the meanings that [`Engine`](crate::engine::Engine) gives them.

use super::run::Continuous;
use super::trajectory::{ContactEvent, Trajectory};
use crate::engine::Forecast;
use crate::engine::chain_state::ChainState;
use crate::engine::derivatives::{StepEnds, by_time};
use crate::engine::pair_impact::ImpactCoefficients;
use crate::model::{Chain, ContactLaw, Cradle, Differential, Mode, ONSET_PERIODS, Record, Results, WorkCounters};
use crate::solver::DoubleDouble;

/// Most steps times balls in one look for the next onset: a few milliseconds.
const LOOK_AHEAD: usize = 20_000;

impl Continuous {
    /// The current time as a place on the solver's last step.
    fn place(&self) -> f64 {
        self.trajectory.path.place(self.now())
    }

    pub(super) fn value(&self, component: usize) -> f64 {
        self.trajectory.path.value(component, self.place())
    }

    /// The state of the equations at the current time.
    pub(super) fn y(&self) -> Vec<f64> {
        self.trajectory.path.state(self.place())
    }

    /// The whole chain in the state `y` of the equations.
    fn chain(&self, y: &[f64]) -> ChainState {
        let n = self.cradle().balls.len();
        let contact = |(i, law): (usize, &ContactLaw)| match y[2 * n + i] {
            overlap if overlap > 0.0 => (overlap, law.mode_when_closed(overlap, y[n + i] - y[n + i + 1])),
            overlap => (overlap, Mode::Open),
        };
        let balls = y[..n].iter().copied().zip(y[n..2 * n].iter().copied());
        ChainState::new(balls, self.cradle().contacts.iter().enumerate().map(contact))
    }

    pub(crate) fn step_ends(&self) -> StepEnds {
        let [start, end] = [&self.y_at_step, &self.y()].map(|y| self.chain(y));
        let (inputs, impacts) = (self.inputs.at(self.time), ImpactCoefficients::of(self.cradle()));
        StepEnds { start, end, began: self.step_start, inputs, impacts }
    }

    /// See [`by_time`]. The polynomials of the steps have too low an order for overlaps: the second and third
    /// derivatives of a force at rest are rounding and solver error.
    pub(crate) fn time_derivative(&self, order: usize) -> Differential {
        by_time(self.cradle(), self.chain(&self.y()), &self.inputs.at(self.time), order)
    }

    /// Time of the next onset or release, s, if it is on the solver's steps so far or, in flight, on those ahead.
    pub fn next_event(&self) -> Option<f64> {
        let known = self.trajectory.events.iter().find(|event| event.kind != ContactEvent::Peak);
        let in_flight = || self.trajectory.closed.iter().all(|closed| !closed);
        let next = match known {
            Some(event) => Some(event.time.value_up()),
            None => self.next_onset().found().filter(|_| in_flight()),
        };
        next.filter(|next| *next > self.time)
    }

    /// The first onset beyond the last step; never if there is none within 1000 periods of the first ball. If a fixed
    /// number of steps does not reach it, the time reached; the next look continues there.
    fn look_ahead(&self, now: DoubleDouble) -> Forecast {
        let limit = now + ONSET_PERIODS * self.cradle().period();
        let mut known = self.ahead.borrow_mut();
        if known.as_ref().is_some_and(|ahead| ahead.path.end < self.trajectory.path.end) {
            *known = None;
        }
        let ahead = known.get_or_insert_with(|| Box::new(self.trajectory.clone()));
        let mut work = 0;
        let found = loop {
            if let Some(onset) = onset_after(ahead, now) {
                break if DoubleDouble::from(onset) <= limit { Forecast::At(onset) } else { Forecast::Never };
            }
            let reached = ahead.path.end;
            if reached > limit {
                break Forecast::Never;
            }
            ahead.events.clear();
            if work >= LOOK_AHEAD || ahead.advance().is_err() {
                break Forecast::not_before(reached.value_down(), self.time);
            }
            work += self.ledgers.len() + 1;
        };
        // A copy that has left the range of doubles is no state to save.
        known.take_if(|ahead| ahead.check_finite().is_err());
        found
    }
}

impl Chain for Continuous {
    fn cradle(&self) -> &Cradle {
        &self.trajectory.dynamics.cradle
    }

    fn state_of(&self, i: usize) -> (f64, f64) {
        (self.value(i), self.value(self.trajectory.dynamics.v(i)))
    }

    fn overlap(&self, i: usize) -> f64 {
        self.trajectory.overlap(i, self.place()).0
    }

    fn force(&self, i: usize) -> f64 {
        self.trajectory.force(i, self.place())
    }

    fn forcing_of(&self, i: usize) -> f64 {
        self.trajectory.dynamics.forcing(i, self.now())
    }
}

impl Results for Continuous {
    fn step_length(&self) -> f64 {
        self.time - self.step_start
    }

    fn support_impulse_of_step(&self) -> f64 {
        let [.., support] = self.trajectory.dynamics.sums();
        self.value(support) - self.y_at_step[support]
    }

    fn impulse_of_step(&self, i: usize) -> f64 {
        self.impulse(i) - self.y_at_step[self.trajectory.dynamics.impulse(i)]
    }

    fn impulse(&self, i: usize) -> f64 {
        self.value(self.trajectory.dynamics.impulse(i))
    }

    fn force_peak(&self, i: usize) -> f64 {
        let before = self.ledgers[i].peak_in_step(self.step);
        if self.step_length() > 0.0 && self.entered == self.time { before } else { before.max(self.force(i)) }
    }

    fn record(&self, i: usize) -> Record {
        self.ledgers[i].record
    }

    fn energy_at_start(&self) -> f64 {
        self.energy_at_start
    }

    fn dissipated_energy(&self) -> f64 {
        self.value(self.trajectory.dynamics.sums()[0])
    }

    fn external_work(&self) -> f64 {
        self.value(self.trajectory.dynamics.sums()[1])
    }

    fn next_onset(&self) -> Forecast {
        let now = self.now();
        if self.ledgers.is_empty() {
            return Forecast::Never;
        }
        if let Some(onset) = onset_after(&self.trajectory, now) {
            return Forecast::At(onset);
        }
        if let Some((asked_at, answer)) = self.foreseen.get()
            && asked_at == self.time
        {
            return answer;
        }
        let answer = self.look_ahead(now);
        self.foreseen.set(Some((self.time, answer)));
        answer
    }

    fn work(&self) -> WorkCounters {
        self.trajectory.work
    }
}

/// The first onset in the last step of `trajectory` after the time `now`, s.
fn onset_after(trajectory: &Trajectory, now: DoubleDouble) -> Option<f64> {
    let onset = trajectory.events.iter().find(|event| event.kind == ContactEvent::Onset && event.time > now)?;
    Some(onset.time.value_up())
}
