//! Derivatives of the outputs at the end of the last step, by the inputs over it or by all since the start; and those
//! at the start.

use std::cell::Cell;

use super::chain_state::ChainState;
use super::history::Stretch;
use super::tangent::DualRun;
use crate::engine::flight::{Flight, Forcing};
use crate::engine::{HeldInputs, cluster::WindowContact, run::Engine};
use crate::model::{BallModel, Cradle, Differential, Inputs, Parameters, Results};
use crate::solver::{Dual, Scalar};

/// The last step of a run, by any method: the data for its derivatives.
pub struct LastStep<'a> {
    run: &'a dyn Results,
    /// What acts from its end on.
    cradle: &'a Cradle,
    inputs: HeldInputs,
    /// The state at its start.
    start: ChainState,
    /// When it began, s, and its length, s; 0 before the first.
    began: f64,
    length: f64,
    pub(crate) end: ChainState,
    /// Whether to follow the motion beyond its end, for the derivative of the time of the next onset.
    to_next_onset: bool,
    /// Segments that the derivatives have taken so far.
    segments: Cell<usize>,
}

impl Engine {
    /// The last step, or the start before the first, for derivatives along directions.
    pub fn last_step(&self) -> LastStep<'_> {
        let states = [self.state_at_start(), self.state_of_all(self.time.into())];
        LastStep::new(self, states, self.step.time, self.inputs.at(self.time))
    }
}

impl<'a> LastStep<'a> {
    /// Of this run, with its states at the start and at the end of the step, when it began (s), and the inputs at its
    /// end.
    pub(crate) fn new(run: &'a dyn Results, [start, end]: [ChainState; 2], began: f64, inputs: HeldInputs) -> Self {
        let (cradle, length, segments) = (run.cradle(), run.step_length(), Cell::new(0));
        Self { run, cradle, inputs, start, began, length, end, to_next_onset: false, segments }
    }

    /// If `wanted`, with the derivative of the time of the next onset, which may take many times the work of the step;
    /// otherwise that is NaN.
    pub fn with_next_onset(self, wanted: bool) -> Self {
        Self { to_next_onset: wanted, ..self }
    }

    /// Segments that the derivatives have taken so far.
    pub fn segments(&self) -> usize {
        self.segments.get()
    }

    /// Derivatives of the outputs at its end along `inputs`, which were held over it: they change by the same over all
    /// its `stretches`. Before the first step nothing depends on them. `None` if the step cannot be followed: it has
    /// too many segments, leaves the range of numbers, has rigid balls that stay in contact, or its derivatives are
    /// only rounding. `parameters` are the current ones.
    pub(crate) fn along_inputs(
        &self,
        parameters: &Parameters,
        stretches: &[Stretch],
        inputs: &Inputs,
    ) -> Option<Differential> {
        if self.length == 0.0 {
            return Some(Differential::all(self.cradle.balls.len(), 0.0));
        }
        let start = |_: &Cradle<Dual>| lifted(&self.start);
        let coefficients = |acting: &Parameters| Cradle::new(acting).map(Dual::from);
        let run = self.follow(parameters, self.began, stretches, inputs, start, coefficients)?;
        if run.is_cancelled() { None } else { self.outputs_of(run) }
    }

    /// The same along parameters and inputs of the whole run, which began at `start_time` (s) in the state `start`.
    /// Both change by the same over all `stretches`; `parameters` are the current ones.
    pub(crate) fn along_run(
        &self,
        parameters: &Parameters,
        (start_time, start): (f64, &ChainState),
        stretches: &[Stretch],
        (tangent, inputs): (&Parameters, &Inputs),
    ) -> Option<Differential> {
        let start = |along: &Cradle<Dual>| start_along(start, along, tangent);
        let coefficients = |acting: &Parameters| Cradle::along(acting, tangent);
        self.outputs_of(self.follow(parameters, start_time, stretches, inputs, start, coefficients)?)
    }

    /// Follows `stretches` from the time `since` (s) to the end of the step, along `inputs`, the state at the `start`
    /// and `coefficients` that follow from the tunable parameters.
    fn follow(
        &self,
        parameters: &Parameters,
        mut since: f64,
        stretches: &[Stretch],
        inputs: &Inputs,
        start: impl Fn(&Cradle<Dual>) -> ChainState<Dual>,
        coefficients: impl Fn(&Parameters) -> Cradle<Dual>,
    ) -> Option<DualRun> {
        let (mut acting, mut run): (Parameters, Option<DualRun>) = (parameters.clone(), None);
        for stretch in stretches {
            acting.tune(stretch.tunables);
            let along = coefficients(&acting);
            let forcings = forcings_along(&along, &stretch.inputs.at(since), inputs);
            let begun = match run.take() {
                Some(run) => run.under(along, forcings),
                None => {
                    let start = start(&along).under(forcings);
                    DualRun::new(along, start)
                }
            };
            let run = run.insert(begun);
            if since < self.began && self.began < stretch.until {
                run.follow(Some(self.began - since))?;
            }
            if (since..stretch.until).contains(&self.began) {
                run.begin_step();
            }
            run.follow(Some(stretch.until - since))?;
            since = stretch.until;
        }
        run
    }

