//! General-purpose solvers that integrate the whole chain over all time: `bdf`, `adams` and `rk4`.
//!
//! They serve for comparison with the event-driven engine and as an independent check. Contacts switch within the
//! right-hand side (`dynamics`); `bdf` and `adams` (`multistep`) do not restart there, but pass the kinks with steps
//! that their error control shortens. Onsets, releases and peaks are read off the polynomials of the steps
//! (`trajectory`).
//!
//! The solver steps past communication points, where results are evaluated on the step, so its steps do not depend on
//! them. Changed inputs or tunable parameters restart it at the current time. A run is plain data: restored, it
//! continues bit-for-bit identically.

mod corrector;
mod dynamics;
mod multistep;
mod observe;
mod path;
mod run;
mod runge_kutta;
mod trajectory;

pub use run::Continuous;
