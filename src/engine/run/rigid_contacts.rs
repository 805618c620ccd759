//! The events of rigid contacts: impacts, and sustained contacts. See "Rigid contacts" in docs/theory.md.

use std::ops::Range;

use super::contact::{ContactRole, RestRule, contiguous_range};
use super::engine::Engine;
use super::interaction::Interaction;
use crate::engine::flight::{Forcing, Rounding, Separation, places, shifted, start_by_centre};
use crate::engine::rigid::restitution::{self, Block, Impact, TouchingRow};
use crate::engine::rigid::{Body, acceleration_rounding};
use crate::engine::tape::Unfollowed;
use crate::engine::{EngineError, Fault, Forecast, Observer, RAPID};
use crate::model::Mode;
use crate::solver::{DoubleDouble, Oscillator};

/// Smallest approach speed over the rounding of the velocities.
const RESOLVED_ROUNDINGS: f64 = 16.0;

/// Effort (see [`Engine::effort`]) of an impact: there may be millions in an event.
const IMPACT: u64 = 1;

/// Number of bounces of a contact in a row, each shorter than [`RAPID`], after which the next one is the last. Bounces
/// of elastic balls pressed together, slowed only by drag, would end in rounding after billions.
const MANY: u64 = 1 << 16;

impl Engine {
    pub(crate) fn is_rigid(&self) -> bool {
        self.cradle.rigid
    }

    /// Refuses a start with overlapping rigid balls; an overlap by rounding counts as touching.
    pub(crate) fn touch_where_close(&mut self) -> Result<(), EngineError> {
        for i in 0..self.contacts.len() {
            let places = self.anchors(i);
            let overlap = self.cradle.pair(i).overlap(places);
            let rounding = 2.0 * f64::EPSILON * places[0].abs().max(places[1].abs());
            if overlap > rounding {
                let (left, right) = (i + 1, i + 2);
                return Err(EngineError::NotRigid(format!(
                    "rigid balls {left} and {right} overlap by {overlap:.4e} m; allowed: x_start[{left}] - \
                     x_start[{right}] up to contact.gap[{left}] + contact.deadBand"
                )));
            }
            self.contacts[i].set_anchored(if overlap >= -rounding { 0.0 } else { overlap }, Mode::Open);
        }
        Ok(())
    }

    /// Carries out the impacts of all balls in touch at the onset of contact `i` at the time `t`.
    pub(crate) fn rigid_impact(&mut self, i: usize, t: DoubleDouble, observer: &mut dyn Observer) {
        let clock_stands = self.totals.standstill > self.most_without_progress() / 2;
        let e = if clock_stands { 0.0 } else { self.cradle.contacts[i].restitution };
        let Some(separation) = self.contacts[i].separation() else { return };
        let shortest = if self.contacts[i].ledger.rapid < MANY { 0.0 } else { RAPID };
        let (last_bounce, overlap_rounding) = (separation.is_last_bounce(t, e, shortest), separation.rounding);
        let group = contiguous_range(i, self.contacts.len(), |j| {
            let touches = |separation: &Separation| separation.touches(t, overlap_rounding);
            self.constraint(j).is_some() || self.contacts[j].separation().is_some_and(touches)
        });
        let (first, balls) = (group.start, group.start..group.end + 1);
        // Also at the start of a step, because the velocities jump.
        balls.clone().for_each(|ball| self.record_start(ball));
        self.separate(group.clone(), t);
        self.align(group.clone());
        let row = TouchingRow::new(&self.cradle, balls.clone(), |ball| self.balls[ball].flight.x);
        let row = match row.map(|row| if clock_stands { row.without_rebound() } else { row }) {
            Ok(row) => row,
            Err(left) => return self.note(left, Some((t, Fault::Across))),
        };
        let mut v: Vec<f64> = self.balls[balls.clone()].iter().map(|ball| ball.flight.v).collect();
        let rounding = RESOLVED_ROUNDINGS * self.rounding(balls.clone()).velocity;
        let approach = row.approach(&v, i - first);
        let unresolved = if last_bounce { approach.max(rounding) } else { rounding };
        let before = self.recorder.is_some().then(|| v.clone());
        let outcome = restitution::collide(&row, &mut v, unresolved, rounding);
        if let (Some(mut v), Some(recorder)) = (before, &mut self.recorder) {
            let state = |ball: usize| (self.balls[ball].flight.x, v[ball - first]);
            recorder.onset(i, [i, i + 1].map(state), &self.cradle);
            let places: Vec<f64> = self.balls[balls.clone()].iter().map(|ball| ball.flight.x).collect();
            recorder.collide((&self.cradle, &self.inputs), (first, t), (&places, &mut v), &outcome.groups);
        }
        self.effort = self.effort.saturating_add(IMPACT * outcome.impacts.len() as u64);
        let mut impacts = self.beyond_rounding(first, outcome.impacts, rounding);
        if impacts.iter().all(|impact| first + impact.contact != i) {
            // Its onset was announced, so it needs a pulse.
            impacts.push(Impact { contact: i - first, impulse: 0.0 });
        }
        self.totals.contact_loss += outcome.loss;
        for (ball, v) in self.balls[balls].iter_mut().zip(v) {
            ball.flight.v = v;
        }
        // A contact that closed without speed is pressed, if only by rounding.
        let keep = if approach <= unresolved { RestRule::Contact(i) } else { RestRule::Nothing };
        self.regroup(group, t, keep, &impacts, observer);
    }

