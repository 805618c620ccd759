//! Parameter sets and reference results that travel in the FMU, so that any host can check itself: FMI-LS-REF, a
//! layered standard of FMI (<https://github.com/modelica/fmi-ls-ref>), as of its version 1.0.0-beta.1.
//!
//! `Case` is a cradle that a host makes of the FMU by setting parameters, `parameter_set` what it has to set, `record`
//! runs the FMU's own binary for what it should get, [`add`] puts all of it into the FMU, and [`check`] runs the binary
//! once more.

mod case;
mod child;
mod files;
mod host;
mod parameter_set;
mod record;

pub use files::{add, beside, check};
pub use record::run;
