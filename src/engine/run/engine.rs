//! The state of an event-driven run, its start, and changes of inputs and parameters.

use std::cell::{Cell, RefCell};
use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::contact::{Contact, RestRule};
use super::interaction::Interaction;
use crate::engine::chain_state::ChainState;
use crate::engine::cluster::{Cluster, Control};
use crate::engine::flight::{Ball, Flight};
use crate::engine::tape::Recorder;
use crate::engine::{EngineError, Fault, Forecast, HeldInputs, StepStart, Unrecorded, pair_impact::ImpactCoefficients};
use crate::model::{Chain, Cradle, Inputs, Mode, Parameters, WorkCounters, check_start};
use crate::solver::{DoubleDouble, EventQueue, Stretching};

/// Start of the step of a copy that looks ahead, s: after all events.
pub(crate) const NO_STEP: f64 = f64::MAX;

/// A cradle and its trajectory up to the current time. The serialized fields form a [`Snapshot`](super::Snapshot). Read
/// one with [`Engine::restore`]: plain deserialization leaves the skipped fields empty.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Engine {
    #[serde(skip)]
    pub(crate) cradle: Cradle,
    pub(crate) inputs: HeldInputs,
    #[serde(skip)]
    pub(crate) control: Control,
    #[serde(skip)]
    pub(crate) impact_coefficients: Arc<ImpactCoefficients>,
    pub(crate) time: f64,
    pub(crate) balls: Vec<Ball>,
    pub(crate) contacts: Vec<Contact>,
    /// Interactions of balls, by number.
    pub(crate) interactions: Vec<Option<Interaction>>,
    #[serde(skip)]
    pub(crate) queue: EventQueue,
    /// The current step. A copy that looks ahead records nothing: its step begins after all events.
    pub(crate) step: StepStart,
    pub(crate) totals: Totals,
    #[serde(skip)]
    pub(crate) caches: Caches,
    /// Queue entries handled so far, and onsets among them.
    pub(crate) handled: u64,
    pub(crate) onsets: u64,
    /// What has ended the flight of a ball: time, ball and reason.
    #[serde(skip)]
    pub(crate) fault: Option<(DoubleDouble, usize, Fault)>,
    /// Work so far, in units of about a tenth of a microsecond, which limits a look ahead.
    #[serde(skip)]
    pub(crate) effort: u64,
    /// Notes the parts of a repeated run for its derivatives; none in a host's run.
    #[serde(skip)]
    pub(crate) recorder: Option<Box<Recorder>>,
    /// Whether the run has yet to begin: rigid contacts then transmit nothing and have had no onset. Otherwise their
    /// forces would depend on all balls and inputs, and coupled models would have to iterate.
    #[serde(skip)]
    pub(crate) initializing: bool,
}

#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Totals {
    /// Energy lost in the contacts up to the start of their current segments, J.
    pub contact_loss: f64,
    /// Total energy at the start, J.
    pub energy_at_start: f64,
    pub work: WorkCounters,
    /// Time of the last event, and number of events at that time.
    pub last_event: DoubleDouble,
    pub standstill: usize,
}

/// A time (s; NaN for none), the anchor of a ball's flight at that time, and its position (m) and velocity (m/s).
type KnownState = (f64, DoubleDouble, (f64, f64));

/// Values that could be computed again. They are no state, except for the progress of a look ahead, from which the next
/// look goes on.
#[derive(Debug, Default)]
pub(crate) struct Caches {
    /// For each ball: its state when it was last asked for.
    pub states: Vec<Cell<KnownState>>,
    /// A copy of the run that has gone ahead on the same trajectory, to the next onset at most; dropped when inputs
    /// change.
    pub ahead: RefCell<Option<Box<Engine>>>,
    /// The last result of a look ahead, and the time of the request, s.
    pub found: Cell<Option<(f64, Forecast)>>,
    /// The last cluster that ended, whose memory is reused.
    pub spare: Option<Box<Cluster>>,
}

impl Caches {
    /// Empty caches for so many balls.
    fn new(balls: usize) -> Self {
        let states = vec![Cell::new((f64::NAN, DoubleDouble::ZERO, (0.0, 0.0))); balls];
        Self { states, ahead: RefCell::default(), found: Cell::default(), spare: None }
    }
}

/// A copy keeps the look ahead; everything else is computed again.
impl Clone for Caches {
    fn clone(&self) -> Self {
        Self { ahead: self.ahead.clone(), found: self.found.clone(), ..Self::new(self.states.len()) }
    }
}

