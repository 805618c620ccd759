//! The motion of neighbours at nodes in time, linearised: how the accelerations of the balls and the forces of the
//! contacts change with the motion and with the coefficients.

use super::coefficients::{Coefficients, FORCE, GAMMA, GRAVITY, LENGTH, MASS, OF_LAW, law_derivatives};
use crate::model::{BallModel, ContactLaw, Cradle, Linkage};
use crate::solver::weighted;

/// A ball at the nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct BallNodes<const N: usize> {
    /// Position (m) and velocity (m/s) along the path.
    pub x: [f64; N],
    pub v: [f64; N],
    /// Acceleration by contacts and external force, m/s2, and derivative of the acceleration by the position, 1/s2.
    pub pushed: [f64; N],
    pub by_place: [f64; N],
    /// Rate of the acceleration by the inputs, m/s3.
    pub by_time: [f64; N],
}

impl<const N: usize> BallNodes<N> {
    /// A ball at these positions (m) and velocities (m/s), under these contact forces along the path (N). `inputs` are
    /// the external force (N) and the acceleration of the support (m/s2), each with its rate.
    pub fn new(model: &BallModel, [x, v]: [[f64; N]; 2], contacts: &[f64; N], inputs: [[[f64; N]; 2]; 2]) -> Self {
        let [[force, force_rate], [support, support_rate]] = inputs;
        let [mut pushed, mut by_place, mut by_time] = [[0.0; N]; 3];
        for m in 0..N {
            let place = model.place(x[m]);
            let forcing = force[m] / model.mass - support[m];
            pushed[m] = (contacts[m] + force[m] * place.cos) / model.mass;
            by_time[m] = (force_rate[m] / model.mass - support_rate[m]) * place.cos;
            by_place[m] = -(model.gravity * place.cos + forcing * place.sin) / model.length;
        }
        Self { x, v, pushed, by_place, by_time }
    }

    /// The acceleration along the path at a node, m/s2, for this acceleration of the support.
    pub fn acceleration(&self, model: &BallModel, m: usize, support: f64) -> f64 {
        let (restoring, drag) = (model.gravity * model.restoring(self.x[m]), 2.0 * model.gamma * self.v[m]);
        self.pushed[m] - support * model.place(self.x[m]).cos - (restoring + drag)
    }

    /// Changes of the acceleration (m/s2) at the nodes by these `changes` of the coefficients of ball `i`.
    pub fn accelerations(&self, model: &BallModel, i: usize, changes: &Coefficients) -> [f64; N] {
        if changes.leave(i) {
            return [0.0; N];
        }
        let of = changes.of_ball(i);
        let input = of[FORCE] / model.mass - changes.support();
        std::array::from_fn(|m| {
            let x = self.x[m];
            let by_inertia = self.pushed[m] / model.mass * of[MASS] + 2.0 * self.v[m] * of[GAMMA];
            let by_gravity = model.restoring(x) * of[GRAVITY] + self.by_place[m] * x / model.length * of[LENGTH];
            input * model.place(x).cos - by_inertia - by_gravity
        })
    }

    /// Adds the derivatives of a number by the coefficients of ball `i`, from its derivatives `by` the accelerations.
    pub fn add_derivatives(&self, model: &BallModel, i: usize, by: &[f64; N], sums: &mut Coefficients) {
        let [mut inputs, mut by_gravity, mut by_length] = [0.0; 3];
        for ((by, x), by_place) in by.iter().zip(&self.x).zip(&self.by_place) {
            inputs += by * model.place(*x).cos;
            by_gravity -= by * model.restoring(*x);
            by_length -= by * by_place * x;
        }
        *sums.support_mut() -= inputs;
        let of = sums.of_ball_mut(i);
        of[FORCE] += inputs / model.mass;
        of[MASS] -= weighted(by, &self.pushed) / model.mass;
        of[GAMMA] -= 2.0 * weighted(by, &self.v);
        of[GRAVITY] += by_gravity;
        of[LENGTH] += by_length / model.length;
    }
}

/// A pressing contact at the nodes.
#[derive(Clone, Debug)]
pub(super) struct ContactNodes<const N: usize> {
    /// Overlap, m; its rate, m/s; force, N; derivatives of the force by overlap, N/m, and by rate, N.s/m.
    pub overlap: [f64; N],
    pub rate: [f64; N],
    pub force: [f64; N],
    pub by_overlap: [f64; N],
    pub by_rate: [f64; N],
    /// Its linkages to the balls; `None` on lines.
    links: Option<Box<Links<N>>>,
}

/// Linkages and velocities of the balls (m/s) at the nodes, and linkages at the start and at the end.
#[derive(Clone, Debug)]
struct Links<const N: usize> {
    nodes: [(Linkage, [f64; 2]); N],
    ends: [Linkage; 2],
}

/// Two numbers, of the left and of the right ball.
type Both = [f64; 2];

