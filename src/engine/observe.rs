//! What can be read at the current time. Nothing here moves the trajectory.

use super::ball::Tally;
use super::cluster::{Cluster, Mode};
use super::{Engine, NEVER, Work};
use crate::solver::double_double::DoubleDouble;

/// Periods of the first ball within which the next onset is looked for.
const ONSET_PERIODS: f64 = 1000.0;

impl Engine {
    fn now(&self) -> DoubleDouble {
        self.time.into()
    }

    /// The cluster that ball `i` belongs to, and the time since the start of its segment.
    fn cluster_of_ball(&self, i: usize, t: DoubleDouble) -> Option<(&Cluster, f64)> {
        let cluster = self.clusters[self.balls[i].cluster? as usize].as_ref()?;
        Some((cluster, (t - cluster.start).value()))
    }

    /// The same for contact `i`, which may lie between a member and a spectator.
    fn cluster_of_contact(&self, i: usize, t: DoubleDouble) -> Option<(&Cluster, f64)> {
        let cluster = self.clusters[self.contacts[i].cluster? as usize].as_ref()?;
        Some((cluster, (t - cluster.start).value()))
    }

    /// Position (m) and velocity (m/s) of ball `i` at the time `t`, not before its anchor.
    fn state_at(&self, i: usize, t: DoubleDouble) -> (f64, f64) {
        let (x, (displacement, v)) = match self.cluster_of_ball(i, t) {
            Some((cluster, tau)) => (cluster.flights[i - cluster.window.start].x, cluster.moved(i, tau)),
            None => (self.balls[i].flight.x, self.balls[i].moved(t)),
        };
        (x + displacement, v)
    }

    fn tally_at(&self, i: usize, t: DoubleDouble) -> Tally {
        match self.cluster_of_ball(i, t) {
            Some((cluster, tau)) => cluster.tally(i, &self.balls[i], tau),
            None => self.balls[i].tally_at(t),
        }
    }

    /// Position of ball `i`, m.
    pub fn x(&self, i: usize) -> f64 {
        self.state_at(i, self.now()).0
    }

    /// Velocity of ball `i`, m/s.
    pub fn v(&self, i: usize) -> f64 {
        self.state_at(i, self.now()).1
    }

    /// Acceleration of ball `i`, m/s2.
    pub fn a(&self, i: usize) -> f64 {
        let model = &self.cradle.balls[i];
        let (x, v) = self.state_at(i, self.now());
        let from_left = if i > 0 { self.force(i - 1) } else { 0.0 };
        let from_right = if i < self.contacts.len() { self.force(i) } else { 0.0 };
        let push = self.inputs.force[i] / model.mass - self.inputs.support_acceleration;
        (from_left - from_right) / model.mass + push - model.omega2 * x - 2.0 * model.gamma * v
    }

    /// Force in contact `i`, N.
    pub fn force(&self, i: usize) -> f64 {
        match self.cluster_of_contact(i, self.now()) {
            Some((cluster, tau)) if cluster.mode(i) == Mode::Pressing => {
                let (overlap, rate) = cluster.overlap(i, tau);
                self.cradle.contacts[i].unclipped_force(overlap, rate)
            }
            _ => 0.0,
        }
    }

    /// Overlap of contact `i`, m; negative while apart.
    pub fn overlap(&self, i: usize) -> f64 {
        match (self.cluster_of_contact(i, self.now()), &self.contacts[i].separation) {
            (Some((cluster, tau)), _) => cluster.overlap(i, tau).0,
            (None, Some(separation)) => separation.at_time(self.now()).0,
            (None, None) => self.contacts[i].overlap,
        }
    }

    /// Whether the overlap of contact `i` is positive.
    pub fn in_contact(&self, i: usize) -> bool {
        self.overlap(i) > 0.0
    }

    fn impulse_at(&self, i: usize, t: DoubleDouble) -> DoubleDouble {
        let segment = self.cluster_of_contact(i, t).map_or(0.0, |(cluster, tau)| cluster.impulse(i, tau));
        self.contacts[i].ledger.impulse + segment
    }

    /// Integral of the force in contact `i` since the start, N.s.
    pub fn impulse(&self, i: usize) -> f64 {
        self.impulse_at(i, self.now()).value()
    }

    /// Length of the last step, s; 0 before the first.
    fn step_length(&self) -> f64 {
        self.time - self.step_start.time
    }

    /// Mean of the force in contact `i` over the last step, N; the force itself before the first step.
    pub fn force_mean(&self, i: usize) -> f64 {
        if self.step_length() == 0.0 {
            return self.force(i);
        }
        self.contacts[i].ledger.impulse_in_step(self.step, self.impulse_at(i, self.now())) / self.step_length()
    }

    /// Largest force in contact `i` in the last step, N; 0 if the contact was open throughout. The force itself before the
    /// first step.
    pub fn force_peak(&self, i: usize) -> f64 {
        if self.step_length() == 0.0 {
            return self.force(i);
        }
        let segment = self.cluster_of_contact(i, self.now()).map_or(0.0, |(cluster, tau)| {
            let from = (DoubleDouble::from(self.step_start.time) - cluster.start).value().max(0.0);
            cluster.peak(i, from, tau)
        });
        segment.max(self.contacts[i].ledger.peak_in_step(self.step))
    }

    /// Onsets of contact `i` so far.
    pub fn pulses(&self, i: usize) -> u64 {
        self.contacts[i].ledger.pulses
    }

    /// Last onset of contact `i`, s; -1e30 before the first.
    pub fn last_onset(&self, i: usize) -> f64 {
        self.contacts[i].ledger.onset
    }

    /// Last release of contact `i`, s; -1e30 before the first.
    pub fn last_release(&self, i: usize) -> f64 {
        self.contacts[i].ledger.release
    }

