//! The solution with its history, step by step, and the switchings of contacts within the steps.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::corrector::MAX_ORDER;
use super::dynamics::Dynamics;
use super::path::NordsieckStep;
use crate::engine::{EngineError, flight::Forcing};
use crate::model::{Cradle, SolverMethod, WorkCounters};
use crate::solver::{DoubleDouble, crossing, root};

/// Longest step of the general-purpose solvers, s.
pub(super) const LONGEST_STEP: f64 = 1e3;
/// Largest ratio of the second step to the first one, which is a guess.
const FIRST_GROWTH: f64 = 1e4;

/// What happens in a contact within a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum ContactEvent {
    Onset,
    /// The force is largest.
    Peak,
    Release,
}

/// A contact event with its time, and the force then, N; for an onset, the force right after it.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Event {
    pub time: DoubleDouble,
    pub contact: usize,
    pub kind: ContactEvent,
    pub force: f64,
}

impl Event {
    fn is_sound(&self) -> bool {
        self.time.is_sound() && self.force.is_finite()
    }
}

/// Highest degree of the polynomials over a step; for multistep methods, their highest order.
pub(super) fn max_degree(method: SolverMethod) -> usize {
    match method {
        SolverMethod::Adams => MAX_ORDER,
        SolverMethod::Bdf => 5,
        SolverMethod::Rk4 | SolverMethod::EventDriven => 3,
    }
}

/// Degree for which polynomials have room: a multistep method also tries the order above.
fn room(method: SolverMethod) -> usize {
    max_degree(method) + usize::from(method != SolverMethod::Rk4)
}

/// Whether double-doubles resolve steps of `step` (s) at the time `t`.
pub(super) fn resolved(t: DoubleDouble, step: f64) -> bool {
    step > 1e-32 * t.value().abs().max(1.0)
}

/// The motion up to the end of the last step, independent of communication points.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Trajectory {
    pub dynamics: Dynamics,
    /// Adams-Moulton of orders 1 to 12, by fixed-point iteration; for stiff motions backward differentiation of orders
    /// 1 to 5, by Newton's method; or the classical Runge-Kutta formula.
    pub method: SolverMethod,
    /// Step of the Runge-Kutta formula, s.
    pub fixed_step: f64,
    pub path: NordsieckStep,
    /// The step that is being tried.
    #[serde(skip)]
    pub(super) trial: NordsieckStep,
    /// Lengths of the last steps, s, the latest first.
    pub(super) steps: [f64; MAX_ORDER + 1],
    /// Order of the next step and its length, s.
    pub(super) order: usize,
    pub(super) step: f64,
    /// Steps until another order is considered.
    pub(super) wait: usize,
    /// Largest growth of the next step.
    pub(super) growth: f64,
    /// Correction `e` of the last step; that of the step before, and its spread, if they are stored.
    pub(super) correction: Vec<f64>,
    pub(super) kept: Vec<f64>,
    pub(super) kept_spread: Option<f64>,
    /// Working memory for states and rates.
    #[serde(skip)]
    pub(super) state: Vec<f64>,
    #[serde(skip)]
    pub(super) rates: Vec<f64>,
    pub work: WorkCounters,
    /// Which contacts are closed at the end of the last step.
    pub closed: Vec<bool>,
    /// Events of the last step not handled yet, in the order of time.
    pub events: VecDeque<Event>,
}

