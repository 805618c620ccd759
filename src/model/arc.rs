//! Geometry of balls on arcs about their pivots, in doubles and dual numbers; see "Arcs" in docs/theory.md. For balls
//! on a line, the same functions give the linear model. Overlaps are computed without cancellation.

use super::contact::ContactLaw;
use super::cradle::{BallModel, Cradle};
use crate::solver::dual::Scalar;

/// A place on the path of a ball.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place<S = f64> {
    /// Horizontal deflection and height above rest, m.
    pub x: S,
    pub y: S,
    /// Sine and cosine of the angle: (cos, sin) is the direction of the path.
    pub sin: S,
    pub cos: S,
    /// Acceleration by gravity towards rest along the path, divided by g.
    pub restoring: S,
}

impl<S: Scalar> BallModel<S> {
    /// The place at `s` (m) along the path.
    pub(crate) fn place(&self, s: S) -> Place<S> {
        if !self.on_arc {
            let y = S::from(0.5) * s * s / self.length;
            return Place { x: s, y, sin: S::default(), cos: S::from(1.0), restoring: s / self.length };
        }
        let (sin, cos) = (S::from(0.5) * s / self.length).sin_cos();
        let (double, twice) = (S::from(2.0) * sin, self.length * S::from(2.0) * sin);
        let sine = double * cos;
        Place { x: twice * cos, y: twice * sin, sin: sine, cos: (cos - sin) * (cos + sin), restoring: sine }
    }

    /// Gravitational potential energy per unit of mass at `s` (m) along the path, m2/s2.
    pub(crate) fn potential(&self, s: S) -> S {
        if self.on_arc { self.gravity * self.place(s).y } else { S::from(0.5) * (self.omega2 * s * s) }
    }

    /// Acceleration by gravity towards rest at `s` (m) along the path, divided by g.
    pub(crate) fn restoring(&self, s: S) -> S {
        self.place(s).restoring
    }

    /// Length (m) of the chord of a `stretch` (m) of the path.
    pub(crate) fn chord(&self, stretch: S) -> S {
        if !self.on_arc {
            return stretch;
        }
        let (half, _) = (S::from(0.5) * stretch / self.length).sin_cos();
        S::from(2.0) * self.length * half
    }

    /// Acceleration (m/s2) along the path at `s` (m) by gravity and the horizontal `forcing` (m/s2), less its value on
    /// a line.
    pub(crate) fn arc_correction(&self, s: S, forcing: S) -> S {
        if !self.on_arc {
            return S::default();
        }
        let (sin, cos) = (s / self.length).sin_cos();
        forcing * (cos - S::from(1.0)) + self.gravity * (s / self.length - sin)
    }

    /// State along the path (m, m/s) for the horizontal deflection `x` (m, `|x|` < length) and its rate `v` (m/s).
    pub fn along_path(&self, x: S, v: S) -> (S, S) {
        if !self.on_arc {
            return (x, v);
        }
        // The arc tangent keeps all digits near 90 degrees; a step of Newton's method adds the derivative.
        let below = ((self.length - x) * (self.length + x)).sqrt();
        let angle = libm::atan2(x.value(), below.value());
        let (sin, cos) = S::from(angle).sin_cos();
        (self.length * S::from(angle) + (x * cos - below * sin), v * self.length / below)
    }
}

/// Unit vector from the centre of a ball to the centre of the next, on arcs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line<S = f64>([S; 2]);

impl<S: Scalar> Line<S> {
    pub fn new(left: &Place<S>, right: &Place<S>, pivots: S) -> Self {
        let (width, height) = (pivots + (right.x - left.x), right.y - left.y);
        let distance = (width * width + height * height).sqrt();
        Self([width / distance, height / distance])
    }

    /// Component along the path at a place.
    pub fn along(&self, place: &Place<S>) -> S {
        self.0[0] * place.cos + self.0[1] * place.sin
    }

