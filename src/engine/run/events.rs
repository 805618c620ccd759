//! The events of a run: the next one, onsets, and the regrouping of contacts.

use std::ops::Range;

use super::contact::{ContactRole, contiguous_range};
use super::engine::Engine;
use super::interaction::Interaction;
use crate::engine::flight::{EVALUATIONS, Separation};
use crate::engine::{EngineError, Fault, Forecast, Observer, Unrecorded};
use crate::model::Mode;
use crate::solver::DoubleDouble;

/// Effort (see [`Engine::effort`]) of an event.
const EVENT: u64 = 8;

/// Number of events at one time, plus some for each ball, beyond which a run has stalled. Fewer would stop runs that go
/// on (`tests/rust/stiff.rs`), more only delay the error.
const EVENTS_AT_ONCE: usize = 100;
const EVENTS_AT_ONCE_OF_A_BALL: usize = 20;

/// If balls on arcs are farther apart than this part of the distance of their pivots, their angles give the gap. Kept
/// as a quantity of its own, its rounding would grow with the ratio of distances until the next contact.
const APART: f64 = 1e-4;

impl Engine {
    pub(crate) fn process(
        &mut self,
        t: DoubleDouble,
        key: usize,
        observer: &mut dyn Observer,
    ) -> Result<(), EngineError> {
        if t.value() == f64::NEG_INFINITY {
            return Err(self.lost(key));
        }
        let crossing = self.contacts[key].separation().and_then(Separation::crossing);
        if crossing.is_some_and(|crossing| crossing <= t) {
            self.note(key, Some((t, Fault::Sides)));
            self.look_for_faults(0..self.balls.len(), t);
            return self.check_fault(0.0);
        }
        self.watch_progress(t, self.switching(key))?;
        self.handled = self.handled.saturating_add(1);
        self.effort = self.effort.saturating_add(EVENT);
        match &self.contacts[key].role {
            ContactRole::Interacting(id) => match &self.interactions[*id as usize] {
                Some(Interaction::Cluster(_)) => return self.end_segment(*id as usize, observer),
                Some(Interaction::Impact(_)) => self.end_impact(key, t, observer),
                Some(Interaction::Body(body)) if body.releases(key) => self.release_constraint(key, t, observer),
                Some(Interaction::Body(_)) | None => self.forecast(key, t),
            },
            ContactRole::Open(_, Forecast::At(_)) if self.is_rigid() => self.rigid_impact(key, t, observer),
            ContactRole::Open(_, Forecast::At(_)) => {
                if !self.begin_impact(key, t, observer) {
                    self.close(key, t, key..key + 1, observer);
                }
            }
            ContactRole::Open(..) if self.cradle.on_arcs() => {
                // Renews the series of this contact, and of neighbours whose series end soon. Those of rigid balls side
                // by side are renewed together, so that the balls stay side by side to the last bit.
                let beside = |separation: &Separation| self.is_rigid() && separation.touches(t, 0.0);
                let worn = |separation: &Separation| separation.nears_end(t) || beside(separation);
                let worn = |j: usize| self.contacts[j].separation().is_some_and(worn);
                let contacts = contiguous_range(key, self.contacts.len(), worn);
                self.reanchor_free(contacts.start..contacts.end + 1, t);
                let balls = self.balls[contacts.start..contacts.end + 1].iter_mut();
                balls.filter(|ball| ball.anchor == t).for_each(|ball| ball.starts_long = true);
                for j in contacts {
                    let rounding = self.contacts[j].separation().map_or(0.0, |separation| separation.rounding);
                    self.open_contact(j, t, rounding);
                }
            }
            ContactRole::Open(..) | ContactRole::Anchored(_) => self.forecast(key, t),
        }
        Ok(())
    }

    /// What has left the range of doubles, if the time of the queue entry `key` is not finite.
    pub(crate) fn lost(&self, key: usize) -> EngineError {
        let (time, contact) = (self.totals.last_event.value(), self.switching(key));
        let infinite = |ball: &usize| !self.balls[*ball].is_finite();
        let of_ball = |ball| EngineError::NotFinite { time, ball };
        (contact..contact + 2).find(infinite).map_or(EngineError::ContactNotFinite { time, contact }, of_ball)
    }