impl Engine {
    /// Starts a run at `start_time` (s) with the start values of `parameters`, which must be in their ranges.
    pub fn new(parameters: &Parameters, inputs: &Inputs, start_time: f64) -> Result<Self, EngineError> {
        let cradle = Cradle::new(parameters);
        cradle.check(parameters).map_err(EngineError::NoCoefficient)?;
        check_start(&cradle, &parameters.x_start).map_err(EngineError::NoArc)?;
        let inputs = HeldInputs::constant(inputs.clone(), start_time);
        let mut engine = Self::apart(parameters, inputs, start_time);
        let start = DoubleDouble::from(start_time);
        if engine.is_rigid() {
            engine.touch_where_close()?;
            engine.regroup(0..engine.contacts.len(), start, RestRule::Nothing, &[], &mut Unrecorded);
        } else {
            engine.close_where_overlapping(start);
            engine.form(0..engine.contacts.len(), start);
        }
        engine.check()?;
        engine.totals.energy_at_start = engine.total_energy();
        if !engine.totals.energy_at_start.is_finite() {
            return Err(EngineError::EnergyNotFinite { time: start_time });
        }
        Ok(engine)
    }

    /// A run with all balls in flight from the start values, and with anchored contacts.
    pub(crate) fn apart(parameters: &Parameters, inputs: HeldInputs, start_time: f64) -> Self {
        let cradle = Cradle::new(parameters);
        let caches = Caches::new(cradle.balls.len());
        if cradle.on_arcs() || cradle.contacts.iter().any(|law| !law.is_linear()) {
            Stretching::compute_tables();
        }
        let start = DoubleDouble::from(start_time);
        let balls = cradle.balls.iter().enumerate().map(|(i, model)| {
            let (x, v) = model.along_path(parameters.x_start[i], parameters.v_start[i]);
            let forcing = inputs.forcing(i, model.mass);
            Ball::new(model, start, Flight { x, v, forcing })
        });
        let balls = balls.collect();
        let contacts = vec![Contact::default(); cradle.contacts.len()];
        Self {
            queue: EventQueue::new(contacts.len()),
            inputs,
            control: Control::new(parameters.tolerance),
            impact_coefficients: ImpactCoefficients::of(&cradle),
            time: start_time,
            balls,
            contacts,
            interactions: Vec::new(),
            step: StepStart::new(cradle.balls.len(), cradle.contacts.len(), start_time),
            totals: Totals { last_event: start, ..Totals::default() },
            caches,
            handled: 0,
            onsets: 0,
            fault: None,
            effort: 0,
            recorder: None,
            initializing: false,
            cradle,
        }
    }

    /// A run that goes on from this state at `time` (s).
    pub(crate) fn begun_from(parameters: &Parameters, inputs: HeldInputs, time: f64, state: &ChainState) -> Self {
        let mut engine = Self::apart(parameters, inputs, time);
        for (ball, flight) in engine.balls.iter_mut().zip(&state.flights) {
            (ball.flight.x, ball.flight.v) = (flight.x, flight.v);
        }
        for (j, contact) in state.contacts.iter().enumerate() {
            engine.contacts[j].set_anchored(contact.overlap, contact.mode);
            if engine.is_rigid() && contact.mode != Mode::Open {
                engine.balls[j + 1].flight.v = engine.balls[j].flight.v;
            }
        }
        engine.resume();
        engine
    }

    /// Ends all that is under way at the current time, and begins it again.
    pub(crate) fn interrupt(&mut self) {
        self.suspend();
        self.resume();
    }

    /// Current time, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// From the current time on, `inputs` act, changing with these `derivatives` by time, from the first up to order
    /// [`MAX_INPUT_DERIVATIVE`](crate::model::MAX_INPUT_DERIVATIVE). The trajectory does not change if they are
    /// constant and act already. Values over a step stay valid, whether the step goes on or has ended.
    pub fn hold(&mut self, inputs: &Inputs, derivatives: &[Inputs]) -> Result<(), EngineError> {
        if let Some(inputs) = self.inputs.changed(self.time, inputs, derivatives) {
            self.suspend();
            self.inputs = inputs;
            for (i, ball) in self.balls.iter_mut().enumerate() {
                ball.flight.forcing = self.inputs.forcing(i, ball.model.mass);
            }
            self.resume();
            self.check()?;
        }
        Ok(())
    }

    /// From the current time on, the tunable ones of these `parameters` act: drag and losses of contacts.
    pub fn retune(&mut self, parameters: &Parameters) -> Result<(), EngineError> {
        let cradle = Cradle::new(parameters);
        if cradle != self.cradle {
            cradle.check(parameters).map_err(EngineError::NoCoefficient)?;
            self.suspend();
            for (ball, model) in self.balls.iter_mut().zip(&cradle.balls) {
                let integrals = ball.integrals;
                *ball = Ball::new(model, ball.anchor, ball.flight);
                ball.integrals = integrals;
            }
            self.cradle = cradle;
            self.resume();
            self.check()?;
        }
        Ok(())
    }

