//! The events of a run: onsets, releases and switchings, and what they do to the clusters.

use std::ops::Range;

use super::ball::Held;
use super::cluster::Cluster;
use super::pace::Pace;
use super::separation::{EVALUATIONS, Forecast, Separation};
use super::window::{Mode, Switch, WindowContact};
use super::{Engine, EngineError, Observer};
use crate::solver::double_double::DoubleDouble;

/// Effort (see [`Engine::effort`]) of an event, of each contact of a cluster's window in a new segment, and of each evaluation of a
/// contact force for it.
const EVENT: u64 = 8;
const SEGMENT: u64 = 24;
const EVALUATION: u64 = 2;

impl Engine {
    /// Handles the event of queue entry `key` at time `t`.
    pub(super) fn process(
        &mut self,
        t: DoubleDouble,
        key: usize,
        observer: &mut dyn Observer,
    ) -> Result<(), EngineError> {
        if t.value() == f64::NEG_INFINITY {
            return Err(EngineError::NotFinite { time: self.last_event.value(), ball: key });
        }
        self.watch_progress(t, self.switching(key))?;
        self.handled += 1;
        self.effort = self.effort.saturating_add(EVENT);
        let contact = &self.contacts[key];
        if let Some(id) = contact.cluster {
            return self.end_segment(id as usize, observer);
        }
        if contact.impact.is_some() {
            self.end_impact(key, t, observer);
        } else if !contact.due {
            self.forecast(key, t);
        } else if contact.bond.is_some() {
            self.part(key, t, observer);
        } else if self.is_rigid() {
            self.meet(key, t, observer);
        } else if !self.begin_impact(key, t) {
            self.close(key, t, key..key + 1);
        }
        Ok(())
    }

    /// The contact that the queue entry `key` is about: of a cluster the one that switches, if one does.
    pub(super) fn switching(&self, key: usize) -> usize {
        let cluster = self.contacts[key].cluster.and_then(|id| self.clusters[id as usize].as_ref());
        cluster.and_then(|cluster| cluster.switch).map_or(key, |(contact, _)| contact)
    }

    /// The segment of cluster `id` is over: go on, or switch what switches there.
    fn end_segment(&mut self, id: usize, observer: &mut dyn Observer) -> Result<(), EngineError> {
        let Some(t) = self.clusters[id].as_ref().map(Cluster::end) else { return Ok(()) };
        let Some(mut cluster) = self.take_cluster(id, t) else { return Ok(()) };
        self.fold(&mut cluster, t);
        if let Some(ball) = cluster.flights.iter().position(|f| !(f.x.is_finite() && f.v.is_finite())) {
            let error = EngineError::NotFinite { time: t.value(), ball: cluster.window.start + ball };
            self.follow(id, cluster); // What is left can still be looked at.
            return Err(error);
        }
        let switch = cluster.switch;
        match switch {
            None => self.follow(id, cluster),
            Some((i, Switch::Clip | Switch::Unclip)) => {
                let mode = if switch == Some((i, Switch::Clip)) { Mode::Clipped } else { Mode::Pressing };
                cluster.contacts[i - cluster.window.start].mode = mode;
                self.count_event();
                self.follow(id, cluster);
            }
            Some((i, Switch::Release)) => {
                let range = cluster.window_contacts();
                self.release_members(cluster, t);
                (self.contacts[i].overlap, self.contacts[i].mode) = (0.0, Mode::Open);
                observer.pulse(self.contacts[i].ledger.close_pulse(i, t));
                self.count_event();
                self.form(range, t);
            }
            Some((i, Switch::Onset)) => {
                let range = cluster.window_contacts();
                self.release_members(cluster, t);
                self.close(i, t, range);
            }
        }
        Ok(())
    }

    /// Contact `i` closes at time `t`: the clusters that its balls belong to or border on become one, with the contacts of
    /// `range`, which have left theirs.
    fn close(&mut self, i: usize, t: DoubleDouble, range: Range<usize>) {
        let closed = |engine: &Self, j: &usize| engine.contacts[*j].mode != Mode::Open;
        let mut members = range.clone().find(|j| closed(self, j)).map_or(i, |first| first.min(i))
            ..range.clone().rev().find(|j| closed(self, j)).map_or(i, |last| last.max(i)) + 2;
        let mut range = range;
        // Balls next to a member that are held themselves become members, and so on.
        let mut ball = members.start.saturating_sub(1);
        while ball < (members.end + 1).min(self.balls.len()) {
            let freed = match self.balls[ball].held {
                Held::Free | Held::Bond => ball..ball,
                Held::Impact(contact) => {
                    self.break_impact(contact as usize, t);
                    contact as usize..contact as usize + 2
                }
                Held::Cluster(id) => {
                    let (balls, contacts) = self.dissolve(id as usize, t);
                    range = range.start.min(contacts.start)..range.end.max(contacts.end);
                    balls
                }
            };
            if freed.is_empty() {
                ball += 1;
            } else {
                members = members.start.min(freed.start)..members.end.max(freed.end);
                ball = members.start.saturating_sub(1);
            }
        }
        range = range.start.min(members.start.saturating_sub(1))..range.end.max(members.end.min(self.contacts.len()));
        self.land_free(range.start..range.end + 1, t);
        for j in range.clone() {
            self.contacts[j].waits = false;
        }
        self.close_separation(i);
        let rate = self.balls[i].moved(t).1 - self.balls[i + 1].moved(t).1;
        self.contacts[i].mode = Mode::of_closed(&self.cradle.contacts[i], 0.0, rate);
        self.contacts[i].ledger.open_pulse(t, self.step);
        self.onsets = self.onsets.saturating_add(1);
        self.count_event();
        self.form(range, t);
    }

