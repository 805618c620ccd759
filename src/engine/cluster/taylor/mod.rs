//! Power series of the motions and forces of a window.
//!
//! [`Series`] holds the coefficients and is its own dense output; [`Workspace`] computes them, by the recurrences of the
//! equations (`recurrences`), with less arithmetic and to a higher order those of linear contacts (`linear`), of elastic contacts whose
//! exponent is not whole (`lanes`), and of balls that have long been pressed together (`persistent`). Collocation fills in a [`Series`], too.

pub(super) mod lanes;
mod linear;
mod persistent;
mod recurrences;
mod series;

pub(super) use recurrences::velocity_scale;
pub(crate) use series::Series;

/// Memory of the expansions, which a copy does without.
#[derive(Debug, Default)]
pub(super) struct Workspace {
    pub recurrences: recurrences::Workspace,
    pub lanes: lanes::Workspace,
    pub linear: linear::Workspace,
    pub persistent: persistent::Workspace,
}

impl Workspace {
    /// Forgets what is only known of these balls.
    pub fn forget_balls(&mut self) {
        self.persistent = persistent::Workspace::default();
    }
}

impl Clone for Workspace {
    fn clone(&self) -> Self {
        Self::default()
    }
}
