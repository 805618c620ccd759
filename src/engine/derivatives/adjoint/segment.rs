//! How the motion of neighbours that press on each other changes with its start and with the coefficients.
//!
//! The motion is solved by Gauss collocation (see [`gauss`](crate::solver::gauss)), and its change by the same equations made linear
//! about it: forwards for a direction, or transposed, from the end to the start, for the derivatives of one number by everything. Both
//! are Picard's iteration with the same coefficients, so that they agree to rounding.

use super::coefficients::Coefficients;
use super::pair::law_derivatives;
use super::slots::Slots;
use crate::engine::flight::{Forcing, forcing_at};
use crate::model::{BallModel, ContactLaw, Cradle};
use crate::solver::gauss::{NODES, Nodes, Stretching, Table, combine, weighted};

/// Iterations after which a segment counts as too long.
const MOST: usize = 30;

/// Change of the accelerations over their largest value at which the iteration for the motion is at its end, and that for changes of
/// the motion, where there is no rounding but that of the changes.
const CONVERGED: f64 = 1e-14;
const LINEAR_CONVERGED: f64 = 1e-17;

/// Part of the largest acceleration that may be left in the two highest terms of their interpolation. In the stretched time `c^2` forces
/// are smooth whose exponent is a multiple of 1/2: the error at the end of a segment is far smaller then.
const TAIL: f64 = 1e-11;
const SMOOTH_TAIL: f64 = 1e-7;

/// The motion of one ball, at the nodes.
#[derive(Clone, Debug)]
struct BallNodes {
    /// Position, m, and velocity, m/s.
    x: Nodes,
    v: Nodes,
    /// Force of contacts and inputs, N.
    force: Nodes,
}

/// One contact, at the nodes.
#[derive(Clone, Debug)]
struct ContactNodes {
    overlap: Nodes,
    rate: Nodes,
    /// Force, N, and its derivative by the overlap, N/m.
    force: Nodes,
    slope: Nodes,
}

/// Neighbours that press on each other, all contacts between them closed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group<'a> {
    /// The first ball.
    pub first: usize,
    pub models: &'a [BallModel],
    pub laws: &'a [ContactLaw],
    /// State of the balls and overlaps of the contacts at the start of a segment.
    pub x: &'a [f64],
    pub v: &'a [f64],
    pub overlaps: &'a [f64],
    /// External force on each ball (N) and acceleration of the support (m/s2) from then on.
    pub pushes: &'a [Forcing],
    pub support: &'a Forcing,
}

/// Their motion for some time.
#[derive(Clone, Debug)]
pub(super) struct Segment {
    first: usize,
    pub tuning: usize,
    length: f64,
    stretching: Stretching,
    balls: Vec<BallNodes>,
    contacts: Vec<ContactNodes>,
}

/// What a segment ends with: displacements and changes of the velocity of the balls.
pub(super) type End = Vec<(f64, f64)>;

/// `start + slope t + sum_l columns[l] values[l]` at the nodes.
fn along(columns: &[Nodes; NODES], values: &Nodes, factor: f64, start: f64, slope: f64, times: &Nodes) -> Nodes {
    let sums = combine(columns, values);
    std::array::from_fn(|m| start + slope * times[m] + factor * sums[m])
}

/// `sum_l columns[m][l] values[l]`: the transposed.
fn transposed(columns: &[Nodes; NODES], values: &Nodes) -> Nodes {
    std::array::from_fn(|m| weighted(&columns[m], values))
}

fn largest(nodes: &[Nodes]) -> f64 {
    nodes.iter().flatten().fold(0.0, |most, value| value.abs().max(most))
}

fn distance(a: &[Nodes], b: &[Nodes]) -> f64 {
    a.iter().flatten().zip(b.iter().flatten()).fold(0.0, |most, (a, b)| (a - b).abs().max(most))
}