    /// Component away from the pivot of the ball at a place.
    pub fn outward(&self, place: &Place<S>) -> S {
        self.0[0] * place.sin - self.0[1] * place.cos
    }
}

/// Two neighbours and the law of their contact. Places and states are measured along the paths (m, m/s).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair<'a, S = f64> {
    pub balls: [&'a BallModel<S>; 2],
    pub law: &'a ContactLaw<S>,
}

impl<S: Scalar> Cradle<S> {
    /// The balls of contact `j` and its law.
    pub(crate) fn pair(&self, j: usize) -> Pair<'_, S> {
        Pair { balls: [&self.balls[j], &self.balls[j + 1]], law: &self.contacts[j] }
    }
}

impl<S: Scalar> Pair<'_, S> {
    /// Horizontal and vertical displacement (m), right ball less left ball; without cancellation for equal pendulums.
    fn relative_displacement(&self, [l, r]: [S; 2]) -> [S; 2] {
        let [left, right] = self.balls;
        if left.length != right.length {
            let (left, right) = (left.place(l), right.place(r));
            return [right.x - left.x, right.y - left.y];
        }
        let (sin, cos) = (S::from(0.5) * (l + r) / left.length).sin_cos();
        let chord = left.chord(r - l);
        [chord * cos, chord * sin]
    }

    /// Horizontal and vertical distance (m) from the left centre to the right one, on arcs.
    pub fn distances(&self, places: [S; 2]) -> [S; 2] {
        let [width, height] = self.relative_displacement(places);
        [self.law.pivots + width, height]
    }

    /// Overlap, m.
    pub fn overlap(&self, places: [S; 2]) -> S {
        let ContactLaw { pivots, clearance, .. } = *self.law;
        if !self.balls[0].on_arc {
            return places[0] - places[1] - clearance;
        }
        let [width, height] = self.relative_displacement(places);
        let excess = width * (S::from(2.0) * pivots + width) + height * height;
        let distance = (pivots * pivots + excess).sqrt();
        -(excess / (distance + pivots)) - clearance
    }

    /// Components, along the two paths, of the unit vector from the left centre to the right one.
    #[inline]
    pub fn parts_along(&self, places: [S; 2]) -> [S; 2] {
        if self.balls[0].on_arc { self.parts_along_arcs(places) } else { [S::from(1.0); 2] }
    }

    fn parts_along_arcs(&self, [l, r]: [S; 2]) -> [S; 2] {
        let [left, right] = [self.balls[0].place(l), self.balls[1].place(r)];
        let line = Line::new(&left, &right, self.law.pivots);
        [line.along(&left), line.along(&right)]
    }

    /// Components of the [`Line`] along the path of the left (0) or right (1) ball, and away from its pivot.
    pub fn parts_of(&self, side: usize, places: [&Place<S>; 2]) -> [S; 2] {
        if !self.balls[0].on_arc {
            return [S::from(1.0), S::default()];
        }
        let line = Line::new(places[0], places[1], self.law.pivots);
        [line.along(places[side]), line.outward(places[side])]
    }

    /// Rate of the overlap (m/s) in the states `[l, r]`.
    #[inline]
    pub fn overlap_rate(&self, [l, r]: [(S, S); 2]) -> S {
        let [left, right] = self.parts_along([l.0, r.0]);
        l.1 * left - r.1 * right
    }

    /// Acceleration of the overlap (m/s2) in these states, with these accelerations along the paths (m/s2).
    pub fn overlap_acceleration(&self, states: [(S, S); 2], [left, right]: [S; 2]) -> S {
        let [a, b] = self.balls;
        if !a.on_arc {
            return left - right;
        }
        let [(l, u), (r, w)] = states;
        let [width, height] = self.distances([l, r]);
        let [l, r] = [a.place(l), b.place(r)];
        let line = Line::new(&l, &r, self.law.pivots);
        let [out_l, out_r] = [line.outward(&l), line.outward(&r)];
        let across = out_r * w - out_l * u;
        let round = w * w / b.length * out_r - u * u / a.length * out_l;
        let distance = (width * width + height * height).sqrt();
        line.along(&l) * left - line.along(&r) * right + (round - across * across / distance)
    }

    /// Whether the right ball lies beyond the line from the left centre to the right pivot; for one overlap it has a
    /// place on either side. Only balls that swing far out to both sides may be beyond, not those side by side.
    pub fn is_beyond(&self, places: [S; 2]) -> bool {
        self.parts_along(places)[1].value() < 0.0
    }

    /// Place of the right ball (m) for the place `left` and the `overlap` (m), [beyond](Self::is_beyond) that line or
    /// not. NaN if there is none within 90 degrees.
    ///
    /// With the right ball at the angle of the left one, the vector V between the centres has the components l along
    /// the path of the right ball and o away from its pivot. Turned further by an angle whose half has the tangent t,
    /// that ball is at the distance D (law of cosines): `(L - o + c) t^2 + l t + c = 0` with `c = (V^2 - D^2) / (4 L)`.
    pub fn place_beside(&self, left: S, overlap: S, beyond: bool) -> S {
        let Self { balls: [_, ball], law } = self;
        if !ball.on_arc {
            return left - (overlap + law.clearance);
        }
        let [one, two, half] = [1.0, 2.0, 0.5].map(S::from);
        // The right ball starts at the angle of the left one, where equal pendulums keep the distance of their pivots.
        let angle = left / self.balls[0].length;
        let start = ball.length * angle;
        let [width, height] = self.relative_displacement([left, start]);
        let (sin, cos) = angle.sin_cos();
        let along = (law.pivots + width) * cos + height * sin;
        let outward = (law.pivots + width) * sin - height * cos;
        let closer = law.clearance + overlap;
        let excess = width * (two * law.pivots + width) + height * height + closer * (two * law.pivots - closer);
        // The root of the discriminant has the sign of the component along the path at the solution.
        let c = half * half * excess / ball.length;
        let a = ball.length - outward + c;
        let root = (along * along - excess * (one - outward / ball.length) - two * two * c * c).sqrt();
        let root = if beyond { -root } else { root };
        // Without cancellation.
        let tangent = if (along.value() < 0.0) == (root.value() < 0.0) {
            -two * c / (along + root)
        } else {
            (root - along) / (two * a)
        };
        let place = start.value() + 2.0 * ball.length.value() * libm::atan(tangent.value());
        // A step of Newton's method gives the derivatives, and the digits that `excess` lost for unequal pendulums.
        let place = S::from(place);
        let missing = self.overlap([left, place]) - overlap;
        let place = place + missing / self.parts_along([left, place])[1];
        let within = place.value().abs() <= std::f64::consts::FRAC_PI_2 * ball.length.value();
        let found = within && closer.value() < law.pivots.value();
        if found { place } else { S::from(f64::NAN) }
    }
}

