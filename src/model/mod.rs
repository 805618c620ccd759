//! The physics of the cradle in SI units, independent of FMI and numerical methods, in doubles and dual numbers.

#[cfg(feature = "engine")]
pub(crate) mod algebraic;
#[cfg(feature = "engine")]
mod arc;
#[cfg(feature = "engine")]
mod contact;
#[cfg(feature = "engine")]
mod cradle;
#[cfg(feature = "engine")]
mod damping;
mod enumeration;
#[cfg(feature = "engine")]
mod forces;
#[cfg(feature = "engine")]
mod impact;
mod parameters;
mod results;

#[cfg(feature = "engine")]
pub(crate) use arc::{Pair, overlap_of_approach};
#[cfg(feature = "engine")]
pub use contact::{ContactLaw, Mode};
#[cfg(feature = "engine")]
pub use cradle::{BallModel, Cradle, hertz_stiffness};
#[cfg(feature = "engine")]
pub use damping::{Damping, SignOfForce};
pub use enumeration::Item;
pub(crate) use enumeration::enumerations;
pub use parameters::{
    ContactModel, DampingLaw, ExchangedContacts, Inputs, Parameters, PendulumModel, SolverMethod, Tunables,
};
pub use results::{Differential, MAX_INPUT_DERIVATIVE, MAX_OUTPUT_DERIVATIVE, ONSET_PERIODS, Results, WorkCounters};
