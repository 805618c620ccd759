//! Orders of magnitude, for the host's tolerances and for the shifts of indicators.

use serde::{Deserialize, Serialize};

use crate::engine::equations::State;
use crate::model::{ContactLaw, Cradle};

/// Number of continuous states; [`Exchange`](super::Exchange) lists them.
pub const fn state_count(balls: usize) -> usize {
    3 * balls + 1
}

/// Slowest nominal speed (m/s), and that of a cradle at rest.
const LEAST_SPEED: f64 = 1e-9;
const SPEED_AT_REST: f64 = 1e-3;

/// Shift of an indicator over the nominal overlap or force.
pub(super) const SHIFT: f64 = 1e-6;

/// Orders of magnitude at the energy of the start. All are positive.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Scales {
    /// Nominal values of the states, in their order.
    pub nominals: Vec<f64>,
    /// Scale of all velocities, m/s.
    pub speed: f64,
    /// Scales of the contact forces, N.
    pub forces: Vec<f64>,
}

/// The scale, made positive and finite, with room for a host's operations.
fn bounded(scale: f64) -> f64 {
    if scale.is_nan() { 1.0 } else { scale.clamp(1e-150, 1e150) }
}

impl Scales {
    /// From the scale of the [speeds in reach](Cradle::speed_in_reach) of the balls in `state`.
    pub fn new(state: &State) -> Self {
        let cradle = &state.cradle;
        let Cradle { balls, contacts, .. } = cradle;
        let motion = [&state.x[..], &state.v, &state.overlaps];
        let fastest = cradle.speed_in_reach(motion, |i| state.forcings[i]);
        let speed = bounded(if fastest > 0.0 { fastest.max(LEAST_SPEED) } else { SPEED_AT_REST });
        let unit = balls[0].unit_of_time();
        let heaviest = balls.iter().fold(0.0_f64, |most, ball| most.max(ball.mass));
        let rigid = cradle.rigid;
        let compression = |(j, law): (usize, &ContactLaw)| {
            bounded(if rigid { SHIFT * speed * unit } else { law.largest_overlap(cradle.reduced_mass(j), speed) })
        };
        let compressions: Vec<f64> = contacts.iter().enumerate().map(compression).collect();
        let energy = bounded(0.5 * heaviest * speed * speed);
        let mut nominals = Vec::with_capacity(state_count(balls.len()));
        nominals.push(bounded(speed * unit));
        nominals.extend_from_slice(&compressions);
        nominals.extend(balls.iter().map(|_| speed));
        nominals.extend((0..contacts.len()).map(|j| bounded(2.0 * cradle.reduced_mass(j) * speed)));
        nominals.extend([energy, energy]);
        let force = |(j, law): (usize, &ContactLaw)| {
            bounded(if rigid { cradle.reduced_mass(j) * speed / unit } else { law.elastic_force(compressions[j]) })
        };
        let forces = contacts.iter().enumerate().map(force).collect();
        Self { nominals, speed, forces }
    }

    pub fn are_sound(&self, balls: usize) -> bool {
        let sound = |scale: &f64| *scale > 0.0 && scale.is_finite();
        let lengths = self.nominals.len() == state_count(balls) && self.forces.len() + 1 == balls;
        lengths && self.nominals.iter().chain(&self.forces).chain([&self.speed]).all(sound)
    }

    /// Nominal overlap of contact `j`, m.
    pub fn overlap(&self, j: usize) -> f64 {
        self.nominals[1 + j]
    }

    /// Shift of the indicator of contact `j`, m. Without it the indicator of balls at rest in touch would be 0.
    pub fn shift(&self, j: usize) -> f64 {
        SHIFT * self.overlap(j)
    }
}
