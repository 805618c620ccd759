//! The motion of neighbours that press on each other, by Gauss collocation (see [`gauss`](crate::solver::gauss)).

use super::pair::law_derivatives;
use crate::engine::flight::{Forcing, forcing_at};
use crate::model::{BallModel, ContactLaw};
use crate::solver::gauss::{NODES, Nodes, Stretching, combine, weighted};

/// Iterations after which a segment counts as too long.
const MOST: usize = 30;

/// Change of the accelerations over their size, both summed over balls and nodes, at which the iteration is at its end.
const CONVERGED: f64 = 1e-14;

/// Part of the largest acceleration that may be left in the two highest terms of their interpolation. In the stretched
/// time `c^2` forces are smooth whose exponent is a multiple of 1/2: the error at the end of a segment is far smaller
/// then.
const TAIL: f64 = 1e-11;
const SMOOTH_TAIL: f64 = 1e-7;

/// The motion of one ball, at the nodes.
#[derive(Clone, Debug)]
pub(super) struct BallNodes {
    /// Position, m, and velocity, m/s.
    pub x: Nodes,
    pub v: Nodes,
    /// Force of contacts and inputs, N.
    pub force: Nodes,
}

/// One contact, at the nodes.
#[derive(Clone, Debug)]
pub(super) struct ContactNodes {
    pub overlap: Nodes,
    pub rate: Nodes,
    /// Force, N, and its derivative by the overlap, N/m.
    pub force: Nodes,
    pub slope: Nodes,
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
    pub first: usize,
    pub tuning: usize,
    pub length: f64,
    pub stretching: Stretching,
    pub balls: Vec<BallNodes>,
    pub contacts: Vec<ContactNodes>,
}

/// What a segment ends with: displacements and changes of the velocity of the balls.
pub(super) type End = Vec<(f64, f64)>;

/// `start + slope t + sum_l columns[l] values[l]` at the nodes.
fn along(columns: &[Nodes; NODES], values: &Nodes, factor: f64, start: f64, slope: f64, times: &Nodes) -> Nodes {
    let sums = combine(columns, values);
    std::array::from_fn(|m| start + slope * times[m] + factor * sums[m])
}

/// How far an iteration has come, at the nodes: sums of absolute values, which are finite only if all values are.
#[derive(Debug, Default)]
pub(super) struct Progress {
    size: Nodes,
    change: Nodes,
    /// The change of the iteration before.
    before: f64,
}

impl Progress {
    /// Puts new values in the place of old ones.
    pub fn renew(&mut self, values: &mut Nodes, new: &Nodes) {
        for m in 0..NODES {
            self.size[m] += new[m].abs();
            self.change[m] += (new[m] - values[m]).abs();
        }
        *values = *new;
    }

    /// Whether the iteration that is complete now has left no more than this part of the values to change.
    pub fn is_done(&mut self, part: f64) -> bool {
        let sum = |values: &mut Nodes| std::mem::take(values).iter().sum::<f64>();
        let (size, change) = (sum(&mut self.size), sum(&mut self.change));
        // It converges faster and faster: the next change is far below this.
        let next = 100.0 * change * (change / std::mem::replace(&mut self.before, change));
        size.is_finite() && change.min(next) <= part * size
    }
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
        let (mut converged, mut progress) = (false, Progress::default());
        let total = |forces: &[Nodes]| {
            let mut total = pushes.clone();
            for (j, force) in forces.iter().enumerate() {
                for m in 0..NODES {
                    total[j][m] -= force[m];
                    total[j + 1][m] += force[m];
                }
            }
            total
        };
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
            for (i, (g, force)) in g.iter_mut().zip(total(&forces)).enumerate() {
                let model = &group.models[i];
                let next = std::array::from_fn(|m| {
                    model.acceleration(group.x[i] + moved[i][m], rates[i][m], force[m], -support[m])
                });
                progress.renew(g, &next);
            }
            converged = progress.is_done(CONVERGED);
            if converged {
                break;
            }
        }
        let scale = g.iter().flatten().fold(0.0, |most: f64, g| most.max(g.abs()));
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
        let forces = total(&forces);
        let ball = |i: usize| BallNodes { x: moved[i].map(|moved| group.x[i] + moved), v: rates[i], force: forces[i] };
        let contacts = group.laws.iter().enumerate().map(contact).collect();
        let balls = (0..count).map(ball).collect();
        Some((Self { first: group.first, tuning, length, stretching, balls, contacts }, end))
    }

    /// Numbers that it holds.
    pub fn numbers(&self) -> usize {
        (3 * self.balls.len() + 4 * self.contacts.len()) * NODES
    }
}

impl ContactNodes {
    /// Derivatives of the force at node `m` by the coefficients.
    pub fn derivatives(&self, law: &ContactLaw, m: usize) -> [f64; 7] {
        law_derivatives(law, self.overlap[m], self.rate[m], self.force[m], self.slope[m])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_finite_values_have_converged() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for m in 0..NODES {
                let (mut values, mut progress) = ([1.0; NODES], Progress::default());
                let mut new = values;
                new[m] = value;
                for _ in 0..3 {
                    progress.renew(&mut values, &new);
                    assert!(!progress.is_done(0.5), "{value}");
                }
            }
        }
        let (mut values, mut progress) = ([1.0; NODES], Progress::default());
        for (new, done) in [(2.0, false), (2.0, true)] {
            progress.renew(&mut values, &[new; NODES]);
            assert_eq!(progress.is_done(0.1), done);
        }
    }
}
