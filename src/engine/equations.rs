//! The equations of motion, with contacts that act by flags, in doubles and dual numbers.

use std::ops::Deref;

use serde::{Deserialize, Serialize};

use crate::model::{BallModel, Chain, Cradle, Mode};
use crate::solver::Scalar;

/// A chain in a state, with its forces.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct State<S = f64> {
    #[serde(skip)]
    pub(crate) cradle: Cradle<S>,
    /// Flags of the contacts, which change only in events.
    pub(crate) modes: Vec<Mode>,
    /// For each contact, whether its right ball is [beyond](crate::model::Pair::is_beyond) the line from the left
    /// centre to the right pivot. An overlap fits two places of the right ball, one on either side of that line; the
    /// ball stays on the side where it starts.
    #[serde(skip)]
    pub(crate) beyond: Vec<bool>,
    /// Positions (m) and velocities (m/s) along the paths, and overlaps (m).
    #[serde(skip)]
    pub(crate) x: Vec<S>,
    #[serde(skip)]
    pub(crate) v: Vec<S>,
    #[serde(skip)]
    pub(crate) overlaps: Vec<S>,
    /// Accelerations by the inputs, m/s2.
    #[serde(skip)]
    pub(crate) forcings: Vec<S>,
    #[serde(skip)]
    pub(crate) forces: Vec<S>,
}

impl<S: Scalar> State<S> {
    /// The state with these flags, positions and velocities along the paths, overlaps, and accelerations by the inputs.
    pub fn at(cradle: Cradle<S>, modes: Vec<Mode>, [x, v, overlaps]: [Vec<S>; 3], forcings: Vec<S>) -> Self {
        let mut state = Self { cradle, modes, beyond: Vec::new(), x, v, overlaps, forcings, forces: Vec::new() };
        state.forces = if state.cradle.rigid {
            state.constraint_forces()
        } else {
            (0..state.modes.len()).map(|j| state.contact_force(j)).collect()
        };
        state
    }

    /// The state from a host's state vector `y`, in the order of [`Exchange`](super::Exchange). A position follows from
    /// its left neighbour's, the overlap and the clearance; on arcs along the paths.
    pub(crate) fn new(cradle: Cradle<S>, (modes, beyond): (Vec<Mode>, Vec<bool>), y: &[S], forcings: Vec<S>) -> Self {
        let n = cradle.balls.len();
        let (overlaps, v) = (y[1..n].to_vec(), y[n..2 * n].to_vec());
        let mut x = Vec::with_capacity(n);
        let (mut place, _) = cradle.balls[0].along_path(y[0], S::default());
        x.push(place);
        for (j, (overlap, beyond)) in overlaps.iter().zip(&beyond).enumerate() {
            place = cradle.pair(j).place_beside(place, *overlap, *beyond);
            x.push(place);
        }
        let along = |((ball, x), v): ((&BallModel<S>, &S), &S)| *v / ball.place(*x).cos;
        let v = cradle.balls.iter().zip(&x).zip(&v).map(along).collect();
        Self { beyond, ..Self::at(cradle, modes, [x, v, overlaps], forcings) }
    }

    /// Force of a pressing contact, N. If it has yet to open although its overlap has vanished, it has no elastic
    /// force.
    fn contact_force(&self, j: usize) -> S {
        if self.modes[j] != Mode::Pressing {
            return S::default();
        }
        let overlap = self.overlaps[j];
        let overlap = if overlap.value() > 0.0 { overlap } else { S::from(f64::MIN_POSITIVE) };
        let rate = self.cradle.pair(j).overlap_rate([j, j + 1].map(|i| (self.x[i], self.v[i])));
        self.cradle.contacts[j].unclipped_force(overlap, rate)
    }

    /// Constraint forces, N, that give balls joined by closed rigid contacts one acceleration.
    fn constraint_forces(&self) -> Vec<S> {
        let Self { cradle, modes, .. } = self;
        let mut forces = vec![S::default(); modes.len()];
        let free = |i: usize| match cradle.balls[i].on_arc {
            // The pendulums are equal: only the forcing differs.
            true => self.forcings[i],
            false => cradle.balls[i].acceleration(self.x[i], self.v[i], S::default(), self.forcings[i]),
        };
        let closed: Vec<usize> = (0..modes.len()).filter(|&j| modes[j] != Mode::Open).collect();
        for run in closed.chunk_by(|left, right| left + 1 == *right) {
            let balls = run[0]..run[0] + run.len() + 1;
            let own: Vec<S> = balls.clone().map(free).collect();
            let masses = || cradle.balls[balls.clone()].iter().map(|ball| ball.mass);
            // Relative to the first ball, so that common parts cancel.
            let moment: S = masses().zip(&own).map(|(mass, a)| mass * (*a - own[0])).sum();
            let mean = moment / masses().sum();
            let mut force = S::default();
            for (j, (mass, a)) in run.iter().zip(masses().zip(&own)) {
                force += mass * ((*a - own[0]) - mean);
                forces[*j] = force;
            }
        }
        forces
    }
}

/// Anything that holds a state is a chain.
impl<S: Scalar, T: Deref<Target = State<S>>> Chain<S> for T {
    fn cradle(&self) -> &Cradle<S> {
        &self.cradle
    }

    fn state_of(&self, i: usize) -> (S, S) {
        (self.x[i], self.v[i])
    }

    fn forcing_of(&self, i: usize) -> S {
        self.forcings[i]
    }

    fn overlap(&self, i: usize) -> S {
        self.overlaps[i]
    }

    fn force(&self, i: usize) -> S {
        self.forces[i]
    }

    fn in_contact(&self, i: usize) -> bool {
        self.modes[i] != Mode::Open
    }

    /// An open contact has no energy, whatever its overlap.
    fn elastic_overlap(&self, i: usize) -> S {
        if self.modes[i] == Mode::Open { S::default() } else { self.overlaps[i] }
    }
}
