//! Impacts of rigid balls, linearised, each at its own time.

use std::ops::Range;

use super::coefficients::{Coefficients, IMPULSE, LENGTH, MASS, RESTITUTION, STATE, V, X};
use super::events::Overlap;
use super::part::Part;
use super::record::Recorder;
use super::scene::acceleration;
use super::unfollowed::Unfollowed;
use crate::engine::HeldInputs;
use crate::engine::rigid::restitution::{TouchingRow, collide_at_once};
use crate::model::Cradle;
use crate::solver::{DoubleDouble, Dual, Scalar};

/// A ball in an impact: its position along the path, m, and velocities (m/s) and accelerations (m/s2) before and after.
#[derive(Clone, Copy, Debug)]
pub(super) struct Struck {
    pub x: f64,
    pub v: [f64; 2],
    pub a: [f64; 2],
}

/// One impact of touching rigid balls: of two, or of more at once.
#[derive(Debug)]
pub(super) struct RigidImpact {
    pub first: usize,
    pub balls: Vec<Struck>,
    /// The overlap that vanishes at the time of the impact.
    pub overlap: Overlap,
    /// Whether they part by the coefficient of restitution; otherwise they come to rest.
    pub parts: bool,
}

/// Changes of the impact itself. For each ball: position, velocity, mass, length; for the contact at its right:
/// distance of the pivots, restitution.
type Changes = Vec<[f64; 6]>;

const OF_BALL: [usize; 2] = [X, V];

impl RigidImpact {
    fn range(&self) -> Range<usize> {
        self.first..self.first + self.balls.len()
    }

    fn none(&self) -> Changes {
        vec![[0.0; 6]; self.balls.len()]
    }

    /// Changes of the velocities (m/s) and of the impulses of the contacts (N.s).
    fn respond(&self, cradle: &Cradle, changes: &Changes) -> (Vec<f64>, Vec<f64>) {
        let balls = self.range();
        let mut along = Cradle {
            balls: cradle.balls[balls.clone()].iter().map(|ball| ball.map(Dual::from)).collect(),
            contacts: cradle.contacts[balls.start..balls.end - 1].iter().map(|law| law.map(Dual::from)).collect(),
            rigid: true,
        };
        let number = Dual::with_tangent;
        for (k, [_, _, mass, length, pivots, restitution]) in changes.iter().enumerate() {
            let ball = &mut along.balls[k];
            (ball.mass, ball.length) = (number(ball.mass.value(), *mass), number(ball.length.value(), *length));
            if let Some(law) = along.contacts.get_mut(k) {
                law.pivots = number(law.pivots.value(), *pivots);
                law.restitution = number(law.restitution.value(), *restitution);
            }
        }
        let of = |k: usize, which: usize, value: f64| number(value, changes[k][which]);
        let (mut v, mut impulses) = (Vec::new(), vec![0.0; self.balls.len() - 1]);
        v.extend(self.balls.iter().enumerate().map(|(k, ball)| of(k, 1, ball.v[0])));
        if let Ok(row) = TouchingRow::new(&along, 0..self.balls.len(), |k| of(k, 0, self.balls[k].x)) {
            let row = if self.parts { row } else { row.without_rebound() };
            for impact in collide_at_once(&row, &mut v).impacts {
                impulses[impact.contact] += impact.impulse.tangent();
            }
        }
        (v.into_iter().map(Dual::tangent).collect(), impulses)
    }

    /// Delay of the impact for a unit of its overlap, s/m.
    fn delay(&self) -> f64 {
        let rate = self.overlap.rate();
        if rate > 0.0 { -1.0 / rate } else { 0.0 }
    }
}

impl Part for RigidImpact {
    fn numbers(&self) -> usize {
        8 * self.balls.len() + 20
    }

    fn forward(&self, cradle: &Cradle, changes: &Coefficients, state: &mut [f64]) {
        let later = self.delay() * self.overlap.change(changes, state);
        let mut impact = self.none();
        for (k, (i, ball)) in self.range().zip(&self.balls).enumerate() {
            let ([x, v], of) = (OF_BALL.map(|number| state[i * STATE + number]), changes.of_ball(i));
            let pivots = changes.of_linkage(i.min(cradle.contacts.len() - 1))[4];
            let place = [x + ball.v[0] * later, v + ball.a[0] * later];
            impact[k] = [place[0], place[1], of[MASS], of[LENGTH], pivots, of[RESTITUTION]];
        }
        let (velocities, impulses) = self.respond(cradle, &impact);
        for (k, (i, ball)) in self.range().zip(&self.balls).enumerate() {
            state[i * STATE + X] += (ball.v[0] - ball.v[1]) * later;
            state[i * STATE + V] = velocities[k] - ball.a[1] * later;
            state[i * STATE + IMPULSE] += impulses.get(k).copied().unwrap_or_default();
        }
    }

