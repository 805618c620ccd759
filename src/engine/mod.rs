//! Drives a run: flight, collision phases, events and the ledger of pulses.
//!
//! - A ball that touches nothing is in *flight*: a closed form of its state at its anchor (`ball`).
//! - Two neighbours in flight have a forecast of their next onset (`separation`); the earliest event is on top of a queue.
//! - Two elastic balls that nothing else touches have an *impact* of known outcome (`pair`, `impact`).
//! - Other balls that touch form a *cluster*, followed from switching to switching (`cluster`, `window`): by Taylor series
//!   (`taylor`); where the contacts are linear, and damped or closed for a while, by natural modes (`modes`, `natural`); other
//!   contacts that stay closed by implicit collocation (`collocation`).
//! - Onsets and releases form, merge, split and dissolve clusters (`events`).
//! - Rigid contacts are instantaneous impacts (`restitution`); those that last make one body of their balls (`bond`, `rigid`).
//!
//! Events happen at their own times, never at communication points: between changes of the inputs the trajectory is the same,
//! bit for bit, however a host cuts its steps. What a host asks for at a communication point is evaluated there
//! (`observe`; the next onset: `ahead`) and moves nothing. A run can be put down as plain data and taken up again (`snapshot`).
//!
//! The methods that integrate the whole chain over all time are apart from all this (`continuous`); a `Simulation` is a run by any.

mod ahead;
mod ball;
mod bond;
mod cluster;
mod collocation;
mod continuous;
mod differential;
mod error;
mod events;
mod expansion;
mod impact;
mod inside;
mod last_step;
mod ledger;
mod modes;
mod natural;
mod observe;
mod observer;
mod pace;
mod pair;
mod restitution;
mod rigid;
mod sensitivity;
mod separation;
mod simulation;
mod snapshot;
mod step_start;
mod taylor;
mod window;

use serde::{Deserialize, Serialize};

use crate::model::{Cradle, Inputs, Parameters};
use crate::solver::double_double::DoubleDouble;
use crate::solver::oscillator::MAX_FORCE_ORDER;
use crate::solver::queue::EventQueue;
use ahead::Ahead;
use ball::{Ball, Flight, Push};
use bond::Bond;
use cluster::Cluster;
pub use continuous::Continuous;
pub use cradle_interface::results::{
    Differential, MAX_INPUT_DERIVATIVE, MAX_OUTPUT_DERIVATIVE, NEVER, NextOnset, Results, Work,
};
use error::Endurance;
pub use error::EngineError;
use ledger::Ledger;
pub use observer::{Observer, Progress, Unrecorded};
use pair::{PairImpact, Shape};
use rigid::Keep;
pub use sensitivity::NotFollowed;
use separation::Separation;
pub use simulation::{Simulation, SimulationSnapshot};
pub use snapshot::{Snapshot, Unsound};
use step_start::ContactStart;
use taylor::Control;
use window::Mode;

// The inputs are polynomials of the degree that the closed forms take.
const _: () = assert!(MAX_INPUT_DERIVATIVE == MAX_FORCE_ORDER);

/// Counts stay far below this, 2^62: nothing happens so often.
const LARGEST_COUNT: u64 = 1 << 62;

/// One finished contact pulse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// Index of the contact, from 0.
    pub contact: usize,
    /// When the contact closed, s.
    pub onset: f64,
    /// When it opened again, s.
    pub release: f64,
    /// Largest contact force, N.
    pub peak: f64,
    /// Integral of the contact force, N.s.
    pub impulse: f64,
}

/// A contact of the cradle: its ledger, and how it stands.
#[derive(Clone, Debug)]
struct Contact {
    ledger: Ledger,
    /// The cluster whose window it belongs to.
    cluster: Option<u32>,
    /// The impact of known outcome that is under way in it.
    impact: Option<PairImpact>,
    /// What holds its balls together while it lasts, if it is rigid.
    bond: Option<Bond>,
    /// Its motion while it is open and both balls are in flight.
    separation: Option<Separation>,
    /// Whether its entry in the event queue is an onset or the end of a bond, or only the end of what has been looked at.
    due: bool,
    /// Segments that its cluster has been followed for, while clusters are taken apart and formed anew.
    age: u32,
    /// Whether it waits, open, for the end of an impact beside it.
    waits: bool,
    /// Overlap (m) and mode while clusters are taken apart and formed anew. While it waits: the overlap between where its balls
    /// are at their anchors, which differ.
    overlap: f64,
    mode: Mode,
    /// How it stood at the start of a step, and of which.
    at_start: ContactStart,
}

/// The inputs that act: polynomials of the time.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct HeldInputs {
    /// Time that the values and derivatives refer to, s.
    since: f64,
    values: Inputs,
    /// From the first on; those beyond are zero.
    derivatives: Vec<Inputs>,
}

