//! How the overlap of two neighbours and the direction of their contact change with what they depend on.

use super::arc::Pair;
use super::contact::ContactLaw;
use super::cradle::BallModel;
use crate::solver::dual::{Dual, Scalar};

/// How overlap and directions of a pair depend on its places and lengths.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Linkage {
    /// The parts of the direction from the left to the right one along their paths.
    pub along: [f64; 2],
    /// Derivatives of the overlap and of these parts by the two places, the two lengths and the distance of the pivots.
    pub by: [[f64; 5]; 3],
}

impl Linkage {
    /// On a line.
    pub const STRAIGHT: Self = Self { along: [1.0; 2], by: [[1.0, -1.0, 0.0, 0.0, 0.0], [0.0; 5], [0.0; 5]] };
}

impl Pair<'_> {
    /// The linkage at these places.
    pub fn linkage(&self, places: [f64; 2]) -> Linkage {
        if !self.balls[0].on_arc {
            return Linkage::STRAIGHT;
        }
        let mut linkage = Linkage { along: self.parts_along(places), by: [[0.0; 5]; 3] };
        for number in 0..5 {
            let along = |k: usize, value: f64| Dual::with_tangent(value, if k == number { 1.0 } else { 0.0 });
            let ball =
                |k: usize| BallModel { length: along(2 + k, self.balls[k].length), ..self.balls[k].map(Dual::from) };
            let law = ContactLaw { pivots: along(4, self.law.pivots), ..self.law.map(Dual::from) };
            let (balls, places) = ([ball(0), ball(1)], [along(0, places[0]), along(1, places[1])]);
            let pair = Pair { balls: [&balls[0], &balls[1]], law: &law };
            let [left, right] = pair.parts_along(places);
            for (by, of) in linkage.by.iter_mut().zip([pair.overlap(places), left, right]) {
                by[number] = of.tangent();
            }
        }
        linkage
    }
}
