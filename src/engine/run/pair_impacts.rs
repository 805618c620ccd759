//! Impacts of two balls whose outcome is known at their onset: how they begin, end, and are given up if something
//! interferes. When read within, they are followed in segments like a cluster.

use std::ops::Range;

use super::contact::ContactRole;
use super::engine::Engine;
use super::interaction::Interaction;
use crate::engine::Observer;
use crate::engine::cluster::{Cluster, Control, Method, StepHistory, Switch, WindowContact};
use crate::engine::flight::RunningIntegrals;
use crate::engine::pair_impact::{Interior, PairImpact};
use crate::engine::tape::Unfollowed;
use crate::model::Mode;
use crate::solver::DoubleDouble;

impl Engine {
    /// Begins an impact of known outcome in contact `i` at `t`, if its balls are in flight and stay clear of their
    /// neighbours until the impact is over. Returns whether it did.
    pub(crate) fn begin_impact(&mut self, i: usize, t: DoubleDouble, observer: &mut dyn Observer) -> bool {
        let neighbours = i.saturating_sub(1)..(i + 3).min(self.balls.len());
        let beside = (neighbours.start..neighbours.end - 1).filter(|j| *j != i);
        let in_cluster = |i: usize| matches!(self.interaction_of_ball(i), Some(Interaction::Cluster(_)));
        let beside_cluster = neighbours.clone().any(in_cluster);
        if !self.are_in_flight(i) || beside_cluster || !self.control.allows(Method::PairImpact) {
            return false;
        }
        self.reanchor_free(neighbours, t);
        self.contacts[i].set_anchored(0.0, Mode::Open);
        self.queue.remove(i);
        beside.clone().for_each(|j| self.stop_separation(j, t));
        if beside.into_iter().any(|j| self.are_in_flight(j) && self.contacts[j].at_anchors().overlap >= 0.0) {
            return false; // A next ball touches one of these.
        }
        let Some(impact) = self.impact_of(i) else { return false };
        let clear_left = i == 0 || self.stays_open(i - 1, t, None, Some(&impact));
        let clear_right = i + 2 == self.balls.len() || self.stays_open(i + 1, t, Some(&impact), None);
        if !(clear_left && clear_right) {
            return false;
        }
        let id = self.number_of_next();
        self.enter_impact(id, impact);
        self.begin_pulse(i, t, observer);
        self.totals.work.steps = self.totals.work.steps.saturating_add(1);
        self.totals.work.evaluations = self.totals.work.evaluations.saturating_add(1);
        true
    }

    /// The impact in contact `i` of balls that meet now, if it has a closed form.
    pub(super) fn impact_of(&self, i: usize) -> Option<PairImpact> {
        let balls = [&self.balls[i], &self.balls[i + 1]];
        PairImpact::new(i, balls, &self.cradle.contacts[i], &self.impact_coefficients)
    }

    /// Lets an impact govern its balls, as interaction number `id`.
    pub(super) fn enter_impact(&mut self, id: u32, impact: PairImpact) {
        let i = impact.contact;
        self.queue.set(i, impact.end());
        self.contacts[i].role = ContactRole::Interacting(id);
        self.balls[i..i + 2].iter_mut().for_each(|ball| ball.interaction = Some(id));
        self.interactions[id as usize] = Some(Interaction::Impact(impact));
    }

    fn are_in_flight(&self, j: usize) -> bool {
        self.balls[j..j + 2].iter().all(|ball| ball.interaction.is_none())
    }

