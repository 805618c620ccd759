//! A run as plain data, from which it continues bit-for-bit identically: anchors, overlaps, forecasts and sums, of
//! which all else is computed by the same operations as before. Inconsistent snapshots are refused.

use serde::{Deserialize, Serialize};

use super::contact::ContactRole;
use super::engine::{Engine, NO_STEP};
use crate::engine::cluster::Cluster;
use crate::engine::flight::{Ball, BallRole, Flight};
use crate::engine::{Forecast, StepStart, pair_impact::PairImpact};
use crate::model::{Mode, Parameters};
use crate::solver::{DoubleDouble, Oscillator};

/// A run as plain data.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Snapshot {
    run: Engine,
    /// The copy that looks ahead, unless it is where the run is.
    copy: Option<Box<Engine>>,
    /// The result of the look ahead, and the time of the request, s.
    found: Option<(f64, Forecast)>,
}

/// An inconsistent snapshot, and what shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InvalidState(pub &'static str);

pub(crate) fn require(holds: bool, reason: &'static str) -> Result<(), InvalidState> {
    if holds { Ok(()) } else { Err(InvalidState(reason)) }
}

impl Engine {
    /// The run as it is now, without the part of its look ahead that has passed.
    pub fn snapshot(&self) -> Snapshot {
        let run = self.clone();
        let mut copy = run.caches.ahead.take().filter(|copy| copy.handled > run.handled);
        if copy.take_if(|copy| !copy.has_finite_sums()).is_some() {
            self.caches.ahead.take(); // Both go on in the same way.
        }
        let found = run.caches.found.get().filter(|(_, found)| found.time() > run.time);
        Snapshot { run, copy, found }
    }

    /// The run of `snapshot`, with its parameters and its start time (s). After a failed step (`failed`) any values
    /// pass, because the run can only be read.
    pub fn restore(
        parameters: &Parameters,
        start: f64,
        snapshot: Snapshot,
        failed: bool,
    ) -> Result<Self, InvalidState> {
        let Snapshot { run, copy, found } = snapshot;
        let engine = run.rebuilt(parameters, start, failed)?;
        let now = DoubleDouble::from(engine.time);
        let missed = |run: &Self, since: DoubleDouble| run.queue.first().is_some_and(|(t, _)| t < since);
        require(failed || !missed(&engine, now), "an event was missed")?;
        if let Some(mut copy) = copy {
            // The time of a copy that looks ahead is that of its last event. Its field means nothing; it is kept so
            // that the same state has the same bytes.
            let (time, last) = (copy.time, copy.totals.last_event);
            (copy.time, copy.step.time) = (last.value_up(), last.value_up());
            let mut copy = copy.rebuilt(parameters, start, failed)?;
            let sound = failed || last >= now && !missed(&copy, last);
            require(sound && copy.handled > engine.handled, "its look ahead ends in the past")?;
            (copy.time, copy.step.time) = (time, NO_STEP);
            engine.caches.ahead.replace(Some(Box::new(copy)));
        }
        engine.caches.found.set(found.filter(|(_, found)| found.time() > engine.time));
        Ok(engine)
    }