    /// Derivatives of the outputs at its end, which `run` has reached.
    fn outputs_of(&self, mut run: DualRun) -> Option<Differential> {
        run.agree_with(&self.end)?;
        let outputs = run.outputs_of_step(self.length);
        Some(Differential { next_onset: self.next_onset(run), ..outputs })
    }

    /// Derivatives of the outputs at its end along `inputs` that act from then on: of the accelerations, the power and
    /// the next onset, but not of constraint forces.
    pub fn at_end_along_inputs(&self, inputs: &Inputs) -> Differential {
        let along = self.cradle.map(Dual::from);
        let forcings = forcings_along(&along, &self.inputs, inputs);
        let run = DualRun::new(along, lifted(&self.end).under(forcings));
        let outputs = run.outputs();
        Differential { next_onset: self.next_onset(run), ..outputs }
    }

    /// Derivatives of the outputs at the start of a run along a direction of parameters and inputs.
    pub fn along_parameters(&self, parameters: &Parameters, tangent: &Parameters, inputs: &Inputs) -> Differential {
        let along = Cradle::along(parameters, tangent);
        let forcings = forcings_along(&along, &self.inputs, inputs);
        let state = start_along(&self.end, &along, tangent).under(forcings);
        let first = along.balls[0].omega2;
        let run = DualRun::new(along, state);
        let mut outputs = run.outputs_of_step(0.0);
        if first.value() > 0.0 {
            outputs.period = (Dual::from(std::f64::consts::TAU) / first.sqrt()).tangent();
        }
        outputs.next_onset = self.next_onset(run);
        outputs
    }

    /// Derivative of the time of the next onset after `run`; NaN if it is not wanted, or cannot be followed.
    fn next_onset(&self, mut run: DualRun) -> f64 {
        let delay = match self.to_next_onset {
            true if self.run.next_onset().found().is_none() => 0.0,
            true => run.follow(None).map_or(f64::NAN, |()| run.delay),
            false => f64::NAN,
        };
        self.segments.set(self.segments.get() + run.segments);
        delay
    }
}

/// Accelerations by the inputs `held`, with derivatives along a constant change `tangent` of the inputs and along those
/// of the masses.
fn forcings_along(cradle: &Cradle<Dual>, held: &HeldInputs, tangent: &Inputs) -> Vec<Forcing<Dual>> {
    let forcing = |(i, ball): (usize, &BallModel<Dual>)| {
        let mut forcing = held.forcing(i, ball.mass);
        let [force, support] = [tangent.force[i], tangent.support_acceleration].map(|t| Dual::with_tangent(0.0, t));
        forcing[0] += force / ball.mass - support;
        forcing
    };
    cradle.balls.iter().enumerate().map(forcing).collect()
}

/// A state without derivatives.
fn lifted(state: &ChainState) -> ChainState<Dual> {
    let ball = |flight: &Flight| (flight.x.into(), flight.v.into());
    let contact = |contact: &WindowContact| (contact.overlap.into(), contact.mode);
    ChainState::new(state.flights.iter().map(ball), state.contacts.iter().map(contact))
}

/// The start state, with its derivatives for derivatives `tangent` of the parameters.
fn start_along(state: &ChainState, cradle: &Cradle<Dual>, tangent: &Parameters) -> ChainState<Dual> {
    let mut start = lifted(state);
    for (i, (ball, Flight { x, v, .. })) in cradle.balls.iter().zip(&mut start.flights).enumerate() {
        let place = ball.map(Dual::value).place(x.value());
        let deflection = Dual::with_tangent(place.x, tangent.x_start[i]);
        let (ds, du) = ball.along_path(deflection, Dual::with_tangent(v.value() * place.cos, tangent.v_start[i]));
        (*x, *v) = (Dual::with_tangent(x.value(), ds.tangent()), Dual::with_tangent(v.value(), du.tangent()));
    }
    for (j, contact) in start.contacts.iter_mut().enumerate() {
        let change = cradle.pair(j).overlap([start.flights[j].x, start.flights[j + 1].x]);
        contact.overlap = Dual::with_tangent(contact.overlap.value(), change.tangent());
    }
    start
}
