//! The velocities of touching rigid balls after the impacts of one instant: impacts of two, one after another, or joint
//! impacts. See "Rigid contacts" in docs/theory.md for their order and outcome, and [`TouchingRow`] for balls on arcs.

use std::ops::Range;

use crate::model::Cradle;
use crate::solver::{EventQueue, Scalar};

/// A row of touching balls, as they collide on a line.
///
/// On arcs, two neighbours approach each other at `l u_l - r u_r`, with the velocities u along the paths and the parts
/// l and r of the direction between them. In the velocities `w = c u`, whose factors c have the ratio `r / l` from one
/// ball to the next, the speed of approach is `(l / c_l) (w_l - w_r)`. So in w the balls collide as on a line, with the
/// masses `m / c^2`.
pub(crate) struct TouchingRow<S> {
    /// Masses on that line, kg.
    masses: Vec<S>,
    /// Velocities on that line over those along the paths.
    factors: Vec<S>,
    /// For each contact, the speed of approach over the difference of the velocities on that line.
    parts: Vec<S>,
    /// For each contact, the coefficient of restitution.
    restitution: Vec<S>,
}

impl<S: Scalar> TouchingRow<S> {
    /// The row of `balls` at these places along their paths (m). `Err` with the left ball of a contact that cannot push
    /// one of its balls along its path, or that pushes against the sense of the first contact.
    pub fn new(cradle: &Cradle<S>, balls: Range<usize>, place: impl Fn(usize) -> S) -> Result<Self, usize> {
        let (mut factors, mut parts) = (vec![S::from(1.0)], Vec::with_capacity(balls.len() - 1));
        for j in balls.start..balls.end - 1 {
            let (factor, places) = (factors[factors.len() - 1], [j, j + 1].map(&place));
            let [a, b] = cradle.pair(j).parts_along(places);
            parts.push(a / factor);
            factors.push(factor * (b / a));
            let sense = |part: S| part.value().signum();
            if a.value() * b.value() == 0.0 || sense(parts[0]) != sense(a / factor) {
                return Err(j);
            }
        }
        let restitution = cradle.contacts[balls.start..balls.end - 1].iter().map(|law| law.restitution).collect();
        let masses = cradle.balls[balls].iter().zip(&factors).map(|(ball, factor)| ball.mass / (*factor * *factor));
        Ok(Self { masses: masses.collect(), factors, parts, restitution })
    }

    /// The row with contacts that do not rebound.
    pub fn without_rebound(mut self) -> Self {
        self.restitution.fill(S::default());
        self
    }

    /// Speed at which the balls of contact `j` of the row approach each other, m/s, for velocities along the paths.
    pub fn approach(&self, v: &[S], j: usize) -> S {
        self.parts[j] * (self.factors[j] * v[j] - self.factors[j + 1] * v[j + 1])
    }
}

/// The impulse that a contact transmits in one impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Impact<S> {
    /// Index of the contact in the row.
    pub contact: usize,
    /// Impulse, N.s.
    pub impulse: S,
}

/// The outcome of the impacts of one instant, besides the velocities.
#[derive(Clone, Debug)]
pub(crate) struct Collisions<S> {
    pub impacts: Vec<Impact<S>>,
    /// The balls of each impact, in the order of time, and whether they part; otherwise they come to rest.
    pub groups: Vec<(Range<usize>, bool)>,
    /// Energy lost, J.
    pub loss: S,
}

/// Neighbours with the weighted mean of their values.
pub(crate) struct Block<S> {
    pub members: Range<usize>,
    pub mean: S,
    mass: S,
}

/// Joins neighbours to blocks until `meet(contact, difference)`, with the difference of their means (left minus right),
/// holds nowhere. It gives balls that stick a common velocity or acceleration (isotonic regression by pooling adjacent
/// violators: Barlow et al., Statistical Inference under Order Restrictions, 1972).
pub(crate) fn pool<S: Scalar>(masses: &[S], values: &[S], meet: impl Fn(usize, S) -> bool) -> Vec<Block<S>> {
    let mut blocks: Vec<Block<S>> = Vec::with_capacity(masses.len());
    for (i, (mass, value)) in masses.iter().zip(values).enumerate() {
        let mut block = Block { members: i..i + 1, mean: *value, mass: *mass };
        while let Some(left) = blocks.pop_if(|left| meet(block.members.start - 1, left.mean - block.mean)) {
            let mass = left.mass + block.mass;
            let mean = left.mean + (block.mean - left.mean) * (block.mass / mass);
            block = Block { members: left.members.start..block.members.end, mean, mass };
        }
        blocks.push(block);
    }
    blocks
}