    /// Contacts that overlap at the start are closed from then on.
    pub(super) fn close_where_overlapping(&mut self, start: DoubleDouble) {
        for i in 0..self.contacts.len() {
            let (left, right) = (&self.balls[i].flight, &self.balls[i + 1].flight);
            let (law, contact) = (&self.cradle.contacts[i], &mut self.contacts[i]);
            contact.overlap = left.x - right.x - law.clearance;
            if contact.overlap > 0.0 {
                contact.mode = Mode::of_closed(law, contact.overlap, left.v - right.v);
                contact.ledger.open_pulse(start, self.step);
                self.onsets = self.onsets.saturating_add(1);
                self.work.events += 1;
            }
        }
    }

    /// Forms clusters of what is closed among the contacts of `range` and lets the others fly. None of them is in a cluster.
    pub(super) fn form(&mut self, range: Range<usize>, t: DoubleDouble) {
        let closed = |engine: &Self, i: usize| i < range.end && engine.contacts[i].mode != Mode::Open;
        let mut i = range.start;
        while i < range.end {
            if closed(self, i) {
                let first = i;
                let mut last = i;
                // Groups whose outermost balls are neighbours act on one another before long: one cluster.
                while let Some(next) = [last + 1, last + 2].into_iter().find(|&j| closed(self, j)) {
                    last = next;
                }
                self.found(first..last + 2, t);
                i = last + 1;
            } else {
                i += 1;
            }
        }
        for i in range {
            if self.contacts[i].cluster.is_none() {
                self.fly(i, t);
            }
        }
    }

    /// A new cluster of the balls `members` at time `t`.
    fn found(&mut self, members: Range<usize>, t: DoubleDouble) {
        let window = members.start.saturating_sub(1)..(members.end + 1).min(self.balls.len());
        let id = self.clusters.iter().position(Option::is_none).unwrap_or_else(|| {
            self.clusters.push(None);
            self.clusters.len() - 1
        });
        for i in members.clone() {
            self.land(i, t);
            self.balls[i].held = Held::Cluster(id as u32);
        }
        let contacts = window.start..window.end - 1;
        let age = self.contacts[contacts.clone()].iter().map(|contact| contact.age).max().unwrap_or_default();
        let contacts = contacts.map(|i| {
            self.stop_separation(i, t);
            let contact = &mut self.contacts[i];
            contact.cluster = Some(id as u32);
            WindowContact { overlap: contact.overlap, mode: contact.mode }
        });
        let contacts = contacts.collect();
        let flights = window.clone().map(|i| self.balls[i].flight_at(t)).collect();
        self.follow(id, Cluster::new(members, window, t, flights, contacts, Pace::aged(age)));
    }

    /// Computes the next segment of a cluster and puts it back in its place.
    fn follow(&mut self, id: usize, mut cluster: Cluster) {
        cluster.expand(&self.balls, &self.cradle.contacts, &self.control);
        self.work.steps = self.work.steps.saturating_add(1);
        self.work.evaluations = self.work.evaluations.saturating_add(cluster.evaluations);
        let effort = SEGMENT * cluster.contacts.len() as u64 + EVALUATION * cluster.evaluations + cluster.searched();
        self.effort = self.effort.saturating_add(effort);
        self.queue.set(cluster.key(), cluster.end());
        self.clusters[id] = Some(cluster);
    }

    /// Cluster `id`, if it is there, taken out of its place by an event at `t`.
    fn take_cluster(&mut self, id: usize, t: DoubleDouble) -> Option<Cluster> {
        for i in self.clusters[id].as_ref()?.members.clone() {
            self.before_move(i, t);
        }
        self.clusters[id].take()
    }