    /// The `impacts`, with contacts counted from `first`, in which velocities change by more than `rounding` (m/s). The
    /// impulses of the others are no pulses, but enter the ledgers.
    fn beyond_rounding(&mut self, first: usize, impacts: Vec<Impact<f64>>, rounding: f64) -> Vec<Impact<f64>> {
        let lighter = |j: usize| self.balls[first + j].model.mass.min(self.balls[first + j + 1].model.mass);
        let (beyond, within): (Vec<_>, Vec<_>) =
            impacts.into_iter().partition(|impact| impact.impulse > rounding * lighter(impact.contact));
        for Impact { contact, impulse } in within {
            let ledger = &mut self.contacts[first + contact].ledger;
            ledger.begin_step(self.step.number, ledger.impulse);
            ledger.impulse += impulse;
        }
        beyond
    }

    /// Adjusts the positions of the balls of the contacts `group` so that they touch exactly; otherwise rounding would
    /// build up over many impacts. The energy change counts as lost.
    fn align(&mut self, group: Range<usize>) {
        let distance = |j: usize| {
            let (pair, places) = (self.cradle.pair(j), self.anchors(j));
            if self.swing_as_one(j) {
                return pair.law.clearance;
            }
            places[0] - places[1] - pair.overlap(places) * pair.parts_along(places)[1]
        };
        let distances: Vec<f64> = group.clone().map(distance).collect();
        let places = places(distances.iter().copied());
        let balls = &mut self.balls[group.start..group.end + 1];
        let start = start_by_centre(balls.iter().map(|ball| (ball.model.mass, ball.flight.x)).zip(places.clone()));
        for (ball, x) in balls.iter_mut().zip(places.map(|place| start + place)) {
            let model = ball.model;
            let raised = model.chord(x - ball.flight.x) * model.chord(x + ball.flight.x);
            self.totals.contact_loss -= 0.5 * ball.model.mass * model.omega2 * raised;
            ball.flight.x = x;
        }
        for contact in &mut self.contacts[group] {
            contact.set_anchored(0.0, contact.at_anchors().mode);
        }
    }

    /// Ends the constraint of contact `i`, which would have to pull from `t` on.
    pub(crate) fn release_constraint(&mut self, i: usize, t: DoubleDouble, observer: &mut dyn Observer) {
        let body = contiguous_range(i, self.contacts.len(), |j| self.constraint(j).is_some());
        self.separate(body.clone(), t);
        self.regroup(body, t, RestRule::Nothing, &[], observer);
    }

    /// Begins or ends a pulse of the anchored contact `i` at `t`, unless that has been done.
    fn set_closed(&mut self, i: usize, closed: bool, t: DoubleDouble, observer: &mut dyn Observer) {
        let contact = &mut self.contacts[i];
        if contact.is_closed() == closed {
            return;
        }
        contact.set_anchored(contact.at_anchors().overlap, if closed { Mode::Pressing } else { Mode::Open });
        if closed { self.begin_pulse(i, t, observer) } else { self.end_pulse(i, t, observer) }
    }

    /// Rounding of the positions and velocities of these balls in flight.
    fn rounding(&self, balls: Range<usize>) -> Rounding {
        let rounding = self.balls[balls].iter().map(|ball| ball.flight.rounding(&ball.oscillator));
        rounding.fold(Rounding::default(), Rounding::max)
    }

