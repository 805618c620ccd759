//! The outputs at the current time, and the records of the start of the step. Nothing here changes the trajectory.

use crate::engine::flight::{RunningIntegrals, forcing_at};
use crate::engine::run::{ContactRole, Engine, NO_STEP, SegmentAt};
use crate::engine::{Forecast, chain_state::ChainState, records::BallStart};
use crate::model::{Chain, Cradle, Mode, Record, Results, WorkCounters};
use crate::solver::DoubleDouble;

impl Engine {
    fn now(&self) -> DoubleDouble {
        self.time.into()
    }

    /// Position (m) and velocity (m/s) of ball `i` at the time `t`, not before its anchor.
    pub(crate) fn state_at(&self, i: usize, t: DoubleDouble) -> (f64, f64) {
        let (x, (displacement, v)) = match self.segment_of_ball(i, t) {
            Some(SegmentAt { cluster, tau, .. }) => {
                (cluster.flights[i - cluster.window.start].x, cluster.moved(i, tau))
            }
            None => (self.balls[i].flight.x, self.balls[i].moved(t)),
        };
        (x + displacement, v)
    }

    pub(crate) fn integrals_at(&self, i: usize, t: DoubleDouble) -> RunningIntegrals {
        let ball = &self.balls[i];
        if let Some(segment) = self.segment_of_ball(i, t) {
            let mut integrals = segment.cluster.integrals(i, &ball.integrals, ball, segment.tau);
            segment.add_earlier(i, &mut integrals);
            return integrals;
        }
        match ball.interaction {
            Some(_) => ball.integrals_under(&self.own_forcing(i, ball.anchor), t),
            None => ball.integrals_under(&ball.flight.forcing, t),
        }
    }

    /// Whether contact `i` is rigid and will be closed once the run begins.
    fn is_held_back(&self, i: usize) -> bool {
        self.initializing && self.constraint(i).is_some()
    }

    /// Overlap of contact `i` (m) and its mode at the time `t`.
    pub(crate) fn overlap_at(&self, i: usize, t: DoubleDouble) -> (f64, Mode) {
        match (&self.contacts[i].role, self.segment_of_contact(i, t)) {
            (_, Some(SegmentAt { cluster, tau, .. })) => (cluster.overlap(i, tau).0, cluster.mode(i)),
            // Rigid balls that move as one.
            (ContactRole::Interacting(_), None) => (0.0, Mode::Pressing),
            // Rigid balls side by side overlap by rounding only.
            (ContactRole::Open(separation, _), _) if self.is_rigid() => (separation.at_time(t).0.min(0.0), Mode::Open),
            (ContactRole::Open(separation, _), _) => (separation.at_time(t).0, Mode::Open),
            (ContactRole::Anchored(contact), _) => (self.overlap_since_anchors(i, contact.overlap, t), contact.mode),
        }
    }

    /// The whole chain at the time `t`, not before any anchor.
    pub(crate) fn state_of_all(&self, t: DoubleDouble) -> ChainState {
        let balls = (0..self.balls.len()).map(|i| self.state_at(i, t));
        ChainState::new(balls, (0..self.contacts.len()).map(|i| self.overlap_at(i, t)))
    }

    /// Overlap of contact `i` at the time `t`, m, from the overlap `between_anchors` of its balls, m.
    fn overlap_since_anchors(&self, i: usize, between_anchors: f64, t: DoubleDouble) -> f64 {
        // Displacement since the anchor; for a ball in an impact, since its onset.
        let displacement = |ball: usize| match self.segment_of_ball(ball, t) {
            Some(SegmentAt { cluster, tau, .. }) => {
                let came_with = self.balls[ball].flight.x;
                (cluster.flights[ball - cluster.window.start].x - came_with) + cluster.moved(ball, tau).0
            }
            None => self.balls[ball].moved(t).0,
        };
        between_anchors + self.cradle.pair(i).change_of_overlap(self.anchors(i), [i, i + 1].map(displacement))
    }

    pub(crate) fn impulse_at(&self, i: usize, t: DoubleDouble) -> DoubleDouble {
        let since = match (self.constraint(i), self.segment_of_contact(i, t)) {
            (Some(constraint), _) => constraint.impulse(t),
            (None, Some(segment)) => segment.impulse + segment.cluster.impulse(i, segment.tau),
            (None, None) => 0.0,
        };
        self.contacts[i].ledger.impulse + since
    }

