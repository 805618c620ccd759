//! Drives a run: flight, collision phases, events and the ledger of pulses.

use crate::model::{Inputs, Parameters};

/// Time given for "never" where an event lies ahead, s.
pub const NEVER: f64 = 1e30;

/// One finished contact pulse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// Index of the contact, from 0.
    pub contact: usize,
    /// When the contact closed, s.
    pub onset: f64,
    /// When it opened again, s.
    pub release: f64,
    /// Largest contact force, N.
    pub peak: f64,
    /// Integral of the contact force, N.s.
    pub impulse: f64,
}

/// A run that cannot go on, with the time and the values that stopped it.
#[derive(Clone, Debug, PartialEq)]
pub enum EngineError {
    /// A state became infinite or NaN.
    NotFinite { time: f64, ball: usize },
    /// No progress in time: the step shrank below the resolution of the clock.
    Stalled { time: f64, contact: usize },
}

impl std::fmt::Display for EngineError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotFinite { time, ball } => write!(f, "the state of ball {} is not finite at t = {time} s", ball + 1),
            Self::Stalled { time, contact } => write!(f, "no progress in contact {} at t = {time} s", contact + 1),
        }
    }
}

impl std::error::Error for EngineError {}

/// Work counters since the start; they saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Integration steps accepted in contact phases.
    pub steps: u64,
    /// Evaluations of the contact forces (of their Taylor series, where the method uses them).
    pub evaluations: u64,
    /// Onsets, releases and switchings of contact laws handled.
    pub events: u64,
}

/// A cradle and its trajectory up to the current time.
#[derive(Clone, Debug)]
pub struct Engine {
    time: f64,
    n: usize,
}

#[allow(unused_variables)]
impl Engine {
    /// Starts a run at `start_time` (s) with the start values of `parameters`.
    pub fn new(parameters: &Parameters, inputs: &Inputs, start_time: f64) -> Result<Self, EngineError> {
        Ok(Self { time: start_time, n: parameters.balls() })
    }
    /// Current time, s.
    pub fn time(&self) -> f64 {
        self.time
    }
    /// From the current time on, `inputs` act. No change of the trajectory if they are the ones that act already.
    pub fn hold(&mut self, inputs: &Inputs) -> Result<(), EngineError> {
        Ok(())
    }
    /// From the current time on, the drag and contact damping of `parameters` (the tunable ones) act.
    pub fn retune(&mut self, parameters: &Parameters) -> Result<(), EngineError> {
        Ok(())
    }
    /// Moves the current time to `time` (s, later than the current one); pulses that finish on the way are appended
    /// to `pulses` in the order of their release. The values "over the last step" refer to this call.
    pub fn advance(&mut self, time: f64, pulses: &mut Vec<Pulse>) -> Result<(), EngineError> {
        self.time = time;
        Ok(())
    }
    /// First onset strictly after the current time, s; [`NEVER`] if there is none.
    pub fn next_onset(&self) -> f64 {
        NEVER
    }
    /// Position of ball `i`, m.
    pub fn x(&self, i: usize) -> f64 {
        0.0
    }
    /// Velocity of ball `i`, m/s.
    pub fn v(&self, i: usize) -> f64 {
        0.0
    }
    /// Acceleration of ball `i`, m/s2.
    pub fn a(&self, i: usize) -> f64 {
        0.0
    }
    /// Force in contact `i`, N.
    pub fn force(&self, i: usize) -> f64 {
        0.0
    }
    /// Overlap of contact `i`, m; negative while apart.
    pub fn overlap(&self, i: usize) -> f64 {
        0.0
    }
    /// Whether the overlap of contact `i` is positive.
    pub fn in_contact(&self, i: usize) -> bool {
        false
    }
    /// Integral of the force in contact `i` since the start, N.s.
    pub fn impulse(&self, i: usize) -> f64 {
        0.0
    }
    /// Mean of the force in contact `i` over the last step, N.
    pub fn force_mean(&self, i: usize) -> f64 {
        0.0
    }
    /// Largest force in contact `i` in the last step, N; 0 if the contact was open throughout.
    pub fn force_peak(&self, i: usize) -> f64 {
        0.0
    }
    /// Onsets of contact `i` so far.
    pub fn pulses(&self, i: usize) -> u64 {
        0
    }
    /// Last onset of contact `i`, s; -1e30 before the first.
    pub fn last_onset(&self, i: usize) -> f64 {
        -NEVER
    }
    /// Last release of contact `i`, s; -1e30 before the first.
    pub fn last_release(&self, i: usize) -> f64 {
        -NEVER
    }
    /// Kinetic energy of ball `i`, J.
    pub fn kinetic_energy(&self, i: usize) -> f64 {
        0.0
    }
    /// Energy of ball `i` in the field of gravity, J.
    pub fn gravity_energy(&self, i: usize) -> f64 {
        0.0
    }
    /// Elastic energy of contact `i`, J.
    pub fn contact_energy(&self, i: usize) -> f64 {
        0.0
    }
    /// Kinetic, gravity and contact energy of all, J.
    pub fn total_energy(&self) -> f64 {
        0.0
    }
    /// Energy dissipated by drag and contacts since the start, J.
    pub fn dissipated_energy(&self) -> f64 {
        0.0
    }
    /// Work of the external forces and of the support's acceleration since the start, J.
    pub fn external_work(&self) -> f64 {
        0.0
    }
    /// `total + dissipated - external - total at the start`, J: the engine's own energy error.
    pub fn energy_residual(&self) -> f64 {
        0.0
    }
    /// Sum of `m v`, kg.m/s.
    pub fn momentum(&self) -> f64 {
        0.0
    }
    /// Horizontal force on the support, N.
    pub fn support_force(&self) -> f64 {
        0.0
    }
    /// Mean of the force on the support over the last step, N.
    pub fn support_force_mean(&self) -> f64 {
        0.0
    }
    /// Work counters since the start.
    pub fn work(&self) -> Work {
        Work::default()
    }
}
