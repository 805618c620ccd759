//! Clusters within a run: formed, followed from switching to switching, and dissolved.

use std::ops::Range;

use super::contact::ContactRole;
use super::engine::Engine;
use super::interaction::Interaction;
use crate::engine::cluster::{Cluster, StepHistory, Switch};
use crate::engine::{EngineError, Fault, Observer, Peak};
use crate::model::Mode;
use crate::solver::DoubleDouble;

/// Effort ([`Engine::effort`]) of a segment: for each contact of the window, and for each evaluation of a contact
/// force.
const SEGMENT: u64 = 24;
const EVALUATION: u64 = 2;

impl Engine {
    /// Whether a force law acts in contact `j`.
    pub(crate) fn presses(&self, j: usize) -> bool {
        match self.interaction_of_contact(j) {
            Some(Interaction::Cluster(cluster)) => cluster.mode(j) != Mode::Open,
            Some(Interaction::Impact(_)) => true,
            Some(Interaction::Body(_)) | None => false,
        }
    }

    /// Ends the segment of cluster `id`: continues with the next one, or handles the switching.
    pub(crate) fn end_segment(&mut self, id: usize, observer: &mut dyn Observer) -> Result<(), EngineError> {
        let Some(Interaction::Cluster(cluster)) = &self.interactions[id] else { return Ok(()) };
        let t = cluster.end();
        let Some(mut cluster) = self.take_cluster(id, t) else { return Ok(()) };
        self.account_until(&mut cluster, t);
        let finite = cluster.check_finite();
        if finite.is_err() {
            self.follow(id, cluster); // What is left can still be read.
            return finite;
        }
        self.look_for_faults(cluster.members.clone(), t);
        match cluster.switch {
            None => self.follow(id, cluster),
            Some((i, Switch::Clip)) => {
                let mode = &mut cluster.contacts[i - cluster.window.start].mode;
                *mode = if *mode == Mode::Pressing { Mode::Clipped } else { Mode::Pressing };
                self.count_event();
                self.follow(id, cluster);
            }
            Some((i, Switch::Onset)) => {
                let range = cluster.window_contacts();
                self.release_members(cluster, t);
                self.close(i, t, range, observer);
            }
            Some((i, Switch::Release)) => {
                let range = cluster.window_contacts();
                self.release_members(cluster, t);
                self.contacts[i].set_anchored(0.0, Mode::Open);
                self.end_pulse(i, t, observer);
                self.form(range, t);
            }
        }
        Ok(())
    }

    pub(crate) fn form_cluster(&mut self, members: Range<usize>, t: DoubleDouble) {
        let window = members.start.saturating_sub(1)..(members.end + 1).min(self.balls.len());
        let id = self.number_of_next();
        for i in members.clone() {
            self.reanchor(i, t);
            self.balls[i].interaction = Some(id);
        }
        let mut cluster = self.caches.spare.take().unwrap_or_default();
        let contacts = window.start..window.end - 1;
        cluster.renew(members, window.clone(), t, StepHistory::default());
        cluster.flights.extend(self.balls[window].iter().map(|ball| ball.flight_at(t)));
        cluster.contacts.extend(contacts.map(|i| {
            self.stop_separation(i, t);
            let contact = self.contacts[i].at_anchors();
            self.contacts[i].role = ContactRole::Interacting(id);
            contact
        }));
        self.follow(id as usize, cluster);
    }

    /// Computes the next segment of a cluster and puts it back in its place.
    fn follow(&mut self, id: usize, mut cluster: Box<Cluster>) {
        cluster.expand(&self.balls, &self.cradle, &self.control);
        self.totals.work.steps = self.totals.work.steps.saturating_add(1);
        self.totals.work.evaluations = self.totals.work.evaluations.saturating_add(cluster.evaluations);
        let effort = SEGMENT * cluster.contacts.len() as u64 + EVALUATION * cluster.evaluations + cluster.searched();
        self.effort = self.effort.saturating_add(effort);
        self.queue.set(cluster.key(), cluster.end());
        if let Some(contact) = cluster.crossed(&self.cradle) {
            self.note(contact, Some((cluster.start, Fault::Sides)));
        }
        self.interactions[id] = Some(Interaction::Cluster(cluster));
    }

