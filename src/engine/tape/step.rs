//! A part of the motion of neighbours, linearised by collocation at its nodes.
//!
//! Changes `g` of the accelerations at the nodes move a ball by `h^2 Q2 g` and change its velocity by `h Q1 g` (see
//! [`gauss`](crate::solver::gauss)); these change the accelerations by `T g`. So `g = known + T g`, where `known` has
//! all other causes. An explicit step is short enough for the Neumann series, `g = known + T known + T T known + ...`.
//! With the transposed `T`, such a series also gives the derivatives of a number by `known`. Stiff equations are solved
//! at once, on the nodes of an implicit step.

use std::fmt::Debug;
use std::sync::LazyLock;

use super::coefficients::{Coefficients, IMPULSE, OVERLAP, STATE, TIME, V, X};
use super::nodes::{BallNodes, ContactNodes};
use super::part::Part;
use crate::model::Cradle;
use crate::solver::radau::{BlockRow, Matrix, RADAU, STAGES, Stages, solve};
use crate::solver::{NODES, Table, combine, weighted};

/// Most terms of the series.
const TERMS: usize = 60;

/// A part of the motion of neighbours, whose contacts all press, at the nodes of a rule.
#[derive(Debug)]
pub(super) struct CollocationStep<const N: usize, R: 'static> {
    /// First ball.
    pub first: usize,
    /// Length, s.
    pub length: f64,
    pub rule: &'static R,
    pub balls: Vec<BallNodes<N>>,
    pub contacts: Vec<ContactNodes<N>>,
}

/// A collocation rule with N nodes.
pub(super) trait CollocationRule<const N: usize>: Debug + Send + Sync {
    /// The times of the nodes, over the length of the step.
    fn times(&self) -> &[f64; N];

    /// Weights of the integrals that give rate and position at the end.
    fn at_end(&self) -> [&[f64; N]; 2];

    /// `Q1 g` and `Q2 g` at the nodes.
    fn integrate(&self, g: &[f64; N]) -> [[f64; N]; 2];

    /// The transposed for a step of length h: `h Q1' v + h^2 Q2' x`.
    fn integrate_back(&self, h: f64, motion: &NodalStates<N>) -> [f64; N];

    /// Solves `g = known + T g`: for the changes of the accelerations or, backwards, with the transposed `T`, for the
    /// derivatives by them.
    fn solve(step: &CollocationStep<N, Self>, cradle: &Cradle, known: Vec<[f64; N]>, way: Way) -> Vec<[f64; N]>
    where
        Self: Sized;
}

/// The map or its transposed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    Forwards,
    Backwards,
}

/// Explicit steps: Gauss collocation with time that may be stretched.
impl CollocationRule<NODES> for Table {
    fn times(&self) -> &[f64; NODES] {
        &self.times
    }

    fn at_end(&self) -> [&[f64; NODES]; 2] {
        [&self.of_rate, &self.of_position]
    }

    fn integrate(&self, g: &[f64; NODES]) -> [[f64; NODES]; 2] {
        self.integrate_both(g)
    }

    fn integrate_back(&self, h: f64, [x, v]: &NodalStates<NODES>) -> [f64; NODES] {
        let of_x = self.integrate_back(x);
        self.integrate_back(&std::array::from_fn(|m| h * (h * of_x[m] + v[m])))
    }

    fn solve(
        step: &CollocationStep<NODES, Self>,
        cradle: &Cradle,
        known: Vec<[f64; NODES]>,
        way: Way,
    ) -> Vec<[f64; NODES]> {
        let size = |of: &[[f64; NODES]]| of.iter().flatten().fold(0.0, |most: f64, g| most.max(g.abs()));
        let nothing = vec![[0.0; NODES]; step.contacts.len()];
        let (mut term, mut sum) = (known.clone(), known);
        for _ in 0..TERMS {
            term = match way {
                Way::Forwards => step.accelerations(cradle, &step.integrate(&term)),
                Way::Backwards => step.integrate_back(&step.back(cradle, &term, &nothing)),
            };
            sum.iter_mut().flatten().zip(term.iter().flatten()).for_each(|(sum, term)| *sum += term);
            if size(&term) <= f64::EPSILON * size(&sum) {
                break;
            }
        }
        sum
    }
}

/// Implicit steps: Radau collocation.
#[derive(Debug)]
pub(super) struct Implicit {
    times: [f64; STAGES],
    /// One column per node.
    rates: [[f64; STAGES]; STAGES],
    positions: [[f64; STAGES]; STAGES],
    at_end: [[f64; STAGES]; 2],
    twice: Matrix,
}

pub(super) static IMPLICIT: LazyLock<Implicit> = LazyLock::new(|| {
    let (once, twice) = (RADAU.integral, RADAU.integral * RADAU.integral);
    let last = |matrix: &Matrix| std::array::from_fn(|l| matrix[(STAGES - 1, l)]);
    Implicit {
        times: RADAU.nodes.into(),
        rates: once.into(),
        positions: twice.into(),
        at_end: [last(&once), last(&twice)],
        twice,
    }
});

