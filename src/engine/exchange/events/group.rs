//! A group of contacts, followed within an event by the event-driven engine from its onset until all are open; with
//! rigid contacts, all contacts from the first impact to the end of chatter.

use std::ops::Range;

use crate::engine::run::{ContactRole, Engine, RestRule, contiguous_range};
use crate::engine::{
    EngineError, Forecast, HeldInputs, Observer, Pulse, RAPID, exchange::run::Exchange, flight::Ball,
    rigid::restitution,
};
use crate::model::{Inputs, Mode};
use crate::solver::DoubleDouble;

/// Longest duration of a group over the period of ball 1; without gravity, over 2 pi s.
const LONGEST_GROUP: f64 = 1e-3;

/// Largest effort of a group, in units of about a tenth of a microsecond.
const EFFORT: u64 = 1_000_000;

/// Time at which an engine that follows a group starts.
pub(super) const START: DoubleDouble = DoubleDouble::ZERO;

pub(super) struct MappedGroup {
    /// Engine that has followed the group, with time 0 at the onset, and its first ball.
    pub engine: Engine,
    first: usize,
    /// The contacts of the engine that had pulses.
    contacts: Range<usize>,
    /// Onset relative to now, and end relative to the onset, s.
    onset: f64,
    end: DoubleDouble,
    pulses: Vec<Pulse>,
}

impl MappedGroup {
    pub fn contains(&self, j: usize) -> bool {
        (self.first + self.contacts.start..self.first + self.contacts.end).contains(&j)
    }

    /// From the end of the group to now, s.
    fn back(&self) -> f64 {
        (DoubleDouble::from(-self.onset) - self.end).value()
    }
}

impl Exchange {
    /// An engine for the balls of `range`, whose time 0 is `onset` (s) from now. The `closed` contacts, in ascending
    /// order, press.
    pub(in crate::engine::exchange) fn engine_at(
        &self,
        balls: &[Ball],
        range: &Range<usize>,
        onset: f64,
        closed: &[usize],
        observer: &mut dyn Observer,
    ) -> Engine {
        let contacts = range.start..range.end - 1;
        let inputs = Inputs { force: self.inputs.force[range.clone()].to_vec(), ..self.inputs };
        let mut engine = Engine::apart(&self.parameters.part(range), HeldInputs::constant(inputs, 0.0), 0.0);
        for (ball, before) in engine.balls.iter_mut().zip(&balls[range.clone()]) {
            let (displacement, v) = before.moved(onset.into());
            (ball.flight.x, ball.flight.v) = (before.flight.x + displacement, v);
        }
        let all = 0..engine.contacts.len();
        let is_closed = |j: usize| closed.binary_search(&(contacts.start + j)).is_ok();
        for (j, contact) in contacts.clone().zip(&mut engine.contacts) {
            match closed.binary_search(&j).is_ok() {
                true if self.is_rigid() => contact.set_anchored(0.0, Mode::Pressing),
                true => contact.set_anchored(self.state.overlaps[j], Mode::Pressing),
                false => {
                    contact.set_anchored(self.separation(balls, j, onset).at_time(onset.into()).0.min(0.0), Mode::Open);
                }
            }
        }
        if self.is_rigid() {
            // Velocities of balls that move as one differ by rounding only.
            let (masses, v): (Vec<f64>, Vec<f64>) =
                engine.balls.iter().map(|ball| (ball.model.mass, ball.flight.v)).unzip();
            for block in restitution::pool(&masses, &v, |j, _| is_closed(j)) {
                engine.balls[block.members].iter_mut().for_each(|ball| ball.flight.v = block.mean);
            }
            engine.regroup(all, START, RestRule::Closed, &[], observer);
            return engine;
        }
        for j in all.clone().filter(|j| is_closed(*j)) {
            engine.set_pressing(j, engine.contacts[j].at_anchors().overlap, START);
            engine.begin_pulse(j, START, observer);
        }
        engine.form(all.clone(), START);
        for j in all.filter(|j| !is_closed(*j)) {
            // Balls that have yet to part count as apart from then on.
            if engine.contacts[j].separation().is_some()
                && let Some(parting) = self.parting(balls, contacts.start + j, onset)
            {
                let anchor = DoubleDouble::from(parting - onset);
                let flight = self.separation(balls, contacts.start + j, parting);
                let overlap = flight.at_time(parting.into()).0.min(0.0);
                let separation = engine.separation(j, anchor, overlap);
                engine.contacts[j].role = ContactRole::Open(separation, Forecast::Never);
                engine.forecast(j, anchor);
            }
        }
        engine
    }

