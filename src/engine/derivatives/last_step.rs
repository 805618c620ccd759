//! Derivatives of the outputs at the end of the last step, by the inputs over it or by everything since the start; and
//! derivatives of the outputs at the start.

use std::cell::Cell;
use std::sync::Arc;

use super::history::Stretch;
use crate::engine::chain_state::ChainState;
use crate::engine::flight::{Flight, integral_of};
use crate::engine::pair_impact::ImpactCoefficients;
use crate::engine::tape::{
    Direction, End, Recorder, Sink, Tape, Unfollowed, along_direction, change_of_start, cradle_along,
};
use crate::engine::{EngineError, HeldInputs, Unrecorded, run::Engine};
use crate::model::{Differential, Inputs, Parameters, Results, SolverMethod};
use crate::solver::{Dual, Scalar};

/// Allowed difference between the ends of a run and of its repetition, over the amplitude. Inputs that go on after a
/// change of the parameters are rounded.
const AGREEMENT: f64 = 1e-9;

/// The last step of a run, by any method: the data for its derivatives.
pub struct LastStep<'a> {
    run: &'a dyn Results,
    parameters: &'a Parameters,
    /// Inputs from its end on.
    inputs: HeldInputs,
    /// State at its start.
    start: ChainState,
    /// Start, s; before the first step its `length` (s) is 0.
    began: f64,
    impacts: Arc<ImpactCoefficients>,
    length: f64,
    pub(crate) end: ChainState,
    /// Whether to follow the motion beyond its end, for the derivative of the time of the next onset.
    to_next_onset: bool,
    /// Integration steps taken so far on the way to the next onset.
    steps_to_onset: Cell<u64>,
}

/// The states at the start and at the end of a step, when it began (s), and the inputs at its end.
pub(crate) struct StepEnds {
    pub start: ChainState,
    pub end: ChainState,
    pub began: f64,
    pub inputs: HeldInputs,
    /// Coefficients for impacts that the run has computed; a repetition needs them, too.
    pub impacts: Arc<ImpactCoefficients>,
}

impl Engine {
    /// The ends of the last step; before the first, both are the start.
    pub(crate) fn step_ends(&self) -> StepEnds {
        let (start, end) = (self.state_at_start(), self.state_of_all(self.time.into()));
        let (inputs, impacts) = (self.inputs.at(self.time), self.impact_coefficients.clone());
        StepEnds { start, end, began: self.step.time, inputs, impacts }
    }
}

/// Where a run that is recorded begins: when (s), and in which state.
type StartState<'a> = (f64, &'a ChainState);

impl<'a> LastStep<'a> {
    /// The last step of this run, with its current parameters.
    pub(crate) fn new(run: &'a dyn Results, parameters: &'a Parameters, ends: StepEnds) -> Self {
        let StepEnds { start, end, began, inputs, impacts } = ends;
        Self {
            run,
            parameters,
            inputs,
            impacts,
            start,
            began,
            length: run.step_length(),
            end,
            to_next_onset: false,
            steps_to_onset: Cell::new(0),
        }
    }

    /// If `wanted`, the derivative of the time of the next onset is computed, which may take many times the work of the
    /// step; otherwise it is NaN.
    pub fn with_next_onset(self, wanted: bool) -> Self {
        Self { to_next_onset: wanted, ..self }
    }

    /// Integration steps taken so far to follow the motion to the next onset.
    pub fn steps_to_onset(&self) -> u64 {
        self.steps_to_onset.get()
    }

    fn balls(&self) -> usize {
        self.end.flights.len()
    }

    /// Derivatives of the outputs at the end of the step along a direction of the inputs, which change by the same over
    /// all its `stretches`. Before the first step nothing depends on them. An error if the step cannot be followed.
    pub(crate) fn along_inputs(&self, stretches: &[Stretch], inputs: &Inputs) -> Result<Differential, Unfollowed> {
        if self.length == 0.0 {
            return Ok(Differential::all(self.balls(), 0.0));
        }
        self.along((self.began, &self.start), stretches, (None, inputs))
    }

    /// Derivatives of the outputs along a direction of parameters and inputs, which change by the same over all
    /// `stretches`: over the run from this start, or over a step without changes of parameters.
    pub(crate) fn along(
        &self,
        start: StartState,
        stretches: &[Stretch],
        direction: Direction,
    ) -> Result<Differential, Unfollowed> {
        let cradle = cradle_along(self.parameters, direction);
        let change = change_of_start(self.parameters, direction, &cradle);
        let mut run = self.record(start, stretches, Sink::along(direction, change))?;
        let changes = run.recorder.as_ref().and_then(|recorder| recorder.changes()).ok_or(Unfollowed::NoHistory)?;
        let outputs = self.at_end(stretches).outputs(cradle, direction.1, changes);
        Ok(Differential { next_onset: self.next_onset(&mut run), ..outputs })
    }

    pub(crate) fn tape_of_step(&self, stretches: &[Stretch]) -> Result<Tape, Unfollowed> {
        self.tape((self.began, &self.start), stretches)
    }

    /// The run from this start in parts; an error if it cannot be followed.
    pub(crate) fn tape(&self, start: StartState, stretches: &[Stretch]) -> Result<Tape, Unfollowed> {
        let mut run = self.record(start, stretches, Sink::default())?;
        let tape = run.recorder.take().and_then(|recorder| recorder.tape(self.at_end(stretches)));
        tape.ok_or(Unfollowed::NoHistory)
    }

