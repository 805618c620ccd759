//! Steps of the solver, and the switchings of contacts within them.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::dynamics::{Dynamics, LARGEST};
use super::path::Path;
use super::solver::{Method, Solver};
use crate::engine::{EngineError, flight::Forcing};
use crate::model::{Cradle, Parameters, SolverMethod, WorkCounters};
use crate::solver::{DoubleDouble, crossing, root};

/// What happens in a contact within a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Kind {
    Onset,
    /// The force is largest.
    Peak,
    Release,
}

/// Its time, and the force there, N; at an onset that right after it.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Event {
    pub time: DoubleDouble,
    pub contact: usize,
    pub kind: Kind,
    pub force: f64,
}

/// The method that the parameters select, if it is not the event-driven one.
pub(crate) fn method(parameters: &Parameters) -> Option<Method> {
    match parameters.method {
        SolverMethod::EventDriven => None,
        SolverMethod::Bdf => Some(Method::Bdf),
        SolverMethod::Adams => Some(Method::Adams),
        SolverMethod::Rk4 => Some(Method::RungeKutta(parameters.fixed_step)),
    }
}

/// The motion up to the end of the solver's last step, independent of communication points.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Trajectory {
    pub dynamics: Dynamics,
    pub solver: Solver,
    /// Which contacts are closed at the end of the last step.
    pub closed: Vec<bool>,
    /// Events of the last step not handled yet, in the order of time.
    pub events: VecDeque<Event>,
}

impl Trajectory {
    /// From the state `y` at `dynamics.since` on.
    pub fn new(method: Method, dynamics: Dynamics, y: &[f64]) -> Self {
        let closed = (0..dynamics.cradle.contacts.len()).map(|i| y[dynamics.overlap(i)] > 0.0).collect();
        let solver = Solver::new(method, &dynamics, dynamics.since, y, WorkCounters::default());
        Self { dynamics, solver, closed, events: VecDeque::new() }
    }

    /// Restarts from the state `y` at `dynamics.since`, on the last step, with other equations.
    pub fn restart(&mut self, dynamics: Dynamics, y: &[f64]) {
        // Later events do not happen like this.
        for event in self.events.drain(..) {
            match event.kind {
                Kind::Onset => self.closed[event.contact] = false,
                Kind::Release => self.closed[event.contact] = true,
                Kind::Peak => {}
            }
        }
        self.solver = Solver::new(self.solver.method, &dynamics, dynamics.since, y, self.solver.work);
        self.dynamics = dynamics;
    }

    /// Restores it from plain data; `None` if it does not fit a run of `cradle` by `method`. Any values pass if it is
    /// `broken`.
    pub fn restored(mut self, method: Method, cradle: Cradle, forcings: Vec<Forcing>, broken: bool) -> Option<Self> {
        (self.dynamics.cradle, self.dynamics.forcings) = (cradle, forcings);
        self.solver = self.solver.restored(method, self.dynamics.components(), broken)?;
        let contacts = self.dynamics.cradle.contacts.len();
        let finite = |event: &Event| event.time.is_sound() && event.force.is_finite();
        let event = |event: &Event| event.contact < contacts && (broken || finite(event));
        let sound =
            self.closed.len() == contacts && (broken || self.dynamics.is_sound()) && self.events.iter().all(event);
        sound.then_some(self)
    }

    pub fn path(&self) -> &Path {
        &self.solver.path
    }

    /// Force in contact `i` at `s` on the last step, N.
    pub fn force(&self, i: usize, s: f64) -> f64 {
        let (overlap, rate) = self.overlap(i, s);
        self.dynamics.cradle.contacts[i].force(overlap, rate)
    }

    /// Overlap (m) of contact `i` and its rate (m/s) at `s` on the last step.
    pub fn overlap(&self, i: usize, s: f64) -> (f64, f64) {
        let (path, v) = (self.path(), self.dynamics.v(i));
        (path.value(self.dynamics.overlap(i), s), path.value(v, s) - path.value(v + 1, s))
    }

    /// Makes a step and finds the events in it; those of the step before must have been taken.
    pub fn step(&mut self) -> Result<(), EngineError> {
        self.solver.step(&self.dynamics)?;
        let dynamic = &self.path().last()[..2 * self.dynamics.balls()];
        if let Some(i) = dynamic.iter().position(|y| y.is_nan() || y.abs() > LARGEST) {
            let ball = i % self.dynamics.balls();
            return Err(EngineError::NotFinite { time: self.path().end.value(), ball });
        }
        for i in 0..self.closed.len() {
            let closes = self.path().last()[self.dynamics.overlap(i)] > 0.0;
            let was_closed = std::mem::replace(&mut self.closed[i], closes);
            if was_closed || closes {
                self.follow_contact(i, was_closed, closes);
            }
        }
        self.events.make_contiguous().sort_by(|a, b| a.time.partial_cmp(&b.time).unwrap_or(std::cmp::Ordering::Equal));
        Ok(())
    }

    /// Finds onset or release of contact `i` and the largest force on the last step.
    fn follow_contact(&mut self, i: usize, was_closed: bool, closes: bool) {
        let (mut from, mut to) = (-1.0, 0.0);
        if was_closed != closes {
            let series = self.dynamics.overlap_series(self.path(), i);
            let sign = if closes { 1.0 } else { -1.0 };
            let s = crossing::first_positive(&series, sign, 0.0, 1.0).unwrap_or(1.0) - 1.0;
            let kind = if closes { Kind::Onset } else { Kind::Release };
            // The damper acts at once.
            let law = &self.dynamics.cradle.contacts[i];
            let force = if closes { law.force(f64::MIN_POSITIVE, self.overlap(i, s).1) } else { 0.0 };
            self.events.push_back(Event { time: self.path().time(s), contact: i, kind, force });
            *(if closes { &mut from } else { &mut to }) = s;
        }
        let slope = |s: f64| self.force_slope(i, s);
        if slope(from) > 0.0 && slope(to) <= 0.0 {
            let s = root::falling_zero(slope, from, to);
            let (time, force) = (self.path().time(s), self.force(i, s));
            self.events.push_back(Event { time, contact: i, kind: Kind::Peak, force });
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
        let (path, v) = (self.path(), self.dynamics.v(i));
        by_overlap * rate + by_rate * (path.rate(v, s) - path.rate(v + 1, s))
    }
}
