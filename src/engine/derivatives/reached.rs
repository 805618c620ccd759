//! What follows from the state that a motion in dual numbers has reached.

use super::tangent::Run;
use crate::model::algebraic::Chain;
use crate::model::{Cradle, Differential, Mode};
use crate::solver::dual::{Dual, Scalar};

impl Run<'_> {
    /// Derivatives of what follows from the state alone, and of the impulses.
    pub fn outputs(&self) -> Differential {
        let mut outputs = Differential::along(self);
        outputs.impulse = self.impulse.iter().map(|impulse| impulse.tangent()).collect();
        if self.cradle.restitution.is_some() {
            // Of a constraint force there is none.
            let pressing = outputs.force.iter_mut().zip(&self.state.modes).filter(|(_, mode)| **mode == Mode::Pressing);
            pressing.for_each(|(force, _)| *force = f64::NAN);
        }
        outputs
    }
}

impl Chain<Dual> for Run<'_> {
    fn cradle(&self) -> &Cradle<Dual> {
        &self.along
    }

    fn state_of(&self, i: usize) -> (Dual, Dual) {
        (self.state.x[i], self.state.v[i])
    }

    fn overlap_of(&self, i: usize) -> Dual {
        self.state.overlaps[i]
    }

    fn force_of(&self, i: usize) -> Dual {
        match self.state.modes[i] {
            Mode::Pressing => self.along.contacts[i].unclipped_force(self.state.overlaps[i], self.overlap_rate(i)),
            Mode::Open | Mode::Clipped => Dual::default(),
        }
    }

    fn forcing_of(&self, i: usize) -> Dual {
        self.forcings[i][0]
    }
}
