//! Balls that touch nothing. A ball swings in closed form from its anchor, the time of its last event ([`Ball`],
//! [`Flight`]). The overlap of two balls has a closed form, too, which gives the next onset ([`Separation`]). On an
//! arc, power series take the place of closed forms or, under strong drag, implicit steps (`path`, `approach`,
//! `implicit`).

mod approach;
mod ball;
mod free_motion;
mod implicit;
mod path;
mod separation;

pub(crate) use ball::{Ball, places, start_by_centre};
pub(crate) use free_motion::{Flight, Forcing, Rounding, RunningIntegrals, degree, forcing_at, integral_of, shifted};
pub(crate) use implicit::{
    BallStages, LEAST_ROUNDINGS, PLACE_ITERATIONS, Response, free_acceleration, highest_terms, next_length,
};
pub use path::Fault;
pub(crate) use path::integrals_of_inputs;
pub(crate) use separation::{EVALUATIONS, ROUNDINGS, Separation, forecast, reach};
