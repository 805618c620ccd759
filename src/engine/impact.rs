//! Impacts of two balls whose outcome is known at their onset: begun, ended, and given up where something interferes.

use std::ops::Range;

use super::ball::Held;
use super::pair::PairImpact;
use super::window::Mode;
use super::{Engine, Observer};
use crate::solver::double_double::DoubleDouble;

impl Engine {
    /// Begins the closing of contact `i` at `t` as an impact of known outcome, if it is one: two balls that are in flight, and
    /// stay clear of their neighbours until the impact is over.
    pub(super) fn begin_impact(&mut self, i: usize, t: DoubleDouble) -> bool {
        let neighbours = i.saturating_sub(1)..(i + 3).min(self.balls.len());
        let held = |ball: usize| self.balls[ball].held;
        if held(i) != Held::Free || held(i + 1) != Held::Free {
            return false;
        }
        if neighbours.clone().any(|ball| matches!(held(ball), Held::Cluster(_))) {
            return false;
        }
        self.land_free(neighbours.clone(), t);
        self.close_separation(i);
        for beside in neighbours.start..neighbours.end - 1 {
            self.stop_separation(beside, t);
        }
        let (left, right) = (&self.balls[i], &self.balls[i + 1]);
        // In its place at once: it is large to move.
        self.contacts[i].impact = PairImpact::new(left, right, &self.cradle.contacts[i], &self.shape);
        let impact = self.contacts[i].impact.as_ref();
        let Some(end) = impact.map(PairImpact::end) else { return false };
        let clear_left = i == 0 || self.stays_open(i - 1, t, None, impact);
        let clear_right = i + 2 == self.balls.len() || self.stays_open(i + 1, t, impact, None);
        if !(clear_left && clear_right) {
            self.contacts[i].impact = None;
            return false;
        }
        self.queue.set(i, end);
        for beside in neighbours.start..neighbours.end - 1 {
            self.contacts[beside].waits = beside != i;
        }
        (self.balls[i].held, self.balls[i + 1].held) = (Held::Impact(i as u32), Held::Impact(i as u32));
        self.contacts[i].ledger.open_pulse(t, self.step);
        self.onsets = self.onsets.saturating_add(1);
        self.count_event();
        self.work.steps = self.work.steps.saturating_add(1);
        self.work.evaluations = self.work.evaluations.saturating_add(1);
        true
    }

    /// Whether the open contact `j` provably stays open from `t` on until the impacts of its balls are over: the impact about
    /// to begin, given for the ball that it moves, and one that may be under way for the other.
    fn stays_open(&self, j: usize, t: DoubleDouble, left: Option<&PairImpact>, right: Option<&PairImpact>) -> bool {
        let under_way = |ball: usize| match self.balls[ball].held {
            Held::Impact(contact) => self.contacts[contact as usize].impact.as_ref(),
            _ => None,
        };
        // Each ball, the time since its anchor, its impact, and how long that still lasts.
        let sides = [(j, left), (j + 1, right)].map(|(i, impact)| {
            let (ball, impact) = (&self.balls[i], impact.or_else(|| under_way(i)));
            let age = (t - ball.anchor).value();
            (ball, age, impact, impact.map_or(0.0, |impact| (impact.duration - age).max(0.0)))
        });
        let remaining = sides.map(|(.., rest)| rest);
        let longest = remaining[0].max(remaining[1]);
        let slack: f64 = sides.iter().map(|(ball, age, ..)| ball.bend(age + longest)).sum();
        // Displacement since the anchor along the chord of the impact, or straight on in flight.
        let chord = |side: usize, after: f64| {
            let (ball, age, impact, _) = sides[side];
            impact.map_or(ball.flight.v * (age + after), |impact| impact.chord(1 - side, age + after))
        };
        let overlap = |after: f64| self.contacts[j].overlap + (chord(0, after) - chord(1, after)) + slack;
        [0.0, remaining[0], remaining[1]].into_iter().all(|after| overlap(after) < 0.0)
    }