    /// The contact of the queue entry `key`; for a cluster, the one that switches.
    pub(crate) fn switching(&self, key: usize) -> usize {
        self.cluster(key).and_then(|cluster| cluster.switch).map_or(key, |(contact, _)| contact)
    }

    /// Closes contact `i` at `t`, and forms clusters with it, the interactions that its balls are in or next to, and
    /// the contacts of `range`.
    pub(crate) fn close(&mut self, i: usize, t: DoubleDouble, mut range: Range<usize>, observer: &mut dyn Observer) {
        let closed = |engine: &Self, j: &usize| engine.contacts[*j].is_closed();
        let mut members = range.clone().find(|j| closed(self, j)).map_or(i, |first| first.min(i))
            ..range.clone().rev().find(|j| closed(self, j)).map_or(i, |last| last.max(i)) + 2;
        // Balls next to a member that take part in an interaction become members, and so on.
        let mut ball = members.start.saturating_sub(1);
        while ball < (members.end + 1).min(self.balls.len()) {
            let freed = self.balls[ball].interaction.map_or(0..0, |id| self.dissolve(id as usize, t));
            if freed.is_empty() {
                ball += 1;
            } else {
                members = members.start.min(freed.start)..members.end.max(freed.end);
                ball = members.start.saturating_sub(1);
            }
        }
        range = range.start.min(members.start.saturating_sub(1))..range.end.max(members.end.min(self.contacts.len()));
        self.reanchor_free(range.start..range.end + 1, t);
        self.queue.remove(i);
        self.set_pressing(i, 0.0, t);
        self.begin_pulse(i, t, observer);
        self.form(range, t);
    }

    /// Closes contact `i` with this overlap (m) at `t`, where its balls are anchored.
    pub(crate) fn set_pressing(&mut self, i: usize, overlap: f64, t: DoubleDouble) {
        let rate = self.cradle.pair(i).overlap_rate([i, i + 1].map(|ball| self.state_at(ball, t)));
        let mode = self.cradle.contacts[i].mode_when_closed(overlap, rate);
        self.contacts[i].set_anchored(overlap, mode);
    }

    pub(crate) fn close_where_overlapping(&mut self, start: DoubleDouble) {
        for i in 0..self.contacts.len() {
            let overlap = self.cradle.pair(i).overlap(self.anchors(i));
            self.contacts[i].set_anchored(overlap, Mode::Open);
            if overlap > 0.0 {
                self.set_pressing(i, overlap, start);
                self.begin_pulse(i, start, &mut Unrecorded);
            }
        }
    }

    pub(crate) fn begin_pulse(&mut self, i: usize, t: DoubleDouble, observer: &mut dyn Observer) {
        let ledger = &mut self.contacts[i].ledger;
        ledger.open_pulse(t, self.step.number);
        observer.onset(i, ledger.record.onset);
        if let Some(recorder) = &mut self.recorder {
            let states = [i, i + 1].map(|ball| (self.balls[ball].flight.x, self.balls[ball].flight.v));
            recorder.onset(i, states, &self.cradle);
        }
        self.onsets = self.onsets.saturating_add(1);
        self.count_event();
    }

    pub(crate) fn end_pulse(&mut self, i: usize, t: DoubleDouble, observer: &mut dyn Observer) {
        observer.pulse(self.contacts[i].ledger.close_pulse(i, t));
        self.count_event();
    }

    /// Forms clusters of the closed contacts of `range`, none of which is in a cluster, and lets the other balls fly.
    pub(crate) fn form(&mut self, range: Range<usize>, t: DoubleDouble) {
        let closed: Vec<usize> = range.clone().filter(|&i| self.contacts[i].is_closed()).collect();
        // Groups whose outermost balls are neighbours soon act on one another, so they are one cluster.
        for group in closed.chunk_by(|left, right| left + 2 >= *right) {
            self.form_cluster(group[0]..group[group.len() - 1] + 2, t);
        }
        for i in range {
            if self.cluster(i).is_none() {
                self.open_contact(i, t, 0.0);
            }
        }
    }