/// Carries out the impacts of a row of touching balls with the velocities `v` along their paths (m/s), which it
/// updates. Balls that approach each other at up to `unresolved` (m/s) come to rest; speeds that differ by up to
/// `rounding` (m/s) count as equal.
pub(crate) fn collide(row: &TouchingRow<f64>, v: &mut [f64], unresolved: f64, rounding: f64) -> Collisions<f64> {
    let mut outcome = Collisions { impacts: Vec::new(), groups: Vec::new(), loss: 0.0 };
    v.iter_mut().zip(&row.factors).for_each(|(v, factor)| *v *= *factor);
    if row.restitution.iter().any(|e| *e > 0.0) {
        sequence(row, v, unresolved, rounding, &mut outcome);
    }
    // Balls that still approach come to rest against each other.
    for block in pool(&row.masses, v, |j, difference| row.parts[j] * difference > 0.0) {
        if block.members.len() > 1 {
            outcome.groups.push((block.members.clone(), false));
            let e = vec![0.0; block.members.len() - 1];
            joint_impact(&row.masses, v, &e, block.members, block.mean, &mut outcome);
        }
    }
    finish(row, v, &mut outcome);
    outcome
}

/// Converts velocities and impulses from the line back to the paths.
fn finish<S: Scalar>(row: &TouchingRow<S>, v: &mut [S], outcome: &mut Collisions<S>) {
    v.iter_mut().zip(&row.factors).for_each(|(v, factor)| *v = *v / *factor);
    for Impact { contact, impulse } in &mut outcome.impacts {
        *impulse = *impulse / row.parts[*contact];
    }
}

/// Carries out one impact of all balls of a row with the velocities `v` along their paths (m/s), which it updates.
pub(crate) fn collide_at_once<S: Scalar>(row: &TouchingRow<S>, v: &mut [S]) -> Collisions<S> {
    let mut outcome = Collisions { impacts: Vec::new(), groups: Vec::new(), loss: S::default() };
    v.iter_mut().zip(&row.factors).for_each(|(v, factor)| *v = *v * *factor);
    match v.len() {
        2 => impact_of_two(row, v, 0, &mut outcome),
        balls => {
            let centre = pool(&row.masses, v, |_, _| true)[0].mean;
            joint_impact(&row.masses, v, &row.restitution, 0..balls, centre, &mut outcome);
        }
    }
    finish(row, v, &mut outcome);
    outcome
}

/// Most impacts: per ball if some lose energy, else in all; far beyond what everyday mass ratios need. Fewer would end
/// inelastic collapse sooner.
const INELASTIC_IMPACTS: usize = 1000;
const ELASTIC_IMPACTS: usize = 1_000_000;

