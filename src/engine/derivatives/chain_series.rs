//! The Taylor series of all motions about one state of the whole chain, in doubles or in dual numbers.
//!
//! The recursions are those of a contact phase (`cluster::recurrences`), which is made to follow few balls quickly. This one gives
//! derivatives: by time as the first coefficients, along a direction as the tangents of dual numbers.

use super::chain_state::ChainState;
use crate::engine::cluster::OVERLAP_TERMS;
use crate::engine::flight::Forcing;
use crate::model::{Cradle, Mode};
use crate::solver::dual::Scalar;

/// Coefficients of the motions and forces as functions of the time since the state over `unit`.
#[derive(Clone, Debug)]
pub(crate) struct Expansion<S> {
    /// Unit of time of the series, s.
    pub unit: f64,
    stride: usize,
    positions: Vec<S>,
    overlaps: Vec<S>,
    elastic: Vec<S>,
    forces: Vec<S>,
}

impl<S: Scalar> Expansion<S> {
    /// The series with `order` coefficients of the forces and two more of the motions. Contacts marked as `negligible` have no elastic
    /// force. Overlaps that are `given`, in the unit of the series, are taken as they are; the forces follow from them.
    pub fn new(
        cradle: &Cradle<S>,
        state: &ChainState<S>,
        forcings: &[Forcing<S>],
        order: usize,
        unit: f64,
        negligible: impl Fn(usize) -> bool,
        given: &[Option<[S; OVERLAP_TERMS]>],
    ) -> Self {
        let (balls, contacts, stride) = (cradle.balls.len(), cradle.contacts.len(), order + 2);
        let zeros = |rows: usize| vec![S::default(); rows * stride];
        let mut series = Self {
            unit,
            stride,
            positions: zeros(balls),
            overlaps: zeros(contacts),
            elastic: zeros(contacts),
            forces: zeros(contacts),
        };
        for i in 0..balls {
            series.positions[i * stride] = state.x[i];
            series.positions[i * stride + 1] = state.v[i] * S::from(unit);
        }
        let given = |j: usize| given.get(j).and_then(Option::as_ref);
        for j in 0..contacts {
            let overlap = &mut series.overlaps[j * stride..(j + 1) * stride];
            match given(j) {
                Some(given) => overlap[..given.len()].copy_from_slice(given),
                None => {
                    overlap[0] = state.overlaps[j];
                    overlap[1] = (state.v[j] - state.v[j + 1]) * S::from(unit);
                }
            }
        }
        let mut powers = vec![Vec::new(); contacts];
        for k in 0..order {
            for (j, powers) in powers.iter_mut().enumerate().filter(|(j, _)| state.modes[*j] != Mode::Open) {
                series.expand_force(j, cradle, k, (!negligible(j)).then_some(powers));
            }
            series.expand_motion(cradle, state, forcings, k, |j| given(j).is_some());
        }
        series
    }

    /// Coefficient `k` of the force of contact `j` by its law, from the powers of its overlap if it has an elastic force.
    fn expand_force(&mut self, j: usize, cradle: &Cradle<S>, k: usize, powers: Option<&mut Vec<S>>) {
        let (law, at) = (&cradle.contacts[j], j * self.stride);
        let overlap = &self.overlaps[at..at + self.stride];
        if let Some(powers) = powers {
            self.elastic[at + k] = law.elastic_coefficient(overlap, powers, k);
        }
        let rate = |k: usize| S::from((k + 1) as f64 / self.unit) * overlap[k + 1];
        let elastic = &self.elastic[at..];
        let product = || (0..=k).map(|i| elastic[i] * rate(k - i)).sum();
        self.forces[at + k] = law.force_coefficient(elastic[k], rate(k), product);
    }

    /// Coefficient `k` of the accelerations, hence `k + 2` of the positions and of the overlaps that are not given.
    fn expand_motion(
        &mut self,
        cradle: &Cradle<S>,
        state: &ChainState<S>,
        forcings: &[Forcing<S>],
        k: usize,
        given: impl Fn(usize) -> bool,
    ) {
        let stride = self.stride;
        let time_to_k = (1..=k).fold(1.0, |power, i| power * self.unit / i as f64);
        let acting = |j: usize| match state.modes.get(j) {
            Some(Mode::Pressing) => self.forces[j * stride + k],
            _ => S::default(),
        };
        for (i, ball) in cradle.balls.iter().enumerate() {
            let from_left = if i > 0 { acting(i - 1) } else { S::default() };
            let forcing = forcings[i].get(k).map_or(S::default(), |forcing| *forcing * S::from(time_to_k));
            let x = &mut self.positions[i * stride..(i + 1) * stride];
            let rate = S::from((k + 1) as f64 / self.unit) * x[k + 1];
            let acceleration =
                (from_left - acting(i)) / ball.mass + forcing - ball.omega2 * x[k] - S::from(2.0) * ball.gamma * rate;
            x[k + 2] = acceleration * S::from(self.unit * self.unit / ((k + 1) * (k + 2)) as f64);
        }
        for j in (0..cradle.contacts.len()).filter(|j| !given(*j)) {
            let at = j * stride + k + 2;
            self.overlaps[at] = self.positions[at] - self.positions[at + stride];
        }
    }

    /// Takes the motions as given, and as forces in the contacts that press what they need beside gravity, drag and inputs.
    pub fn constrain(&mut self, cradle: &Cradle<S>, state: &ChainState<S>, forcings: &[Forcing<S>]) {
        for (j, mode) in state.modes.iter().enumerate() {
            if *mode != Mode::Pressing {
                continue;
            }
            let (ball, x) = (&cradle.balls[j], self.position(j));
            let (v, mut factorial) = (self.rate(x), 1.0);
            let a = self.rate(&v);
            let left = (j > 0 && state.modes[j - 1] == Mode::Pressing).then(|| self.force(j - 1));
            let force = |k: usize| {
                factorial *= k.max(1) as f64;
                let forcing = forcings[j].get(k).map_or(S::default(), |forcing| *forcing / S::from(factorial));
                let free = forcing - ball.omega2 * x[k] - S::from(2.0) * ball.gamma * v[k];
                left.map_or(S::default(), |left| left[k]) + ball.mass * (free - a[k])
            };
            let forces: Vec<S> = (0..self.stride - 2).map(force).collect();
            let at = j * self.stride;
            self.forces[at..at + forces.len()].copy_from_slice(&forces);
        }
    }

    fn row<'a>(&self, rows: &'a [S], i: usize) -> &'a [S] {
        &rows[i * self.stride..(i + 1) * self.stride]
    }

    /// Position of ball `i`, m.
    pub fn position(&self, i: usize) -> &[S] {
        self.row(&self.positions, i)
    }

    /// Overlap of contact `j`, m.
    pub fn overlap(&self, j: usize) -> &[S] {
        self.row(&self.overlaps, j)
    }

    /// Elastic force of contact `j`, N; zero while it is open.
    pub fn elastic(&self, j: usize) -> &[S] {
        &self.row(&self.elastic, j)[..self.stride - 2]
    }

    /// Force of contact `j` by its law without clipping, N; zero while it is open.
    pub fn force(&self, j: usize) -> &[S] {
        &self.row(&self.forces, j)[..self.stride - 2]
    }

    /// All positions, a row for each ball.
    pub fn positions(&self) -> impl Iterator<Item = &[S]> {
        self.positions.chunks_exact(self.stride)
    }

    /// The derivative of a row by time.
    pub fn rate(&self, row: &[S]) -> Vec<S> {
        row.iter().enumerate().skip(1).map(|(k, c)| *c * S::from(k as f64 / self.unit)).collect()
    }
}