    /// Follows the group of contact `first` from its onset, `onset` (s) from now, with contacts that are `closed`
    /// already. `None` if the group does not end soon, or if a contact that is closed for the host takes part.
    pub(super) fn follow(
        &self,
        balls: &[Ball],
        first: usize,
        onset: f64,
        closed: &[usize],
    ) -> Result<Option<MappedGroup>, EngineError> {
        let is_closed = |j: usize| self.modes[j] != Mode::Open;
        let free = contiguous_range(first, self.modes.len(), |j| !is_closed(j) || closed.binary_search(&j).is_ok());
        let mut members = free.start..free.end + 1;
        loop {
            let mut pulses = Vec::new();
            let mut engine = self.engine_at(balls, &members, onset, closed, &mut pulses);
            let j = first - members.start;
            if self.is_rigid() {
                engine.rigid_impact(j, START, &mut pulses);
            } else if closed.is_empty() && !engine.begin_impact(j, START, &mut pulses) {
                engine.close(j, START, j..j + 1, &mut pulses);
            }
            let outcome = self.to_the_end(&mut engine, j, &mut pulses);
            engine.check_fault(self.time + onset)?;
            let Some((contacts, end)) = outcome? else { return Ok(None) };
            let beyond = |j: usize| !contacts.contains(&j) && engine.contacts[j].ledger.record.pulses > 0;
            if (0..engine.contacts.len()).any(beyond) {
                // Contacts of other groups have had pulses as well: repeats without them.
                members = members.start + contacts.start..members.start + contacts.end + 1;
                continue;
            }
            // A ball at the edge on which a closed contact acts was not in flight.
            let at_left = contacts.start == 0 && members.start > 0 && is_closed(members.start - 1);
            let at_end = contacts.end == engine.contacts.len() && members.end < self.balls();
            if at_left || at_end && is_closed(members.end - 1) {
                return Ok(None);
            }
            return Ok(Some(MappedGroup { engine, first: members.start, contacts, onset, end, pulses }));
        }
    }

    /// Advances `engine` until the group of contact `first` is open and has been so for as long as it lasted; with
    /// rigid contacts until no impact follows rapidly on the last, or until that takes too long. Returns the contacts
    /// of the group (all, if rigid) and that time; `None` if it does not come soon.
    fn to_the_end(
        &self,
        engine: &mut Engine,
        first: usize,
        observer: &mut dyn Observer,
    ) -> Result<Option<(Range<usize>, DoubleDouble)>, EngineError> {
        let limit = DoubleDouble::from(LONGEST_GROUP * std::f64::consts::TAU * self.cradle.balls[0].unit_of_time());
        let enough = engine.effort.saturating_add(EFFORT);
        let rigid = self.is_rigid();
        loop {
            let has_pulses = |j: usize| rigid || engine.contacts[j].ledger.record.pulses > 0;
            let group = contiguous_range(first, engine.contacts.len(), has_pulses);
            let records = engine.contacts[group.clone()].iter().map(|contact| contact.ledger.record);
            let last = records.fold(0.0, |last: f64, record| last.max(record.onset).max(record.release));
            let end = DoubleDouble::from(if rigid { last } else { 2.0 * last });
            let quiet = end + if rigid { RAPID } else { 0.0 };
            let open = rigid || !group.clone().any(|j| engine.presses(j));
            match engine.queue.first().filter(|(t, _)| !open || *t <= quiet) {
                None => return Ok(open.then_some((group, end))),
                Some((t, _)) if t > limit || engine.effort > enough => return Ok(rigid.then_some((group, end))),
                Some((t, key)) => engine.process(t, key, observer)?,
            }
        }
    }

    /// Applies the outcome of `group` to the states: from its end all balls move back, or on, to the current time, in
    /// flight or in a body. `balls` are the balls before it, `before` is the impulse of a contact from now to the onset
    /// (N.s).
    pub(super) fn apply(
        &mut self,
        balls: &[Ball],
        group: &MappedGroup,
        before: impl Fn(usize) -> f64,
        observer: &mut dyn Observer,
    ) {
        self.apply_motion(balls, group);
        self.apply_pulses(group, &before, observer);
        self.apply_impulses(group, &before);
        self.refresh();
    }

