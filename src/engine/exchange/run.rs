//! The state of a run that its host integrates, with its setters, the derivatives, and the event indicators.

use std::ops::Deref;

use serde::{Deserialize, Serialize};

use super::contact::ContactRecord;
use super::scales::{SHIFT, Scales, state_count};
use crate::engine::equations::State;
use crate::engine::run::{Engine, InvalidState, require};
use crate::engine::{EngineError, Forecast};
use crate::model::{
    Chain, Cradle, Differential, ExchangedContacts, Inputs, Mode, Parameters, Record, Results, WorkCounters,
};
use crate::solver::{Dual, Scalar};

/// A cradle whose host integrates its equations of motion. Its states are, for n balls,
///
/// - the position of the first ball (m), the n-1 overlaps (m), negative while apart, and the n velocities (m/s),
/// - the impulses of the n-1 contacts (N.s), the energy dissipated and the work of the inputs (J).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Exchange {
    pub(super) parameters: Parameters,
    pub(super) inputs: Inputs,
    /// Current time, s.
    pub time: f64,
    /// The states, in the order above.
    pub(super) y: Vec<f64>,
    pub(super) contacts: Vec<ContactRecord>,
    pub(super) scales: Scales,
    pub(super) energy_at_start: f64,
    /// The next onset as known at the last event, and its contact.
    pub(super) next: Forecast,
    pub(super) next_contact: Option<usize>,
    /// Whether there has been no event yet, so that contacts closed at the start have not been followed.
    pub(super) at_start: bool,
    /// The flags, and values that follow from the states, the flags and the inputs.
    pub(super) state: State,
}

impl Exchange {
    /// Starts a run at `start_time` (s) with the start values of `parameters`, which must be in their ranges.
    pub fn new(parameters: &Parameters, inputs: &Inputs, start_time: f64) -> Result<Self, EngineError> {
        // The engine refuses an invalid start.
        let engine = Engine::new(parameters, inputs, start_time)?;
        let cradle = Cradle::new(parameters);
        let (n, m) = (parameters.balls(), parameters.contacts());
        let mut y = vec![parameters.x_start[0]];
        let start = |j: usize| engine.overlap_at(j, start_time.into());
        y.extend((0..m).map(|j| start(j).0));
        y.extend_from_slice(&parameters.v_start);
        y.resize(state_count(n), 0.0);
        // Rigid contacts close in the first event.
        let modes = (0..m).map(|j| if cradle.rigid { Mode::Open } else { start(j).1 }).collect();
        let mut run = Self {
            parameters: parameters.clone(),
            inputs: inputs.clone(),
            time: start_time,
            contacts: vec![ContactRecord::default(); m],
            scales: Scales::default(),
            energy_at_start: engine.total_energy(),
            next: engine.next_onset(),
            next_contact: None,
            at_start: true,
            state: State { beyond: beyond_at_start(&cradle, parameters), cradle, modes, ..State::default() },
            y,
        };
        run.refresh();
        run.scales = Scales::new(&run.state);
        for (mode, contact) in run.state.modes.iter().zip(&mut run.contacts) {
            if *mode != Mode::Open {
                contact.open_pulse(start_time.into(), 0.0);
            }
        }
        Ok(run)
    }

    /// The run that was saved; see [`Engine::restore`]. After a failed event (`failed`) any values pass.
    pub fn restored(mut self, parameters: &Parameters, start: f64, failed: bool) -> Result<Self, InvalidState> {
        let (n, m) = (parameters.balls(), parameters.contacts());
        require(self.parameters == *parameters, "its parameters are not those that it was set up with")?;
        let lengths = [self.y.len(), self.modes.len(), self.contacts.len(), self.inputs.force.len()];
        require(lengths == [state_count(n), m, m, n], "its size does not match the cradle")?;
        require(self.scales.are_sound(n), "an order of magnitude is not one")?;
        require(failed || self.time >= start && self.time.is_finite(), "its time lies before its start")?;
        require(self.inputs.is_finite(), "an input is not finite")?;
        let sums = self.energy_at_start.is_finite() && self.contacts.iter().all(|contact| contact.ledger.is_sound());
        require(failed || sums, "a sum is not finite")?;
        self.state.cradle = Cradle::new(parameters);
        self.state.beyond = beyond_at_start(&self.cradle, parameters);
        require(
            self.modes.iter().zip(&self.cradle.contacts).all(|(mode, law)| *mode != Mode::Clipped || law.clips()),
            "a contact is clipped whose law does not clip",
        )?;
        self.refresh();
        Ok(self)
    }

    /// Recomputes what follows from the states, the flags and the inputs.
    pub(super) fn refresh(&mut self) {
        let forcings = self.forcings();
        let State { cradle, modes, beyond, .. } = std::mem::take(&mut self.state);
        self.state = State::new(cradle, (modes, beyond), &self.y, forcings);
    }

