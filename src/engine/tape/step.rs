//! A part of the motion of neighbours, linearised by collocation at its nodes.
//!
//! Without a change of anything else, accelerations `g` at the nodes move a ball by `h^2 Q2 g` and change its velocity
//! by `h Q1 g` (see [`gauss`](crate::solver::gauss)). With what these do to forces, `T g`, the changes of the
//! accelerations solve `g = known + T g`. An explicit step is short enough for the Neumann series, `g = known + T known
//! + T T known + ...`; the derivatives of a number by what is known follow likewise from those by the accelerations,
//! with the transposed `T`. Stiff equations are solved at once, on the nodes of an implicit step.

use std::sync::LazyLock;

use super::coefficients::{Coefficients, IMPULSE, OVERLAP, STATE, TIME, V, X};
use super::nodes::{BallNodes, ContactNodes};
use super::part::Part;
use crate::model::Cradle;
use crate::solver::radau::{Matrix, RADAU, Row, STAGES, Stages, solve};
use crate::solver::{NODES, Nodes, Table, combine, weighted};

/// Terms of the series at most.
const TERMS: usize = 60;

/// A part of the motion of neighbours between which all contacts press.
#[derive(Debug)]
pub(super) struct Step {
    /// The first of its balls.
    pub first: usize,
    /// In s.
    pub length: f64,
    pub rule: Rule,
    pub balls: Vec<BallNodes>,
    pub contacts: Vec<ContactNodes>,
}

/// The nodes of a step.
#[derive(Clone, Copy, Debug)]
pub(super) enum Rule {
    Explicit(&'static Table),
    Implicit,
}

/// The coefficients of implicit collocation, with nodes without weight after its own.
struct Implicit {
    times: Nodes,
    rates: [Nodes; NODES],
    positions: [Nodes; NODES],
    of_rate: Nodes,
    of_position: Nodes,
}

static IMPLICIT: LazyLock<Implicit> = LazyLock::new(|| {
    let twice = RADAU.integral * RADAU.integral;
    let entry = |matrix: &Matrix, m: usize, l: usize| {
        if m < STAGES && l < STAGES { matrix[(m, l)] } else { 0.0 }
    };
    let columns = |matrix| std::array::from_fn(|l| std::array::from_fn(|m| entry(matrix, m, l)));
    let last = |matrix| std::array::from_fn(|l| entry(matrix, STAGES - 1, l));
    Implicit {
        times: std::array::from_fn(|m| if m < STAGES { RADAU.nodes[m] } else { 1.0 }),
        rates: columns(&RADAU.integral),
        positions: columns(&twice),
        of_rate: last(&RADAU.integral),
        of_position: last(&twice),
    }
});

impl Rule {
    /// The times of the nodes, over the length of the step.
    pub fn times(self) -> &'static Nodes {
        match self {
            Self::Explicit(table) => &table.times,
            Self::Implicit => &IMPLICIT.times,
        }
    }

    /// Weights of the rate and of the position at the end.
    fn at_end(self) -> [&'static Nodes; 2] {
        match self {
            Self::Explicit(table) => [&table.of_rate, &table.of_position],
            Self::Implicit => [&IMPLICIT.of_rate, &IMPLICIT.of_position],
        }
    }
}

/// Positions and velocities of a ball, or derivatives by them, at the nodes.
type Motion = [Nodes; 2];

impl Step {
    /// The accelerations by changes of the motion (m, m/s).
    fn accelerations(&self, cradle: &Cradle, motion: &[Motion]) -> Vec<Nodes> {
        let of_ball = |(i, (ball, [x, v])): (usize, (&BallNodes, &Motion))| {
            let gamma = cradle.balls[self.first + i].gamma;
            std::array::from_fn(|m| ball.by_place[m] * x[m] - 2.0 * gamma * v[m])
        };
        let mut found: Vec<Nodes> = self.balls.iter().zip(motion).enumerate().map(of_ball).collect();
        for (j, contact) in self.contacts.iter().enumerate() {
            let lightness = [j, j + 1].map(|i| 1.0 / cradle.balls[self.first + i].mass);
            let (before, after) = found.split_at_mut(j + 1);
            for (m, (on_left, on_right)) in before[j].iter_mut().zip(&mut after[0]).enumerate() {
                let (_, [left, right]) = contact.by_moves(m, moves(motion, j, m));
                *on_left += lightness[0] * left;
                *on_right += lightness[1] * right;
            }
        }
        found
    }