    /// The run without its look ahead.
    fn rebuilt(self, parameters: &Parameters, start: f64, failed: bool) -> Result<Self, InvalidState> {
        let (n, m) = (parameters.balls(), parameters.contacts());
        let StepStart { balls, contacts, .. } = &self.step;
        let lengths = [(self.balls.len(), self.contacts.len()), (balls.len(), contacts.len())];
        let fits = lengths == [(n, m); 2] && self.clusters.len() <= m && self.inputs.fit(n);
        require(fits, "its size does not match the cradle")?;
        if !failed {
            self.check_values(start)?;
        }
        // All fields that are not skipped: what is saved is restored here, and checked.
        let Self { time, inputs, balls, contacts, clusters, step, totals, handled, onsets, .. } = self;
        let apart = Self::apart(parameters, inputs, time);
        let mut engine = Self { contacts, step: step.restored(), totals, handled, onsets, ..apart };
        require(totals.standstill <= engine.most_without_progress() + 1, "a count is too large")?;
        for (ball, Ball { anchor, flight, integrals, starts_long, .. }) in engine.balls.iter_mut().zip(balls) {
            (ball.anchor, ball.flight, ball.integrals, ball.starts_long) = (anchor, flight, integrals, starts_long);
        }
        for cluster in clusters {
            engine.clusters.push(None);
            cluster.map_or(Ok(()), |cluster| engine.restore_cluster(cluster))?;
        }
        let contacts = 0..engine.contacts.len();
        for i in contacts.clone() {
            match &engine.contacts[i].role {
                ContactRole::Impact(_) => engine.restore_impact(i)?,
                ContactRole::Constraint(constraint, _) => {
                    engine.restore_constraint(i, constraint.oscillator, failed)?
                }
                ContactRole::Window(id) => {
                    let cluster = engine.clusters.get(*id as usize).and_then(Option::as_ref);
                    let its_own = cluster.is_some_and(|cluster| cluster.window_contacts().contains(&i));
                    require(its_own, "a contact lost its cluster")?;
                }
                ContactRole::Open(..) | ContactRole::BesideImpact(_) | ContactRole::Unassigned(_) => {}
            }
        }
        contacts.into_iter().try_for_each(|i| engine.restore_role(i, failed))?;
        Ok(engine)
    }

    fn restore_cluster(&mut self, mut cluster: Box<Cluster>) -> Result<(), InvalidState> {
        let Cluster { members, flights, contacts, .. } = &*cluster;
        let balls = self.balls.len();
        require(members.start < members.end && members.end <= balls && members.len() > 1, "a cluster has no balls")?;
        let window = members.start.saturating_sub(1)..(members.end + 1).min(balls);
        let fits = flights.len() == window.len() && contacts.len() + 1 == window.len();
        require(fits, "the size of a cluster does not match its window")?;
        let id = self.clusters.len() - 1;
        for (i, state) in (window.start..window.end - 1).zip(contacts) {
            let its_own = self.contacts[i].cluster() == Some(id as u32);
            require(its_own, "a contact is not in the window of its cluster")?;
            let law = &self.cradle.contacts[i];
            require(state.mode != Mode::Clipped || law.clips(), "a contact is clipped whose law does not clip")?;
        }
        let closed = |i: usize| contacts[i - window.start].mode != Mode::Open;
        require(closed(members.start) && closed(members.end - 2), "a cluster holds balls that touch nothing")?;
        for ball in &mut self.balls[members.clone()] {
            require(ball.role == BallRole::Flight, "a ball is in two clusters")?;
            ball.role = BallRole::Cluster(id as u32);
        }
        (cluster.window, cluster.history) = (window, cluster.history_before);
        cluster.expand(&self.balls, &self.cradle, &self.control);
        self.queue.set(cluster.key(), cluster.end());
        self.clusters[id] = Some(cluster);
        Ok(())
    }

    fn restore_impact(&mut self, i: usize) -> Result<(), InvalidState> {
        let (left, right) = (&self.balls[i], &self.balls[i + 1]);
        require(left.role == BallRole::Flight && right.role == BallRole::Flight, "a ball is in two impacts")?;
        require(left.anchor == right.anchor, "the balls of an impact have not met")?;
        let impact = PairImpact::new(left, right, &self.cradle.contacts[i], &self.impact_coefficients);
        let impact = impact.ok_or(InvalidState("an impact has no outcome"))?;
        self.queue.set(i, impact.end());
        self.contacts[i].role = ContactRole::Impact(Some(impact));
        for ball in &mut self.balls[i..i + 2] {
            ball.role = BallRole::Impact(i as u32);
        }
        Ok(())
    }