    /// Whether the open contact `j` provably stays open from `t` until the impacts of its balls are over: the impact
    /// about to begin, given for the ball that it moves, and any current one of the other ball.
    fn stays_open(&self, j: usize, t: DoubleDouble, left: Option<&PairImpact>, right: Option<&PairImpact>) -> bool {
        let under_way = |ball: usize| match self.interaction_of_ball(ball) {
            Some(Interaction::Impact(impact)) => Some(impact),
            _ => None,
        };
        // Each ball, the time since its anchor, its impact, and how long that still lasts.
        let sides = [(j, left), (j + 1, right)].map(|(i, impact)| {
            let (ball, impact) = (&self.balls[i], impact.or_else(|| under_way(i)));
            let age = (t - ball.anchor).value();
            (ball, age, impact, impact.map_or(0.0, |impact| (impact.outcome.duration - age).max(0.0)))
        });
        let remaining = sides.map(|(.., rest)| rest);
        let longest = remaining[0].max(remaining[1]);
        let mut slack: f64 = sides.iter().map(|(ball, age, ..)| ball.chord_deviation(age + longest)).sum();
        let mut along = [1.0; 2];
        if self.cradle.on_arcs() {
            // The distance is at least its component along its present direction; the turn of the paths adds to the
            // slack.
            along = self.cradle.pair(j).parts_along(self.anchors(j));
            for (ball, age, impact, _) in &sides {
                let after = impact
                    .map_or(0.0, |impact| impact.outcome.velocities[0].abs().max(impact.outcome.velocities[1].abs()));
                let way = (ball.flight.v.abs() + after) * (age + longest);
                slack += way * way / ball.model.length;
            }
        }
        // Displacement since the anchor along the chord of the impact, or straight on in flight.
        let chord = |side: usize, after: f64| {
            let (ball, age, impact, _) = sides[side];
            impact.map_or(ball.flight.v * (age + after), |impact| impact.chord(1 - side, age + after))
        };
        let approach = |after: f64| along[0] * chord(0, after) - along[1] * chord(1, after);
        let overlap = |after: f64| self.contacts[j].at_anchors().overlap + approach(after) + slack;
        [0.0, remaining[0], remaining[1]].into_iter().all(|after| overlap(after) < 0.0)
    }

    pub(crate) fn end_impact(&mut self, i: usize, t: DoubleDouble, observer: &mut dyn Observer) {
        self.before_move(i, t);
        self.before_move(i + 1, t);
        let in_step = self.impact_peak(i, self.step.time.into(), t);
        self.begin_ledger(i, t);
        self.record_impact(i, t);
        let Some(Interaction::Impact(impact)) = self.leave(i) else { return };
        let displacements = impact.outcome.displacements;
        let ledger = &mut self.contacts[i].ledger;
        ledger.add(impact.outcome.impulse);
        ledger.raise_peak(impact.outcome.peak.after(impact.start), impact.start);
        ledger.raise_peak_of_step(in_step);
        for (side, ball) in self.balls[i..i + 2].iter_mut().enumerate() {
            ball.flight.x += displacements[side];
            ball.flight.v = impact.outcome.velocities[side];
            ball.anchor = t;
            ball.integrals.add(&impact.integrals[side]);
            ball.starts_long = false;
        }
        (0..2).for_each(|side| self.shift_contacts(i + side, displacements[side]));
        self.contacts[i].set_anchored(0.0, Mode::Open);
        self.end_pulse(i, t, observer);
        let neighbours = i.saturating_sub(1)..(i + 3).min(self.balls.len());
        self.reanchor_free(neighbours.clone(), t);
        for j in neighbours.start..neighbours.end - 1 {
            if self.are_in_flight(j) {
                self.open_contact(j, t, 0.0);
            }
        }
    }

    /// Records the impact in contact `i`, which is over at `t`, as a whole or in segments.
    fn record_impact(&mut self, i: usize, t: DoubleDouble) {
        let Some(mut recorder) = self.recorder.take() else { return };
        let acting = (&self.cradle, &self.inputs);
        if let Some(impact) = self.impact(i)
            && !recorder.strike(impact, &self.balls, &self.impact_coefficients, acting)
        {
            self.interior(impact, t);
            let segments = impact.interior.get().map_or(&[][..], Vec::as_slice);
            for Interior { segment, .. } in segments {
                recorder.follow(segment, segment.length, true, &self.cradle, &self.inputs);
            }
            if !segments.last().is_some_and(|last| matches!(last.segment.switch, Some((_, Switch::Release)))) {
                recorder.fail(Unfollowed::Unresolved);
            }
        }
        self.recorder = Some(recorder);
    }