impl CollocationRule<STAGES> for Implicit {
    fn times(&self) -> &[f64; STAGES] {
        &self.times
    }

    fn at_end(&self) -> [&[f64; STAGES]; 2] {
        self.at_end.each_ref()
    }

    fn integrate(&self, g: &[f64; STAGES]) -> [[f64; STAGES]; 2] {
        [combine(&self.rates, g), combine(&self.positions, g)]
    }

    fn integrate_back(&self, h: f64, [x, v]: &NodalStates<STAGES>) -> [f64; STAGES] {
        std::array::from_fn(|l| h * (h * weighted(&self.positions[l], x) + weighted(&self.rates[l], v)))
    }

    /// By elimination, because a ball depends only on its neighbours.
    fn solve(
        step: &CollocationStep<STAGES, Self>,
        cradle: &Cradle,
        known: Vec<[f64; STAGES]>,
        way: Way,
    ) -> Vec<[f64; STAGES]> {
        let (balls, h) = (known.len(), step.length);
        let row = |known: &[f64; STAGES]| BlockRow {
            lower: Matrix::zeros(),
            diagonal: Matrix::identity(),
            upper: Matrix::zeros(),
            known: Stages::from(*known),
        };
        let mut rows: Vec<BlockRow> = known.iter().map(row).collect();
        // Forces at a node depend on the motion at that node. Every third ball has a unit change at once, because each
        // ball depends on only one of these.
        for (ball, number) in (0..balls.min(3)).flat_map(|ball| [0, 1].map(|number| (ball, number))) {
            let mut units = vec![[[0.0; STAGES]; 2]; balls];
            units.iter_mut().skip(ball).step_by(3).for_each(|unit| unit[number] = [1.0; STAGES]);
            let integral = if number == 0 { step.rule.twice * (h * h) } else { RADAU.integral * h };
            for (i, by) in step.accelerations(cradle, &units).into_iter().enumerate() {
                let block = Matrix::from_fn(|m, l| by[m] * integral[(m, l)]);
                // The unit change that acts on ball i is its own, its left neighbour's, or its right neighbour's.
                match ((i + 3 - ball) % 3, way) {
                    (0, Way::Forwards) => rows[i].diagonal -= block,
                    (0, Way::Backwards) => rows[i].diagonal -= block.transpose(),
                    (1, Way::Forwards) => rows[i].lower -= block,
                    (1, Way::Backwards) if i > 0 => rows[i - 1].upper -= block.transpose(),
                    (2, Way::Forwards) => rows[i].upper -= block,
                    (2, Way::Backwards) if i + 1 < balls => rows[i + 1].lower -= block.transpose(),
                    _ => {}
                }
            }
        }
        match solve(&mut rows) {
            Some(solved) => solved.map(Into::into).collect(),
            None => vec![[f64::NAN; STAGES]; balls],
        }
    }
}

/// The states of a ball at the nodes, its positions (m) and velocities (m/s), or derivatives by them.
type NodalStates<const N: usize> = [[f64; N]; 2];