impl Trajectory {
    /// A trajectory from the state `y` at `dynamics.since` on, after this `work`. Unless the method has a fixed step
    /// (s), the first step has order 1 and changes the state by no more than the allowed error.
    pub fn new(method: SolverMethod, fixed_step: f64, dynamics: Dynamics, y: &[f64], work: WorkCounters) -> Self {
        let (since, path) = (dynamics.since, NordsieckStep::resting(dynamics.since, y, room(method)));
        let closed = (0..dynamics.cradle.contacts.len()).map(|i| y[dynamics.overlap(i)] > 0.0).collect();
        let mut trajectory = Self {
            dynamics,
            method,
            fixed_step,
            trial: path.clone(),
            path,
            steps: [0.0; MAX_ORDER + 1],
            order: 1,
            step: 0.0,
            wait: 2,
            growth: FIRST_GROWTH,
            correction: vec![0.0; y.len()],
            kept: vec![0.0; y.len()],
            kept_spread: None,
            state: y.to_vec(),
            rates: vec![0.0; y.len()],
            work,
            closed,
            events: VecDeque::new(),
        };
        trajectory.evaluate(since);
        let pace = trajectory.dynamics.size(&trajectory.state, &trajectory.rates);
        trajectory.step = match method {
            SolverMethod::Rk4 => fixed_step,
            _ if pace > 0.0 => (1.0 / pace).min(LONGEST_STEP),
            _ => 1.0,
        };
        (trajectory.path.step, trajectory.path.degree) = (trajectory.step, 1);
        trajectory.set_slope(trajectory.step);
        trajectory
    }

    /// Restarts from the state `y` at `dynamics.since`, a time on the last step, with other equations.
    pub fn restart(&mut self, dynamics: Dynamics, y: &[f64]) {
        // Later events will not happen as found.
        for event in self.events.drain(..) {
            match event.kind {
                ContactEvent::Onset => self.closed[event.contact] = false,
                ContactEvent::Release => self.closed[event.contact] = true,
                ContactEvent::Peak => {}
            }
        }
        let closed = std::mem::take(&mut self.closed);
        *self = Self { closed, ..Self::new(self.method, self.fixed_step, dynamics, y, self.work) };
    }

    /// Completes a saved trajectory; `None` if it does not fit a run of `cradle` by its method. If it is `broken`, any
    /// values pass.
    pub fn restored(mut self, cradle: Cradle, forcings: Vec<Forcing>, broken: bool) -> Option<Self> {
        (self.dynamics.cradle, self.dynamics.forcings) = (cradle, forcings);
        let (size, contacts) = (4 * self.dynamics.balls() + 1, self.dynamics.cradle.contacts.len());
        let lengths = self.steps.iter().all(|step| *step >= 0.0 && step.is_finite());
        let next = self.step > 0.0 && self.growth >= 1.0 && self.step.max(self.growth).is_finite();
        let kept = self.correction.iter().chain(&self.kept).chain(&self.kept_spread).all(|value| value.is_finite());
        let event = |event: &Event| event.contact < contacts && (broken || event.is_sound());
        let orders = 1..=max_degree(self.method);
        let sound = self.path.is_sound(size, room(self.method), broken)
            && [self.correction.len(), self.kept.len()] == [size; 2]
            && orders.contains(&self.order)
            && orders.contains(&self.path.degree)
            && (1..=MAX_ORDER + 2).contains(&self.wait)
            && (broken || (self.dynamics.is_sound() && self.path.step > 0.0 && lengths && next && kept))
            && self.closed.len() == contacts
            && self.events.iter().all(event);
        let (trial, none) = (self.path.clone(), vec![0.0; size]);
        sound.then_some(Self { trial, state: none.clone(), rates: none, ..self })
    }

    pub(super) fn evaluate(&mut self, t: DoubleDouble) {
        self.dynamics.rates(t, &self.state, &mut self.rates);
        self.work.evaluations = self.work.evaluations.saturating_add(1);
    }

    /// Sets the slope of the path at its end from the last rates, for steps of this length (s).
    pub(super) fn set_slope(&mut self, step: f64) {
        self.path.column_mut(1).iter_mut().zip(&self.rates).for_each(|(c, rate)| *c = step * rate);
    }

    /// Force in contact `i` at `s` on the last step, N.
    pub fn force(&self, i: usize, s: f64) -> f64 {
        let (overlap, rate) = self.overlap(i, s);
        self.dynamics.cradle.contacts[i].force(overlap, rate)
    }

