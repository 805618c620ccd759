//! Power series of the motions and forces of a window.
//!
//! [`Series`] holds the coefficients and is its own dense output. They follow by the recurrences of the equations
//! (`recurrences`, with `arcs` for the geometry of balls on arcs); with less arithmetic and to a higher order where
//! contacts are linear (`linear`). Implicit collocation fills in a [`Series`], too.

mod arcs;
mod linear;
mod recurrences;
mod series;

pub(super) use linear::Workspace;
pub(crate) use recurrences::velocity_scale;
pub(super) use series::integrate;
pub(crate) use series::{INVERSE_FACTORIAL, Series};
