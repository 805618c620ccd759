//! The physics of the cradle in SI units, independent of FMI and numerical methods, in doubles and dual numbers.

mod arc;
mod contact;
mod cradle;
mod damping;
mod enumeration;
mod forces;
mod impact;
mod linkage;
mod losses;
mod parameters;
mod results;
mod start;

pub(crate) use arc::{Pair, overlap_of_approach};
pub use contact::{ContactLaw, Mode, SignOfForce};
pub use cradle::{BallModel, Cradle, hertz_stiffness};
pub use damping::{Damping, Growth};
pub use enumeration::Item;
pub(crate) use enumeration::enumerations;
pub(crate) use linkage::Linkage;
pub use parameters::{
    ContactModel, DampingLaw, ExchangedContacts, Inputs, Parameters, PendulumModel, SolverMethod, Tunables,
};
pub use results::{
    Chain, Differential, MAX_INPUT_DERIVATIVE, MAX_OUTPUT_DERIVATIVE, ONSET_PERIODS, Record, Results, WorkCounters,
};
pub(crate) use start::check_start;
