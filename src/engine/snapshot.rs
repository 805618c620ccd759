//! A run as plain data, from which it goes on with the same bits.
//!
//! A snapshot holds what the run so far has left behind: anchors, overlaps, forecasts, sums. Whatever follows from these, the
//! motion of clusters and the outcome of impacts, is computed anew, by the same operations as before. What no run can have left
//! behind is refused.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::ahead::NO_STEP;
use super::ball::{Ball, Flight, Held, Tally};
use super::bond::Bond;
use super::cluster::Cluster;
use super::ledger::Ledger;
use super::pace::Pace;
use super::pair::PairImpact;
use super::separation::Separation;
use super::step_start::{BallStart, ContactStart};
use super::window::{Mode, WindowContact};
use super::{Engine, HeldInputs, LARGEST_COUNT, NextOnset, Work};
use crate::model::Parameters;
use crate::solver::double_double::DoubleDouble;

/// A run as plain data.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Snapshot {
    run: RunState,
    /// The copy that has gone ahead, and by how many entries of the queue, where it is not still where the run is.
    scout: Option<(RunState, u64)>,
    /// What was found ahead, and when it was asked for, s.
    found: Option<(f64, NextOnset)>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct RunState {
    time: f64,
    inputs: HeldInputs,
    balls: Vec<BallState>,
    contacts: Vec<ContactState>,
    clusters: Vec<Option<ClusterState>>,
    step: u64,
    step_start: f64,
    contact_loss: f64,
    energy_at_start: f64,
    work: Work,
    last_event: DoubleDouble,
    standstill: usize,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct BallState {
    anchor: DoubleDouble,
    flight: Flight,
    tally: Tally,
    /// If it has moved within the step.
    at_start: Option<BallStart>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct ContactState {
    ledger: Ledger,
    course: Course,
    /// If one of its balls has moved within the step.
    at_start: Option<ContactStart>,
}

/// What a contact is part of.
#[derive(Clone, Debug, Serialize, Deserialize)]
enum Course {
    /// The window of a cluster.
    Cluster,
    /// An impact of known outcome.
    Impact,
    /// Open beside such an impact, with the overlap between the anchors, m.
    Waits(f64),
    /// Open between balls in flight, with the entry in the event queue and whether that is an onset.
    Open(Separation, Option<(DoubleDouble, bool)>),
    /// A lasting contact of rigid balls, with the entry in the event queue and whether that is its end.
    Bond(Bond, Option<(DoubleDouble, bool)>),
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct ClusterState {
    members: Range<usize>,
    start: DoubleDouble,
    flights: Vec<Flight>,
    contacts: Vec<WindowContact>,
    pace: Pace,
}

/// A snapshot that no run can have left behind, and what gives it away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unsound(pub &'static str);

/// Refuses what does not hold.
fn require(holds: bool, reason: &'static str) -> Result<(), Unsound> {
    if holds { Ok(()) } else { Err(Unsound(reason)) }
}

impl Engine {
    /// The run as it is now.
    pub fn snapshot(&self) -> Snapshot {
        let scout = self.ahead.scout.borrow();
        let state = |scout: &Self| {
            // The time of a copy that goes ahead is that of its last event.
            let now = scout.last_event.value_up();
            (RunState { time: now, step_start: now, ..scout.run_state() }, scout.handled - self.handled)
        };
        // What has been passed by now is of no use any more.
        let found = self.ahead.found.get().filter(|(_, found)| found.time > self.time);
        let further = scout.as_deref().filter(|scout| scout.handled > self.handled);
        Snapshot { run: self.run_state(), scout: further.map(state), found }
    }

    fn run_state(&self) -> RunState {
        let ball = |i: usize| {
            let ball = &self.balls[i];
            let at_start = Some(ball.at_start).filter(|start| start.step == self.step);
            BallState { anchor: ball.anchor, flight: ball.flight, tally: ball.tally, at_start }
        };
        let contact = |i: usize| {
            let contact = &self.contacts[i];
            let course = if contact.cluster.is_some() {
                Course::Cluster
            } else if contact.impact.is_some() {
                Course::Impact
            } else if let Some(bond) = &contact.bond {
                Course::Bond(bond.clone(), self.queue.get(i).map(|time| (time, contact.due)))
            } else if let Some(separation) = &contact.separation {
                Course::Open(separation.clone(), self.queue.get(i).map(|time| (time, contact.due)))
            } else {
                Course::Waits(contact.overlap)
            };
            let at_start = Some(contact.at_start).filter(|start| start.step == self.step);
            ContactState { ledger: contact.ledger.clone(), course, at_start }
        };
        let cluster = |cluster: &Cluster| ClusterState {
            members: cluster.members.clone(),
            start: cluster.start,
            flights: cluster.flights.clone(),
            contacts: cluster.contacts.clone(),
            pace: cluster.pace_before,
        };
        RunState {
            time: self.time,
            inputs: self.inputs.clone(),
            balls: (0..self.balls.len()).map(ball).collect(),
            contacts: (0..self.contacts.len()).map(contact).collect(),
            clusters: self.clusters.iter().map(|slot| slot.as_ref().map(cluster)).collect(),
            step: self.step,
            step_start: self.step_start,
            contact_loss: self.contact_loss,
            energy_at_start: self.energy_at_start,
            work: self.work,
            last_event: self.last_event,
            standstill: self.standstill,
        }
    }

    /// The run that left `snapshot` behind, with the parameters that acted then and the start time (s). After a failed step
    /// (`failed`) its values may be anything, for it can only be looked at.
    pub fn restore(parameters: &Parameters, start: f64, snapshot: Snapshot, failed: bool) -> Result<Self, Unsound> {
        let Snapshot { run, scout, found } = snapshot;
        let engine = Self::rebuild(parameters, start, run, failed)?;
        let now = DoubleDouble::from(engine.time);
        let missed = |run: &Self, since: DoubleDouble| run.queue.first().is_some_and(|(t, _)| t < since);
        require(failed || !missed(&engine, now), "an event was missed")?;
        if let Some((scout, lead)) = scout {
            let mut scout = Self::rebuild(parameters, start, scout, failed)?;
            let sound = scout.last_event >= now && !missed(&scout, scout.last_event) && lead < LARGEST_COUNT;
            require(failed || sound, "it looks ahead to the past")?;
            (scout.step_start, scout.handled) = (NO_STEP, lead);
            engine.ahead.scout.replace(Some(Box::new(scout)));
        }
        require(failed || found.is_none_or(|(_, found)| found.time > engine.time), "what lies ahead has been")?;
        engine.ahead.found.set(found);
        Ok(engine)
    }

    /// The run, without what it has seen of the future.
    fn rebuild(parameters: &Parameters, start: f64, snapshot: RunState, failed: bool) -> Result<Self, Unsound> {
        snapshot.check_lengths(parameters)?;
        if !failed {
            snapshot.check_values(start)?;
        }
        let RunState { time, inputs, balls, contacts, clusters, .. } = snapshot;
        let mut engine = Self::apart(parameters, inputs, time);
        engine.step = snapshot.step;
        engine.step_start = snapshot.step_start;
        engine.contact_loss = snapshot.contact_loss;
        engine.energy_at_start = snapshot.energy_at_start;
        engine.work = snapshot.work;
        engine.last_event = snapshot.last_event;
        engine.standstill = snapshot.standstill;
        require(engine.standstill <= engine.most_without_progress() + 1, "a count is too large")?;
        for (ball, state) in engine.balls.iter_mut().zip(balls) {
            (ball.anchor, ball.flight, ball.tally) = (state.anchor, state.flight, state.tally);
            ball.at_start = state.at_start.unwrap_or_default();
        }
        let mut courses = Vec::with_capacity(contacts.len());
        for (contact, state) in engine.contacts.iter_mut().zip(contacts) {
            contact.ledger = state.ledger;
            contact.at_start = state.at_start.unwrap_or_default();
            engine.onsets = engine.onsets.saturating_add(contact.ledger.pulses);
            courses.push(state.course);
        }
        for state in clusters {
            engine.clusters.push(None);
            if let Some(state) = state {
                engine.restore_cluster(state, &courses)?;
            }
        }
        for (i, course) in courses.iter().enumerate() {
            match course {
                Course::Cluster => require(engine.contacts[i].cluster.is_some(), "a contact lost its cluster")?,
                Course::Impact => engine.restore_impact(i)?,
                Course::Bond(bond, _) => engine.restore_bond(i, bond, failed)?,
                _ => {}
            }
        }
        for (i, course) in courses.into_iter().enumerate() {
            engine.restore_open(i, course, failed)?;
        }
        Ok(engine)
    }

    /// Puts a cluster into the last slot.
    fn restore_cluster(&mut self, state: ClusterState, courses: &[Course]) -> Result<(), Unsound> {
        let ClusterState { members, start, flights, contacts, pace } = state;
        let balls = self.balls.len();
        require(members.start < members.end && members.end <= balls && members.len() > 1, "a cluster has no balls")?;
        let window = members.start.saturating_sub(1)..(members.end + 1).min(balls);
        let fits = flights.len() == window.len() && contacts.len() + 1 == window.len();
        require(fits, "a cluster is not as large as its window")?;
        let id = self.clusters.len() - 1;
        for (i, state) in (window.start..window.end - 1).zip(&contacts) {
            let contact = &mut self.contacts[i];
            let free = matches!(courses[i], Course::Cluster) && contact.cluster.is_none();
            require(free, "a contact has two parts to play")?;
            let law = &self.cradle.contacts[i];
            require(state.mode != Mode::Clipped || law.clips(), "a contact is clipped whose law does not clip")?;
            (contact.cluster, contact.mode) = (Some(id as u32), state.mode);
        }
        let closed = |i: usize| contacts[i - window.start].mode != Mode::Open;
        require(closed(members.start) && closed(members.end - 2), "a cluster holds balls that touch nothing")?;
        for ball in &mut self.balls[members.clone()] {
            require(ball.held == Held::Free, "a ball is in two clusters")?;
            ball.held = Held::Cluster(id as u32);
        }
        let mut cluster = Cluster::new(members, window, start, flights, contacts, pace);
        cluster.expand(&self.balls, &self.cradle.contacts, &self.control);
        self.queue.set(cluster.key(), cluster.end());
        self.clusters[id] = Some(cluster);
        Ok(())
    }

    fn restore_impact(&mut self, i: usize) -> Result<(), Unsound> {
        let (left, right) = (&self.balls[i], &self.balls[i + 1]);
        require(left.held == Held::Free && right.held == Held::Free, "a ball is in two impacts")?;
        require(left.anchor == right.anchor, "the balls of an impact have not met")?;
        let impact = PairImpact::new(left, right, &self.cradle.contacts[i], &self.shape);
        let impact = impact.ok_or(Unsound("an impact has no outcome"))?;
        self.queue.set(i, impact.end());
        self.contacts[i].impact = Some(impact);
        for ball in &mut self.balls[i..i + 2] {
            ball.held = Held::Impact(i as u32);
        }
        Ok(())
    }

    fn restore_open(&mut self, i: usize, course: Course, failed: bool) -> Result<(), Unsound> {
        let (left, right) = (&self.balls[i], &self.balls[i + 1]);
        let flies = |ball: &Ball| matches!(ball.held, Held::Free | Held::Bond);
        let in_flight = flies(left) && flies(right);
        let in_cluster = |held: Held| matches!(held, Held::Cluster(_));
        let contact = &mut self.contacts[i];
        match course {
            Course::Cluster | Course::Impact => {}
            Course::Bond(bond, entry) => {
                let sound = bond.is_sound(left, right, self.time.into());
                require(failed || sound, "a lasting contact does not fit its balls")?;
                contact.bond = Some(bond);
                self.restore_entry(i, entry, failed)?;
            }
            Course::Waits(overlap) => {
                let beside_impact = !in_flight && !in_cluster(left.held) && !in_cluster(right.held);
                require(beside_impact && (failed || overlap.is_finite()), "a contact waits for nothing")?;
                (contact.overlap, contact.waits) = (overlap, true);
            }
            Course::Open(separation, entry) => {
                let sound = separation.is_sound(left, right, self.time.into());
                require(in_flight && (failed || sound), "an open contact does not fit its balls")?;
                contact.separation = Some(separation);
                self.restore_entry(i, entry, failed)?;
            }
        }
        Ok(())
    }

    /// Enters contact `i` in the event queue, with its time and whether something happens then.
    fn restore_entry(&mut self, i: usize, entry: Option<(DoubleDouble, bool)>, failed: bool) -> Result<(), Unsound> {
        if let Some((time, due)) = entry {
            require(failed || time.is_sound(), "a time of an event is none")?;
            self.contacts[i].due = due;
            self.queue.set(i, time);
        }
        Ok(())
    }

    /// The balls of contact `i` move as `bond` says.
    fn restore_bond(&mut self, i: usize, bond: &Bond, failed: bool) -> Result<(), Unsound> {
        for ball in &mut self.balls[i..i + 2] {
            let free = matches!(ball.held, Held::Free | Held::Bond);
            require(
                free && (failed || self.cradle.restitution.is_some()),
                "a bond holds balls that are held otherwise",
            )?;
            (ball.held, ball.oscillator) = (Held::Bond, bond.oscillator());
        }
        Ok(())
    }
}

impl RunState {
    fn check_lengths(&self, parameters: &Parameters) -> Result<(), Unsound> {
        let (balls, contacts) = (parameters.balls(), parameters.contacts());
        let fits = self.balls.len() == balls
            && self.contacts.len() == contacts
            && self.clusters.len() <= contacts
            && self.inputs.fit(balls);
        require(fits, "it is not as large as the cradle")
    }

    /// That all values are finite and no time of the past lies ahead.
    fn check_values(&self, start: f64) -> Result<(), Unsound> {
        let now = DoubleDouble::from(self.time);
        let past = |t: DoubleDouble| t.is_sound() && t <= now && t >= DoubleDouble::from(start);
        require(self.inputs.are_finite(), "an input is not finite")?;
        let times = [self.time, self.inputs.since, self.step_start].map(DoubleDouble::from);
        require(times.into_iter().chain([self.last_event]).all(past), "a time of the past is not in the past")?;
        let ball = |ball: &BallState| past(ball.anchor) && ball.flight.is_finite() && ball.tally.is_finite();
        require(self.balls.iter().all(ball), "the state of a ball is not finite, or of the future")?;
        require(self.contacts.iter().all(|contact| contact.ledger.is_sound()), "a ledger is not finite")?;
        for cluster in self.clusters.iter().flatten() {
            let flights = cluster.flights.iter().all(Flight::is_finite);
            let contacts = cluster.contacts.iter().all(|contact| contact.overlap.is_finite());
            require(
                past(cluster.start) && flights && contacts && cluster.pace.is_sound(),
                "a cluster is not finite, or of the future",
            )?;
        }
        let ball = |ball: &BallState| ball.at_start.is_none_or(|start| start.step == self.step && start.is_finite());
        let contact = |contact: &ContactState| {
            contact.at_start.is_none_or(|start| start.step == self.step && start.overlap.is_finite())
        };
        let start = self.balls.iter().all(ball) && self.contacts.iter().all(contact);
        require(start, "the state at the start of the step is not finite, or of another step")?;
        let sums = [self.contact_loss, self.energy_at_start];
        require(sums.iter().all(|sum| sum.is_finite()), "a sum is not finite")?;
        require(self.step < LARGEST_COUNT, "a count is too large")
    }
}