    /// Separates the balls of the contacts `group` at `t`; no constraint leads out of the group. The balls are then in
    /// flight, anchored as the contacts are; contacts press where there was a constraint.
    pub(crate) fn separate(&mut self, group: Range<usize>, t: DoubleDouble) {
        let balls = group.start..group.end + 1;
        balls.clone().for_each(|i| self.before_move(i, t));
        for i in balls.clone() {
            if self.is_in_body(i) {
                self.leave_body(i, t);
            } else {
                self.reanchor(i, t);
            }
        }
        for j in group {
            if !self.end_constraint(j, t) {
                self.stop_separation(j, t);
            }
        }
        for i in balls {
            if let Some(id) = self.balls[i].interaction.take() {
                self.interactions[id as usize] = None;
            }
        }
    }

    /// Anchors ball `i`, which is in a body, at `t` as if it were in flight.
    fn leave_body(&mut self, i: usize, t: DoubleDouble) {
        if let Some(recorder) = &mut self.recorder {
            recorder.fail(Unfollowed::RigidBody);
        }
        self.look_for_faults(i..i + 1, t);
        let (before, after) = (self.own_forcing(i, self.balls[i].anchor), self.own_forcing(i, t));
        let (model, ball) = (&self.cradle.balls[i], &mut self.balls[i]);
        ball.integrals = ball.integrals_under(&before, t);
        ball.flight = ball.flight_at(t);
        ball.flight.forcing = after;
        ball.anchor = t;
        ball.oscillator = Oscillator::new(model.omega2, model.gamma);
    }

    /// Enters the force of the constraint of contact `j` up to `t` in its ledger, and anchors the contact, pressing.
    /// Returns false if the contact has no constraint.
    fn end_constraint(&mut self, j: usize, t: DoubleDouble) -> bool {
        let sums = self.constraint(j).map(|constraint| {
            let in_step = constraint.peak(self.step.time.into(), t).force;
            (constraint.impulse(t), constraint.peak(constraint.anchor, t), constraint.anchor, in_step)
        });
        let Some((impulse, peak, anchor, in_step)) = sums else { return false };
        self.begin_ledger(j, t);
        self.queue.remove(j);
        // If an input is set twice at one instant, its first value acts for no time: its force is no part of the pulse.
        if anchor < t {
            let ledger = &mut self.contacts[j].ledger;
            ledger.add(impulse);
            ledger.raise_peak(peak.after(anchor), anchor);
            ledger.raise_peak_of_step(in_step);
        }
        self.contacts[j].set_anchored(0.0, Mode::Pressing);
        // The balls of a body differ by rounding only.
        self.balls[j + 1].flight.v = self.balls[j].flight.v;
        true
    }

    /// Acceleration of ball `i` by the inputs at the time `t`.
    pub(crate) fn own_forcing(&self, i: usize, t: DoubleDouble) -> Forcing {
        let forcing = self.inputs.forcing(i, self.balls[i].model.mass);
        shifted(&forcing, self.input_age(t))
    }

    /// How long the inputs have acted at the time `t`, s.
    pub(crate) fn input_age(&self, t: DoubleDouble) -> f64 {
        (t - DoubleDouble::from(self.inputs.since)).value()
    }

    /// Regroups the separated contacts `group` at `t`: joins balls that press each other to bodies, enters the
    /// `impacts`, with contacts counted from the first of the group, in the ledgers, and lets the other balls and their
    /// neighbours fly.
    pub(crate) fn regroup(
        &mut self,
        group: Range<usize>,
        t: DoubleDouble,
        keep: RestRule,
        impacts: &[Impact<f64>],
        observer: &mut dyn Observer,
    ) {
        let mut bodies = Vec::new();
        let resting: Vec<usize> = group.clone().filter(|&j| self.rests(j)).collect();
        for run in resting.chunk_by(|left, right| left + 1 == *right) {
            self.join_where_pressed(run[0]..run[0] + run.len(), t, keep, &mut bodies);
        }
        let mut lasting = vec![false; group.len()];
        for contacts in bodies.iter().map(Body::contacts) {
            lasting[contacts.start - group.start..contacts.end - group.start].fill(true);
        }
        let mut last = vec![0; group.len()];
        impacts.iter().enumerate().for_each(|(k, impact)| last[impact.contact] = k);
        for (k, Impact { contact, impulse }) in impacts.iter().enumerate() {
            // A pulse without duration, unless the contact lasts from here on.
            let (i, lasts) = (group.start + contact, k == last[*contact] && lasting[*contact]);
            self.set_closed(i, false, t, observer);
            self.set_closed(i, true, t, observer);
            self.contacts[i].ledger.add(*impulse);
            self.set_closed(i, lasts, t, observer);
        }
        let rounding = self.rounding(group.start..group.end + 1);
        group.clone().zip(lasting).for_each(|(j, lasts)| self.set_closed(j, lasts, t, observer));
        for body in bodies {
            let contacts = body.contacts();
            self.enter_body(body);
            contacts.for_each(|j| self.forecast(j, t));
        }
        for j in group.start.saturating_sub(1)..(group.end + 1).min(self.contacts.len()) {
            if self.constraint(j).is_none() {
                self.open_contact(j, t, rounding.position);
                let held = self.is_held(j, t, rounding.velocity).then_some((t, Fault::Held));
                self.note(j, held);
            }
        }
    }