    /// The transposed: derivatives of a number by the motion, from those by the accelerations and by the forces of the
    /// contacts.
    fn back(&self, cradle: &Cradle, accelerations: &[Nodes], forces: &[Nodes]) -> Vec<Motion> {
        let of_ball = |(i, (ball, by)): (usize, (&BallNodes, &Nodes))| {
            let gamma = cradle.balls[self.first + i].gamma;
            [std::array::from_fn(|m| ball.by_place[m] * by[m]), std::array::from_fn(|m| -2.0 * gamma * by[m])]
        };
        let mut found: Vec<Motion> = self.balls.iter().zip(accelerations).enumerate().map(of_ball).collect();
        for (j, (contact, by_force)) in self.contacts.iter().zip(forces).enumerate() {
            let lightness = [j, j + 1].map(|i| 1.0 / cradle.balls[self.first + i].mass);
            for (m, by_force) in by_force.iter().enumerate() {
                let on_balls = [0, 1].map(|k| lightness[k] * accelerations[j + k][m]);
                let moves = contact.to_moves(m, *by_force, on_balls);
                for (number, [left, right]) in moves.into_iter().enumerate() {
                    found[j][number][m] += left;
                    found[j + 1][number][m] += right;
                }
            }
        }
        found
    }

    /// The motion by accelerations, and the transposed.
    fn integrate(&self, accelerations: &[Nodes]) -> Vec<Motion> {
        let h = self.length;
        let of_ball = |g: &Nodes| {
            let [once, twice] = match self.rule {
                Rule::Explicit(table) => table.integrate_both(g),
                Rule::Implicit => [combine(&IMPLICIT.rates, g), combine(&IMPLICIT.positions, g)],
            };
            [twice.map(|x| h * h * x), once.map(|v| h * v)]
        };
        accelerations.iter().map(of_ball).collect()
    }

    fn integrate_back(&self, motion: &[Motion]) -> Vec<Nodes> {
        let h = self.length;
        let of_ball = |[x, v]: &Motion| -> Nodes {
            match self.rule {
                Rule::Explicit(table) => {
                    let of_x = table.integrate_back(x);
                    table.integrate_back(&std::array::from_fn(|m| h * (h * of_x[m] + v[m])))
                }
                Rule::Implicit => {
                    let mut found = [0.0; NODES];
                    for (l, found) in found[..STAGES].iter_mut().enumerate() {
                        let sum =
                            |by: &Nodes, of: &Nodes| by[..STAGES].iter().zip(of).map(|(by, of)| by * of).sum::<f64>();
                        *found = h * (h * sum(&IMPLICIT.positions[l], x) + sum(&IMPLICIT.rates[l], v));
                    }
                    found
                }
            }
        };
        motion.iter().map(of_ball).collect()
    }

    /// Solves `g = known + T g` for the map `T` of accelerations, or of derivatives by them.
    fn solve(&self, known: Vec<Nodes>, map: impl Fn(&[Nodes]) -> Vec<Nodes>) -> Vec<Nodes> {
        if let Rule::Implicit = self.rule {
            return solve_at_once(&known, map);
        }
        let size = |of: &[Nodes]| of.iter().flatten().fold(0.0, |most: f64, g| most.max(g.abs()));
        let (mut term, mut sum) = (known.clone(), known);
        for _ in 0..TERMS {
            term = map(&term);
            sum.iter_mut().flatten().zip(term.iter().flatten()).for_each(|(sum, term)| *sum += term);
            if size(&term) <= f64::EPSILON * size(&sum) {
                break;
            }
        }
        sum
    }
}

