//! Power series of the motions and forces of a window, by the recurrences of the equations. Implicit collocation fills
//! in a [`Series`], too.

mod arcs;
mod recurrences;
mod series;

pub(crate) use recurrences::velocity_scale;
pub(super) use series::integrate;
pub(crate) use series::{INVERSE_FACTORIAL, Series};