    fn forcings(&self) -> Vec<f64> {
        let forces = self.cradle.balls.iter().zip(&self.inputs.force);
        forces.map(|(ball, force)| force / ball.mass - self.inputs.support_acceleration).collect()
    }

    pub(super) fn balls(&self) -> usize {
        self.cradle.balls.len()
    }

    pub(super) fn is_rigid(&self) -> bool {
        self.cradle.rigid
    }

    /// Whether events follow contacts to their end.
    pub(super) fn is_mapped(&self) -> bool {
        self.is_rigid() || self.parameters.exchange_contacts == ExchangedContacts::Mapped
    }

    pub(super) fn closed(&self) -> Vec<usize> {
        (0..self.modes.len()).filter(|&j| self.modes[j] != Mode::Open).collect()
    }

    /// Overlap of contact `j`, m, and its rate, m/s.
    pub(super) fn overlap_and_rate(&self, j: usize) -> (f64, f64) {
        (self.state.overlaps[j], self.overlap_rate(j))
    }

    pub(super) fn impulse_place(&self, j: usize) -> usize {
        2 * self.balls() + j
    }

    pub(super) fn sums_place(&self) -> [usize; 2] {
        [3 * self.balls() - 1, 3 * self.balls()]
    }

    /// The states, in the order above.
    pub fn states(&self) -> &[f64] {
        &self.y
    }

    /// Sets all states.
    pub fn set_states(&mut self, states: &[f64]) {
        self.y.copy_from_slice(states);
        self.refresh();
    }

    /// Whether a ball has no place on its arc. Then the balls to its right have none either.
    pub fn lacks_places(&self) -> bool {
        self.state.x[self.balls() - 1].is_nan()
    }

    /// Why a cradle cannot have these states; `None` if it can.
    pub fn lost(&self) -> Option<EngineError> {
        let (time, State { x, v, .. }) = (self.time, &self.state);
        let ball = (0..self.balls()).find(|&i| !(x[i].is_finite() && v[i].is_finite()))?;
        let of_arc = self.cradle.on_arcs() && x[ball].is_nan();
        Some(if of_arc { EngineError::NoPlace { time, ball } } else { EngineError::NotFinite { time, ball } })
    }

    /// Orders of magnitude of the states, all of them positive.
    pub fn nominals(&self) -> &[f64] {
        &self.scales.nominals
    }

    /// Sets inputs and tunable parameters from now on.
    pub fn set(&mut self, parameters: &Parameters, inputs: &Inputs) {
        if self.inputs != *inputs {
            // The flight is no longer the one that began at the end of an event.
            self.contacts.iter_mut().for_each(|contact| contact.followed_until = None);
            self.inputs.clone_from(inputs);
        }
        if !parameters.is_tuned_as(&self.parameters) {
            self.parameters.tune(&parameters.tunables());
            self.state.cradle = Cradle::new(&self.parameters);
            for (mode, law) in self.state.modes.iter_mut().zip(&self.state.cradle.contacts) {
                if *mode == Mode::Clipped && !law.clips() {
                    *mode = Mode::Pressing;
                }
            }
        }
        self.refresh();
    }

    /// Derivatives of the states by time.
    pub fn derivatives(&self) -> Vec<f64> {
        let mut rates = Vec::with_capacity(self.y.len());
        rates.push(self.y[self.balls()]);
        rates.extend((0..self.modes.len()).map(|j| self.overlap_rate(j)));
        rates.extend((0..self.balls()).map(|i| self.a(i)));
        rates.extend_from_slice(&self.state.forces);
        rates.extend([self.dissipation(), self.external_power()]);
        rates
    }

    /// Derivatives of all results along a direction of the states and the inputs.
    pub fn along(&self, states: &[f64], inputs: &Inputs) -> Differential {
        let dual = |(value, tangent): (&f64, &f64)| Dual::with_tangent(*value, *tangent);
        let y: Vec<Dual> = self.y.iter().zip(states).map(dual).collect();
        let forcing = |(i, value): (usize, f64)| {
            Dual::with_tangent(value, inputs.force[i] / self.cradle.balls[i].mass - inputs.support_acceleration)
        };
        let forcings = self.forcings().into_iter().enumerate().map(forcing).collect();
        let state = State::new(self.cradle.map(Dual::from), (self.modes.clone(), self.beyond.clone()), &y, forcings);
        let [loss, work] = self.sums_place();
        let mut outputs = Differential::along(&&state);
        outputs.impulse = states[self.impulse_place(0)..self.impulse_place(self.modes.len())].to_vec();
        (outputs.dissipated_energy, outputs.external_work) = (states[loss], states[work]);
        outputs.force_mean.clone_from(&outputs.force);
        Differential { support_force_mean: outputs.support_force, ..outputs }
    }

    /// The event indicators: n-1 that are negative while a contact is open and positive while it is closed, then n-1
    /// that are negative while a contact is clipped. An event is due where one of them changes its sign.
    pub fn indicators(&self) -> Vec<f64> {
        let contacts = 0..self.modes.len();
        contacts.clone().map(|j| self.contact_indicator(j)).chain(contacts.map(|j| self.clip_indicator(j))).collect()
    }