/// The same by elimination, at the nodes of an implicit step. The map makes balls depend on their neighbours only.
fn solve_at_once(known: &[Nodes], map: impl Fn(&[Nodes]) -> Vec<Nodes>) -> Vec<Nodes> {
    let stages = |nodes: &Nodes| Stages::from_fn(|m, _| nodes[m]);
    let row = |known: &Nodes| Row {
        lower: Matrix::zeros(),
        diagonal: Matrix::identity(),
        upper: Matrix::zeros(),
        known: stages(known),
    };
    let mut rows: Vec<Row> = known.iter().map(row).collect();
    // Every third ball at once: a ball depends on one of them.
    for (ball, stage) in (0..known.len().min(3)).flat_map(|ball| (0..STAGES).map(move |stage| (ball, stage))) {
        let mut units = vec![[0.0; NODES]; known.len()];
        units.iter_mut().skip(ball).step_by(3).for_each(|unit| unit[stage] = 1.0);
        for (i, (row, found)) in rows.iter_mut().zip(map(&units)).enumerate() {
            let block = match (i + 3 - ball) % 3 {
                0 => &mut row.diagonal,
                1 => &mut row.lower,
                _ => &mut row.upper,
            };
            block.column_mut(stage).iter_mut().zip(found).for_each(|(entry, of)| *entry -= of);
        }
    }
    let nodes = |solved: Stages| std::array::from_fn(|m| if m < STAGES { solved[m] } else { 0.0 });
    match solve(&mut rows) {
        Some(solved) => solved.map(nodes).collect(),
        None => vec![[f64::NAN; NODES]; known.len()],
    }
}

/// Changes of the balls of contact `j` of a step at a node.
fn moves(motion: &[Motion], j: usize, m: usize) -> [[f64; 2]; 2] {
    [0, 1].map(|number| [j, j + 1].map(|i| motion[i][number][m]))
}

impl Part for Step {
    fn numbers(&self) -> usize {
        5 * NODES * self.balls.len() + self.contacts.iter().map(ContactNodes::numbers).sum::<usize>()
    }

    fn forward(&self, cradle: &Cradle, changes: &Coefficients, state: &mut [f64]) {
        let (h, first, times) = (self.length, self.first, self.rule.times());
        let state = &mut state[first * STATE..][..self.balls.len() * STATE];
        let mass = |k: usize| cradle.balls[first + k].mass;
        let undisturbed: Vec<Motion> =
            state.chunks(STATE).map(|state| [times.map(|c| h * c * state[V]), [state[V]; NODES]]).collect();
        let mut known = self.accelerations(cradle, &undisturbed);
        for (k, (ball, known)) in self.balls.iter().zip(&mut known).enumerate() {
            let by = ball.accelerations(&cradle.balls[first + k], first + k, changes);
            let [x, later] = [X, TIME].map(|number| state[k * STATE + number]);
            (0..NODES).for_each(|m| known[m] += ball.by_place[m] * x + by[m] + ball.by_time[m] * later);
        }
        // Without moves since the start.
        let mut forces = vec![[0.0; NODES]; self.contacts.len()];
        for (j, contact) in self.contacts.iter().enumerate() {
            let by = contact.by_coefficients(&cradle.contacts[first + j], first + j, changes);
            let [force, left, right] = by.unwrap_or_default();
            let places = [j, j + 1].map(|k| state[k * STATE + X]);
            for m in 0..NODES {
                let (of_start, on_balls) = contact.by_start(m, state[j * STATE + OVERLAP], places);
                forces[j][m] = force[m] + of_start;
                known[j][m] += (left[m] + on_balls[0]) / mass(j);
                known[j + 1][m] += (right[m] + on_balls[1]) / mass(j + 1);
            }
        }
        let found = self.solve(known, |g| self.accelerations(cradle, &self.integrate(g)));
        let mut motion = self.integrate(&found);
        for (own, start) in motion.iter_mut().flatten().flatten().zip(undisturbed.iter().flatten().flatten()) {
            *own += start;
        }
        let [of_rate, of_position] = self.rule.at_end();
        let moved: Vec<f64> = found
            .iter()
            .zip(state.chunks(STATE))
            .map(|(g, state)| h * (state[V] + h * weighted(of_position, g)))
            .collect();
        for (j, (contact, force)) in self.contacts.iter().zip(&mut forces).enumerate() {
            (0..NODES).for_each(|m| force[m] += contact.by_moves(m, moves(&motion, j, m)).0);
            state[j * STATE + IMPULSE] += h * weighted(of_rate, force);
            let ([left, right], turn) = contact.at_end();
            let mut geometry = changes.of_linkage(first + j);
            (geometry[0], geometry[1]) = (state[j * STATE + X], state[(j + 1) * STATE + X]);
            let of_turn: f64 = turn.iter().zip(geometry).map(|(by, change)| by * change).sum();
            state[j * STATE + OVERLAP] += left * moved[j] + right * moved[j + 1] + of_turn;
        }
        for ((g, moved), state) in found.iter().zip(moved).zip(state.chunks_mut(STATE)) {
            state[X] += moved;
            state[V] += h * weighted(of_rate, g);
        }
    }

