//! The motion of neighbours that press on each other, by Gauss collocation (see [`gauss`](crate::solver::gauss)), and
//! its derivatives by their start and by the coefficients, from the variational equations.
//!
//! With positions `y = x + v t + h^2 Q2 g` at the nodes, the changes of the accelerations there are
//!
//! ```text
//! g_i = (f_(i-1) - f_i) / m_i - omega_i^2 y_i - 2 gamma_i (v + h Q1 g_i) + what the coefficients do,
//! f_j = slope_j (y_j - y_(j+1)) + what the coefficients do,
//! ```
//!
//! linear equations, `A g = known`, with a block for each ball and its neighbours. The derivatives of a number at the
//! end, `c g`, by everything known follow from one solution of `A^T z = c^T`.

use super::map::{
    CLEARANCE, COEFFICIENTS, IMPULSE, Map, OF_BALL, OF_CONTACT, STATE, V, X, law_derivatives, numbers_of_state,
};
use crate::engine::flight::{Forcing, forcing_at};
use crate::model::{BallModel, ContactLaw};
use crate::solver::{NODES, Nodes, Table, combine, weighted};

/// Iterations after which a segment counts as too long.
const MOST: usize = 30;

/// Change of the accelerations over their size, both summed over balls and nodes, at which the iteration ends.
const CONVERGED: f64 = 1e-14;

/// Allowed size of the two highest terms of the interpolation over the largest acceleration; also for exponents that
/// are multiples of 1/2, whose forces are smooth in the stretched time `c^2`: the error at the end is then far smaller.
const TAIL: f64 = 1e-11;
const SMOOTH_TAIL: f64 = 1e-7;

/// Neighbours that press on each other, all contacts between them closed, at the start of a segment.
#[derive(Clone, Copy, Debug)]
pub(super) struct PressedBalls<'a> {
    pub first: usize,
    pub tuning: usize,
    pub models: &'a [BallModel],
    pub laws: &'a [ContactLaw],
    pub x: &'a [f64],
    pub v: &'a [f64],
    pub overlaps: &'a [f64],
    /// External force on each ball (N) and acceleration of the support (m/s2) from then on.
    pub pushes: &'a [Forcing],
    pub support: &'a Forcing,
    /// Length of the segment, s, and the coefficients for the stretching of its time.
    pub length: f64,
    pub table: &'a Table,
}

#[derive(Clone, Copy, Debug, Default)]
struct BallNodes {
    /// Displacement, m, and velocity, m/s.
    moved: Nodes,
    v: Nodes,
    /// Acceleration, m/s2, and the force of contacts and inputs, N.
    g: Nodes,
    force: Nodes,
}

/// Derivatives of the force of one contact at the nodes, by the overlap and by the coefficients.
struct ContactNodes {
    slope: Nodes,
    by_coefficients: [Nodes; OF_CONTACT],
}

/// `start + slope t + sum_l columns[l] values[l]` at the nodes.
fn along(columns: &[Nodes; NODES], values: &Nodes, factor: f64, start: f64, slope: f64, times: &Nodes) -> Nodes {
    let sums = combine(columns, values);
    std::array::from_fn(|m| start + slope * times[m] + factor * sums[m])
}

/// Unknowns in the equations for the forces of a contact: its own, and those of its neighbours before and behind them.
const BAND: usize = 3 * NODES;