    /// Kinetic energy of ball `i`, J.
    pub fn kinetic_energy(&self, i: usize) -> f64 {
        let v = self.v(i);
        0.5 * self.balls[i].mass * v * v
    }

    /// Energy of ball `i` in the field of gravity, J.
    pub fn gravity_energy(&self, i: usize) -> f64 {
        let x = self.x(i);
        0.5 * self.balls[i].mass * self.cradle.balls[i].omega2 * x * x
    }

    /// Elastic energy of contact `i`, J.
    pub fn contact_energy(&self, i: usize) -> f64 {
        self.cradle.contacts[i].elastic_energy(self.overlap(i))
    }

    /// Kinetic, gravity and contact energy of all, J.
    pub fn total_energy(&self) -> f64 {
        let ball = |i: usize| {
            let (x, v) = self.state_at(i, self.now());
            0.5 * self.balls[i].mass * (v * v + self.cradle.balls[i].omega2 * x * x)
        };
        let contacts: f64 = (0..self.contacts.len()).map(|i| self.contact_energy(i)).sum();
        (0..self.balls.len()).map(ball).sum::<f64>() + contacts
    }

    /// Energy dissipated by drag and contacts since the start, J.
    pub fn dissipated_energy(&self) -> f64 {
        let now = self.now();
        let drag: f64 = (0..self.balls.len()).map(|i| self.tally_at(i, now).drag_loss).sum();
        let contact = |i: usize| {
            let law = &self.cradle.contacts[i];
            self.cluster_of_contact(i, now).map_or(0.0, |(cluster, tau)| cluster.contact_loss(i, law, tau))
        };
        drag + self.contact_loss + (0..self.contacts.len()).map(contact).sum::<f64>()
    }

    /// Work of the external forces and of the support's acceleration since the start, J.
    pub fn external_work(&self) -> f64 {
        (0..self.balls.len()).map(|i| self.tally_at(i, self.now()).work).sum()
    }

    /// `total + dissipated - external - total at the start`, J: the engine's own energy error.
    pub fn energy_residual(&self) -> f64 {
        (self.total_energy() - self.energy_at_start) + (self.dissipated_energy() - self.external_work())
    }

    /// Sum of `m v`, kg.m/s.
    pub fn momentum(&self) -> f64 {
        (0..self.balls.len()).map(|i| self.balls[i].mass * self.v(i)).sum()
    }

    /// Horizontal force on the support, N.
    pub fn support_force(&self) -> f64 {
        let ball = |i: usize| {
            let (x, v) = self.state_at(i, self.now());
            let model = &self.cradle.balls[i];
            model.mass * (model.omega2 * x + 2.0 * model.gamma * v)
        };
        (0..self.balls.len()).map(ball).sum()
    }

    /// Integral of the force on the support since the start up to a constant, N.s.
    fn support_impulse_at(&self, t: DoubleDouble) -> f64 {
        let ball = |i: usize| {
            let model = &self.cradle.balls[i];
            let drag = if model.gamma > 0.0 { 2.0 * model.gamma * self.state_at(i, t).0 } else { 0.0 };
            model.mass * (model.omega2 * self.tally_at(i, t).x_integral + drag)
        };
        (0..self.balls.len()).map(ball).sum()
    }

    /// Mean of the force on the support over the last step, N; the force itself before the first step.
    pub fn support_force_mean(&self) -> f64 {
        if self.step_length() == 0.0 {
            return self.support_force();
        }
        // Without an event in the step the anchors still lie before its start.
        let at_start = || self.support_impulse_at(self.step_start.time.into());
        let before = self.step_start.support_impulse.unwrap_or_else(at_start);
        (self.support_impulse_at(self.now()) - before) / self.step_length()
    }

    /// First onset strictly after the current time, s, with the inputs continued; [`NEVER`] if there is none within 1000
    /// periods of the first ball.
    pub fn next_onset(&self) -> f64 {
        let period = std::f64::consts::TAU / self.balls[0].oscillator.omega();
        let limit = DoubleDouble::from(self.time + ONSET_PERIODS * period);
        let Some((t, key)) = self.queue.first() else { return NEVER };
        if self.contacts[key].cluster.is_none() && self.contacts[key].closes {
            return if t <= limit { t.value_up() } else { NEVER };
        }
        // A contact phase is under way, or the forecasts do not reach far enough: follow a copy.
        let mut ahead = self.clone();
        let onsets = |engine: &Self| engine.contacts.iter().map(|c| c.ledger.pulses).sum::<u64>();
        let before = onsets(self);
        while let Some((t, key)) = ahead.queue.first().filter(|(t, _)| *t <= limit) {
            if ahead.process(t, key, &mut Vec::new()).is_err() {
                break;
            }
            if onsets(&ahead) > before {
                return t.value_up();
            }
        }
        NEVER
    }

    /// Work counters since the start.
    pub fn work(&self) -> Work {
        self.work
    }

    /// Starts a new step at the current time.
    pub(super) fn begin_step(&mut self) {
        self.step += 1;
        self.step_start = super::StepStart { time: self.time, support_impulse: None };
        for id in 0..self.clusters.len() {
            let Some(cluster) = &self.clusters[id] else { continue };
            for i in cluster.window_contacts() {
                let impulse = self.impulse_at(i, self.now());
                self.contacts[i].ledger.begin_step(self.step, impulse);
            }
        }
    }

    /// Takes down what the means over the step need, before the first event of the step moves the anchors.
    pub(super) fn keep_step_start(&mut self) {
        if self.step_start.support_impulse.is_none() {
            self.step_start.support_impulse = Some(self.support_impulse_at(self.step_start.time.into()));
        }
    }
}
