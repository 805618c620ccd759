//! Balls on arcs within a step: the directions of paths and contacts, which turn by some 1e-4 in a contact. The
//! acceleration of an overlap is three contact forces times factors, plus that without contact forces: see "Arcs" in
//! docs/theory.md.

use crate::engine::flight::{Flight, forcing_at};
use crate::model::BallModel;
use crate::solver::{NODES, Nodes};

/// A ball at some times: its direction, its rate along the path (m/s), and its acceleration without contacts (m/s2).
#[derive(Clone, Copy, Debug)]
pub(crate) struct BallOnArc<const N: usize> {
    /// Sine and cosine at the start.
    start: (f64, f64),
    /// Their changes since the start, which keep their digits, and their values.
    changes: [[f64; N]; 2],
    sin: [f64; N],
    cos: [f64; N],
    u: [f64; N],
    pub free: [f64; N],
}

impl BallOnArc<1> {
    pub fn at_start((ball, flight): (&BallModel, &Flight)) -> Self {
        let (start, none) = (libm::sincos(flight.x / ball.length), [0.0]);
        let mut at_start = Self { start, changes: [none; 2], sin: none, cos: none, u: none, free: none };
        at_start.follow(ball, flight, &[none, [flight.v]], &none);
        at_start
    }

    /// The state of this ball, repeated for N times.
    pub fn lasting<const N: usize>(&self) -> BallOnArc<N> {
        let all = |[value]: [f64; 1]| [value; N];
        let &Self { start, changes, sin, cos, u, free } = self;
        BallOnArc { start, changes: changes.map(all), sin: all(sin), cos: all(cos), u: all(u), free: all(free) }
    }

    /// Rate of the overlap with the `next` ball, m/s.
    pub fn approach(&self, next: &Self, between: &ContactDirection<1>) -> f64 {
        let [[left], [right]] = between.along;
        self.u[0] * left - next.u[0] * right
    }
}

impl<const N: usize> BallOnArc<N> {
    /// Moves the ball by these displacements (m) from the start, with these rates (m/s), at these times (s).
    pub fn follow(&mut self, ball: &BallModel, flight: &Flight, [way, u]: &[[f64; N]; 2], times: &[f64; N]) {
        let ((sine, cosine), inverse) = (self.start, 1.0 / ball.length);
        (0..N).for_each(|m| {
            // Series for small angles.
            let a = way[m] * inverse;
            let square = a * a;
            let rise = a - a * (square * (1.0 / 6.0)) * (1.0 - square * (1.0 / 20.0));
            let fall = 0.5 * square * (1.0 - square * (1.0 / 12.0));
            self.changes[0][m] = cosine * rise - sine * fall;
            self.changes[1][m] = -(sine * rise + cosine * fall);
            self.sin[m] = sine + self.changes[0][m];
            self.cos[m] = cosine + self.changes[1][m];
        });
        let (gravity, drag) = (ball.gravity, 2.0 * ball.gamma);
        self.u = *u;
        (0..N).for_each(|m| self.free[m] = -gravity * self.sin[m] - drag * u[m]);
        if flight.forcing.iter().any(|f| *f != 0.0) {
            (0..N).for_each(|m| self.free[m] += forcing_at(&flight.forcing, times[m]) * self.cos[m]);
        }
    }
}

/// A contact at some times: components of its direction along its balls' paths and outward, and the acceleration of
/// its overlap without contact forces, m/s2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactDirection<const N: usize> {
    pub along: [[f64; N]; 2],
    pub outward: [[f64; N]; 2],
    pub free: [f64; N],
}

impl ContactDirection<1> {
    /// The state of this contact, repeated for N times.
    pub fn lasting<const N: usize>(&self) -> ContactDirection<N> {
        let [along, outward] = [self.along, self.outward].map(|parts| parts.map(|[value]| [value; N]));
        ContactDirection { along, outward, free: [self.free[0]; N] }
    }
}