    /// Moves the anchors of those of `balls` that are in flight to `t`.
    pub(crate) fn reanchor_free(&mut self, balls: Range<usize>, t: DoubleDouble) {
        for ball in balls {
            if self.balls[ball].interaction.is_none() {
                self.reanchor(ball, t);
            }
        }
    }

    /// Moves the anchor of ball `i`, in flight, to `t`, and adjusts what refers to it.
    pub(crate) fn reanchor(&mut self, i: usize, t: DoubleDouble) {
        if self.balls[i].anchor == t {
            return;
        }
        self.before_move(i, t);
        if let Some(recorder) = &mut self.recorder {
            recorder.fly(i, &self.balls, t, &self.cradle, &self.inputs);
        }
        self.look_for_faults(i..i + 1, t);
        let displacement = self.balls[i].reanchor(t);
        self.shift_contacts(i, displacement);
    }

    /// Adjusts the overlaps of the anchored contacts of ball `i` to the last displacement (m) of its anchor.
    #[inline]
    fn shift_contacts(&mut self, i: usize, displacement: f64) {
        for (j, side) in [(i.wrapping_sub(1), 1), (i, 0)] {
            if let Some(ContactRole::Anchored(contact)) = self.contacts.get_mut(j).map(|contact| &mut contact.role) {
                let (mut places, mut moves) = ([0, 1].map(|side| self.balls[j + side].flight.x), [0.0; 2]);
                places[side] -= displacement;
                moves[side] = displacement;
                contact.overlap += self.cradle.pair(j).change_of_overlap(places, moves);
            }
        }
    }

    /// Gives up the known outcome of contact `i` at the time `t` within its impact: follows the impact from its onset
    /// to `t`, and leaves its balls in flight and its contact closed.
    pub(crate) fn break_impact(&mut self, i: usize, t: DoubleDouble) {
        self.before_move(i, t);
        self.before_move(i + 1, t);
        self.begin_ledger(i, t);
        let Some(Interaction::Impact(impact)) = self.leave(i) else { return };
        let (mut cluster, control) = (self.first_segment(&impact), self.control_within(&impact));
        self.queue.remove(i);
        let mut moved = [0.0; 2];
        loop {
            let goes_on = cluster.start < cluster.end() && cluster.end() < t && cluster.switch.is_none();
            let end = if goes_on { cluster.end() } else { t };
            let tau = (end - cluster.start).value();
            for (side, moved) in moved.iter_mut().enumerate() {
                *moved += cluster.moved(i + side, tau).0;
            }
            self.account_until(&mut cluster, end);
            if end == t {
                break;
            }
            cluster.expand(&self.balls, &self.cradle, &control);
        }
        moved.into_iter().enumerate().for_each(|(side, moved)| self.shift_contacts(i + side, moved));
        self.contacts[i].set_anchored(cluster.contacts[0].overlap, Mode::Pressing);
    }

    /// Takes the interaction of contact `i` away from its balls.
    fn leave(&mut self, i: usize) -> Option<Interaction> {
        let id = self.balls[i].interaction?;
        self.balls[i..i + 2].iter_mut().for_each(|ball| ball.interaction = None);
        self.interactions[id as usize].take()
    }

    /// Step control within an impact, for which the number of segments does not depend on the speed.
    fn control_within(&self, impact: &PairImpact) -> Control {
        Control { longest: self.control.longest.max(impact.outcome.duration), ..self.control }
    }

    /// The balls of an impact as a cluster without spectators, from the onset on.
    fn first_segment(&self, impact: &PairImpact) -> Cluster {
        let members = impact.contact..impact.contact + 2;
        let mut cluster = Cluster::default();
        cluster.renew(members.clone(), members.clone(), impact.start, StepHistory::default());
        cluster.flights.extend(self.balls[members].iter().map(|ball| ball.flight));
        cluster.contacts.push(WindowContact { overlap: 0.0, mode: Mode::Pressing });
        cluster.expand(&self.balls, &self.cradle, &self.control_within(impact));
        cluster
    }