impl PressedBalls<'_> {
    /// Numbers needed to linearise the motion of this many balls: the map, and the equations for the forces.
    pub fn numbers_of(balls: usize) -> usize {
        let contacts = balls - 1;
        Map::numbers_of(balls) + contacts * NODES * (BAND + numbers_of_state(balls))
    }

    /// The linearised motion on the segment, and the balls' displacements and velocities; `None` if it is too long.
    pub fn press(&self) -> Option<(Map, Vec<(f64, f64)>)> {
        let (length, table) = (self.length, self.table);
        let balls = self.follow()?;
        let end = |(ball, v): (&BallNodes, &f64)| {
            let (moved, faster) = (weighted(&table.of_position, &ball.g), weighted(&table.of_rate, &ball.g));
            (length * v + length * length * moved, v + length * faster)
        };
        Some((self.linearise(&balls), balls.iter().zip(self.v).map(end).collect()))
    }

    /// The motion at the nodes, if the iteration converges and they are close enough.
    fn follow(&self) -> Option<Vec<BallNodes>> {
        let (h, table) = (self.length, self.table);
        let times = table.times.map(|part| h * part);
        let pushes: Vec<Nodes> = self.pushes.iter().map(|push| times.map(|t| forcing_at(push, t))).collect();
        let support = times.map(|t| forcing_at(self.support, t));
        let mut balls = vec![BallNodes::default(); self.models.len()];
        let (mut converged, mut before) = (false, 0.0);
        for _ in 0..MOST {
            for (i, ball) in balls.iter_mut().enumerate() {
                ball.moved = along(&table.positions, &ball.g, h * h, 0.0, self.v[i], &times);
                if self.models[i].gamma > 0.0 {
                    ball.v = along(&table.rates, &ball.g, h, self.v[i], 0.0, &times);
                }
                ball.force = pushes[i];
            }
            for (j, law) in self.laws.iter().enumerate() {
                for m in 0..NODES {
                    let force = law.elastic_force(self.overlaps[j] + (balls[j].moved[m] - balls[j + 1].moved[m]));
                    balls[j].force[m] -= force;
                    balls[j + 1].force[m] += force;
                }
            }
            // At the nodes, summed over the balls: finite only if all values are.
            let (mut size, mut change) = ([0.0; NODES], [0.0; NODES]);
            for (i, BallNodes { moved, v, g, force }) in balls.iter_mut().enumerate() {
                let (model, x) = (&self.models[i], self.x[i]);
                for m in 0..NODES {
                    let new = model.acceleration(x + moved[m], v[m], force[m], -support[m]);
                    size[m] += new.abs();
                    change[m] += (new - g[m]).abs();
                    g[m] = new;
                }
            }
            let [size, change] = [size, change].map(|parts| parts.iter().sum::<f64>());
            // Convergence accelerates: the next change is far below this.
            let next = 100.0 * change * (change / before);
            before = change;
            converged = size.is_finite() && change.min(next) <= CONVERGED * size;
            if converged {
                break;
            }
        }
        let scale = balls.iter().flat_map(|ball| ball.g).fold(0.0, |most: f64, g| most.max(g.abs()));
        let tails = table.tail.iter().flat_map(|tail| balls.iter().map(|ball| weighted(tail, &ball.g).abs()));
        let tail = tails.fold(0.0, f64::max);
        let smooth = self.laws.iter().all(|law| (2.0 * law.exponent).fract() == 0.0);
        let allowed = if smooth { SMOOTH_TAIL } else { TAIL } * scale;
        for (ball, v) in balls.iter_mut().zip(self.v) {
            ball.v = along(&table.rates, &ball.g, h, *v, 0.0, &times);
        }
        (converged && tail <= allowed).then_some(balls)
    }

    fn contact(&self, j: usize, left: &BallNodes, right: &BallNodes) -> ContactNodes {
        let (law, mut by_coefficients) = (&self.laws[j], [[0.0; NODES]; OF_CONTACT]);
        let slope = std::array::from_fn(|m| {
            let (overlap, rate) = (self.overlaps[j] + (left.moved[m] - right.moved[m]), left.v[m] - right.v[m]);
            let (force, slope) = law.elastic_continued(overlap).filter(|_| overlap > 0.0).unwrap_or_default();
            let at_node = law_derivatives(law, overlap, rate, force, slope);
            by_coefficients.iter_mut().zip(at_node).for_each(|(by, at_node)| by[m] = at_node);
            slope
        });
        by_coefficients[CLEARANCE] = slope.map(|slope| -slope);
        ContactNodes { slope, by_coefficients }
    }

    /// The map from the state at the start and the coefficients to the state at the end.
    fn linearise(&self, balls: &[BallNodes]) -> Map {
        let contact = |(j, pair): (usize, &[BallNodes])| self.contact(j, &pair[0], &pair[1]);
        let contacts: Vec<ContactNodes> = balls.windows(2).enumerate().map(contact).collect();
        let mut responses: Vec<Response> = Vec::new();
        for (i, model) in self.models.iter().enumerate() {
            let alike = i > 0 && [model.omega2, model.gamma] == [self.models[i - 1].omega2, self.models[i - 1].gamma];
            responses.push(if alike {
                responses[i - 1].clone()
            } else {
                Response::new(model, self.length, self.table)
            });
        }
        let numbers = numbers_of_state(balls.len());
        let by_forces = self.by_forces(&contacts, &responses, numbers);
        let mut map = Map::zero(self.first, balls.len(), self.tuning);
        for number in 0..numbers {
            let by_force = |j: usize| std::array::from_fn(|m| by_forces[j * NODES + m][number]);
            let by_forces: Vec<Nodes> = (0..contacts.len()).map(by_force).collect();
            let [state, coefficients] = map.row(number);
            if number % STATE == X {
                state[number + V] += self.length;
            }
            let by_places = self.by_places(&contacts, &by_forces);
            for (i, (ball, by_place)) in balls.iter().zip(&by_places).enumerate() {
                let mut z = combine(&responses[i].to_force, by_place);
                if number / STATE == i && number % STATE != IMPULSE {
                    let direct = &responses[i].at_end[number % STATE];
                    z.iter_mut().zip(direct).for_each(|(z, direct)| *z += direct);
                }
                self.enter([&mut *state, &mut *coefficients], i, ball, by_place, &z);
            }
            for (j, by_force) in by_forces.iter().enumerate() {
                let sums = coefficients[COEFFICIENTS * j + OF_BALL..].iter_mut();
                sums.zip(&contacts[j].by_coefficients).for_each(|(sum, by)| *sum = weighted(by, by_force));
            }
        }
        map
    }

    /// The derivatives of a number at the end by the displacements of the balls at the nodes, through the forces of the
    /// contacts, from those by these forces.
    fn by_places(&self, contacts: &[ContactNodes], by_forces: &[Nodes]) -> Vec<Nodes> {
        let mut places = vec![[0.0; NODES]; self.models.len()];
        for (j, (contact, by_force)) in contacts.iter().zip(by_forces).enumerate() {
            for m in 0..NODES {
                places[j][m] += contact.slope[m] * by_force[m];
                places[j + 1][m] -= contact.slope[m] * by_force[m];
            }
        }
        places
    }

    /// Enters the derivatives of a number at the end by state and coefficients of ball `i`, from its derivatives by the
    /// displacements through the contact forces, and `z` by the accelerations at the nodes.
    fn enter(&self, [state, coefficients]: [&mut [f64]; 2], i: usize, ball: &BallNodes, by_place: &Nodes, z: &Nodes) {
        let BallModel { mass, omega2, gamma, .. } = self.models[i];
        let by_place: Nodes = std::array::from_fn(|m| by_place[m] - omega2 * z[m]);
        let total = z.iter().sum::<f64>();
        state[STATE * i + X] += by_place.iter().sum::<f64>();
        state[STATE * i + V] += self.length * weighted(&self.table.times, &by_place) - 2.0 * gamma * total;
        let by_omega2 = self.x[i] * total + weighted(&ball.moved, z);
        let by_mass = -weighted(&ball.force, z) / (mass * mass);
        let by_ball = [by_mass, -by_omega2, -2.0 * weighted(&ball.v, z), total / mass];
        coefficients[COEFFICIENTS * i..][..OF_BALL].copy_from_slice(&by_ball);
        coefficients[coefficients.len() - 1] -= total;
    }

    /// The derivatives of all `numbers` of the state at the end by the forces of the contacts at the nodes: of each
    /// contact a row for each node, the solution of
    ///
    /// `w_j = direct_j + z_(j+1) / m_(j+1) - z_j / m_j`,
    /// `z_i = direct_i + to_force_i (slope_i w_i - slope_(i-1) w_(i-1))`.
    fn by_forces(&self, contacts: &[ContactNodes], responses: &[Response], numbers: usize) -> Vec<Vec<f64>> {
        let mut rows = vec![vec![0.0; BAND + numbers]; contacts.len() * NODES];
        for (k, row) in rows.iter_mut().enumerate() {
            let (j, l) = (k / NODES, k % NODES);
            row[NODES + l] = 1.0;
            row[BAND + STATE * j + IMPULSE] = self.length * self.table.of_rate[l];
            for (i, sign) in [(j, 1.0), (j + 1, -1.0)] {
                let (response, lightness) = (&responses[i], sign / self.models[i].mass);
                for number in [X, V] {
                    row[BAND + STATE * i + number] = -lightness * response.at_end[number][l];
                }
                // The contacts at the left and at the right of this ball, if there are any.
                for (other, sign) in [(i.wrapping_sub(1), -1.0), (i, 1.0)] {
                    let Some(contact) = contacts.get(other) else { continue };
                    let block = row[(1 + other - j) * NODES..].iter_mut();
                    for ((to, to_force), slope) in block.zip(&response.to_force).zip(contact.slope) {
                        *to += sign * lightness * to_force[l] * slope;
                    }
                }
            }
        }
        eliminate(&mut rows);
        rows.iter_mut().for_each(|row| _ = row.drain(..BAND));
        rows
    }
}