impl Pair<'_> {
    /// Whether, on arcs, the centre of one ball is beside the string of the other and on its wrong side.
    pub fn changed_sides(&self, places: [f64; 2]) -> bool {
        let [width, height] = self.distances(places);
        let beyond = |k: usize, side: f64| {
            let (Place { sin, cos, .. }, length) = (self.balls[k].place(places[k]), self.balls[k].length);
            width * cos + height * sin <= 0.0 && (0.0..length).contains(&(side * (width * sin - height * cos)))
        };
        beyond(0, -1.0) || beyond(1, 1.0)
    }

    /// Place of the left ball less the right one's, m; on a line from the overlap, which has more digits.
    pub fn apart(&self, [left, right]: [f64; 2], overlap: f64) -> f64 {
        if self.balls[0].on_arc { left - right } else { overlap + self.law.clearance }
    }

    /// Change of the overlap (m) by `moves` (m) from `places`, with the relative accuracy of the moves.
    #[inline]
    pub fn change_of_overlap(&self, places: [f64; 2], moves: [f64; 2]) -> f64 {
        if self.balls[0].on_arc { self.change_along_arcs(places, moves) } else { moves[0] - moves[1] }
    }

    fn change_along_arcs(&self, places: [f64; 2], moves: [f64; 2]) -> f64 {
        let [left, right] = [0, 1].map(|k| {
            let length = self.balls[k].length;
            let half = 0.5 * moves[k] / length;
            let (chord, (sin, cos)) = (2.0 * length * libm::sin(half), libm::sincos(places[k] / length + half));
            (chord * cos, chord * sin)
        });
        self.change_of_distance(places, [right.0 - left.0, right.1 - left.1])
    }

    /// As [`Self::change_of_overlap`], given the difference `relative` (m) of the moves, left less right. For equal
    /// pendulums the change has the relative accuracy of that difference.
    pub fn change_by_relative(&self, places: [f64; 2], moves: [f64; 2], relative: f64) -> f64 {
        let (ball, apart) = (self.balls[0], places[1] - places[0]);
        if !ball.on_arc {
            return relative;
        }
        if ball.length != self.balls[1].length {
            return self.change_along_arcs(places, moves);
        }
        // The chord between the two places changes its length and turns.
        let half_turn = 0.25 * (moves[0] + moves[1]) / ball.length;
        let before = 0.5 * (places[0] + places[1]) / ball.length;
        let longer = -2.0 * libm::cos(0.5 * (apart - 0.5 * relative) / ball.length) * ball.chord(0.5 * relative);
        let across = 2.0 * ball.chord(apart) * libm::sin(half_turn);
        let ((sin, cos), (sin_end, cos_end)) =
            (libm::sincos(before + half_turn), libm::sincos(before + 2.0 * half_turn));
        self.change_of_distance(places, [longer * cos_end - across * sin, longer * sin_end + across * cos])
    }

    /// Change of the overlap (m) when the horizontal and the vertical distance grow by these amounts (m).
    fn change_of_distance(&self, places: [f64; 2], [wider, higher]: [f64; 2]) -> f64 {
        let [width, height] = self.distances(places);
        let distance = (width * width + height * height).sqrt();
        let excess = wider * (2.0 * width + wider) + higher * (2.0 * height + higher);
        -excess / ((distance * distance + excess).sqrt() + distance)
    }
}