impl Segment {
    /// The motion of a group over this `length` (s), and its end; nothing if that is too long.
    pub fn new(group: &Group, tuning: usize, length: f64, stretching: Stretching) -> Option<(Self, End)> {
        let (h, table) = (length, stretching.table());
        let times = table.times.map(|part| h * part);
        let count = group.models.len();
        let mut g = vec![[0.0; NODES]; count];
        let mut moved = vec![[0.0; NODES]; count];
        let mut rates = vec![[0.0; NODES]; count];
        let pushes: Vec<Nodes> = group.pushes.iter().map(|push| times.map(|t| forcing_at(push, t))).collect();
        let support = times.map(|t| forcing_at(group.support, t));
        let mut forces = vec![[0.0; NODES]; group.laws.len()];
        let mut converged = false;
        for _ in 0..MOST {
            for i in 0..count {
                moved[i] = along(&table.positions, &g[i], h * h, 0.0, group.v[i], &times);
                if group.models[i].gamma > 0.0 {
                    rates[i] = along(&table.rates, &g[i], h, group.v[i], 0.0, &times);
                }
            }
            for (j, (law, force)) in group.laws.iter().zip(&mut forces).enumerate() {
                *force =
                    std::array::from_fn(|m| law.elastic_force(group.overlaps[j] + (moved[j][m] - moved[j + 1][m])));
            }
            let before = g.clone();
            for (i, g) in g.iter_mut().enumerate() {
                let model = &group.models[i];
                for m in 0..NODES {
                    let force = net(&forces, i, m) + pushes[i][m];
                    g[m] = model.acceleration(group.x[i] + moved[i][m], rates[i][m], force, -support[m]);
                }
            }
            let scale = largest(&g);
            if !scale.is_finite() {
                return None;
            }
            if distance(&g, &before) <= CONVERGED * scale {
                converged = true;
                break;
            }
        }
        let scale = largest(&g);
        let tail = table.tail.iter().flat_map(|tail| g.iter().map(|g| weighted(tail, g).abs())).fold(0.0, f64::max);
        let smooth = group.laws.iter().all(|law| (2.0 * law.exponent).fract() == 0.0);
        if !converged || tail > if smooth { SMOOTH_TAIL } else { TAIL } * scale {
            return None;
        }
        for (i, rates) in rates.iter_mut().enumerate() {
            *rates = along(&table.rates, &g[i], h, group.v[i], 0.0, &times);
        }
        let end = g
            .iter()
            .zip(group.v)
            .map(|(g, v)| (h * v + h * h * weighted(&table.of_position, g), h * weighted(&table.of_rate, g)));
        let end = end.collect();
        let contact = |(j, law): (usize, &ContactLaw)| {
            let overlap: Nodes = std::array::from_fn(|m| group.overlaps[j] + (moved[j][m] - moved[j + 1][m]));
            let rate: Nodes = std::array::from_fn(|m| rates[j][m] - rates[j + 1][m]);
            let slope = std::array::from_fn(|m| law.force_slopes(overlap[m], rate[m]).0);
            ContactNodes { overlap, rate, force: forces[j], slope }
        };
        let ball = |i: usize| BallNodes {
            x: moved[i].map(|moved| group.x[i] + moved),
            v: rates[i],
            force: std::array::from_fn(|m| net(&forces, i, m) + pushes[i][m]),
        };
        let contacts = group.laws.iter().enumerate().map(contact).collect();
        let balls = (0..count).map(ball).collect();
        Some((Self { first: group.first, tuning, length, stretching, balls, contacts }, end))
    }

    /// Numbers that it holds.
    pub fn numbers(&self) -> usize {
        (3 * self.balls.len() + 4 * self.contacts.len()) * NODES
    }

