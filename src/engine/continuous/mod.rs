//! General-purpose solvers that integrate the whole chain over all time: `bdf`, `adams` and `rk4`.
//!
//! They are there for comparison with the event-driven engine and as an independent check of it. Contacts switch within
//! the right-hand side (`dynamics`); `bdf` and `adams` are not started anew there but pass the kinks with steps that
//! their error control makes short enough. Onsets, releases and peaks are read off the polynomials of the steps
//! (`trajectory`) and act on nothing.
//!
//! The solver steps past a communication point, and what is asked for there is evaluated on the step: its steps do not
//! depend on the communication points. Inputs or tunable parameters that change start it anew at the current time. A
//! run is plain data: put down and taken up again it goes on with the same bits.

mod dynamics;
mod observe;
mod run;
mod trajectory;

pub use run::Continuous;
pub(crate) use trajectory::method;