    /// Integral of the force of ball `i` on the support over its mass, up to a constant, m/s.
    fn support_at(&self, i: usize, t: DoubleDouble) -> DoubleDouble {
        self.integrals_at(i, t).support + -self.horizontal_velocity(i, t)
    }

    /// Horizontal velocity of ball `i` on an arc, m/s, otherwise 0. The impulse of the inputs that is not in the
    /// momentum acts on the support; contact forces cancel in the sum.
    fn horizontal_velocity(&self, i: usize, t: DoubleDouble) -> f64 {
        let model = &self.cradle.balls[i];
        if !model.on_arc {
            return 0.0;
        }
        let (s, u) = self.state_at(i, t);
        u * model.place(s).cos
    }

    /// Integral of the force of ball `i` on the support over its mass, in the step so far, m/s.
    fn support_in_step(&self, i: usize) -> f64 {
        let (ball, now, start) = (&self.balls[i], self.now(), DoubleDouble::from(self.step.time));
        match &self.step.balls[i] {
            Some(start) => (self.support_at(i, now) + -start.support).value(),
            None if self.flies(i) => {
                let momentum = self.horizontal_velocity(i, now) - self.horizontal_velocity(i, start);
                ball.support_between(start, now) - momentum
            }
            None => (self.support_at(i, now) + -self.support_at(i, start)).value(),
        }
    }

    /// Records the start of the step before an event at a later time `t` changes the motion of ball `i` or its
    /// contacts.
    pub(crate) fn before_move(&mut self, i: usize, t: DoubleDouble) {
        if t > self.step.time.into() {
            self.record_start(i);
        }
    }

    /// Records the states of ball `i` and its contacts at the start of the step, unless that has been done.
    pub(crate) fn record_start(&mut self, i: usize) {
        // A copy that looks ahead needs no records.
        if self.step.time == NO_STEP || self.step.balls[i].is_some() {
            return;
        }
        let start = self.step.time.into();
        for j in i.saturating_sub(1)..(i + 1).min(self.contacts.len()) {
            if self.step.contacts[j].is_none() {
                self.step.contacts[j] = Some(self.overlap_at(j, start));
            }
        }
        let (state, support) = (self.state_at(i, start), self.support_at(i, start));
        self.step.balls[i] = Some(BallStart { state, support });
        self.step.moved.push(i as u32);
    }

    /// Records the impulse at the start of the step before an event at a later time `t` changes the ledger of contact
    /// `i`.
    #[inline(always)]
    pub(crate) fn begin_ledger(&mut self, i: usize, t: DoubleDouble) {
        if t > self.step.time.into() && self.contacts[i].ledger.impulse_at_start(self.step.number).is_none() {
            self.record_impulse_at_start(i, t);
        }
    }

    fn record_impulse_at_start(&mut self, i: usize, t: DoubleDouble) {
        let start = self.step.time.into();
        let impulse = match self.constraint(i) {
            Some(constraint) => self.impulse_at(i, t) + -constraint.impulse_between(start, t),
            None => self.impulse_at(i, start),
        };
        self.contacts[i].ledger.begin_step(self.step.number, impulse);
    }

    /// Enters the step so far in the records, before a change that acts from now on.
    pub(crate) fn enter_step(&mut self) {
        if self.step_length() == 0.0 {
            return; // The step has only begun.
        }
        for i in 0..self.balls.len() {
            let (now, so_far) = (self.support_at(i, self.now()), self.support_in_step(i));
            self.record_start(i);
            if let Some(start) = &mut self.step.balls[i] {
                start.support = now + -so_far;
            }
        }
        for i in 0..self.contacts.len() {
            if self.presses(i) || self.constraint(i).is_some() {
                let peak = self.force_peak(i);
                self.begin_ledger(i, self.now());
                self.contacts[i].ledger.raise_peak_of_step(peak);
            }
        }
        self.step.entered = self.time;
    }

    pub(crate) fn state_at_start(&self) -> ChainState {
        let at = self.step.time.into();
        let ball = |i: usize| self.step.balls[i].map_or_else(|| self.state_at(i, at), |start| start.state);
        let contact = |i: usize| self.step.contacts[i].unwrap_or_else(|| self.overlap_at(i, at));
        ChainState::new((0..self.balls.len()).map(ball), (0..self.contacts.len()).map(contact))
    }
}

