//! A run as plain data, from which it continues bit-for-bit identically: anchors, overlaps, forecasts and sums. All
//! else is computed from these by the same operations as before. Inconsistent snapshots are refused.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::contact::{Contact, ContactRole};
use super::engine::{Engine, NO_STEP};
use super::interaction::Interaction;
use crate::engine::cluster::Cluster;
use crate::engine::flight::{Ball, Flight};
use crate::engine::{Forecast, StepStart};
use crate::model::{Mode, Parameters};
use crate::solver::DoubleDouble;

/// A run as plain data.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Snapshot {
    run: Engine,
    /// The copy that looks ahead, if it is ahead of the run.
    copy: Option<Box<Engine>>,
    /// The result of the look ahead, and the time of the request, s.
    found: Option<(f64, Forecast)>,
}

/// An inconsistent snapshot, with the reason.
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
            self.caches.ahead.take(); // A restored run has none either.
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
            // The time of a copy that looks ahead is that of its last event. Its field `time` means nothing; it is kept
            // so that the same state has the same bytes.
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
        let fits = lengths == [(n, m); 2] && self.interactions.len() <= m && self.inputs.fit(n);
        require(fits, "its size does not match the cradle")?;
        if !failed {
            self.check_values(start)?;
        }
        // All fields that are not skipped: what is saved is restored here, and checked.
        let Self { time, inputs, balls, contacts, interactions, step, totals, handled, onsets, .. } = self;
        let apart = Self::apart(parameters, inputs, time);
        let mut engine = Self { contacts, step: step.restored(), totals, handled, onsets, ..apart };
        require(totals.standstill <= engine.most_without_progress() + 1, "a count is too large")?;
        for (ball, Ball { anchor, flight, integrals, starts_long, .. }) in engine.balls.iter_mut().zip(balls) {
            (ball.anchor, ball.flight, ball.integrals, ball.starts_long) = (anchor, flight, integrals, starts_long);
        }
        for (id, interaction) in interactions.into_iter().enumerate() {
            engine.interactions.push(None);
            interaction.map_or(Ok(()), |interaction| engine.restore_interaction(id as u32, interaction, failed))?;
        }
        (0..m).try_for_each(|i| engine.restore_role(i, failed))?;
        Ok(engine)
    }

    fn restore_interaction(&mut self, id: u32, mut interaction: Interaction, failed: bool) -> Result<(), InvalidState> {
        if let Interaction::Cluster(cluster) = &mut interaction {
            let Range { start, end } = cluster.members;
            require(start < end && end <= self.balls.len(), "a cluster has no balls")?;
            cluster.window = start.saturating_sub(1)..(end + 1).min(self.balls.len());
        }
        let contacts = interaction.contacts();
        let own = |contact: &Contact| matches!(contact.role, ContactRole::Interacting(of) if of == id);
        let its_own = self.contacts.get(contacts.clone()).is_some_and(|contacts| contacts.iter().all(own));
        require(!contacts.is_empty() && its_own, "an interaction has not the contacts that it needs")?;
        let members = match &interaction {
            Interaction::Cluster(cluster) => cluster.members.clone(),
            Interaction::Impact(_) | Interaction::Body(_) => contacts.start..contacts.end + 1,
        };
        let taken = self.balls[members.clone()].iter().any(|ball| ball.interaction.is_some());
        require(!taken, "a ball is in two interactions")?;
        let fits = self.is_rigid() == matches!(interaction, Interaction::Body(_));
        require(failed || fits, "an interaction is not of the kind of the contacts")?;
        match interaction {
            Interaction::Cluster(cluster) => self.restore_cluster(id, cluster)?,
            Interaction::Impact(impact) => {
                let (i, anchors) = (impact.contact, [0, 1].map(|side| self.balls[contacts.start + side].anchor));
                require(anchors[0] == anchors[1], "the balls of an impact have not met")?;
                let impact = self.impact_of(i).ok_or(InvalidState("an impact has no outcome"))?;
                self.enter_impact(id, impact);
            }
            Interaction::Body(body) => {
                if let Some(oscillator) = body.oscillator() {
                    self.balls[members.clone()].iter_mut().for_each(|ball| ball.oscillator = oscillator);
                }
                for j in contacts {
                    let (balls, now) = ([&self.balls[j], &self.balls[j + 1]], DoubleDouble::from(self.time));
                    let Some(constraint) = body.constraint(j) else { continue };
                    let sound = failed || constraint.is_sound(balls, now);
                    require(sound, "a sustained contact does not fit its balls")?;
                    constraint.end.until().into_iter().for_each(|time| self.queue.set(j, time));
                }
                self.interactions[id as usize] = Some(Interaction::Body(body));
            }
        }
        self.balls[members].iter_mut().for_each(|ball| ball.interaction = Some(id));
        Ok(())
    }

    fn restore_cluster(&mut self, id: u32, mut cluster: Box<Cluster>) -> Result<(), InvalidState> {
        let (window, Cluster { members, flights, contacts, .. }) = (cluster.window_contacts(), &*cluster);
        require(members.len() > 1, "a cluster has no balls")?;
        let fits = flights.len() == window.len() + 1 && contacts.len() == window.len();
        require(fits, "the size of a cluster does not match its window")?;
        for (law, state) in self.cradle.contacts[window.clone()].iter().zip(contacts) {
            require(state.mode != Mode::Clipped || law.clips(), "a contact is clipped whose law does not clip")?;
        }
        let closed = |i: usize| contacts[i - window.start].mode != Mode::Open;
        require(closed(members.start) && closed(members.end - 2), "a cluster holds balls that touch nothing")?;
        cluster.history = cluster.history_before;
        cluster.expand(&self.balls, &self.cradle, &self.control);
        self.queue.set(cluster.key(), cluster.end());
        self.interactions[id as usize] = Some(Interaction::Cluster(cluster));
        Ok(())
    }

    /// Checks the role of a contact, once all interactions are restored, and enters its forecast.
    fn restore_role(&mut self, i: usize, failed: bool) -> Result<(), InvalidState> {
        let balls = [&self.balls[i], &self.balls[i + 1]];
        match &self.contacts[i].role {
            ContactRole::Interacting(id) => {
                let interaction = self.interactions.get(*id as usize).and_then(Option::as_ref);
                let its_own = interaction.is_some_and(|interaction| interaction.contacts().contains(&i));
                require(its_own, "a contact lost its interaction")
            }
            ContactRole::Anchored(contact) => {
                // A failed step may end in the middle of an event.
                let of_impact = |ball: usize| matches!(self.interaction_of_ball(ball), Some(Interaction::Impact(_)));
                let beside_impact = of_impact(i) || of_impact(i + 1);
                let sound = beside_impact && contact.mode == Mode::Open && contact.overlap.is_finite();
                require(failed || sound, "a contact has no impact beside it")
            }
            ContactRole::Open(separation, forecast) => {
                let in_flight = self.flies(i) && self.flies(i + 1);
                let sound = in_flight && (failed || separation.is_sound(balls, self.time.into()));
                require(sound, "an open contact does not fit its balls")?;
                if let Some(time) = forecast.until() {
                    require(failed || time.is_sound(), "the time of an event is invalid")?;
                    self.queue.set(i, time);
                }
                Ok(())
            }
        }
    }

    fn has_finite_sums(&self) -> bool {
        let of_balls = self.balls.iter().all(|ball| ball.integrals.is_finite());
        let of_contacts = self.contacts.iter().all(|contact| contact.ledger.is_sound());
        of_balls && of_contacts && self.totals.contact_loss.is_finite()
    }

    /// Checks that all values are finite, and that past times are not in the future.
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
        for interaction in self.interactions.iter().flatten() {
            let Interaction::Cluster(cluster) = interaction else { continue };
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