    /// Whether an indicator contradicts the flags, or an event would end the run.
    pub(super) fn is_event_due(&self) -> bool {
        let slack = |i: usize| self.flies(i) && self.tension(i) < 0.0;
        self.cradle.on_arcs() && ((0..self.balls()).any(slack) || self.crossed().is_some())
            || (0..self.modes.len()).any(|j| {
                (self.contact_indicator(j) > 0.0) != (self.modes[j] != Mode::Open) && !self.is_virtual(j)
                    || (self.clip_indicator(j) < 0.0) != (self.modes[j] == Mode::Clipped)
            })
    }

    /// The first contact on arcs whose balls have changed sides.
    pub(super) fn crossed(&self) -> Option<usize> {
        (0..self.modes.len()).find(|&j| self.cradle.pair(j).changed_sides([self.state.x[j], self.state.x[j + 1]]))
    }

    /// Whether all contacts of ball `i` are open. While one is closed, the ball's string counts as taut.
    pub(super) fn flies(&self, i: usize) -> bool {
        let is_open = |j: usize| self.modes.get(j).is_none_or(|mode| *mode == Mode::Open);
        is_open(i) && (i == 0 || is_open(i - 1))
    }

    /// Whether contact `j` overlaps only because its balls have yet to part after an event, or their flight to begin.
    fn is_virtual(&self, j: usize) -> bool {
        let (overlap, rate) = self.overlap_and_rate(j);
        self.is_mapped() && self.modes[j] == Mode::Open && (overlap > 0.0 && rate <= 0.0 || self.is_followed(j))
    }

    pub(crate) fn contact_indicator(&self, j: usize) -> f64 {
        let ((overlap, rate), shift) = (self.overlap_and_rate(j), self.scales.shift(j));
        if self.modes[j] != Mode::Open {
            return overlap + shift;
        }
        if !self.is_mapped() || self.is_beside_closed(j) {
            return overlap - shift;
        }
        let time = self.scales.overlap(j) / self.scales.speed;
        overlap.min(time * rate) - shift
    }

    /// Whether a neighbour of contact `j` is closed, so that no event follows it.
    pub(super) fn is_beside_closed(&self, j: usize) -> bool {
        let closed = |j: usize| self.modes.get(j).is_some_and(|mode| *mode != Mode::Open);
        !self.is_rigid() && (closed(j + 1) || j > 0 && closed(j - 1))
    }

    /// Margin of a closed contact before its law or its constraint would pull, 1; it is 1 for all others.
    pub(crate) fn clip_indicator(&self, j: usize) -> f64 {
        let law = &self.cradle.contacts[j];
        let shift = match self.modes[j] {
            Mode::Open => return 1.0,
            Mode::Pressing => SHIFT,
            Mode::Clipped => -SHIFT,
        };
        let (overlap, rate) = self.overlap_and_rate(j);
        if self.is_rigid() {
            return self.state.forces[j] / self.scales.forces[j] + shift;
        }
        if !law.clips() {
            return 1.0;
        }
        match law.sign_of_force() {
            Some(sign) => sign.at(overlap, rate) / sign.at(self.scales.overlap(j), 0.0) + shift,
            None => law.unclipped_force(overlap.max(f64::MIN_POSITIVE), rate) / self.scales.forces[j] + shift,
        }
    }
}

/// Which balls start [beyond](crate::model::Pair::is_beyond) the line from their left neighbour to their own pivot.
fn beyond_at_start(cradle: &Cradle, parameters: &Parameters) -> Vec<bool> {
    let Parameters { x_start, v_start, .. } = parameters;
    let place = |i: usize| cradle.balls[i].along_path(x_start[i], v_start[i]).0;
    (0..cradle.contacts.len()).map(|j| cradle.pair(j).is_beyond([j, j + 1].map(place))).collect()
}

impl Deref for Exchange {
    type Target = State;

    fn deref(&self) -> &State {
        &self.state
    }
}

/// Values over a step are those of this instant, discrete values those of the last event.
impl Results for Exchange {
    fn impulse(&self, i: usize) -> f64 {
        self.y[self.impulse_place(i)]
    }

    fn force_peak(&self, i: usize) -> f64 {
        if self.at_start { self.force(i) } else { self.contacts[i].peak }
    }

    fn record(&self, i: usize) -> Record {
        self.contacts[i].ledger.record
    }

    fn energy_at_start(&self) -> f64 {
        self.energy_at_start
    }

    fn dissipated_energy(&self) -> f64 {
        self.y[self.sums_place()[0]]
    }

    fn external_work(&self) -> f64 {
        self.y[self.sums_place()[1]]
    }

    fn next_onset(&self) -> Forecast {
        self.next
    }

    /// The host does the work.
    fn work(&self) -> WorkCounters {
        WorkCounters::default()
    }
}