    /// Puts all balls in flight, anchored at the current time as their contacts are.
    pub(crate) fn suspend(&mut self) {
        self.stop_all();
        if let Some(mut recorder) = self.recorder.take() {
            let state = self.state_of_all(self.time.into());
            recorder.interrupt(&state, self.time.into(), &self.cradle, &self.inputs);
            self.recorder = Some(recorder);
        }
    }

    fn stop_all(&mut self) {
        self.enter_step();
        let now = DoubleDouble::from(self.time);
        if self.is_rigid() {
            return self.separate(0..self.contacts.len(), now);
        }
        for id in 0..self.interactions.len() {
            self.dissolve(id, now);
        }
        self.reanchor_free(0..self.balls.len(), now);
        (0..self.contacts.len()).for_each(|i| self.stop_separation(i, now));
    }

    /// Resumes after [`Self::suspend`], from the current states and overlaps.
    pub(super) fn resume(&mut self) {
        let now = DoubleDouble::from(self.time);
        self.caches = Caches::new(self.balls.len());
        if self.is_rigid() {
            // A contact that would have to pull from now on ends in the next step.
            return self.regroup(0..self.contacts.len(), now, RestRule::Closed, &[], &mut Unrecorded);
        }
        for i in 0..self.contacts.len() {
            if self.contacts[i].is_closed() {
                self.set_pressing(i, self.contacts[i].at_anchors().overlap, now);
            }
        }
        self.form(0..self.contacts.len(), now);
    }

    /// Notes what has ended the motion of `balls` along their arcs up to the time `t`, if that is the first fault.
    pub(crate) fn look_for_faults(&mut self, balls: Range<usize>, t: DoubleDouble) {
        balls.for_each(|ball| self.note(ball, self.fault_within(ball, t, u64::MAX).unwrap_or_default()));
    }

    /// What has ended the motion of ball `i` on its arc up to the time `t`, and when. `Err` with the time reached if
    /// `t` is more than `most` series of a flight away. In a cluster only the angle is checked, at the ball's anchor,
    /// the end of the last segment; the string is taken as taut.
    pub(super) fn fault_within(
        &self,
        i: usize,
        t: DoubleDouble,
        most: u64,
    ) -> Result<Option<(DoubleDouble, Fault)>, DoubleDouble> {
        let ball = &self.balls[i];
        if !ball.model.on_arc {
            return Ok(None);
        }
        if self.flies(i) { ball.fault_within(t, most) } else { Ok(ball.fault_at_anchor()) }
    }

    /// Notes a fault of ball `i`, and when, if it is the first fault.
    pub(crate) fn note(&mut self, i: usize, fault: Option<(DoubleDouble, Fault)>) {
        if let Some((time, fault)) = fault
            && self.fault.is_none_or(|(first, ..)| time < first)
        {
            self.fault = Some((time, i, fault));
        }
    }

    /// Fails with the fault of a ball, if there is one; `origin` (s) is the host's time at the time 0 of the run.
    pub(crate) fn check_fault(&self, origin: f64) -> Result<(), EngineError> {
        self.fault.map_or(Ok(()), |(time, ball, fault)| {
            Err(EngineError::OffArc { time: (time + origin).value(), ball, fault })
        })
    }

    /// Fails if the run cannot go on from its present state.
    fn check(&self) -> Result<(), EngineError> {
        self.check_fault(0.0)?;
        self.check_finite(0..self.balls.len())
    }

    /// Fails if `balls`, all that have moved, or sums that have changed meanwhile have left the range of doubles. So
    /// what is saved after a step is finite.
    pub(super) fn check_finite(&self, balls: impl Iterator<Item = usize>) -> Result<(), EngineError> {
        if let Some((_, key)) = self.queue.first().filter(|(t, _)| !t.value().is_finite()) {
            return Err(self.lost(key));
        }
        let time = self.time;
        for ball in balls {
            if !self.balls[ball].is_finite() || !self.step.is_finite_at(ball) {
                return Err(EngineError::NotFinite { time, ball });
            }
            // The contact at its left is checked with the ball there, if that has moved as well.
            let left = ball.checked_sub(1).filter(|left| self.step.balls[*left].is_none());
            let mut beside = left.into_iter().chain((ball < self.contacts.len()).then_some(ball));
            let is_finite = |j: usize| {
                self.contacts[j].is_finite() && self.constraint(j).is_none_or(|constraint| constraint.is_finite())
            };
            if let Some(contact) = beside.find(|contact| !is_finite(*contact)) {
                return Err(EngineError::ContactNotFinite { time, contact });
            }
        }
        if self.totals.contact_loss.is_finite() { Ok(()) } else { Err(EngineError::EnergyNotFinite { time }) }
    }
}
