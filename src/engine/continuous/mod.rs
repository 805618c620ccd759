//! General-purpose solvers that integrate the whole chain over all time: `bdf`, `adams` and `rk4`. See "The other
//! methods" in docs/theory.md.
//!
//! `bdf` and `adams` (`multistep`) do not restart where contacts switch, but pass the kinks with steps that their error
//! control shortens. Changed inputs or tunable parameters restart them at the current time.

mod corrector;
mod dynamics;
mod multistep;
mod observe;
mod path;
mod run;
mod runge_kutta;
mod trajectory;

pub use run::Continuous;
