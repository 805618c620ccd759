//! What follows from the state that a motion in dual numbers has reached.

use super::tangent::Run;
use crate::model::algebraic::{self, Chain};
use crate::model::{Cradle, Differential, Mode};
use crate::solver::dual::{Dual, Scalar};

impl Run<'_> {
    /// Derivatives of what follows from the state alone, and of the impulses.
    pub fn outputs(&self) -> Differential {
        let state = &self.state;
        let tangents = |values: &[Dual]| values.iter().map(|value| value.tangent()).collect::<Vec<f64>>();
        let mut outputs = Differential::zero(state.x.len());
        (outputs.x, outputs.v, outputs.impulse) = (tangents(&state.x), tangents(&state.v), tangents(&self.impulse));
        for j in 0..self.cradle.contacts.len() {
            // Of a constraint force there is none.
            let rigid = self.cradle.restitution.is_some() && state.modes[j] == Mode::Pressing;
            outputs.force[j] = if rigid { f64::NAN } else { self.force_of(j).tangent() };
        }
        outputs.overlap = tangents(&state.overlaps);
        outputs.overlap_rate = (0..state.overlaps.len()).map(|j| self.overlap_rate(j).tangent()).collect();
        outputs.a = (0..state.x.len()).map(|i| algebraic::a(self, i).tangent()).collect();
        outputs.dissipation = algebraic::dissipation(self).tangent();
        outputs.external_power = algebraic::external_power(self).tangent();
        outputs.energy = algebraic::total_energy(self).tangent();
        outputs.momentum = algebraic::momentum(self).tangent();
        outputs.support_force = algebraic::support_force(self).tangent();
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
