//! Running integrals of a ball.

use serde::{Deserialize, Serialize};

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct RunningIntegrals {
    /// Integral of the position, m.s; on an arc that of the acceleration by the inputs, m/s.
    pub x_integral: f64,
    /// Energy lost to drag, J.
    pub drag_loss: f64,
    /// Work of the inputs, J.
    pub work: f64,
}

impl RunningIntegrals {
    pub fn is_finite(&self) -> bool {
        [self.x_integral, self.drag_loss, self.work].iter().all(|value| value.is_finite())
    }

    pub fn add(&mut self, more: &Self) {
        self.x_integral += more.x_integral;
        self.drag_loss += more.drag_loss;
        self.work += more.work;
    }
}