    fn at_end(&self, stretches: &[Stretch]) -> End {
        let mut since = self.began;
        let mut support_speed = 0.0;
        for Stretch { until, inputs, .. } in stretches.iter().filter(|stretch| stretch.until > self.began) {
            let accelerations = inputs.at(since).derivatives(|inputs| inputs.support_acceleration);
            support_speed += integral_of(&accelerations, until - since);
            since = *until;
        }
        End { state: self.end.clone(), inputs: self.inputs.clone(), length: self.length, support_speed }
    }

    /// Repeats the run from this start; the result stands at its end, interrupted.
    fn record(&self, (mut since, start): StartState, stretches: &[Stretch], sink: Sink) -> Result<Engine, Unfollowed> {
        let another = |_: EngineError| Unfollowed::Another;
        let (mut acting, mut run): (Parameters, Option<Engine>) = (self.parameters.clone(), None);
        for stretch in stretches {
            acting.tune(&stretch.tunables);
            let inputs = stretch.inputs.at(since);
            let engine = match &mut run {
                None => {
                    let mut begun = Engine::begun_from(&acting, inputs, since, start);
                    begun.impact_coefficients = self.impacts.clone();
                    begun.recorder = Some(Box::new(Recorder::new(sink.clone(), &begun.cradle, self.began)));
                    run.insert(begun)
                }
                Some(run) => {
                    run.retune(&acting)
                        .and_then(|()| run.hold(&inputs.orders[0], &inputs.orders[1..]))
                        .map_err(another)?;
                    run
                }
            };
            if let Some(recorder) = &mut engine.recorder {
                recorder.under(&acting);
            }
            engine.advance(stretch.until, &mut Unrecorded).map_err(another)?;
            if let Some(why) = engine.recorder.as_ref().and_then(|recorder| recorder.failure()) {
                return Err(why);
            }
            since = stretch.until;
        }
        let mut run = run.ok_or(Unfollowed::NoHistory)?;
        run.suspend();
        let end = run.state_of_all(run.time.into());
        let unit = run.cradle.balls[0].unit_of_time();
        let size = |x: f64, v: f64| x.abs() + v.abs() * unit;
        let amplitude = end.flights.iter().map(|ball| size(ball.x, ball.v)).fold(0.0, f64::max);
        let off = |(own, expected): (&Flight, &Flight)| size(own.x - expected.x, own.v - expected.v);
        let approximate = self.parameters.method != SolverMethod::EventDriven;
        let agree =
            approximate || end.flights.iter().zip(&self.end.flights).map(off).all(|off| off <= AGREEMENT * amplitude);
        if !agree {
            return Err(Unfollowed::Another);
        }
        let recorder = run.recorder.as_mut().ok_or(Unfollowed::NoHistory)?;
        recorder.end(&run.cradle, |i| (end.flights[i].x, end.flights[i].v));
        recorder.failure().map_or(Ok(run), Err)
    }

    /// Derivatives of the outputs at its end along `inputs` that act from then on: of the accelerations, the power and
    /// the next onset.
    pub fn at_end_along_inputs(&self, inputs: &Inputs) -> Differential {
        let cradle = self.run.cradle().map(Dual::from);
        let change = change_of_start(self.parameters, (None, inputs), &cradle);
        let outputs = Differential::along(&&along_direction(cradle, &self.end, &change, &self.inputs, inputs));
        let next_onset = self.next_onset_from_end((None, inputs), change);
        Differential { next_onset, ..outputs }
    }

    /// Derivatives of the outputs at the start of a run along a direction of parameters and inputs.
    pub fn along_parameters(&self, tangent: &Parameters, inputs: &Inputs) -> Differential {
        let direction = (Some(tangent), inputs);
        let cradle = cradle_along(self.parameters, direction);
        let change = change_of_start(self.parameters, direction, &cradle);
        let first = cradle.balls[0].omega2;
        let mut outputs = self.at_end(&[]).outputs(cradle, inputs, &change);
        if first.value() > 0.0 {
            outputs.period = (Dual::from(std::f64::consts::TAU) / first.sqrt()).tangent();
        }
        outputs.next_onset = self.next_onset_from_end(direction, change);
        outputs
    }

    /// Derivative of the time of the next onset after the end of the step, along a direction that changes the state
    /// there by `change`.
    fn next_onset_from_end(&self, direction: Direction, change: Vec<f64>) -> f64 {
        if !self.to_next_onset {
            return f64::NAN;
        }
        let mut run = Engine::begun_from(self.parameters, self.inputs.clone(), self.inputs.since, &self.end);
        let sink = Sink::along(direction, change);
        let mut recorder = Recorder::new(sink, &run.cradle, f64::INFINITY);
        recorder.under(self.parameters);
        run.recorder = Some(Box::new(recorder));
        self.next_onset(&mut run)
    }

    /// Derivative of the time of the next onset after `run`, which stands at the end of the step; NaN if it is not
    /// wanted, or cannot be followed.
    fn next_onset(&self, run: &mut Engine) -> f64 {
        let next = self.run.next_onset().found();
        match (self.to_next_onset, next, &mut run.recorder) {
            (false, ..) | (_, _, None) => return f64::NAN,
            (true, None, _) => return 0.0,
            (true, Some(_), Some(recorder)) => recorder.next_onset = None,
        }
        run.interrupt();
        // In the repeated motion the same onset may be later by rounding.
        let until = next.map_or(0.0, |next| next + 1e-9 * (next - run.time).max(run.time));
        let before = run.work().steps;
        let followed = run.advance(until, &mut Unrecorded);
        self.steps_to_onset.set(self.steps_to_onset.get() + run.work().steps - before);
        let recorder = run.recorder.as_ref().filter(|recorder| recorder.failure().is_none());
        let delay = recorder.and_then(|recorder| recorder.next_onset);
        delay.filter(|_| followed.is_ok()).unwrap_or(f64::NAN)
    }
}