    fn backward(&self, cradle: &Cradle, by_changes: &mut Coefficients, by_state: &mut [f64]) {
        let (h, first, times) = (self.length, self.first, self.rule.times());
        let by_state = &mut by_state[first * STATE..][..self.balls.len() * STATE];
        let [of_rate, of_position] = self.rule.at_end();
        // By the way of each ball to the end, of which the overlaps there are functions.
        let mut by_ways: Vec<f64> = by_state.chunks(STATE).map(|by| by[X]).collect();
        for (j, contact) in self.contacts.iter().enumerate() {
            let (by_overlap, ([left, right], turn)) = (by_state[j * STATE + OVERLAP], contact.at_end());
            by_ways[j] += left * by_overlap;
            by_ways[j + 1] += right * by_overlap;
            by_state[j * STATE + X] += turn[0] * by_overlap;
            by_state[(j + 1) * STATE + X] += turn[1] * by_overlap;
            by_changes.add_of_linkage(first + j, &turn.map(|turn| turn * by_overlap));
        }
        let by_forces: Vec<Nodes> =
            (0..self.contacts.len()).map(|j| of_rate.map(|of| h * of * by_state[j * STATE + IMPULSE])).collect();
        let none = vec![[0.0; NODES]; self.balls.len()];
        let mut known = self.integrate_back(&self.back(cradle, &none, &by_forces));
        for ((known, by), by_way) in known.iter_mut().zip(by_state.chunks(STATE)).zip(&by_ways) {
            (0..NODES).for_each(|m| known[m] += h * (h * of_position[m] * by_way + of_rate[m] * by[V]));
        }
        let nothing = vec![[0.0; NODES]; self.contacts.len()];
        let found = self.solve(known, |g| self.integrate_back(&self.back(cradle, g, &nothing)));
        let motion = self.back(cradle, &found, &by_forces);
        for (k, ([by_x, by_v], ball)) in motion.iter().zip(&self.balls).enumerate() {
            let by = &mut by_state[k * STATE..];
            by[V] += h * (by_ways[k] + weighted(times, by_x)) + by_v.iter().sum::<f64>();
            by[X] += weighted(&ball.by_place, &found[k]);
            by[TIME] += weighted(&ball.by_time, &found[k]);
            ball.add_derivatives(&cradle.balls[first + k], first + k, &found[k], by_changes);
        }
        for (j, (contact, by_force)) in self.contacts.iter().zip(&by_forces).enumerate() {
            let [left, right] = [j, j + 1].map(|k| found[k].map(|by| by / cradle.balls[first + k].mass));
            for m in 0..NODES {
                let (by_overlap, by_places) = contact.to_start(m, by_force[m], [left[m], right[m]]);
                by_state[j * STATE + OVERLAP] += by_overlap;
                (0..2).for_each(|k| by_state[(j + k) * STATE + X] += by_places[k]);
            }
            let law = &cradle.contacts[first + j];
            contact.add_derivatives(law, first + j, [by_force, &left, &right], by_changes);
        }
    }
}
