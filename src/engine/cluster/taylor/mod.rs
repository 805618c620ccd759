//! Power series of the motions and forces of a window.
//!
//! [`Series`] holds the coefficients and is its own dense output; [`Workspace`] computes them, by the recurrences of the
//! equations right after a switching (`recurrences`), by those of a higher order and with less arithmetic where balls have long
//! been pressed together (`persistent`). Collocation fills in a [`Series`], too.

mod persistent;
mod recurrences;
mod series;

pub(super) use recurrences::velocity_scale;
pub(crate) use series::Series;

/// Memory of the expansions, which a copy does without.
#[derive(Debug, Default)]
pub(super) struct Workspace {
    pub recurrences: recurrences::Workspace,
    pub persistent: persistent::Workspace,
}

impl Clone for Workspace {
    fn clone(&self) -> Self {
        Self::default()
    }
}