    /// Ends the motion of contact `i`, if it is open between balls in flight, which are anchored at `t`.
    pub(crate) fn stop_separation(&mut self, i: usize, t: DoubleDouble) {
        if let Some(separation) = self.contacts[i].separation() {
            let overlap = separation.at_time(t).0;
            self.contacts[i].set_anchored(overlap, Mode::Open);
            self.queue.remove(i);
        }
    }

    /// Makes contact `i` open from `t` on, with both balls in flight. Overlaps of rigid balls up to `rounding` (m)
    /// count as none.
    pub(crate) fn open_contact(&mut self, i: usize, t: DoubleDouble, rounding: f64) {
        let before = self.contacts[i].separation();
        let overlap = before.map_or(self.contacts[i].at_anchors().overlap, |separation| separation.at_time(t).0);
        let mut overlap = overlap.min(0.0);
        if self.cradle.on_arcs() {
            // The series of both balls are about the same time.
            self.reanchor_free(i..i + 2, t);
            let pair = self.cradle.pair(i);
            if -overlap > APART * pair.law.pivots {
                overlap = pair.overlap([0, 1].map(|k| self.balls[i + k].flight_at(t).x));
            }
        }
        self.contacts[i].role = ContactRole::Open(self.separation(i, t, overlap), Forecast::Never);
        let (rigid, age) = (self.is_rigid(), self.input_age(t));
        if let ContactRole::Open(separation, _) = &mut self.contacts[i].role
            && rigid
        {
            separation.make_rigid(rounding, age);
        }
        self.forecast(i, t);
    }

    /// The relative motion of the balls of contact `i`, in flight, from `overlap` (m) at `t` on.
    pub(crate) fn separation(&self, i: usize, t: DoubleDouble, overlap: f64) -> Separation {
        Separation::new(&self.balls[i], &self.balls[i + 1], t, overlap, &self.cradle.contacts[i])
    }

    /// Places (m) of the balls of contact `i` at their anchors.
    pub(crate) fn anchors(&self, i: usize) -> [f64; 2] {
        [i, i + 1].map(|ball| self.balls[ball].flight.x)
    }

    /// Forecasts, from `t` on, the next onset of contact `i`, whose balls are in flight, or the end of its constraint.
    pub(crate) fn forecast(&mut self, i: usize, t: DoubleDouble) {
        let mut allowed = EVALUATIONS;
        let (mut found, forecast) = match &mut self.contacts[i].role {
            ContactRole::Open(separation, forecast) => (separation.forecast(t, &mut allowed), forecast),
            ContactRole::Interacting(id) => {
                let Some(Interaction::Body(body)) = &mut self.interactions[*id as usize] else { return };
                let Some(constraint) = body.constraint_mut(i) else { return };
                (constraint.forecast(t, &mut allowed), &mut constraint.end)
            }
            ContactRole::Anchored(_) => return,
        };
        // Rounding at late times must not lead into the past.
        if let Forecast::At(time) | Forecast::NotBefore(time) = &mut found
            && *time < t
        {
            *time = t;
        }
        *forecast = found;
        self.effort = self.effort.saturating_add(u64::from(EVALUATIONS - allowed));
        match found {
            Forecast::At(time) | Forecast::NotBefore(time) => self.queue.set(i, time),
            Forecast::Never => self.queue.remove(i),
        }
    }

    pub(crate) fn count_event(&mut self) {
        self.totals.work.events = self.totals.work.events.saturating_add(1);
    }

    /// Largest number of events at one time.
    pub(crate) fn most_without_progress(&self) -> usize {
        EVENTS_AT_ONCE + EVENTS_AT_ONCE_OF_A_BALL * self.balls.len()
    }

    /// Fails when more events come at one time than an impact can cause.
    fn watch_progress(&mut self, t: DoubleDouble, contact: usize) -> Result<(), EngineError> {
        // Chatter of rigid contacts ends where the rounded time makes no progress.
        let progress =
            if self.is_rigid() { t.value() > self.totals.last_event.value() } else { t > self.totals.last_event };
        if progress {
            self.totals.standstill = 0;
        }
        if t > self.totals.last_event {
            self.totals.last_event = t;
        }
        self.totals.standstill += 1;
        let stalled = self.totals.standstill > self.most_without_progress();
        if stalled { Err(EngineError::Stalled { time: t.value(), contact }) } else { Ok(()) }
    }
}