impl Chain for Engine {
    fn cradle(&self) -> &Cradle {
        &self.cradle
    }

    /// Cached, because most outputs need it.
    fn state_of(&self, i: usize) -> (f64, f64) {
        let (known, own) = (&self.caches.states[i], self.balls[i].anchor);
        let (time, anchor, state) = known.get();
        if time == self.time && anchor == own {
            return state;
        }
        let state = self.state_at(i, self.now());
        known.set((self.time, own, state));
        state
    }

    fn overlap(&self, i: usize) -> f64 {
        self.overlap_at(i, self.now()).0
    }

    /// Rigid balls that press on each other overlap by 0.
    fn in_contact(&self, i: usize) -> bool {
        let presses = self.constraint(i).is_some() && !self.is_held_back(i);
        presses || self.overlap(i) > 0.0
    }

    /// For a lasting rigid contact, the constraint force.
    fn force(&self, i: usize) -> f64 {
        if self.is_held_back(i) {
            return 0.0;
        }
        if let Some(constraint) = self.constraint(i) {
            return constraint.force(self.now());
        }
        match self.segment_of_contact(i, self.now()) {
            Some(SegmentAt { cluster, tau, .. }) if cluster.mode(i) == Mode::Pressing => {
                let (overlap, rate) = cluster.overlap(i, tau);
                self.cradle.contacts[i].force(overlap, rate)
            }
            _ => 0.0,
        }
    }

    fn forcing_of(&self, i: usize) -> f64 {
        forcing_at(&self.inputs.forcing(i, self.cradle.balls[i].mass), self.time - self.inputs.since)
    }
}

impl Results for Engine {
    /// Length of the last step, s; 0 before the first.
    fn step_length(&self) -> f64 {
        self.time - self.step.time
    }

    fn support_impulse_of_step(&self) -> f64 {
        self.cradle.balls.iter().enumerate().map(|(i, ball)| ball.mass * self.support_in_step(i)).sum()
    }

    fn impulse_of_step(&self, i: usize) -> f64 {
        let (now, start) = (self.now(), self.step.time.into());
        match (self.contacts[i].ledger.impulse_at_start(self.step.number), self.constraint(i)) {
            (Some(before), _) => (self.impulse_at(i, now) - before).value(),
            (None, Some(constraint)) => constraint.impulse_between(start, now),
            (None, None) => (self.impulse_at(i, now) - self.impulse_at(i, start)).value(),
        }
    }

    fn impulse(&self, i: usize) -> f64 {
        self.impulse_at(i, self.now()).value()
    }

    fn force_peak(&self, i: usize) -> f64 {
        if self.step_length() == 0.0 {
            return self.force(i);
        }
        let from = DoubleDouble::from(self.step.time);
        let before = self.contacts[i].ledger.peak_in_step(self.step.number);
        if self.step.entered == self.time {
            return before;
        }
        if let Some(constraint) = self.constraint(i) {
            return constraint.peak(from, self.now()).force.max(before);
        }
        match self.cluster(i) {
            Some(cluster) => {
                let [from, to] = [from, self.now()].map(|t| (t - cluster.start).value());
                cluster.largest_force(i, from.max(0.0), to, before)
            }
            None => self.impact_peak(i, from, self.now()).max(before),
        }
    }

    fn record(&self, i: usize) -> Record {
        let record = self.contacts[i].ledger.record;
        if self.is_held_back(i) { Record { release: record.release, ..Record::default() } } else { record }
    }

    fn energy_at_start(&self) -> f64 {
        self.totals.energy_at_start
    }

    fn dissipated_energy(&self) -> f64 {
        let now = self.now();
        let drag: f64 = (0..self.balls.len()).map(|i| self.integrals_at(i, now).drag_loss).sum();
        let contact = |i: usize| {
            let law = &self.cradle.contacts[i];
            self.segment_of_contact(i, now).map_or(0.0, |segment| segment.cluster.contact_loss(i, law, segment.tau))
        };
        drag + self.totals.contact_loss + (0..self.contacts.len()).map(contact).sum::<f64>()
    }

    fn external_work(&self) -> f64 {
        (0..self.balls.len()).map(|i| self.integrals_at(i, self.now()).work).sum()
    }

    fn next_onset(&self) -> Forecast {
        self.find_next_onset()
    }

    fn work(&self) -> WorkCounters {
        self.totals.work
    }
}
