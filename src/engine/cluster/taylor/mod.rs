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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::cluster::dense_output::DenseOutput;
    use crate::engine::cluster::step_control::Control;
    use crate::engine::cluster::window::{Window, WindowContact};
    use crate::engine::flight::{Ball, Flight};
    use crate::model::{BallModel, ContactLaw, Damping, Mode};
    use crate::solver::double_double::DoubleDouble;

    /// A ball strikes another one while it is pulled back. The series of a force that is left out end before it matters, although the
    /// balls are as fast much later as if it never did.
    #[test]
    fn a_force_that_is_left_out_is_not_left_out_for_good() {
        for (exponent, speed, pull) in [(9.9, 0.1, 1e4), (1.05, 0.1, 1e6), (1.8, 1e-4, 1.0), (3.7, 1e-2, 1e2)] {
            let flights = [(speed, -pull), (0.0, 0.0)].map(|(v, a)| Flight { x: 0.0, v, forcing: [a, 0.0, 0.0, 0.0] });
            let model = BallModel { mass: 1.0, omega2: 0.0, gamma: 0.0 };
            let balls = flights.map(|flight| Ball::new(&model, DoubleDouble::from(0.0), flight));
            let contacts = [WindowContact { overlap: 0.0, mode: Mode::Pressing }];
            let law =
                ContactLaw { stiffness: 1e10, overlap_ref: 1e-6, exponent, clearance: 0.0, damping: Damping::None };
            let window = Window { flights: &flights, balls: &balls, contacts: &contacts, laws: &[law] };
            let scale = velocity_scale(&window);
            let mut series = Series::default();
            series.expand_lanes(&mut lanes::Workspace::default(), &window, &Control::new(1e-12), scale);
            let end = series.converges_for();
            let change = law.elastic_force(series.overlap(0, end).0) * end;
            assert!(
                end > 0.0 && end < speed / pull && change < 1e-12 * scale,
                "p = {exponent}: {end:e} s, {change:e} m/s"
            );
        }
    }
}