    fn backward(&self, cradle: &Cradle, by_changes: &mut Coefficients, by_state: &mut [f64]) {
        // What follows is linear in each of the changes.
        let after = by_state[self.first * STATE..self.range().end * STATE].to_vec();
        let of = |i: usize, number: usize| after[(i - self.first) * STATE + number];
        let sum = |changes: &Changes| {
            let (velocities, impulses) = self.respond(cradle, changes);
            let of_velocities = self.range().zip(&velocities).map(|(i, v)| of(i, V) * v).sum::<f64>();
            of_velocities + self.range().zip(&impulses).map(|(i, impulse)| of(i, IMPULSE) * impulse).sum::<f64>()
        };
        let (mut unit, mut by_later) = (self.none(), 0.0);
        for (k, (i, ball)) in self.range().zip(&self.balls).enumerate() {
            let by: [f64; 6] = std::array::from_fn(|number| {
                unit[k][number] = 1.0;
                let found = sum(&unit);
                unit[k][number] = 0.0;
                found
            });
            let [by_x, by_v, by_mass, by_length, by_pivots, by_restitution] = by;
            (by_state[i * STATE + X], by_state[i * STATE + V]) = (by_x + of(i, X), by_v);
            by_later += by_x * ball.v[0] + of(i, X) * (ball.v[0] - ball.v[1]);
            by_later += by_v * ball.a[0] - of(i, V) * ball.a[1];
            by_changes.of_ball_mut(i)[MASS] += by_mass;
            by_changes.of_ball_mut(i)[LENGTH] += by_length;
            if k + 1 < self.balls.len() {
                by_changes.add_of_linkage(i, &[0.0, 0.0, 0.0, 0.0, by_pivots]);
                by_changes.of_ball_mut(i)[RESTITUTION] += by_restitution;
            }
        }
        self.overlap.back(self.delay() * by_later, by_changes, by_state);
    }
}

impl Recorder {
    /// Records a collision at the time `t` of rigid balls from number `first` on, at these places (m) and with the
    /// velocities `v` (m/s), which are then those afterwards, group by group.
    pub fn collide(
        &mut self,
        (cradle, inputs): (&Cradle, &HeldInputs),
        (first, t): (usize, DoubleDouble),
        (places, v): (&[f64], &mut [f64]),
        groups: &[(Range<usize>, bool)],
    ) {
        for (group, parts) in groups {
            // Balls that come to rest because their restitution is 0 would part with a larger one.
            let contacts = first + group.start..first + group.end - 1;
            let parts = *parts || cradle.contacts[contacts].iter().any(|law| law.restitution == 0.0);
            if parts && group.len() > 2 {
                return self.fail(Unfollowed::JointImpact);
            }
            let balls = first + group.start..first + group.end;
            let Ok(row) = TouchingRow::new(cradle, balls.clone(), |i| places[i - first]) else {
                return self.fail(Unfollowed::JointImpact);
            };
            let row = if parts { row } else { row.without_rebound() };
            let before = v[group.clone()].to_vec();
            collide_at_once(&row, &mut v[group.clone()]);
            let struck = group.clone().map(|k| {
                let velocities = [before[k - group.start], v[k]];
                let a = velocities.map(|v| acceleration((cradle, inputs), first + k, t, (places[k], v)));
                Struck { x: places[k], v: velocities, a }
            });
            let struck: Vec<Struck> = struck.collect();
            let contacts = (balls.start..balls.end - 1).map(|j| {
                let states = [j, j + 1].map(|i| (struck[i - balls.start].x, struck[i - balls.start].v[0]));
                Overlap::new(cradle, j, states)
            });
            if let Some(overlap) = contacts.max_by(|a, b| a.rate().total_cmp(&b.rate())) {
                if overlap.rate() <= 0.0 {
                    return self.fail(Unfollowed::Grazing);
                }
                self.enter(cradle, RigidImpact { first: balls.start, balls: struck, overlap, parts });
            }
        }
    }
}
