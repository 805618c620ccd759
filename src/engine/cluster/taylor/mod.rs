//! Power series of the motions and forces of a window.
//!
//! [`Series`] holds the coefficients and is its own dense output; [`Workspace`] computes them, by the recurrences of the
//! equations (`recurrences`), and with less arithmetic and to a higher order those of linear contacts (`linear`). Implicit collocation fills
//! in a [`Series`], too.

mod linear;
mod recurrences;
mod series;

pub(super) use recurrences::velocity_scale;
pub(crate) use series::Series;

/// Memory of the expansions, which a copy does without.
#[derive(Debug, Default)]
pub(super) struct Workspace {
    pub recurrences: recurrences::Workspace,
    pub linear: linear::Workspace,
}

impl Clone for Workspace {
    fn clone(&self) -> Self {
        Self::default()
    }
}
