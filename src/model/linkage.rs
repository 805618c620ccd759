//! How the overlap of two neighbours and the direction of their contact depend on places and lengths.

use super::arc::{Line, Pair, Place};

/// Directions of a contact, with derivatives of them and of the overlap.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Linkage {
    /// Components, along the two paths, of the unit vector from the left centre to the right one.
    pub along: [f64; 2],
    /// Derivatives of the overlap and of these components by the two places, the two lengths and the distance of the
    /// pivots.
    pub by: [[f64; 5]; 3],
}

impl Linkage {
    /// The linkage of balls on a line.
    pub const STRAIGHT: Self = Self { along: [1.0; 2], by: [[1.0, -1.0, 0.0, 0.0, 0.0], [0.0; 5], [0.0; 5]] };
}

impl Pair<'_> {
    /// The linkage at these places.
    pub fn linkage(&self, places: [f64; 2]) -> Linkage {
        if !self.balls[0].on_arc {
            return Linkage::STRAIGHT;
        }
        let at = [0, 1].map(|k| self.balls[k].place(places[k]));
        let [width, height] = self.distances(places);
        let distance = (width * width + height * height).sqrt();
        let (cos, sin, line) = (width / distance, height / distance, Line::new(&at[0], &at[1], self.law.pivots));
        let (along, outward) = (at.each_ref().map(|place| line.along(place)), at.each_ref().map(|at| line.outward(at)));
        let angles = [0, 1].map(|k| places[k] / self.balls[k].length);
        // A longer pendulum moves its ball along the line of centres and across it.
        let [left, right] = [0, 1].map(|k| {
            let Place { y, sin: s, cos: c, .. } = at[k];
            let [x, y] = [s - angles[k] * c, y / self.balls[k].length - angles[k] * s];
            [cos * x + sin * y, cos * y - sin * x]
        });
        let turned = [-outward[0], outward[1], -left[1], right[1], -sin].map(|across| across / distance);
        let of_pivots = height * sin / (distance + width);
        let mut by = [[along[0], -along[1], left[0], -right[0], of_pivots], [0.0; 5], [0.0; 5]];
        for k in 0..2 {
            by[1 + k] = turned.map(|turned| outward[k] * turned);
            by[1 + k][k] -= outward[k] / self.balls[k].length;
            by[1 + k][2 + k] += outward[k] * angles[k] / self.balls[k].length;
        }
        Linkage { along, by }
    }
}