    /// Overlap (m) of contact `i` and its rate (m/s) at `s` on the last step.
    pub fn overlap(&self, i: usize, s: f64) -> (f64, f64) {
        let (path, v) = (&self.path, self.dynamics.v(i));
        (path.value(self.dynamics.overlap(i), s), path.value(v, s) - path.value(v + 1, s))
    }

    /// Makes a step, if double-doubles resolve it, and finds its events. The events of the step before must have been
    /// taken.
    pub fn advance(&mut self) -> Result<(), EngineError> {
        if self.method == SolverMethod::Rk4 { self.runge_kutta() } else { self.multistep() }?;
        self.work.steps = self.work.steps.saturating_add(1);
        if let Some(component) = self.dynamics.beyond_range(&self.path.last()[..2 * self.dynamics.balls()]) {
            return Err(self.dynamics.lost(component, self.path.end));
        }
        for i in 0..self.closed.len() {
            let closes = self.path.last()[self.dynamics.overlap(i)] > 0.0;
            let was_closed = std::mem::replace(&mut self.closed[i], closes);
            if was_closed || closes {
                self.follow_contact(i, was_closed, closes);
            }
        }
        self.events.make_contiguous().sort_by(|a, b| a.time.partial_cmp(&b.time).unwrap_or(std::cmp::Ordering::Equal));
        Ok(())
    }

    /// Fails if anything of the last step has left the range of doubles.
    pub fn check_finite(&self) -> Result<(), EngineError> {
        let columns = (0..=self.path.degree).map(|j| self.path.column(j)).chain([&self.correction[..], &self.kept]);
        let lost = columns.filter_map(|column| column.iter().position(|y| !y.is_finite())).next();
        if let Some(&Event { time, contact, .. }) = self.events.iter().find(|event| !event.is_sound()) {
            return Err(EngineError::ContactNotFinite { time: time.value(), contact });
        }
        lost.map_or(Ok(()), |component| Err(self.dynamics.lost(component, self.path.end)))
    }

    /// Finds onset or release of contact `i` and the largest force on the last step.
    fn follow_contact(&mut self, i: usize, was_closed: bool, closes: bool) {
        let (mut from, mut to) = (-1.0, 0.0);
        if was_closed != closes {
            let series = self.dynamics.overlap_series(&self.path, i);
            let sign = if closes { 1.0 } else { -1.0 };
            let s = crossing::first_positive(&series, sign, 0.0, 1.0).unwrap_or(1.0) - 1.0;
            let kind = if closes { ContactEvent::Onset } else { ContactEvent::Release };
            // A damper acts at once.
            let law = &self.dynamics.cradle.contacts[i];
            let force = if closes { law.force(f64::MIN_POSITIVE, self.overlap(i, s).1) } else { 0.0 };
            self.events.push_back(Event { time: self.path.time(s), contact: i, kind, force });
            *(if closes { &mut from } else { &mut to }) = s;
        }
        let slope = |s: f64| self.force_slope(i, s);
        if slope(from) > 0.0 && slope(to) <= 0.0 {
            let s = root::falling_zero(slope, from, to);
            let (time, force) = (self.path.time(s), self.force(i, s));
            self.events.push_back(Event { time, contact: i, kind: ContactEvent::Peak, force });
        }
    }

    /// Derivative of the force in contact `i` by time at `s`, N/s.
    fn force_slope(&self, i: usize, s: f64) -> f64 {
        let (overlap, rate) = self.overlap(i, s);
        let law = &self.dynamics.cradle.contacts[i];
        let (by_overlap, by_rate) = law.force_slopes(overlap.max(f64::MIN_POSITIVE), rate);
        if by_rate == 0.0 {
            return by_overlap * rate;
        }
        let (path, v) = (&self.path, self.dynamics.v(i));
        by_overlap * rate + by_rate * (path.rate(v, s) - path.rate(v + 1, s))
    }
}