/// Overlap of two neighbours (m), its rate (m/s) and acceleration (m/s2), from the value and derivatives of
/// `G = (touch^2 - D^2) / (2 touch)`, where `touch` (m) is the distance of the centres at first contact.
pub(crate) fn overlap_of_approach<S: Scalar>([g, rate, acceleration]: [S; 3], touch: S) -> [S; 3] {
    let (one, two) = (S::from(1.0), S::from(2.0));
    let q = (one - two * g / touch).sqrt();
    [two * g / (one + q), rate / q, acceleration / q + rate * rate / (touch * q * q * q)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Parameters, PendulumModel};
    use crate::solver::Dual;

    /// Two pendulums of these lengths (m) with balls of radius 0.03 m.
    fn cradle(lengths: [f64; 2]) -> Cradle {
        let mut p = Parameters { pendulum: PendulumModel::Circular, ..Parameters::default_for(2) };
        (p.length, p.length_ratio, p.radius) = (1.0, lengths.to_vec(), 0.03);
        Cradle::new(&p)
    }

    /// Checks equal and unequal pendulums at angles (rad) from side by side to far out, some of them beyond.
    fn each(mut check: impl FnMut(&Pair, [f64; 2], bool)) {
        let angles = [-1.48, -0.7, -1e-3, -1e-9, 0.0, 1e-6, 0.02, 0.9, 1.48];
        for lengths in [[1.0; 2], [0.5, 2.0], [2.0, 0.5], [1.0, 1.01]] {
            let cradle = cradle(lengths);
            for (left, right) in angles.into_iter().flat_map(|left| angles.map(|right| (left, right))) {
                let (pair, places) = (cradle.pair(0), [left * lengths[0], right * lengths[1]]);
                if pair.parts_along(places)[1].abs() > 0.02 {
                    check(&pair, places, pair.is_beyond(places));
                }
            }
        }
    }

    #[test]
    fn arc_position_follows_from_a_neighbour_and_the_overlap() {
        let mut beyond_some = false;
        each(|pair, [left, right], beyond| {
            let overlap = pair.overlap([left, right]);
            let (found, part) = (pair.place_beside(left, overlap, beyond), pair.parts_along([left, right])[1].abs());
            let off = (found - right).abs() / left.abs().max(right.abs()).max(overlap.abs());
            assert!(off <= 8.0 * f64::EPSILON / part, "{left} {right}: {found}, off by {off:e}");
            let other = pair.place_beside(left, overlap, !beyond);
            assert!(other.is_nan() || (other - right).abs() > 1e-6, "{left} {right}: {other}");
            beyond_some |= beyond;
        });
        assert!(beyond_some);
    }

    #[test]
    fn arc_position_beyond_90_degrees_or_out_of_reach_does_not_exist() {
        let cradle = cradle([1.0, 0.5]);
        let pair = cradle.pair(0);
        // Centres closer than 0 apart, and distances too short and too long for the arc.
        for (left, overlap) in [(0.0, 0.0601), (-0.9, 0.05), (0.0, -1.2)] {
            assert!(pair.place_beside(left, overlap, false).is_nan(), "{left} {overlap}");
        }
        assert_eq!(pair.place_beside(0.0, pair.overlap([0.0; 2]), false), 0.0);
    }

    #[test]
    fn arc_position_derivatives_agree_with_differences() {
        each(|pair, [left, right], beyond| {
            let (overlap, part) = (pair.overlap([left, right]), pair.parts_along([left, right])[1]);
            // Derivatives by the left place, the overlap and the right length in turn.
            for along in 0..3 {
                let number = |value: f64, k: usize| Dual::with_tangent(value, if k == along { 1.0 } else { 0.0 });
                let (balls, law) = (pair.balls.map(|ball| ball.map(Dual::from)), pair.law.map(Dual::from));
                let right = BallModel { length: number(balls[1].length.value(), 2), ..balls[1] };
                let dual = Pair { balls: [&balls[0], &right], law: &law };
                let exact = dual.place_beside(number(left, 0), number(overlap, 1), beyond);
                let shifted = |h: f64| {
                    let by = |k: usize| if k == along { h } else { 0.0 };
                    let right = BallModel { length: pair.balls[1].length + by(2), ..*pair.balls[1] };
                    let pair = Pair { balls: [pair.balls[0], &right], law: pair.law };
                    pair.place_beside(left + by(0), overlap + by(1), beyond)
                };
                let h = 1e-5 * part.abs().powi(2);
                let difference = (shifted(h) - shifted(-h)) / (2.0 * h);
                let allowed = 1e-4 * (1.0 + exact.tangent().abs() / part.abs());
                assert!((exact.value() - pair.place_beside(left, overlap, beyond)).abs() <= 1e-14 / part.abs());
                assert!((exact.tangent() - difference).abs() <= allowed, "{left} {right:?}: {exact:?} {difference}");
            }
        });
    }

    #[test]
    fn arc_overlap_acceleration_is_that_along_the_motion() {
        each(|pair, places, _| {
            let ([u, w], [a, b], h) = ([0.7, -0.4], [0.3, 1.1], 1e-4);
            let at = |t: f64| {
                pair.overlap_rate([
                    (places[0] + t * (u + 0.5 * t * a), u + t * a),
                    (places[1] + t * (w + 0.5 * t * b), w + t * b),
                ])
            };
            let exact = pair.overlap_acceleration([(places[0], u), (places[1], w)], [a, b]);
            let difference = (at(h) - at(-h)) / (2.0 * h);
            assert!((exact - difference).abs() <= 1e-4 * (1.0 + exact.abs()), "{places:?}: {exact} {difference}");
        });
    }
}