impl<const N: usize, R: CollocationRule<N>> CollocationStep<N, R> {
    /// Changes of the accelerations (m/s2) by changes of the motion (m, m/s).
    fn accelerations(&self, cradle: &Cradle, motion: &[NodalStates<N>]) -> Vec<[f64; N]> {
        let of_ball = |(i, (ball, [x, v])): (usize, (&BallNodes<N>, &NodalStates<N>))| {
            let gamma = cradle.balls[self.first + i].gamma;
            std::array::from_fn(|m| ball.by_place[m] * x[m] - 2.0 * gamma * v[m])
        };
        let mut found: Vec<[f64; N]> = self.balls.iter().zip(motion).enumerate().map(of_ball).collect();
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

    /// The transposed: derivatives of a number by the motion, from its derivatives by the accelerations and by the
    /// forces of the contacts.
    fn back(&self, cradle: &Cradle, accelerations: &[[f64; N]], forces: &[[f64; N]]) -> Vec<NodalStates<N>> {
        let of_ball = |(i, (ball, by)): (usize, (&BallNodes<N>, &[f64; N]))| {
            let gamma = cradle.balls[self.first + i].gamma;
            [std::array::from_fn(|m| ball.by_place[m] * by[m]), std::array::from_fn(|m| -2.0 * gamma * by[m])]
        };
        let mut found: Vec<NodalStates<N>> = self.balls.iter().zip(accelerations).enumerate().map(of_ball).collect();
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

    /// Changes of the forces (N) without displacements since the start, by the coefficients and by the changes of the
    /// `state` at the start, which belongs to the balls of the step. Adds the changes of the accelerations by these
    /// (m/s2).
    fn forces_without_motion(
        &self,
        cradle: &Cradle,
        changes: &Coefficients,
        state: &[f64],
        accelerations: &mut [[f64; N]],
    ) -> Vec<[f64; N]> {
        let (first, mass) = (self.first, |k: usize| cradle.balls[self.first + k].mass);
        for (k, (ball, sums)) in self.balls.iter().zip(&mut *accelerations).enumerate() {
            let by = ball.accelerations(&cradle.balls[first + k], first + k, changes);
            let [x, later] = [X, TIME].map(|number| state[k * STATE + number]);
            (0..N).for_each(|m| sums[m] += ball.by_place[m] * x + by[m] + ball.by_time[m] * later);
        }
        let mut forces = vec![[0.0; N]; self.contacts.len()];
        for (j, contact) in self.contacts.iter().enumerate() {
            let by = contact.by_coefficients(&cradle.contacts[first + j], first + j, changes);
            let [force, left, right] = by.unwrap_or([[0.0; N]; 3]);
            let places = [j, j + 1].map(|k| state[k * STATE + X]);
            for m in 0..N {
                let (of_start, on_balls) = contact.by_start(m, state[j * STATE + OVERLAP], places);
                forces[j][m] = force[m] + of_start;
                accelerations[j][m] += (left[m] + on_balls[0]) / mass(j);
                accelerations[j + 1][m] += (right[m] + on_balls[1]) / mass(j + 1);
            }
        }
        forces
    }

    /// The motion by accelerations.
    fn integrate(&self, accelerations: &[[f64; N]]) -> Vec<NodalStates<N>> {
        let h = self.length;
        let of_ball = |g: &[f64; N]| {
            let [once, twice] = self.rule.integrate(g);
            [twice.map(|x| h * h * x), once.map(|v| h * v)]
        };
        accelerations.iter().map(of_ball).collect()
    }

    fn integrate_back(&self, motion: &[NodalStates<N>]) -> Vec<[f64; N]> {
        motion.iter().map(|motion| self.rule.integrate_back(self.length, motion)).collect()
    }
}

/// Changes of the balls of contact `j` of a step at a node.
fn moves<const N: usize>(motion: &[NodalStates<N>], j: usize, m: usize) -> [[f64; 2]; 2] {
    [0, 1].map(|number| [j, j + 1].map(|i| motion[i][number][m]))
}

impl<const N: usize, R: CollocationRule<N>> Part for CollocationStep<N, R> {
    fn numbers(&self) -> usize {
        5 * N * self.balls.len() + self.contacts.iter().map(ContactNodes::numbers).sum::<usize>()
    }

    fn forward(&self, cradle: &Cradle, changes: &Coefficients, state: &mut [f64]) {
        let (h, first, times) = (self.length, self.first, self.rule.times());
        let state = &mut state[first * STATE..][..self.balls.len() * STATE];
        let undisturbed: Vec<NodalStates<N>> =
            state.chunks(STATE).map(|state| [times.map(|c| h * c * state[V]), [state[V]; N]]).collect();
        let mut known = self.accelerations(cradle, &undisturbed);
        let mut forces = self.forces_without_motion(cradle, changes, state, &mut known);
        let found = R::solve(self, cradle, known, Way::Forwards);
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
            (0..N).for_each(|m| force[m] += contact.by_moves(m, moves(&motion, j, m)).0);
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
        // Derivatives by the displacement of each ball up to the end, on which the overlaps there depend.
        let mut by_ways: Vec<f64> = by_state.chunks(STATE).map(|by| by[X]).collect();
        for (j, contact) in self.contacts.iter().enumerate() {
            let (by_overlap, ([left, right], turn)) = (by_state[j * STATE + OVERLAP], contact.at_end());
            by_ways[j] += left * by_overlap;
            by_ways[j + 1] += right * by_overlap;
            by_state[j * STATE + X] += turn[0] * by_overlap;
            by_state[(j + 1) * STATE + X] += turn[1] * by_overlap;
            by_changes.add_of_linkage(first + j, &turn.map(|turn| turn * by_overlap));
        }
        let by_forces: Vec<[f64; N]> =
            (0..self.contacts.len()).map(|j| of_rate.map(|of| h * of * by_state[j * STATE + IMPULSE])).collect();
        let none = vec![[0.0; N]; self.balls.len()];
        let mut known = self.integrate_back(&self.back(cradle, &none, &by_forces));
        for ((known, by), by_way) in known.iter_mut().zip(by_state.chunks(STATE)).zip(&by_ways) {
            (0..N).for_each(|m| known[m] += h * (h * of_position[m] * by_way + of_rate[m] * by[V]));
        }
        let found = R::solve(self, cradle, known, Way::Backwards);
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
            for m in 0..N {
                let (by_overlap, by_places) = contact.to_start(m, by_force[m], [left[m], right[m]]);
                by_state[j * STATE + OVERLAP] += by_overlap;
                (0..2).for_each(|k| by_state[(j + k) * STATE + X] += by_places[k]);
            }
            let law = &cradle.contacts[first + j];
            contact.add_derivatives(law, first + j, [by_force, &left, &right], by_changes);
        }
    }
}