/// Carries out impacts one after another, as long as any pair approaches faster than `unresolved` (m/s).
fn sequence(row: &TouchingRow<f64>, v: &mut [f64], unresolved: f64, rounding: f64, outcome: &mut Collisions<f64>) {
    let masses = &row.masses[..];
    let (balls, contacts) = (masses.len(), masses.len() - 1);
    // Number of impacts after which balls that still approach stick. Elastic sequences end (Galperin, On systems of
    // locally interacting and repelling particles, 1981), but mass ratios can put the end far off.
    let loses = row.restitution.iter().any(|e| *e < 1.0);
    let most = if loses { INELASTIC_IMPACTS * balls } else { ELASTIC_IMPACTS + balls * balls };
    // The earliest entry is the fastest approach.
    let mut queue = EventQueue::new(contacts);
    let enter = |queue: &mut EventQueue, v: &[f64], j: usize| {
        let approach = row.parts[j] * (v[j] - v[j + 1]);
        if approach > unresolved { queue.set(j, (-approach).into()) } else { queue.remove(j) }
    };
    (0..contacts).for_each(|j| enter(&mut queue, v, j));
    let mut tied = Vec::new();
    while let Some((fastest, first)) = queue.first()
        && outcome.impacts.len() < most
    {
        queue.remove(first);
        tied.push(first);
        while let Some((speed, j)) = queue.first().filter(|(speed, _)| speed.value() <= fastest.value() + rounding) {
            debug_assert!(speed >= fastest);
            queue.remove(j);
            tied.push(j);
        }
        tied.sort_unstable();
        for run in tied.chunk_by(|left, right| left + 1 == *right) {
            match *run {
                [j] => {
                    outcome.groups.push((j..j + 2, true));
                    impact_of_two(row, v, j, outcome);
                }
                [first, .., last] => {
                    let balls = first..last + 2;
                    outcome.groups.push((balls.clone(), true));
                    let centre = pool(&masses[balls.clone()], &v[balls.clone()], |_, _| true)[0].mean;
                    joint_impact(masses, v, &row.restitution[first..=last], balls, centre, outcome);
                }
                [] => {}
            }
        }
        for j in tied.drain(..) {
            (j.saturating_sub(1)..(j + 2).min(contacts)).for_each(|j| enter(&mut queue, v, j));
        }
    }
}

/// The impact of the balls of contact `j` alone. If it loses nothing, equal balls exchange their velocities to the last
/// digit.
fn impact_of_two<S: Scalar>(row: &TouchingRow<S>, v: &mut [S], j: usize, outcome: &mut Collisions<S>) {
    let (masses, e) = (&row.masses, row.restitution[j]);
    let total = masses[j] + masses[j + 1];
    let (left_share, right_share) = (masses[j] / total, masses[j + 1] / total);
    let (one, approach) = (S::from(1.0), v[j] - v[j + 1]);
    let impulse = (one + e) * masses[j] * right_share * approach;
    if row.factors[j] == row.factors[j + 1] {
        (v[j], v[j + 1]) =
            (v[j + 1] + (one - (one + e) * right_share) * approach, v[j] - (one - (one + e) * left_share) * approach);
    } else {
        // On different scales, each velocity keeps its own digits.
        v[j] += -((one + e) * right_share * approach);
        v[j + 1] += (one + e) * left_share * approach;
    }
    outcome.loss += S::from(0.5) * (one - e) * impulse * approach;
    outcome.impacts.push(Impact { contact: j, impulse });
}

/// The impact of all `balls` at once, whose centre of mass moves at the velocity `centre`: each contact parts at its
/// coefficient of restitution `e` times its speed of approach.
fn joint_impact<S: Scalar>(
    masses: &[S],
    v: &mut [S],
    e: &[S],
    balls: Range<usize>,
    centre: S,
    outcome: &mut Collisions<S>,
) {
    let (before, first) = (v[balls.clone()].to_vec(), balls.start);
    // Velocities up to a common one. Sums from both sides give mirrored results for mirrored starts.
    let parting = |j: usize| e[j] * (before[j] - before[j + 1]);
    let (half, mut sum) = (S::from(0.5), S::default());
    let mut relative = vec![S::default(); before.len()];
    for k in 0..e.len() {
        sum += parting(k);
        relative[k + 1] = half * sum;
    }
    sum = S::default();
    for k in (0..e.len()).rev() {
        sum += parting(k);
        relative[k] = relative[k] - half * sum;
    }
    let mean = pool(&masses[balls.clone()], &relative, |_, _| true)[0].mean;
    for (v, relative) in v[balls.clone()].iter_mut().zip(relative) {
        *v = centre + (relative - mean);
    }
    let mut impulse = S::default();
    for (k, pair) in before.windows(2).enumerate() {
        impulse += masses[first + k] * (before[k] - v[first + k]);
        outcome.loss += half * (S::from(1.0) - e[k]) * impulse * (pair[0] - pair[1]);
        outcome.impacts.push(Impact { contact: first + k, impulse });
    }
}