impl<const N: usize> ContactDirection<N> {
    /// For balls on pendulums of these `lengths` (m), with these horizontal and vertical distances (m) at the start.
    pub fn new(l: &BallOnArc<N>, r: &BallOnArc<N>, lengths: [f64; 2], start: [f64; 2]) -> Self {
        let (none, [left, right]) = ([0.0; N], lengths);
        let mut direction = Self { along: [none; 2], outward: [none; 2], free: none };
        let (inverse_left, inverse_right) = (1.0 / left, 1.0 / right);
        for m in 0..N {
            let width = start[0] + (right * r.changes[0][m] - left * l.changes[0][m]);
            let height = start[1] - (right * r.changes[1][m] - left * l.changes[1][m]);
            let inverse = 1.0 / (width * width + height * height).sqrt();
            let (x, y) = (width * inverse, height * inverse);
            let along = [x * l.cos[m] + y * l.sin[m], x * r.cos[m] + y * r.sin[m]];
            let outward = [x * l.sin[m] - y * l.cos[m], x * r.sin[m] - y * r.cos[m]];
            let across = r.u[m] * outward[1] - l.u[m] * outward[0];
            let round = r.u[m] * r.u[m] * inverse_right * outward[1] - l.u[m] * l.u[m] * inverse_left * outward[0];
            (direction.along[0][m], direction.along[1][m]) = (along[0], along[1]);
            (direction.outward[0][m], direction.outward[1][m]) = (outward[0], outward[1]);
            direction.free[m] = along[0] * l.free[m] - along[1] * r.free[m] + (round - across * across * inverse);
        }
        direction
    }

    /// Factors (1/kg) in the acceleration of overlap `j`: of the forces of its left neighbour, itself and its right
    /// neighbour.
    pub fn factors(directions: &[Self], j: usize, balls: &[BallModel]) -> [[f64; N]; 3] {
        let mut factors = [[0.0; N]; 3];
        let ([l, r], [a, b]) = (&directions[j].along, [j, j + 1].map(|i| 1.0 / balls[i].mass));
        for m in 0..N {
            factors[1][m] = -(l[m] * l[m] * a + r[m] * r[m] * b);
        }
        if j > 0 {
            let left = &directions[j - 1];
            (0..N).for_each(|m| factors[0][m] = l[m] * left.along[1][m] * a);
        }
        if let Some(right) = directions.get(j + 1) {
            (0..N).for_each(|m| factors[2][m] = r[m] * right.along[0][m] * b);
        }
        factors
    }
}

/// The balls and contacts of a window on arcs, at the nodes.
#[derive(Clone, Debug, Default)]
pub(super) struct ArcNodes {
    /// Empty where balls move on lines.
    pub models: Vec<BallModel>,
    pub balls: Vec<BallOnArc<NODES>>,
    pub directions: Vec<ContactDirection<NODES>>,
    pub factors: Vec<[Nodes; 3]>,
    /// For each contact: the distances of the centres at the start, horizontal and vertical, m.
    pub starts: Vec<[f64; 2]>,
    /// Displacements of the balls at the last node for which the directions were last computed, m.
    pub turned: Vec<f64>,
}

impl ArcNodes {
    /// Sets all nodes to the state at the start of the step.
    pub fn begin(&mut self, balls: &[BallOnArc<1>], directions: &[ContactDirection<1>], factors: &[[f64; 3]]) {
        self.balls.clear();
        self.balls.extend(balls.iter().map(BallOnArc::lasting));
        self.directions.clear();
        self.directions.extend(directions.iter().map(ContactDirection::lasting));
        self.factors.clear();
        self.factors.extend(factors.iter().map(|factors| factors.map(|factor| [factor; NODES])));
        self.turned.clear();
        self.turned.resize(balls.len(), 0.0);
    }

    /// The accelerations of ball `i` along its path under the contact `forces` (N), which have a 0 at either end.
    pub fn accelerations(&self, i: usize, forces: &[Nodes]) -> Nodes {
        let (mut sums, inverse_mass) = (self.balls[i].free, 1.0 / self.models[i].mass);
        if let Some(left) = i.checked_sub(1) {
            let along = &self.directions[left].along[1];
            (0..NODES).for_each(|m| sums[m] += forces[i][m] * along[m] * inverse_mass);
        }
        if let Some(right) = self.directions.get(i) {
            let along = &right.along[0];
            (0..NODES).for_each(|m| sums[m] -= forces[i + 1][m] * along[m] * inverse_mass);
        }
        sums
    }

    /// Computes the directions and factors of the contacts from the motion of their balls.
    pub fn update_directions(&mut self) {
        let contacts = 0..self.models.len() - 1;
        for j in contacts.clone() {
            let lengths = [self.models[j].length, self.models[j + 1].length];
            self.directions[j] = ContactDirection::new(&self.balls[j], &self.balls[j + 1], lengths, self.starts[j]);
        }
        for j in contacts {
            self.factors[j] = ContactDirection::factors(&self.directions, j, &self.models);
        }
    }
}