/// The transposed response of a pendulum on a segment.
#[derive(Clone)]
struct Response {
    /// By the accelerations at the nodes: of the position and of the velocity at the end, `E^-T c` with
    /// `E = 1 + omega^2 h^2 Q2 + 2 gamma h Q1`.
    at_end: [Nodes; 2],
    /// Those from derivatives by the displacements, `E^-T h^2 Q2^T`, column by column.
    to_force: [Nodes; NODES],
}

impl Response {
    fn new(model: &BallModel, h: f64, table: &Table) -> Self {
        let transposed = |columns: &[Nodes; NODES], factor: f64| -> [Nodes; NODES] {
            std::array::from_fn(|m| std::array::from_fn(|l| factor * columns[l][m]))
        };
        let at_end = [table.of_position.map(|of| h * h * of), table.of_rate.map(|of| h * of)];
        let to_force = transposed(&table.positions, h * h);
        let mut pull = transposed(&table.rates, 2.0 * model.gamma * h);
        for (pull, places) in pull.as_flattened_mut().iter_mut().zip(to_force.as_flattened()) {
            *pull += model.omega2 * places;
        }
        // `E^-T` as a series in powers of the pull, which is small.
        let (mut response, mut size) = (Self { at_end, to_force }, 1.0);
        let largest = pull.as_flattened().iter().fold(0.0, |most: f64, pull| most.max(pull.abs())) * NODES as f64;
        for _ in 0..MOST {
            size *= largest;
            if size <= f64::EPSILON {
                break;
            }
            let less = |start: &Nodes, of: &Nodes| -> Nodes {
                let pulled = combine(&pull, of);
                std::array::from_fn(|l| start[l] - pulled[l])
            };
            response = Self {
                at_end: std::array::from_fn(|k| less(&at_end[k], &response.at_end[k])),
                to_force: std::array::from_fn(|m| less(&to_force[m], &response.to_force[m])),
            };
        }
        response
    }
}