    /// The segment of an impact under way at the time `t`, with the sums before it; the last segment for a later time.
    /// The first call computes all segments.
    pub(super) fn interior<'a>(&self, impact: &'a PairImpact, t: DoubleDouble) -> Option<&'a Interior> {
        let segments = impact.interior.get_or_init(|| {
            let segment = self.first_segment(impact);
            let first = Interior { segment, impulse: 0.0, integrals: Default::default() };
            std::iter::successors(Some(first), |last| self.after(last, impact)).collect()
        });
        segments.get(segments.partition_point(|interior| interior.segment.end() <= t)).or(segments.last())
    }

    /// The segment after `last`, unless the impact is over or the time stalls.
    fn after(&self, last: &Interior, impact: &PairImpact) -> Option<Interior> {
        let i = impact.contact;
        let over = matches!(last.segment.switch, Some((_, Switch::Release)));
        let (length, end) = (last.segment.length, last.segment.end());
        let goes_on = last.segment.start < end && end < impact.end(); // False for NaN.
        if over || !goes_on {
            return None;
        }
        let mut integrals = last.integrals;
        for (integrals, ball) in integrals.iter_mut().zip(i..) {
            integrals.add(&last.segment.integrals(ball, &RunningIntegrals::default(), &self.balls[ball], length));
        }
        let mut segment = last.segment.clone();
        segment.move_start(length, &self.balls, &self.cradle.contacts);
        segment.expand(&self.balls, &self.cradle, &self.control_within(impact));
        Some(Interior { segment, impulse: last.impulse + last.segment.impulse(i, length), integrals })
    }

    /// Largest force of the current impact in contact `i` between two times, N; 0 if there is none. Without losses the
    /// force is symmetric in time, and largest half way.
    pub(crate) fn impact_peak(&self, i: usize, from: DoubleDouble, to: DoubleDouble) -> f64 {
        let Some(impact) = self.impact(i) else { return 0.0 };
        let since = |t: DoubleDouble| (t - impact.start).value();
        let (begin, end) = (since(from).max(0.0), since(to).min(impact.outcome.duration));
        let top = 0.5 * impact.outcome.duration;
        if begin > end {
            return 0.0;
        }
        // An impact that is too short for the clock ends when it begins.
        if begin <= top && (top <= end || to >= impact.end()) {
            return impact.outcome.peak.force;
        }
        let nearest = impact.start + if end < top { end } else { begin };
        self.interior(impact, nearest).map_or(0.0, |interior| {
            let (overlap, rate) = interior.segment.overlap(i, interior.since(nearest));
            self.cradle.contacts[i].force(overlap, rate)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Unrecorded;
    use crate::model::{Chain, Inputs, Parameters, Results};

    /// Two balls without gravity collide at speeds whose squares underflow, or with a contact that lasts for ever: they
    /// move, and the number of segments of the impact is the usual one.
    #[test]
    fn pair_impacts_of_any_speed() {
        for (speed, exponent) in [(1.0, 10.0), (1e-30, 10.0), (1e-165, 1.0), (1e-165, 10.0), (1e-250, 1.5)] {
            let (x_start, v_start) = (vec![0.0; 2], vec![speed, 0.0]);
            let p =
                Parameters { gravity: 0.0, exponent, dead_band: 0.0, x_start, v_start, ..Parameters::default_for(2) };
            let mut engine = Engine::new(&p, &Inputs::zero(2), 0.0).unwrap();
            engine.advance(1e-12, &mut Unrecorded).unwrap();
            let time = engine.impact(0).map_or(1e-3, |impact| 0.5 * impact.outcome.duration);
            engine.advance(time, &mut Unrecorded).unwrap();
            let moved = (engine.x(0) + engine.x(1)) / (speed * time);
            assert!((moved - 1.0).abs() < 1e-12, "{speed} {exponent}: {moved}");
            assert!(engine.force(0).is_finite() && engine.next_onset().time() > time);
            let segments = engine.impact(0).and_then(|impact| impact.interior.get()).map(Vec::len);
            assert!(segments.is_none_or(|segments| segments <= 12), "{speed} {exponent}: {segments:?}");
            assert!(segments.is_some() || speed < 1e-100, "{speed} {exponent}");
        }
    }
}