    /// Sets positions, velocities and overlaps, and adds to the energies: losses and work of the balls, losses of the
    /// contacts.
    fn apply_motion(&mut self, balls: &[Ball], group: &MappedGroup) {
        let MappedGroup { engine, first, contacts, onset, end, .. } = group;
        let (n, first, onset, end, back) = (self.balls(), *first, *onset, *end, group.back());
        let members = contacts.start..contacts.end + 1;
        // With the balls on either side, if there are any.
        let wide = members.start.saturating_sub(1)..(members.end + 1).min(engine.balls.len());
        let [loss, work] = self.sums_place();
        // Along the paths: places at the end, and displacements from there.
        let (mut places, mut moves, mut edges) = (Vec::new(), Vec::new(), Vec::new());
        for i in wide.clone() {
            let (mut ball, inputs) = (engine.balls[i].clone(), engine.own_forcing(i, end));
            ball.integrals = engine.integrals_at(i, end);
            (ball.flight.x, ball.flight.v) = engine.state_at(i, end);
            ball.anchor = START;
            let (displacement, v) = ball.moved(back.into());
            places.push(ball.flight.x);
            moves.push(displacement);
            if members.contains(&i) {
                for part in [
                    ball.integrals_under(&inputs, back.into()),
                    balls[first + i].integrals_under(&inputs, onset.into()),
                ] {
                    self.y[loss] += part.drag_loss;
                    self.y[work] += part.work;
                }
                let (k, x) = (first + i, ball.flight.x + displacement);
                let (place, change) = (self.cradle.balls[k].place(x), x - self.state.x[k]);
                self.y[n + k] = v * place.cos;
                if k == 0 {
                    self.y[0] = place.x;
                } else if i == 0 {
                    // The ball beside is not part of the engine and flies on.
                    edges.push((k - 1, [0.0, change]));
                }
                if i + 1 == engine.balls.len() && k + 1 < n {
                    edges.push((k, [change, 0.0]));
                }
            }
        }
        for (j, moves) in edges {
            self.y[1 + j] += self.cradle.pair(j).change_of_overlap([self.state.x[j], self.state.x[j + 1]], moves);
        }
        self.y[loss] += engine.totals.contact_loss;
        for (k, j) in (wide.start..wide.end - 1).enumerate() {
            let (places, moves) = ([places[k], places[k + 1]], [moves[k], moves[k + 1]]);
            let overlap = engine.overlap_at(j, end).0 + self.cradle.pair(first + j).change_of_overlap(places, moves);
            self.y[1 + first + j] = if engine.constraint(j).is_some() { 0.0 } else { overlap };
        }
    }

    /// Enters the pulses of the group in the records of its contacts.
    fn apply_pulses(&mut self, group: &MappedGroup, before: &impl Fn(usize) -> f64, observer: &mut dyn Observer) {
        let start = DoubleDouble::from(self.time) + group.onset;
        for pulse in &group.pulses {
            let (j, release) = (group.first + pulse.contact, start + pulse.release);
            if pulse.onset < 0.0 {
                // It began before the onset.
                let impulse = self.y[self.impulse_place(j)] + before(j) + pulse.impulse;
                self.contacts[j].close_pulse(j, release, impulse, observer);
            } else {
                self.contacts[j].open_pulse(start + pulse.onset, 0.0);
                self.contacts[j].ledger.raise_peak(pulse.peak.after(start), start);
                self.contacts[j].close_pulse(j, release, pulse.impulse, observer);
            }
        }
    }

    /// Sets the impulses of the contacts of the group and, if they are rigid, their modes, with a pulse of those that
    /// last.
    fn apply_impulses(&mut self, group: &MappedGroup, before: &impl Fn(usize) -> f64) {
        let MappedGroup { engine, first, contacts, onset, pulses, .. } = group;
        let (start, back) = (DoubleDouble::from(self.time) + *onset, group.back());
        for k in contacts.clone() {
            let (j, place) = (first + k, self.impulse_place(first + k));
            let at_onset = self.y[place] + before(j);
            self.y[place] = at_onset + engine.impulse_at(k, DoubleDouble::from(-onset)).value();
            if !self.is_rigid() {
                self.contacts[j].followed_until = Some(self.time - back);
                continue;
            }
            let (ledger, is_closed) = (&engine.contacts[k].ledger, engine.constraint(k).is_some());
            self.state.modes[j] = if is_closed { Mode::Pressing } else { Mode::Open };
            if is_closed && ledger.record.pulses > 0 {
                let ended: f64 = pulses.iter().filter(|pulse| pulse.contact == k).map(|pulse| pulse.impulse).sum();
                self.contacts[j].open_pulse(start + ledger.record.onset, at_onset + ended);
            }
        }
    }
}