    /// Restores the role of a contact, after all balls.
    fn restore_role(&mut self, i: usize, failed: bool) -> Result<(), InvalidState> {
        let (left, right) = (&self.balls[i], &self.balls[i + 1]);
        let flies = |ball: &Ball| matches!(ball.role, BallRole::Flight | BallRole::Body);
        let in_flight = flies(left) && flies(right);
        let in_cluster = |role: BallRole| matches!(role, BallRole::Cluster(_));
        let now = DoubleDouble::from(self.time);
        let (sound, reason, forecast) = match &self.contacts[i].role {
            ContactRole::Window(_) | ContactRole::Impact(_) => return Ok(()),
            // A failed step may end in the middle of an event.
            ContactRole::Unassigned(_) => (failed, "a contact belongs to nothing", Forecast::Never),
            ContactRole::BesideImpact(overlap) => {
                let beside_impact = !in_flight && !in_cluster(left.role) && !in_cluster(right.role);
                let sound = beside_impact && (failed || overlap.is_finite());
                (sound, "a contact has no impact beside it", Forecast::Never)
            }
            ContactRole::Constraint(constraint, forecast) => {
                let sound = failed || constraint.is_sound(left, right, now);
                (sound, "a sustained contact does not fit its balls", *forecast)
            }
            ContactRole::Open(separation, forecast) => {
                let sound = in_flight && (failed || separation.is_sound(left, right, now));
                (sound, "an open contact does not fit its balls", *forecast)
            }
        };
        require(sound, reason)?;
        if let Forecast::At(time) | Forecast::NotBefore(time) = forecast {
            require(failed || time.is_sound(), "the time of an event is invalid")?;
            self.queue.set(i, time);
        }
        Ok(())
    }

    /// Restores the constraint of contact `i` in a body with this oscillator.
    fn restore_constraint(&mut self, i: usize, oscillator: Oscillator, failed: bool) -> Result<(), InvalidState> {
        for ball in &mut self.balls[i..i + 2] {
            let free = matches!(ball.role, BallRole::Flight | BallRole::Body);
            require(
                free && (failed || self.cradle.restitution.is_some()),
                "a constraint holds balls that something else holds",
            )?;
            (ball.role, ball.oscillator) = (BallRole::Body, oscillator);
        }
        Ok(())
    }

    fn has_finite_sums(&self) -> bool {
        let of_balls = self.balls.iter().all(|ball| ball.integrals.is_finite());
        let of_contacts = self.contacts.iter().all(|contact| contact.ledger.is_sound());
        of_balls && of_contacts && self.totals.contact_loss.is_finite()
    }

    /// Checks that all values are finite and no past time lies ahead.
    fn check_values(&self, start: f64) -> Result<(), InvalidState> {
        let now = DoubleDouble::from(self.time);
        let past = |t: DoubleDouble| t.is_sound() && t <= now && t >= DoubleDouble::from(start);
        require(self.inputs.are_finite(), "an input is not finite")?;
        let times = [self.time, self.inputs.since, self.step.time, self.step.entered].map(DoubleDouble::from);
        require(
            times.into_iter().chain([self.totals.last_event]).all(past),
            "the time of a past event lies in the future",
        )?;
        let ball = |ball: &Ball| past(ball.anchor) && ball.flight.is_finite();
        require(self.balls.iter().all(ball), "the state of a ball is not finite, or lies in the future")?;
        require(self.has_finite_sums(), "a sum is not finite")?;
        for cluster in self.clusters.iter().flatten() {
            let flights = cluster.flights.iter().all(Flight::is_finite);
            let contacts = cluster.contacts.iter().all(|contact| contact.overlap.is_finite());
            require(
                past(cluster.start) && flights && contacts && cluster.history_before.is_sound(),
                "a cluster is not finite, or lies in the future",
            )?;
        }
        require(self.step.is_sound(), "the state at the start of the step is not finite, or its record is invalid")?;
        require(self.totals.energy_at_start.is_finite(), "the energy at the start is not finite")
    }
}
