//! What a run shows at its current time, and derivatives of that.

use serde::{Deserialize, Serialize};

use crate::next::Next;

/// Periods of the first ball within which the next onset is looked for.
pub const ONSET_PERIODS: f64 = 1000.0;

/// Highest derivative of an input that is taken into account.
pub const MAX_INPUT_DERIVATIVE: usize = 3;

/// Highest derivative by time that is offered.
pub const MAX_OUTPUT_DERIVATIVE: usize = 3;

/// A run at its current time. Balls and contacts are counted from 0; contact `i` is that of balls `i` and `i + 1`.
pub trait Results {
    /// Position of ball `i` from its rest position, relative to the support, m.
    fn x(&self, i: usize) -> f64;
    /// Velocity of ball `i` relative to the support, m/s.
    fn v(&self, i: usize) -> f64;
    /// Angle of pendulum `i`, rad.
    fn angle(&self, i: usize) -> f64;
    /// Height of ball `i` above its rest position, m.
    fn y(&self, i: usize) -> f64;
    /// Acceleration of ball `i` relative to the support, m/s2.
    fn a(&self, i: usize) -> f64;
    /// Force of contact `i`, pushing its balls apart, N.
    fn force(&self, i: usize) -> f64;
    /// Overlap of contact `i`, m; negative while apart.
    fn overlap(&self, i: usize) -> f64;
    /// Rate of that overlap, m/s.
    fn overlap_rate(&self, i: usize) -> f64;
    /// Whether the balls of contact `i` overlap.
    fn in_contact(&self, i: usize) -> bool;
    /// Integral of the force of contact `i` since the start, N.s.
    fn impulse(&self, i: usize) -> f64;
    /// Mean force of contact `i` over the last step, N.
    fn force_mean(&self, i: usize) -> f64;
    /// Largest force of contact `i` in the last step, N.
    fn force_peak(&self, i: usize) -> f64;
    /// Onsets of contact `i` so far.
    fn pulses(&self, i: usize) -> u64;
    /// Last onset of contact `i`, s; minus [`NEVER`](crate::next::NEVER) before the first.
    fn last_onset(&self, i: usize) -> f64;
    /// Last release of contact `i`, s; minus [`NEVER`](crate::next::NEVER) before the first.
    fn last_release(&self, i: usize) -> f64;
    /// Kinetic energy of ball `i`, J.
    fn kinetic_energy(&self, i: usize) -> f64;
    /// Energy of ball `i` in the field of gravity, J.
    fn gravity_energy(&self, i: usize) -> f64;
    /// Elastic energy of contact `i`, J.
    fn contact_energy(&self, i: usize) -> f64;
    /// Kinetic, gravity and contact energy of all balls, J.
    fn total_energy(&self) -> f64;
    /// Energy dissipated by drag and contacts since the start, J.
    fn dissipated_energy(&self) -> f64;
    /// Power dissipated by drag and contacts at this instant, W.
    fn dissipation(&self) -> f64;
    /// Work of the external forces and of the moving support since the start, J.
    fn external_work(&self) -> f64;
    /// Power of these at this instant, W.
    fn external_power(&self) -> f64;
    /// The energy error since the start, J.
    fn energy_residual(&self) -> f64;
    /// Sum of mass times velocity, N.s.
    fn momentum(&self) -> f64;
    /// Horizontal force of the pendulums and the drag on the support, N.
    fn support_force(&self) -> f64;
    /// Vertical force on the support, upwards, N: minus the weight of the balls while they hang at rest.
    fn support_force_vertical(&self) -> f64;
    /// Mean of the horizontal force over the last step, N.
    fn support_force_mean(&self) -> f64;
    /// First onset of any contact strictly after the current time, as far as a bounded amount of work shows it.
    fn next_onset(&self) -> Next;
    /// Work counters since the start.
    fn work(&self) -> WorkCounters;
}

/// Work counters since the start; they saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct WorkCounters {
    /// Integration steps accepted in contact phases.
    pub steps: u64,
    /// Evaluations of the contact forces (of their Taylor series, where the method uses them); a closed form counts as
    /// one.
    pub evaluations: u64,
    /// Onsets, releases and switchings of contact laws handled.
    pub events: u64,
}

/// Derivatives of all real outputs, and of the states of model exchange with their derivatives: by time, of one order,
/// or along one direction in the space of inputs, states and parameters. The units are those of the variables over that
/// of the time or of the direction.
#[derive(Clone, Debug, Default)]
pub struct Differential {
    /// Of the positions.
    pub x: Vec<f64>,
    /// Of the velocities.
    pub v: Vec<f64>,
    /// Of the angles.
    pub angle: Vec<f64>,
    /// Of the heights.
    pub y: Vec<f64>,
    /// Of the contact forces.
    pub force: Vec<f64>,
    /// Of the total energy.
    pub energy: f64,
    /// Of the total momentum.
    pub momentum: f64,
    /// Of the force on the support.
    pub support_force: f64,
    /// Of the vertical one.
    pub support_force_vertical: f64,
    /// Of the time of the next onset.
    pub next_onset: f64,
    /// Of the impulses.
    pub impulse: Vec<f64>,
    /// Of the mean forces over the last step.
    pub force_mean: Vec<f64>,
    /// Of the largest forces in the last step.
    pub force_peak: Vec<f64>,
    /// Of the mean force on the support over the last step.
    pub support_force_mean: f64,
    /// Of the period of the first ball.
    pub period: f64,
    /// Of the overlaps, by directions only.
    pub overlap: Vec<f64>,
    /// Of the rates of the overlaps, likewise.
    pub overlap_rate: Vec<f64>,
    /// Of the accelerations, likewise.
    pub a: Vec<f64>,
    /// Of the energy dissipated, likewise.
    pub dissipated_energy: f64,
    /// Of the power dissipated, likewise.
    pub dissipation: f64,
    /// Of the work of the inputs, likewise.
    pub external_work: f64,
    /// Of the power of the inputs, likewise.
    pub external_power: f64,
}

impl Differential {
    /// No change of anything.
    pub fn zero(balls: usize) -> Self {
        let contacts = vec![0.0; balls.saturating_sub(1)];
        Self {
            x: vec![0.0; balls],
            v: vec![0.0; balls],
            angle: vec![0.0; balls],
            y: vec![0.0; balls],
            a: vec![0.0; balls],
            overlap: contacts.clone(),
            overlap_rate: contacts.clone(),
            force: contacts.clone(),
            impulse: contacts.clone(),
            force_mean: contacts.clone(),
            force_peak: contacts,
            ..Self::default()
        }
    }
}