impl HeldInputs {
    /// The values and their derivatives, order by order.
    fn orders(&self) -> impl Iterator<Item = &Inputs> {
        std::iter::once(&self.values).chain(&self.derivatives)
    }

    /// Whether they are those of `balls` balls.
    fn fit(&self, balls: usize) -> bool {
        self.derivatives.len() <= MAX_INPUT_DERIVATIVE && self.orders().all(|inputs| inputs.force.len() == balls)
    }

    /// Whether all of them are finite.
    fn are_finite(&self) -> bool {
        self.orders().all(Inputs::is_finite)
    }

    /// Acceleration of ball `i` by them, with its derivatives.
    fn push(&self, i: usize, mass: f64) -> Push {
        let mut push = Push::default();
        for (push, inputs) in push.iter_mut().zip(self.orders()) {
            *push = inputs.force[i] / mass - inputs.support_acceleration;
        }
        push
    }

    /// The same inputs seen from the time `t` (s).
    fn at(&self, t: f64) -> Self {
        let tau = t - self.since;
        let later = |k: usize| self.derivatives[k].continued(&self.derivatives[k + 1..], tau);
        let values = self.values.continued(&self.derivatives, tau);
        Self { since: t, values, derivatives: (0..self.derivatives.len()).map(later).collect() }
    }

    /// Coefficients of the power series of one of them.
    fn series(&self, input: impl Fn(&Inputs) -> f64) -> [f64; MAX_FORCE_ORDER + 1] {
        let mut series = [0.0; MAX_FORCE_ORDER + 1];
        let mut factorial = 1.0;
        for (k, (c, inputs)) in series.iter_mut().zip(self.orders()).enumerate() {
            factorial *= k.max(1) as f64;
            *c = input(inputs) / factorial;
        }
        series
    }
}

/// A cradle and its trajectory up to the current time.
#[derive(Clone, Debug)]
pub struct Engine {
    cradle: Cradle,
    inputs: HeldInputs,
    control: Control,
    shape: Shape,
    time: f64,
    balls: Vec<Ball>,
    contacts: Vec<Contact>,
    clusters: Vec<Option<Cluster>>,
    queue: EventQueue,
    /// Number of the current step; 0 before the first.
    step: u64,
    /// When it began, s, and the balls that have moved off their closed forms since.
    step_start: f64,
    moved: Vec<u32>,
    contact_loss: f64,
    energy_at_start: f64,
    work: Work,
    ahead: Ahead,
    /// Entries of the queue handled so far, and onsets among what came of them.
    handled: u64,
    onsets: u64,
    /// Work so far, in units of about a tenth of a microsecond: what bounds a look ahead.
    effort: u64,
    /// Time of the last event and how many came without any progress of time.
    last_event: DoubleDouble,
    standstill: usize,
    /// The run has yet to begin, see [`Self::hold_back`].
    initializing: bool,
}

impl Engine {
    /// Starts a run at `start_time` (s) with the start values of `parameters`, whose values are in their ranges.
    pub fn new(parameters: &Parameters, inputs: &Inputs, start_time: f64) -> Result<Self, EngineError> {
        let inputs = HeldInputs { since: start_time, values: inputs.clone(), derivatives: Vec::new() };
        let mut engine = Self::apart(parameters, inputs, start_time);
        let start = DoubleDouble::from(start_time);
        if engine.is_rigid() {
            engine.touch_where_close()?;
            engine.settle(0..engine.contacts.len(), start, Keep::Nothing, &mut Unrecorded);
        } else {
            engine.close_where_overlapping(start);
            engine.form(0..engine.contacts.len(), start);
        }
        engine.check_finite(0..engine.balls.len())?;
        engine.energy_at_start = engine.total_energy();
        if !engine.energy_at_start.is_finite() {
            return Err(EngineError::EnergyNotFinite { time: start_time });
        }
        Ok(engine)
    }

    /// All balls in flight from the start values, their contacts not looked at yet.
    fn apart(parameters: &Parameters, inputs: HeldInputs, start_time: f64) -> Self {
        let cradle = Cradle::new(parameters);
        let start = DoubleDouble::from(start_time);
        let state = parameters.x_start.iter().zip(&parameters.v_start).enumerate();
        let balls = state
            .zip(&cradle.balls)
            .map(|((i, (&x, &v)), model)| Ball::new(model, start, Flight { x, v, push: inputs.push(i, model.mass) }));
        let balls: Vec<Ball> = balls.collect();
        let contacts = vec![
            Contact {
                ledger: Ledger::default(),
                cluster: None,
                impact: None,
                bond: None,
                separation: None,
                due: false,
                waits: false,
                age: 0,
                overlap: 0.0,
                mode: Mode::Open,
                at_start: ContactStart::default(),
            };
            cradle.contacts.len()
        ];
        Self {
            queue: EventQueue::new(contacts.len()),
            inputs,
            control: Control::new(parameters.tolerance),
            shape: Shape::new(cradle.contacts.first().map_or(1.0, |law| law.exponent)),
            time: start_time,
            balls,
            contacts,
            clusters: Vec::new(),
            step: 0,
            step_start: start_time,
            moved: Vec::new(),
            contact_loss: 0.0,
            energy_at_start: 0.0,
            work: Work::default(),
            ahead: Ahead::default(),
            handled: 0,
            onsets: 0,
            effort: 0,
            last_event: start,
            standstill: 0,
            initializing: false,
            cradle,
        }
    }

