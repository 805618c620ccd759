//! Power series of the motions and forces of a window, by the recurrences of the equations; with less arithmetic and to
//! a higher order where contacts are linear (`linear`). Implicit collocation fills in a [`Series`], too.

mod arcs;
mod linear;
mod recurrences;
mod series;

pub(super) use linear::Workspace;
pub(crate) use recurrences::velocity_scale;
pub(super) use series::integrate;
pub(crate) use series::{INVERSE_FACTORIAL, Series};