    /// Lets balls, which have their flights, move as one `body`.
    fn enter_body(&mut self, body: Body) {
        let id = self.number_of_next();
        for j in body.contacts() {
            self.contacts[j].role = ContactRole::Interacting(id);
            self.balls[j..j + 2].iter_mut().for_each(|ball| ball.interaction = Some(id));
        }
        self.interactions[id as usize] = Some(Interaction::Body(body));
    }

    /// Whether the balls of contact `j` can swing as one in touch: on arcs equal pendulums that touch at equal angles.
    fn swing_as_one(&self, j: usize) -> bool {
        let [left, right] = self.cradle.pair(j).balls;
        let alike = left.length == right.length && left.gamma == right.gamma;
        !left.on_arc || alike && self.cradle.contacts[j].clearance == 0.0
    }

    /// Whether contact `j`, open from `t` on without speed, to within `rounding` (m/s), closes again before its balls
    /// are apart by more than rounding, although they cannot swing as one.
    fn is_held(&self, j: usize, t: DoubleDouble, rounding: f64) -> bool {
        let ContactRole::Open(separation, Forecast::At(next)) = &self.contacts[j].role else { return false };
        let still = separation.at_time(t).1.abs() <= RESOLVED_ROUNDINGS * rounding;
        !self.swing_as_one(j) && still && separation.is_last_bounce(*next, 1.0, 0.0)
    }

    /// Whether the balls of contact `j`, both in flight, touch without relative velocity, and would swing as one.
    fn rests(&self, j: usize) -> bool {
        let (left, right) = (&self.balls[j].flight, &self.balls[j + 1].flight);
        self.swing_as_one(j)
            && left.v == right.v
            && self.contacts[j].at_anchors().overlap >= -self.rounding(j..j + 2).position
    }

    /// Joins the balls of the contacts `run`, which touch at rest, to `bodies` where they press.
    fn join_where_pressed(&mut self, run: Range<usize>, t: DoubleDouble, keep: RestRule, bodies: &mut Vec<Body>) {
        let balls = &self.balls[run.start..run.end + 1];
        let masses: Vec<f64> = balls.iter().map(|ball| ball.model.mass).collect();
        let age = self.input_age(t);
        let rounding = balls.iter().map(|ball| acceleration_rounding(ball, age)).fold(0.0, f64::max);
        let approach: Vec<f64> = run.clone().map(|j| self.separation(j, t, 0.0).at_anchor()[2]).collect();
        // Accelerations relative to the first ball.
        let mut accelerations = vec![0.0; masses.len()];
        for (j, approach) in approach.iter().enumerate() {
            accelerations[j + 1] = accelerations[j] - approach;
        }
        let meet = |j: usize, approach: f64| {
            let contact = run.start + j;
            let pressed = approach > 0.0;
            match keep {
                RestRule::Contact(this) if contact == this => approach >= -rounding,
                RestRule::Closed => pressed || self.contacts[contact].is_closed(),
                RestRule::Nothing | RestRule::Contact(_) => pressed,
            }
        };
        for Block { members, .. } in restitution::pool(&masses, &accelerations, meet) {
            if members.len() > 1 {
                let contacts = members.start..members.end - 1;
                let members = run.start + members.start..run.start + members.end;
                bodies.push(Body::join(members.start, &mut self.balls[members], &approach[contacts], rounding, t));
            }
        }
    }
}