    /// Moves the start of the cluster's segment to `t`, and updates the ledgers to then.
    pub(crate) fn account_until(&mut self, cluster: &mut Cluster, t: DoubleDouble) {
        let tau = (t - cluster.start).value().min(cluster.length);
        if tau == 0.0 {
            return; // Nothing has happened yet.
        }
        let step_start = (DoubleDouble::from(self.step.time) - cluster.start).value().clamp(0.0, tau);
        for i in cluster.window_contacts() {
            if cluster.mode(i) != Mode::Open {
                let ledger = &mut self.contacts[i].ledger;
                if ledger.impulse_at_start(self.step.number).is_none() {
                    ledger.begin_step(self.step.number, ledger.impulse + cluster.impulse(i, step_start));
                }
                let (of_pulse, of_step) = (ledger.pulse_peak.force, ledger.peak_in_step(self.step.number));
                // Searched over the whole segment, so that it does not depend on where the steps begin.
                let found = cluster.peak(i, 0.0, tau, of_pulse);
                let peak = found.map_or(of_pulse, |found| found.force.max(of_pulse));
                let in_step = match step_start == 0.0 {
                    true if peak > of_pulse => peak,
                    true if of_step >= peak => of_step,
                    _ => cluster.largest_force(i, step_start, tau, of_step),
                };
                ledger.add(cluster.impulse(i, tau));
                ledger.raise_peak_of_step(in_step);
                if let Some(found) = found {
                    let peak = found.after(cluster.start);
                    let time = if found.time == tau { t.value_up() } else { peak.time };
                    ledger.raise_peak(Peak { time, ..peak }, cluster.start);
                }
                self.totals.contact_loss += cluster.contact_loss(i, &self.cradle.contacts[i], tau);
            }
        }
        if let Some(recorder) = &mut self.recorder {
            recorder.follow(cluster, tau, t == cluster.end(), &self.cradle, &self.inputs);
        }
        for i in cluster.members.clone() {
            self.balls[i].integrals = cluster.integrals(i, &self.balls[i].integrals, &self.balls[i], tau);
            self.balls[i].anchor = t;
        }
        cluster.move_start(tau, &self.balls, &self.cradle.contacts);
        cluster.start = t;
        for i in cluster.members.clone() {
            self.balls[i].flight = cluster.flights[i - cluster.window.start];
            self.balls[i].starts_long = false;
        }
    }

    /// Takes the interaction `id` out of its place for an event at `t`, if it is a cluster.
    fn take_cluster(&mut self, id: usize, t: DoubleDouble) -> Option<Box<Cluster>> {
        let Some(Interaction::Cluster(cluster)) = &self.interactions[id] else { return None };
        cluster.members.clone().for_each(|i| self.before_move(i, t));
        if let Some(Interaction::Cluster(cluster)) = self.interactions[id].take() { Some(cluster) } else { None }
    }

    /// Ends cluster or impact number `id` at the time `t`: its members are then in flight, and its contacts keep their
    /// overlaps and modes. Returns the members; an empty range if there is no such interaction.
    pub(crate) fn dissolve(&mut self, id: usize, t: DoubleDouble) -> Range<usize> {
        match &self.interactions[id] {
            None | Some(Interaction::Body(_)) => 0..0,
            Some(Interaction::Impact(impact)) => {
                let contact = impact.contact;
                self.break_impact(contact, t);
                contact..contact + 2
            }
            Some(Interaction::Cluster(cluster)) => {
                let members = cluster.members.clone();
                if let Some(mut cluster) = self.take_cluster(id, t) {
                    self.account_until(&mut cluster, t);
                    self.release_members(cluster, t);
                }
                members
            }
        }
    }

    /// Ends a cluster that has been followed to the time `t`. All balls of its window are anchored there from then on.
    fn release_members(&mut self, cluster: Box<Cluster>, t: DoubleDouble) {
        self.queue.remove(cluster.key());
        for ball in &mut self.balls[cluster.members.clone()] {
            ball.interaction = None;
        }
        self.reanchor_free(cluster.window.clone(), t);
        for (i, contact) in cluster.window_contacts().zip(&cluster.contacts) {
            self.contacts[i].role = ContactRole::Anchored(*contact);
        }
        self.caches.spare = Some(cluster);
    }
}