    fn table(&self) -> &'static Table {
        self.stretching.table()
    }

    /// Changes of the state at the end from those at the start.
    pub fn forward(&self, cradle: &Cradle, change: &Coefficients, slots: &mut Slots) {
        let (h, table) = (self.length, self.table());
        let times = table.times.map(|part| h * part);
        let count = self.balls.len();
        let models = &cradle.balls[self.first..];
        let forces: Vec<Nodes> = (0..count - 1).map(|j| self.force_change(cradle, change, j)).collect();
        let sources: Vec<Nodes> = (0..count)
            .map(|i| {
                let (ball, by, mass) = (&self.balls[i], &change.balls[self.first + i], models[i].mass);
                std::array::from_fn(|m| {
                    by.force / mass
                        - ball.force[m] * by.mass / (mass * mass)
                        - change.support
                        - by.omega2 * ball.x[m]
                        - 2.0 * by.gamma * ball.v[m]
                })
            })
            .collect();
        let (first, last) = (self.first, self.first + count);
        let (x, v) = (slots.x[first..last].to_vec(), slots.v[first..last].to_vec());
        let overlap = |j: usize| (x[j] - x[j + 1]) - change.contacts[first + j].clearance;
        let overlaps: Vec<f64> = (0..count - 1).map(overlap).collect();
        let mut g = vec![[0.0; NODES]; count];
        let mut changed = forces.clone();
        for _ in 0..2 * MOST {
            let at_nodes = |i: usize| along(&table.positions, &g[i], h * h, 0.0, v[i], &times);
            let moved: Vec<Nodes> = (0..count).map(at_nodes).collect();
            let rate = |i: usize| match models[i].gamma > 0.0 {
                true => along(&table.rates, &g[i], h, v[i], 0.0, &times),
                false => [0.0; NODES],
            };
            let rates: Vec<Nodes> = (0..count).map(rate).collect();
            for (j, changed) in changed.iter_mut().enumerate() {
                let slope = &self.contacts[j].slope;
                *changed =
                    std::array::from_fn(|m| forces[j][m] + slope[m] * (overlaps[j] + (moved[j][m] - moved[j + 1][m])));
            }
            let before = g.clone();
            for (i, g) in g.iter_mut().enumerate() {
                *g = std::array::from_fn(|m| {
                    models[i].acceleration(x[i] + moved[i][m], rates[i][m], net(&changed, i, m), sources[i][m])
                });
            }
            if distance(&g, &before) <= LINEAR_CONVERGED * largest(&g) {
                break;
            }
        }
        for i in 0..count {
            slots.x[first + i] += h * v[i] + h * h * weighted(&table.of_position, &g[i]);
            slots.v[first + i] += h * weighted(&table.of_rate, &g[i]);
        }
        for (j, changed) in changed.iter().enumerate() {
            slots.impulse[first + j] += h * weighted(&table.of_rate, changed);
        }
    }

    /// The derivatives by the state at the start, and by the coefficients, from those by the state at the end.
    pub fn backward(&self, cradle: &Cradle, gradient: &mut Coefficients, slots: &mut Slots) {
        let (h, table) = (self.length, self.table());
        let count = self.balls.len();
        let (first, last) = (self.first, self.first + count);
        let models = &cradle.balls[first..last];
        let (x, v) = (slots.x[first..last].to_vec(), slots.v[first..last].to_vec());
        // Derivatives by the accelerations at the nodes, and from these by the forces, positions and velocities there.
        let of_end = |i: usize| -> Nodes {
            std::array::from_fn(|m| h * (table.of_rate[m] * v[i] + h * table.of_position[m] * x[i]))
        };
        let of_end: Vec<Nodes> = (0..count).map(of_end).collect();
        let of_impulse = |j: usize| table.of_rate.map(|weight| h * weight * slots.impulse[first + j]);
        let of_impulse: Vec<Nodes> = (0..count - 1).map(of_impulse).collect();
        let by_force = |by_g: &[Nodes], j: usize| -> Nodes {
            let (left, right) = (models[j].mass, models[j + 1].mass);
            std::array::from_fn(|m| of_impulse[j][m] + by_g[j + 1][m] / right - by_g[j][m] / left)
        };
        let by_x = |by_g: &[Nodes], by_forces: &[Nodes], i: usize| -> Nodes {
            let slope = |j: usize, m: usize| self.contacts[j].slope[m] * by_forces[j][m];
            std::array::from_fn(|m| {
                let own = if i < count - 1 { slope(i, m) } else { 0.0 };
                let other = if i > 0 { slope(i - 1, m) } else { 0.0 };
                own - other - models[i].omega2 * by_g[i][m]
            })
        };
        let mut by_g = of_end.clone();
        let mut by_forces = vec![[0.0; NODES]; count - 1];
        let mut by_places = vec![[0.0; NODES]; count];
        for _ in 0..2 * MOST {
            (0..count - 1).for_each(|j| by_forces[j] = by_force(&by_g, j));
            (0..count).for_each(|i| by_places[i] = by_x(&by_g, &by_forces, i));
            let before = by_g.clone();
            for (i, by_g) in by_g.iter_mut().enumerate() {
                let of_places = transposed(&table.positions, &by_places[i]);
                let damping = -2.0 * models[i].gamma;
                let of_rates = if damping == 0.0 { [0.0; NODES] } else { transposed(&table.rates, by_g) };
                *by_g = std::array::from_fn(|l| of_end[i][l] + h * (h * of_places[l] + damping * of_rates[l]));
            }
            if distance(&by_g, &before) <= LINEAR_CONVERGED * largest(&by_g) {
                break;
            }
        }
        for i in 0..count {
            let damping = -2.0 * models[i].gamma;
            slots.x[first + i] += by_places[i].iter().sum::<f64>();
            let slope: f64 = (0..NODES).map(|m| h * table.times[m] * by_places[i][m] + damping * by_g[i][m]).sum();
            slots.v[first + i] += h * x[i] + slope;
            let (ball, by, mass) = (&self.balls[i], &mut gradient.balls[first + i], models[i].mass);
            let total: f64 = by_g[i].iter().sum();
            by.force += total / mass;
            gradient.support -= total;
            by.mass -= weighted(&ball.force, &by_g[i]) / (mass * mass);
            by.omega2 -= weighted(&ball.x, &by_g[i]);
            by.gamma -= 2.0 * weighted(&ball.v, &by_g[i]);
        }
        for (j, by_force) in by_forces.iter().enumerate() {
            let mut sums = [0.0; 7];
            for (m, weight) in by_force.iter().enumerate() {
                let of = self.contacts[j].derivatives(&cradle.contacts[first + j], m);
                sums.iter_mut().zip(of).for_each(|(sum, of)| *sum += weight * of);
            }
            gradient.contacts[first + j].add_array(&sums);
            gradient.contacts[first + j].clearance -= weighted(&self.contacts[j].slope, by_force);
        }
    }

    /// Changes of the force of contact `j` by the coefficients alone.
    fn force_change(&self, cradle: &Cradle, change: &Coefficients, j: usize) -> Nodes {
        let (law, by) = (&cradle.contacts[self.first + j], change.contacts[self.first + j].array());
        std::array::from_fn(|m| {
            let of = self.contacts[j].derivatives(law, m);
            of.iter().zip(by).map(|(of, by)| of * by).sum()
        })
    }
}

/// Force of the contacts on ball `i` of a group at node `m`.
fn net(forces: &[Nodes], i: usize, m: usize) -> f64 {
    let from_left = if i > 0 { forces[i - 1][m] } else { 0.0 };
    let from_right = forces.get(i).map_or(0.0, |force| force[m]);
    from_left - from_right
}

impl ContactNodes {
    /// Derivatives of the force at node `m` by the coefficients.
    fn derivatives(&self, law: &ContactLaw, m: usize) -> [f64; 7] {
        law_derivatives(law, self.overlap[m], self.rate[m], self.force[m], self.slope[m])
    }
}