/// Changes at a node: of the overlap (m), of the components of its direction along the paths, of the velocities (m/s),
/// and of the force by its law (N); or derivatives of a number by them.
#[derive(Clone, Copy, Default)]
struct Change {
    overlap: f64,
    along: Both,
    v: Both,
    law: f64,
}

fn dot<const N: usize>(by: &[f64; N], changes: &[f64; N]) -> f64 {
    by.iter().zip(changes).map(|(by, change)| by * change).sum()
}

impl<const N: usize> ContactNodes<N> {
    /// A contact with these overlaps (m) and rates (m/s), between balls with these positions (m) and velocities (m/s).
    /// `ends` are the positions at the start and at the end.
    pub fn new(
        cradle: &Cradle,
        j: usize,
        [overlap, rate]: [[f64; N]; 2],
        balls: [[&[f64; N]; 2]; 2],
        ends: [Both; 2],
    ) -> Self {
        let (pair, law) = (cradle.pair(j), &cradle.contacts[j]);
        let [mut force, mut by_overlap, mut by_rate] = [[0.0; N]; 3];
        for m in 0..N {
            if overlap[m] > 0.0 {
                (force[m], by_overlap[m], by_rate[m]) = law.continued(overlap[m], rate[m]).unwrap_or_default();
            } else {
                // A dashpot acts as soon as the contact has closed; anything else that grows there is rounding.
                force[m] = law.unclipped_force(f64::MIN_POSITIVE, rate[m]);
                by_overlap[m] = law.elastic_continued(f64::MIN_POSITIVE).map_or(0.0, |(_, slope)| slope);
                by_rate[m] = law.unclipped_force(f64::MIN_POSITIVE, 1.0);
            }
        }
        let links = cradle.on_arcs().then(|| {
            let [x, v] = [0, 1].map(|number| balls.map(|ball| ball[number]));
            let node = |m: usize| (pair.linkage(x.map(|x| x[m])), v.map(|v| v[m]));
            Box::new(Links { nodes: std::array::from_fn(node), ends: ends.map(|places| pair.linkage(places)) })
        });
        Self { overlap, rate, force, by_overlap, by_rate, links }
    }

    /// About how many numbers it holds.
    pub fn numbers(&self) -> usize {
        5 * N + self.links.as_ref().map_or(0, |links| size_of_val(&**links) / size_of::<f64>())
    }

    fn link(&self, m: usize) -> (&Linkage, Both) {
        self.links.as_ref().map_or((&Linkage::STRAIGHT, [0.0; 2]), |links| (&links.nodes[m].0, links.nodes[m].1))
    }

    /// Derivatives of the overlap at a node by what its linkage depends on, less these derivatives at the start.
    fn turn(&self, m: usize) -> [f64; 5] {
        let Some(links) = &self.links else { return [0.0; 5] };
        std::array::from_fn(|k| links.nodes[m].0.by[0][k] - links.ends[0].by[0][k])
    }

    /// Derivatives of the overlap at the end: by moves of the balls since the start; and by what its linkage depends
    /// on, less these derivatives at the start.
    pub fn at_end(&self) -> (Both, [f64; 5]) {
        let Some(links) = &self.links else { return ([1.0, -1.0], [0.0; 5]) };
        let [start, end] = links.ends.map(|linkage| linkage.by[0]);
        ([end[0], end[1]], std::array::from_fn(|k| end[k] - start[k]))
    }

    /// The forces on its balls along their paths at a node, N.
    pub fn forces(&self, m: usize) -> Both {
        let [left, right] = self.link(m).0.along;
        [-self.force[m] * left, self.force[m] * right]
    }

    /// Changes of the force and of the forces on the balls, N, by a change at a node.
    fn respond(&self, m: usize, Change { overlap, along, v, law }: Change) -> (f64, Both) {
        let (Linkage { along: [l, r], .. }, velocities) = self.link(m);
        let rate = l * v[0] - r * v[1] + velocities[0] * along[0] - velocities[1] * along[1];
        let force = self.by_overlap[m] * overlap + self.by_rate[m] * rate + law;
        (force, [-(force * l + self.force[m] * along[0]), force * r + self.force[m] * along[1]])
    }

    /// The derivatives of a number by a change at a node, from its derivatives by the force and by the forces on the
    /// balls.
    fn back(&self, m: usize, by_force: f64, by_forces: Both) -> Change {
        let ((Linkage { along: [l, r], .. }, velocities), force) = (self.link(m), self.force[m]);
        let law = by_force - l * by_forces[0] + r * by_forces[1];
        let [overlap, rate] = [self.by_overlap[m] * law, self.by_rate[m] * law];
        let along = [velocities[0] * rate - force * by_forces[0], force * by_forces[1] - velocities[1] * rate];
        Change { overlap, along, v: [l * rate, -r * rate], law }
    }

