//! The velocities of touching rigid balls after the impacts of one instant: impacts of two, one after the other.
//!
//! The pair that approaches fastest is first. For equally fast pairs that share no ball the order makes no difference.
//! Those that share balls collide jointly: all their approach speeds reverse by the coefficient of restitution e at
//! once (Newton's law for simultaneous impacts). Relative to their centre of mass every velocity is multiplied by -e,
//! so mirrored starts have mirrored outcomes.
//!
//! With e < 1 the sequence need not end: many balls, or a small e, lead to endless impacts with speeds that tend to 0
//! (inelastic collapse: McNamara and Young, Inelastic collapse and clumping in a one-dimensional granular medium,
//! 1992). Balls that still approach then come to rest against each other, the limit of the sequence in doubles.

use crate::solver::dual::Scalar;
use crate::solver::queue::EventQueue;

/// The impulse that a contact transmits in one impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Impact<S> {
    /// Index of the contact in the run.
    pub contact: usize,
    /// N.s.
    pub impulse: S,
}

/// The outcome of an instant of impacts besides the velocities.
#[derive(Clone, Debug)]
pub(crate) struct Outcome<S> {
    pub impacts: Vec<Impact<S>>,
    /// Energy lost, J.
    pub loss: S,
}

/// Neighbours with their weighted mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Block<S> {
    /// The first of them, and the one after the last.
    pub start: usize,
    pub end: usize,
    pub mean: S,
    mass: S,
}

/// Joins neighbours to blocks until `meet(contact, difference)` of their means, left minus right, holds nowhere: gives
/// balls that stick a common velocity or acceleration (isotonic regression by pooling adjacent violators: Barlow et
/// al., Statistical Inference under Order Restrictions, 1972).
pub(crate) fn pool<S: Scalar>(masses: &[S], values: &[S], meet: impl Fn(usize, S) -> bool) -> Vec<Block<S>> {
    let mut blocks: Vec<Block<S>> = Vec::with_capacity(masses.len());
    for (i, (mass, value)) in masses.iter().zip(values).enumerate() {
        let mut block = Block { start: i, end: i + 1, mean: *value, mass: *mass };
        while let Some(left) = blocks.pop_if(|left| meet(block.start - 1, left.mean - block.mean)) {
            let mass = left.mass + block.mass;
            let mean = left.mean + (block.mean - left.mean) * (block.mass / mass);
            block = Block { start: left.start, end: block.end, mean, mass };
        }
        blocks.push(block);
    }
    blocks
}

/// The impacts of touching balls with these masses (kg) and velocities (m/s), which it updates, for the coefficient of
/// restitution `e`. Approach speeds up to `unresolved` (m/s) are rounding, and come to rest.
pub(crate) fn collide<S: Scalar>(masses: &[S], v: &mut [S], e: S, unresolved: f64, rounding: f64) -> Outcome<S> {
    let mut outcome = Outcome { impacts: Vec::new(), loss: S::default() };
    if e.value() > 0.0 || e.tangent() != 0.0 {
        sequence(masses, v, e, unresolved, rounding, &mut outcome);
    }
    stick(masses, v, &mut outcome);
    outcome
}

/// Impacts per ball with `e < 1`, far beyond what everyday mass ratios need: more resolve longer sequences, fewer end
/// inelastic collapse sooner.
const INELASTIC_IMPACTS: usize = 1000;
const ELASTIC_IMPACTS: usize = 1_000_000;