    /// Moves the start of the cluster's segment to `t`, a time on it, and enters in the ledgers what happened till then.
    pub(super) fn fold(&mut self, cluster: &mut Cluster, t: DoubleDouble) {
        let tau = (t - cluster.start).value().min(cluster.length);
        let step_start = (DoubleDouble::from(self.step_start) - cluster.start).value().clamp(0.0, tau);
        for i in cluster.window_contacts() {
            if cluster.mode(i) != Mode::Open {
                let ledger = &mut self.contacts[i].ledger;
                if ledger.impulse_at_start(self.step).is_none() {
                    ledger.begin_step(self.step, ledger.impulse + cluster.impulse(i, step_start));
                }
                let (of_pulse, of_step) = (ledger.peak_of_pulse(), ledger.peak_in_step(self.step));
                // Looked for over the whole segment, so that it does not depend on where the steps begin.
                let peak = cluster.peak(i, 0.0, tau, of_pulse);
                let in_step = match step_start == 0.0 {
                    true if peak > of_pulse => peak,
                    true if of_step >= peak => of_step,
                    _ => cluster.peak(i, step_start, tau, of_step),
                };
                self.contacts[i].ledger.add(cluster.impulse(i, tau), peak, in_step);
                self.contact_loss += cluster.contact_loss(i, &self.cradle.contacts[i], tau);
            }
        }
        for i in cluster.members.clone() {
            self.balls[i].tally = cluster.tally(i, &self.balls[i].tally, &self.balls[i], tau);
            self.balls[i].anchor = t;
        }
        cluster.move_start(tau, &self.balls, &self.cradle.contacts);
        cluster.start = t;
    }

    /// Ends cluster `id`, if it is there, at time `t`: its members are in flight, its contacts hold their overlaps and modes.
    /// Returns the members and the contacts of the window; empty ranges if it was not there.
    pub(super) fn dissolve(&mut self, id: usize, t: DoubleDouble) -> (Range<usize>, Range<usize>) {
        let Some(mut cluster) = self.take_cluster(id, t) else { return (0..0, 0..0) };
        let (members, contacts) = (cluster.members.clone(), cluster.window_contacts());
        self.fold(&mut cluster, t);
        self.release_members(cluster, t);
        (members, contacts)
    }

    fn release_members(&mut self, cluster: Cluster, t: DoubleDouble) {
        self.queue.remove(cluster.key());
        for i in cluster.members.clone() {
            let ball = &mut self.balls[i];
            (ball.flight, ball.anchor, ball.held) = (cluster.flights[i - cluster.window.start], t, Held::Free);
        }
        for (i, state) in cluster.window_contacts().zip(&cluster.contacts) {
            let contact = &mut self.contacts[i];
            (contact.overlap, contact.mode, contact.cluster) = (state.overlap, state.mode, None);
            contact.age = cluster.pace.age;
        }
    }

    /// Contact `i`, if it is between balls in flight, holds its overlap at `t` and has no forecast any more.
    pub(super) fn stop_separation(&mut self, i: usize, t: DoubleDouble) {
        let contact = &mut self.contacts[i];
        if let Some(separation) = &contact.separation {
            contact.overlap = separation.at_time(t).0;
            contact.separation = None;
            self.queue.remove(i);
        }
    }

    /// Ends the separation of contact `i`, which is at its onset: its overlap is 0.
    pub(super) fn close_separation(&mut self, i: usize) {
        (self.contacts[i].overlap, self.contacts[i].separation) = (0.0, None);
        self.queue.remove(i);
    }

    /// Contact `i` is open and both its balls are in flight from `t` on.
    pub(super) fn fly(&mut self, i: usize, t: DoubleDouble) {
        let overlap = self.contacts[i].overlap.min(0.0);
        (self.contacts[i].waits, self.contacts[i].age) = (false, 0);
        let clearance = self.cradle.contacts[i].clearance;
        let separation = Separation::new(&self.balls[i], &self.balls[i + 1], t, overlap, clearance);
        self.contacts[i].separation = Some(separation);
        self.forecast(i, t);
    }

    /// Looks from `t` on for the next onset of contact `i`, whose balls are in flight, or for the end of its bond.
    pub(super) fn forecast(&mut self, i: usize, t: DoubleDouble) {
        let contact = &mut self.contacts[i];
        let mut allowed = EVALUATIONS;
        let forecast = match (&contact.bond, &contact.separation) {
            (Some(bond), _) => bond.forecast(t, &mut allowed),
            (None, Some(separation)) => separation.forecast(t, &mut allowed),
            (None, None) => return,
        };
        self.effort = self.effort.saturating_add(u64::from(EVALUATIONS - allowed));
        contact.due = matches!(forecast, Forecast::At(_));
        match forecast {
            Forecast::At(time) | Forecast::NotBefore(time) => self.queue.set(i, time),
            Forecast::Never => self.queue.remove(i),
        }
    }

    pub(super) fn count_event(&mut self) {
        self.work.events = self.work.events.saturating_add(1);
    }

    /// Events that an impact can bring about without any progress of time.
    pub(super) fn most_without_progress(&self) -> usize {
        100 + 20 * self.balls.len()
    }

    /// Fails when events follow each other without any progress of time beyond what one impact can bring about.
    fn watch_progress(&mut self, t: DoubleDouble, contact: usize) -> Result<(), EngineError> {
        // Chatter of rigid contacts is at its end where the clock shows no progress.
        let progress = if self.is_rigid() { t.value() > self.last_event.value() } else { t > self.last_event };
        if progress {
            self.standstill = 0;
        }
        if t > self.last_event {
            self.last_event = t;
        }
        self.standstill += 1;
        if self.standstill > self.most_without_progress() {
            return Err(EngineError::Stalled { time: t.value(), contact });
        }
        Ok(())
    }
}
