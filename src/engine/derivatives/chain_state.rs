//! The state of the whole chain at one time.

use crate::engine::cluster::{Equations, OverlapSeries, Series};
use crate::engine::flight::Forcing;
use crate::model::algebraic::Chain;
use crate::model::{BallModel, ContactLaw, Cradle, MAX_OUTPUT_DERIVATIVE, Mode};
use crate::solver::dual::Scalar;

/// Positions (m), velocities (m/s), overlaps (m) and modes of a chain at one time, which with the inputs determine its
/// motion.
#[derive(Clone, Debug, Default)]
pub(crate) struct ChainState<S = f64> {
    pub x: Vec<S>,
    pub v: Vec<S>,
    pub overlaps: Vec<S>,
    pub modes: Vec<Mode>,
}

/// The equations of a whole chain in a state, with the accelerations of its balls by the inputs.
#[derive(Clone, Copy)]
pub(crate) struct ChainEquations<'a, S> {
    pub cradle: &'a Cradle<S>,
    pub state: &'a ChainState<S>,
    pub forcings: &'a [Forcing<S>],
}

impl<S: Scalar> Equations<S> for ChainEquations<'_, S> {
    fn balls(&self) -> usize {
        self.cradle.balls.len()
    }

    fn ball(&self, i: usize) -> BallModel<S> {
        self.cradle.balls[i]
    }

    fn position(&self, i: usize) -> S {
        self.state.x[i]
    }

    fn velocity(&self, i: usize) -> S {
        self.state.v[i]
    }

    fn forcing(&self, i: usize) -> &Forcing<S> {
        &self.forcings[i]
    }

    fn law(&self, j: usize) -> &ContactLaw<S> {
        &self.cradle.contacts[j]
    }

    fn overlap(&self, j: usize) -> S {
        self.state.overlaps[j]
    }

    fn mode(&self, j: usize) -> Mode {
        self.state.modes[j]
    }
}

impl<S: Scalar> Chain<S> for ChainEquations<'_, S> {
    fn cradle(&self) -> &Cradle<S> {
        self.cradle
    }

    fn state_of(&self, i: usize) -> (S, S) {
        (self.state.x[i], self.state.v[i])
    }

    fn overlap_of(&self, j: usize) -> S {
        self.state.overlaps[j]
    }

    fn force_of(&self, j: usize) -> S {
        match self.state.modes[j] {
            Mode::Pressing => self.cradle.contacts[j].unclipped_force(self.state.overlaps[j], self.overlap_rate(j)),
            Mode::Open | Mode::Clipped => S::default(),
        }
    }

    fn forcing_of(&self, i: usize) -> S {
        self.forcings[i][0]
    }
}

impl ChainEquations<'_, f64> {
    /// The series of all motions and forces, in seconds, for derivatives by time up to the highest order.
    ///
    /// The overlaps of pressing contacts may be `given` by the run's description. By the equations, the acceleration of
    /// an overlap is force over mass minus load: for a contact at rest that is rounding, which each further derivative
    /// multiplies by the angular frequency of the contact, 1e5 1/s.
    pub fn series(&self, given: &[Option<OverlapSeries>]) -> Series {
        let mut series = Series::default();
        series.begin(self, MAX_OUTPUT_DERIVATIVE + 1, 1.0);
        for (j, given) in given.iter().enumerate() {
            if let Some(given) = given {
                let at = j * series.stride();
                series.overlaps[at..at + given.len()].copy_from_slice(given);
            }
        }
        let is_given = |j: usize| given.get(j).is_some_and(Option::is_some);
        series.fill(self, &mut vec![Vec::new(); self.cradle.contacts.len()], |_| false, is_given);
        series
    }
}