    /// Changes of the force and of the forces on the balls (N) at a node: by displacements of the balls since the start
    /// (m) and by changes of their velocities (m/s).
    #[inline(always)]
    pub fn by_moves(&self, m: usize, [moved, v]: [Both; 2]) -> (f64, Both) {
        let Some(links) = &self.links else {
            let force = self.by_overlap[m] * (moved[0] - moved[1]) + self.by_rate[m] * (v[0] - v[1]);
            return (force, [-force, force]);
        };
        let [overlap, left, right] = links.nodes[m].0.by.map(|by| by[0] * moved[0] + by[1] * moved[1]);
        self.respond(m, Change { overlap, along: [left, right], v, law: 0.0 })
    }

    /// The derivatives of a number by the changes of [`Self::by_moves`], from those by the force and by the forces on
    /// the balls.
    #[inline(always)]
    pub fn to_moves(&self, m: usize, by_force: f64, by_forces: Both) -> [Both; 2] {
        let Some(links) = &self.links else {
            let by_force = by_force - by_forces[0] + by_forces[1];
            let [x, v] = [self.by_overlap[m] * by_force, self.by_rate[m] * by_force];
            return [[x, -x], [v, -v]];
        };
        let (by, back) = (&links.nodes[m].0.by, self.back(m, by_force, by_forces));
        let place = |k: usize| dot(&[back.overlap, back.along[0], back.along[1]], &[by[0][k], by[1][k], by[2][k]]);
        [[place(0), place(1)], back.v]
    }

    /// Changes of the force and of the forces on the balls (N) at a node, by changes of the overlap and of the places
    /// at the start (m).
    pub fn by_start(&self, m: usize, overlap: f64, places: Both) -> (f64, Both) {
        let (turn, by) = (self.turn(m), &self.link(m).0.by);
        let of = |by: &[f64; 5]| by[0] * places[0] + by[1] * places[1];
        self.respond(m, Change { overlap: overlap + of(&turn), along: [of(&by[1]), of(&by[2])], ..Change::default() })
    }

    /// The derivatives of a number by the changes of [`Self::by_start`], from those by the force and by the forces on
    /// the balls.
    pub fn to_start(&self, m: usize, by_force: f64, by_forces: Both) -> (f64, Both) {
        let (turn, by, back) = (self.turn(m), &self.link(m).0.by, self.back(m, by_force, by_forces));
        let place = |k: usize| dot(&[back.overlap, back.along[0], back.along[1]], &[turn[k], by[1][k], by[2][k]]);
        (back.overlap, [place(0), place(1)])
    }

    /// Changes of the force and of the forces on the balls (N) by `changes` of the coefficients of contact `j`; `None`
    /// if these do not change.
    pub fn by_coefficients(&self, law: &ContactLaw, j: usize, changes: &Coefficients) -> Option<[[f64; N]; 3]> {
        let (of_law, geometry) = (changes.of_law(j), changes.of_linkage(j));
        let unchanged = of_law.iter().chain(&geometry).all(|change| *change == 0.0);
        (!unchanged).then(|| {
            let [mut forces, mut on_left, mut on_right] = [[0.0; N]; 3];
            for m in 0..N {
                let (turn, by) = (self.turn(m), &self.link(m).0.by);
                let derivatives = law_derivatives(law, self.overlap[m], self.rate[m]);
                let change = Change {
                    overlap: dot(&turn, &geometry),
                    along: [dot(&by[1], &geometry), dot(&by[2], &geometry)],
                    law: derivatives.iter().zip(of_law).map(|(by, change)| by * change).sum(),
                    ..Change::default()
                };
                let (force, [left, right]) = self.respond(m, change);
                (forces[m], on_left[m], on_right[m]) = (force, left, right);
            }
            [forces, on_left, on_right]
        })
    }

    /// Adds the derivatives of a number by the coefficients of contact `j`, from its derivatives `by` the force and by
    /// the forces on the balls.
    pub fn add_derivatives(&self, law: &ContactLaw, j: usize, by: [&[f64; N]; 3], sums: &mut Coefficients) {
        let (mut of_law, mut geometry) = ([0.0; OF_LAW], [0.0; 5]);
        for m in 0..N {
            let back = self.back(m, by[0][m], [by[1][m], by[2][m]]);
            let (turn, by) = (self.turn(m), &self.link(m).0.by);
            for (k, sum) in geometry.iter_mut().enumerate() {
                *sum += dot(&[back.overlap, back.along[0], back.along[1]], &[turn[k], by[1][k], by[2][k]]);
            }
            let by = law_derivatives(law, self.overlap[m], self.rate[m]);
            of_law.iter_mut().zip(by).for_each(|(sum, of)| *sum += back.law * of);
        }
        sums.of_law_mut(j).iter_mut().zip(of_law).for_each(|(sum, of)| *sum += of);
        sums.add_of_linkage(j, &geometry);
    }
}