    /// Until [`Self::begin`], rigid contacts transmit nothing and have had no onset. What balls that are pressed together transmit
    /// depends on all of them and on the inputs: a host that couples this run to others would have to iterate for it.
    pub fn hold_back(&mut self) {
        self.initializing = true;
    }

    /// The run begins.
    pub fn begin(&mut self) {
        self.initializing = false;
    }

    /// Current time, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// From the current time on, `inputs` act, changing with these `derivatives` by time, from the first up to order
    /// [`MAX_INPUT_DERIVATIVE`]. No change of the trajectory if they are constant and act already. The last step is over: the values
    /// over it are gone.
    pub fn hold(&mut self, inputs: &Inputs, derivatives: &[Inputs]) -> Result<(), EngineError> {
        let constant = derivatives.is_empty() && self.inputs.derivatives.is_empty();
        if !constant || *inputs != self.inputs.values {
            self.begin_step();
            self.take_apart();
            self.inputs = HeldInputs { since: self.time, values: inputs.clone(), derivatives: derivatives.to_vec() };
            for (i, ball) in self.balls.iter_mut().enumerate() {
                ball.flight.push = self.inputs.push(i, ball.mass);
            }
            self.put_together();
        }
        self.check_finite(0..self.balls.len())
    }

    /// From the current time on, the drag and the losses of the contacts of `parameters` (the tunable ones) act.
    pub fn retune(&mut self, parameters: &Parameters) -> Result<(), EngineError> {
        let cradle = Cradle::new(parameters);
        if cradle != self.cradle {
            self.begin_step();
            self.take_apart();
            for (ball, model) in self.balls.iter_mut().zip(&cradle.balls) {
                *ball =
                    Ball { tally: ball.tally, at_start: ball.at_start, ..Ball::new(model, ball.anchor, ball.flight) };
            }
            self.cradle = cradle;
            self.put_together();
        }
        self.check_finite(0..self.balls.len())
    }

    /// Moves the current time to `time` (s, not before the current one); `observer` is told of the pulses that finish on the way,
    /// in the order of their release. The values "over the last step" refer to this call.
    pub fn advance(&mut self, time: f64, observer: &mut dyn Observer) -> Result<(), EngineError> {
        self.begin_step();
        let until = DoubleDouble::from(time);
        let mut endurance = Endurance::new(self.time.into(), until);
        while let Some((t, key)) = self.queue.first()
            && t <= until
        {
            endurance.check(t, self.switching(key), self.effort, observer)?;
            self.process(t, key, observer)?;
        }
        self.time = time;
        self.check_finite(self.moved.iter().map(|&ball| ball as usize))
    }

    /// Everything in flight and anchored at the current time, the contacts with their overlaps and modes.
    fn take_apart(&mut self) {
        let now = DoubleDouble::from(self.time);
        if self.is_rigid() {
            return self.unbind(0..self.contacts.len(), now);
        }
        for id in 0..self.clusters.len() {
            self.dissolve(id, now);
        }
        for i in 0..self.contacts.len() {
            self.break_impact(i, now);
        }
        for i in 0..self.contacts.len() {
            self.stop_separation(i, now);
        }
        for i in 0..self.balls.len() {
            self.land(i, now);
        }
        self.contacts.iter_mut().for_each(|contact| contact.waits = false);
    }

    /// The reverse, from what is in flight and overlaps now.
    fn put_together(&mut self) {
        let now = DoubleDouble::from(self.time);
        self.ahead = Ahead::default();
        if self.is_rigid() {
            // A contact that would have to pull from now on ends in the next step.
            return self.settle(0..self.contacts.len(), now, Keep::Closed, &mut Unrecorded);
        }
        for i in 0..self.contacts.len() {
            if self.contacts[i].mode != Mode::Open {
                let rate = self.balls[i].flight.v - self.balls[i + 1].flight.v;
                self.contacts[i].mode = Mode::of_closed(&self.cradle.contacts[i], self.contacts[i].overlap, rate);
            }
        }
        self.form(0..self.contacts.len(), now);
    }

    /// Refuses states of `balls` that are none.
    fn check_finite(&self, mut balls: impl Iterator<Item = usize>) -> Result<(), EngineError> {
        let infinite = |ball: &usize| !self.balls[*ball].flight.is_finite();
        match balls.find(infinite) {
            Some(ball) => Err(EngineError::NotFinite { time: self.time, ball }),
            None => Ok(()),
        }
    }
}