    /// The impact of contact `i` is over at `t`.
    pub(super) fn end_impact(&mut self, i: usize, t: DoubleDouble, observer: &mut dyn Observer) {
        self.before_move(i, t);
        self.before_move(i + 1, t);
        let in_step = self.impact_peak(i, self.step_start.into(), t);
        self.begin_ledger(i, t);
        let contact = &mut self.contacts[i];
        let Some(impact) = &contact.impact else { return };
        contact.ledger.add(impact.impulse, impact.peak, in_step);
        for (side, ball) in self.balls[i..i + 2].iter_mut().enumerate() {
            ball.flight.x += impact.displacement;
            ball.flight.v = impact.velocities[side];
            ball.anchor = t;
            ball.tally.add(&impact.tallies[side]);
            ball.held = Held::Free;
        }
        let displacement = impact.displacement;
        (contact.impact, contact.overlap) = (None, 0.0);
        self.shift_neighbours(i, displacement, displacement);
        observer.pulse(self.contacts[i].ledger.close_pulse(i, t));
        self.count_event();
        let neighbours = i.saturating_sub(1)..(i + 3).min(self.balls.len());
        self.land_free(neighbours.clone(), t);
        for j in neighbours.start..neighbours.end - 1 {
            if self.balls[j].held == Held::Free && self.balls[j + 1].held == Held::Free {
                self.fly(j, t);
            }
        }
    }

    /// Moves the anchors of those of `balls` that are in flight to `t`.
    pub(super) fn land_free(&mut self, balls: Range<usize>, t: DoubleDouble) {
        for ball in balls {
            if self.balls[ball].held == Held::Free {
                self.land(ball, t);
            }
        }
    }

    /// Moves the anchor of ball `i`, in flight, to `t`. Contacts that wait for the end of an impact refer to the anchors.
    pub(super) fn land(&mut self, i: usize, t: DoubleDouble) {
        if self.balls[i].anchor == t {
            return;
        }
        self.before_move(i, t);
        let displacement = self.balls[i].land(t);
        if i > 0 && self.contacts[i - 1].waits {
            self.contacts[i - 1].overlap -= displacement;
        }
        if i < self.contacts.len() && self.contacts[i].waits {
            self.contacts[i].overlap += displacement;
        }
    }

    /// The contacts beside contact `i` follow its balls, whose anchors have moved by these displacements (m).
    fn shift_neighbours(&mut self, i: usize, left: f64, right: f64) {
        if i > 0 {
            self.contacts[i - 1].overlap -= left;
        }
        if i + 1 < self.contacts.len() {
            self.contacts[i + 1].overlap += right;
        }
    }

    /// Gives the known outcome of contact `i` up at `t`, within its impact: the impact is followed from its onset to `t` like
    /// any other, and left there with its balls in flight and its contact closed.
    pub(super) fn break_impact(&mut self, i: usize, t: DoubleDouble) {
        self.before_move(i, t);
        self.before_move(i + 1, t);
        self.begin_ledger(i, t);
        let Some(impact) = self.contacts[i].impact.take() else { return };
        self.queue.remove(i);
        let (mut cluster, control) = self.alone(i, &impact);
        let mut moved = [0.0; 2];
        loop {
            let goes_on = cluster.end() < t && cluster.switch.is_none() && cluster.length > 0.0;
            let end = if goes_on { cluster.end() } else { t };
            let tau = (end - cluster.start).value();
            for (side, moved) in moved.iter_mut().enumerate() {
                *moved += cluster.moved(i + side, tau).0;
            }
            self.fold(&mut cluster, end);
            if end == t {
                break;
            }
            cluster.expand(&self.balls, &self.cradle.contacts, &control);
        }
        for side in 0..2 {
            let ball = &mut self.balls[i + side];
            (ball.flight, ball.anchor, ball.held) = (cluster.flights[side], t, Held::Free);
        }
        self.shift_neighbours(i, moved[0], moved[1]);
        (self.contacts[i].overlap, self.contacts[i].mode) = (cluster.contacts[0].overlap, Mode::Pressing);
    }
}