/// Solves linear equations by Gaussian elimination. Each row has a band of the matrix, of the diagonal block and those
/// beside it, and then the right-hand sides, which become the solutions. No pivoting is needed: where the motion has
/// converged, the matrix is near the identity.
fn eliminate(rows: &mut [Vec<f64>]) {
    let count = rows.len();
    for k in 0..count {
        // Column `k` in its own row; in a row of the next contact it is one block before that.
        let (at, next) = (NODES + k % NODES, (k / NODES + 1) * NODES);
        let end = if next < count { BAND } else { BAND - NODES };
        let (done, later) = rows.split_at_mut(k + 1);
        let pivot = &mut done[k];
        let inverse = 1.0 / pivot[at];
        pivot[at + 1..].iter_mut().for_each(|number| *number *= inverse);
        for (i, row) in (k + 1..next + NODES).zip(later) {
            let before = if i < next { 0 } else { NODES };
            let factor = row[at - before];
            let subtract = |(to, from): (&mut f64, &f64)| *to -= factor * from;
            row[at + 1 - before..end - before].iter_mut().zip(&pivot[at + 1..end]).for_each(subtract);
            row[BAND..].iter_mut().zip(&pivot[BAND..]).for_each(subtract);
        }
    }
    for k in (1..count).rev() {
        let (before, solved) = rows.split_at_mut(k);
        let first = (k / NODES).saturating_sub(1) * NODES;
        for (i, row) in (first..).zip(&mut before[first..]) {
            let factor = row[NODES + k - i / NODES * NODES];
            row[BAND..].iter_mut().zip(&solved[0][BAND..]).for_each(|(to, from)| *to -= factor * from);
        }
    }
}
