//! The state of the whole chain at one time.

use crate::engine::cluster::{Equations, OverlapSeries, Series};
use crate::engine::flight::Forcing;
use crate::model::algebraic::Chain;
use crate::model::{BallModel, ContactLaw, Cradle, Mode};
use crate::solver::dual::Scalar;

/// Positions (m), velocities (m/s), overlaps (m) and modes of a chain at one time: all that its motion depends on but
/// the inputs.
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

impl<S: Scalar> ChainEquations<'_, S> {
    /// The series of all motions and forces with `order` coefficients of the forces, in this unit of time (s). Contacts
    /// marked as `negligible` have no elastic force. Overlaps that are `given`, in that unit, are taken as they are;
    /// the forces follow from them.
    pub fn series(
        &self,
        order: usize,
        unit: f64,
        negligible: impl Fn(usize) -> bool,
        given: &[Option<OverlapSeries<S>>],
    ) -> Series<S> {
        let mut series = Series::default();
        series.begin(self, order, unit);
        let given = |j: usize| given.get(j).and_then(Option::as_ref);
        for j in 0..self.cradle.contacts.len() {
            if let Some(given) = given(j) {
                let at = j * series.stride();
                series.overlaps[at..at + given.len()].copy_from_slice(given);
            }
        }
        series.fill(self, &mut vec![Vec::new(); self.cradle.contacts.len()], negligible, |j| given(j).is_some());
        series
    }
}