/// The sequence of impacts, as long as any pair approaches faster than `unresolved`.
fn sequence<S: Scalar>(masses: &[S], v: &mut [S], e: S, unresolved: f64, rounding: f64, outcome: &mut Outcome<S>) {
    let (balls, contacts) = (masses.len(), masses.len() - 1);
    // Impacts after which approaching balls stick. Elastic sequences end (Galperin, On systems of locally interacting
    // and repelling particles, 1981), but mass ratios can put the end far off.
    let most = if e.value() < 1.0 { INELASTIC_IMPACTS * balls } else { ELASTIC_IMPACTS + balls * balls };
    // The fastest approach is the earliest entry.
    let mut queue = EventQueue::new(contacts);
    let enter = |queue: &mut EventQueue, v: &[S], j: usize| {
        let approach = (v[j] - v[j + 1]).value();
        if approach > unresolved { queue.set(j, (-approach).into()) } else { queue.remove(j) }
    };
    (0..contacts).for_each(|j| enter(&mut queue, v, j));
    let mut tied = Vec::new();
    while let Some((fastest, _)) = queue.first()
        && outcome.impacts.len() < most
    {
        while let Some((speed, j)) = queue.first().filter(|(speed, _)| speed.value() <= fastest.value() + rounding) {
            debug_assert!(speed >= fastest);
            queue.remove(j);
            tied.push(j);
        }
        tied.sort_unstable();
        for run in tied.chunk_by(|left, right| left + 1 == *right) {
            match *run {
                [j] => impact_of_two(masses, v, e, j, outcome),
                [first, .., last] => joint_impact(masses, v, e, first..last + 1, outcome),
                [] => {}
            }
        }
        for j in tied.drain(..) {
            (j.saturating_sub(1)..(j + 2).min(contacts)).for_each(|j| enter(&mut queue, v, j));
        }
    }
}

/// The impact of the balls of contact `j` alone. Equal balls exchange their velocities to the last digit if `e = 1`.
fn impact_of_two<S: Scalar>(masses: &[S], v: &mut [S], e: S, j: usize, outcome: &mut Outcome<S>) {
    let total = masses[j] + masses[j + 1];
    let (left_share, right_share) = (masses[j] / total, masses[j + 1] / total);
    let (one, approach) = (S::from(1.0), v[j] - v[j + 1]);
    let impulse = (one + e) * masses[j] * right_share * approach;
    (v[j], v[j + 1]) =
        (v[j + 1] + (one - (one + e) * right_share) * approach, v[j] - (one - (one + e) * left_share) * approach);
    outcome.loss += S::from(0.5) * (one - e) * impulse * approach;
    outcome.impacts.push(Impact { contact: j, impulse });
}

fn joint_impact<S: Scalar>(masses: &[S], v: &mut [S], e: S, run: std::ops::Range<usize>, outcome: &mut Outcome<S>) {
    let balls = run.start..run.end + 1;
    let before = v[balls.clone()].to_vec();
    let all = pool(&masses[balls.clone()], &before, |_, _| true);
    let centre = all[0].mean;
    v[balls.clone()].iter_mut().for_each(|v| *v = centre - e * (*v - centre));
    let half_loss = S::from(0.5) * (S::from(1.0) - e);
    transmit(&masses[balls.clone()], &before, &v[balls], |contact, impulse| {
        outcome.loss += half_loss * impulse * (before[contact] - before[contact + 1]);
        outcome.impacts.push(Impact { contact: run.start + contact, impulse });
    });
}

/// Balls that still approach come to rest against each other.
fn stick<S: Scalar>(masses: &[S], v: &mut [S], outcome: &mut Outcome<S>) {
    for block in pool(masses, v, |_, approach| approach.value() > 0.0) {
        let balls = block.start..block.end;
        let before = v[balls.clone()].to_vec();
        v[balls.clone()].fill(block.mean);
        transmit(&masses[balls.clone()], &before, &v[balls], |contact, impulse| {
            outcome.loss += S::from(0.5) * impulse * (before[contact] - before[contact + 1]);
            outcome.impacts.push(Impact { contact: block.start + contact, impulse });
        });
    }
}

/// The impulse of each contact, from the changes of the velocities.
fn transmit<S: Scalar>(masses: &[S], before: &[S], after: &[S], mut through: impl FnMut(usize, S)) {
    let mut impulse = S::default();
    for contact in 0..masses.len() - 1 {
        impulse += masses[contact] * (before[contact] - after[contact]);
        through(contact, impulse);
    }
}
