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

macro_rules! differential {
    ($(#[$doc:meta])* balls { $($ball:ident)* } contacts { $($contact:ident)* } sums { $($sum:ident)* }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, Default)]
        pub struct Differential {
            $(#[doc = concat!("Of `", stringify!($ball), "`, for each ball.")] pub $ball: Vec<f64>,)*
            $(#[doc = concat!("Of `", stringify!($contact), "`, for each contact.")] pub $contact: Vec<f64>,)*
            $(#[doc = concat!("Of `", stringify!($sum), "`.")] pub $sum: f64,)*
        }

        impl Differential {
            /// No change of anything.
            pub fn zero(balls: usize) -> Self {
                Self {
                    $($ball: vec![0.0; balls],)*
                    $($contact: vec![0.0; balls.saturating_sub(1)],)*
                    $($sum: 0.0,)*
                }
            }
        }
    };
}

differential! {
    /// Derivatives of the [`Results`] of these names, that is of all real outputs and of the states of model exchange
    /// with their derivatives, of the total `energy`, and of the `period` of the first ball: by time, of one order, or
    /// along one direction in the space of inputs, states and parameters. The units are those of the variables over that
    /// of the time or of the direction. Of `a`, of the overlaps and their rates, and of work, dissipation and power
    /// there are those along directions only.
    balls { x v angle y a }
    contacts { force force_mean force_peak impulse overlap overlap_rate }
    sums {
        energy momentum support_force support_force_mean support_force_vertical next_onset period
        dissipated_energy dissipation external_work external_power
    }
}
