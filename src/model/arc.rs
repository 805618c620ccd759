//! Balls on arcs about their pivots, in doubles and dual numbers; see "Arcs" in docs/theory.md. On a line instead of
//! arcs, the same functions give the linear model. Overlaps are computed without cancellation.

use super::contact::ContactLaw;
use super::cradle::{BallModel, Cradle};
use super::parameters::{Parameters, PendulumModel};
use crate::solver::dual::Scalar;

/// Iterations of Newton's method at most, and the relative correction that ends them.
const ITERATIONS: usize = 50;
const RESOLVED: f64 = 1e-15;

/// A place on the path of a ball.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place<S = f64> {
    /// Horizontal deflection and height above rest, m.
    pub x: S,
    pub y: S,
    /// Sine and cosine of the angle: (cos, sin) is the direction of the path.
    pub sin: S,
    pub cos: S,
}

impl<S: Scalar> BallModel<S> {
    /// The place at `s` (m) along the path.
    pub(crate) fn place(&self, s: S) -> Place<S> {
        if !self.on_arc {
            let y = S::from(0.5) * s * s / self.length;
            return Place { x: s, y, sin: S::default(), cos: S::from(1.0) };
        }
        let (sin, cos) = (S::from(0.5) * s / self.length).sin_cos();
        let (double, twice) = (S::from(2.0) * sin, self.length * S::from(2.0) * sin);
        Place { x: twice * cos, y: twice * sin, sin: double * cos, cos: (cos - sin) * (cos + sin) }
    }

    /// The distance (m) between the ends of a stretch of the path (m).
    pub(crate) fn chord(&self, stretch: S) -> S {
        if !self.on_arc {
            return stretch;
        }
        let (half, _) = (S::from(0.5) * stretch / self.length).sin_cos();
        S::from(2.0) * self.length * half
    }

    /// The state along the path (m, m/s) for this horizontal deflection (m), less than the length, and its rate (m/s).
    pub fn along_path(&self, x: S, v: S) -> (S, S) {
        if !self.on_arc {
            return (x, v);
        }
        // With all digits near 90 degrees, too. A step of Newton's, for the derivative.
        let below = ((self.length - x) * (self.length + x)).sqrt();
        let angle = libm::atan2(x.value(), below.value());
        let (sin, cos) = S::from(angle).sin_cos();
        (self.length * S::from(angle) + (x * cos - below * sin), v * self.length / below)
    }
}

/// Refuses what balls on arcs cannot do at the start: says why, and what is allowed.
pub(crate) fn check_start_on_arcs(p: &Parameters) -> Result<(), String> {
    if p.pendulum == PendulumModel::Linear {
        return Ok(());
    }
    let Cradle { balls, contacts, .. } = Cradle::new(p);
    for (i, (BallModel { length, .. }, x)) in (1..).zip(balls.iter().zip(&p.x_start)) {
        if x.abs() >= *length {
            return Err(format!("x_start[{i}] = {x} m lies beyond its pendulum; allowed: -{length} to {length} m"));
        }
    }
    for (i, ContactLaw { pivots, clearance, .. }) in (1..).zip(contacts) {
        if pivots.min(pivots - clearance) <= 0.0 {
            let text = "contact.gap and contact.deadBand leave no distance between the centres of balls";
            let allowed = "allowed: 2 ball.radius + contact.gap and 2 ball.radius - contact.deadBand above 0";
            return Err(format!("{text} {i} and {}; {allowed}", i + 1));
        }
    }
    check_sides_at_start(p)
}

/// Refuses neighbours that have changed sides.
fn check_sides_at_start(p: &Parameters) -> Result<(), String> {
    let cradle = Cradle::new(p);
    for j in 0..cradle.contacts.len() {
        let (pair, [left, right]) = (cradle.pair(j), [j, j + 1].map(|i| p.x_start[i]));
        let places = [0, 1].map(|k| pair.balls[k].along_path([left, right][k], 0.0).0);
        let touch = pair.overlap(places) >= 0.0;
        let apart = Pair::pushes_apart(pair.parts_along(places));
        if touch && !apart || pair.margin(places) <= 0.0 {
            let (i, next) = (j + 1, j + 2);
            return Err(format!(
                "balls {i} and {next} have changed sides with x_start[{i}] = {left} m and x_start[{next}] = {right} m; \
                 allowed: each on its side of the other one's string"
            ));
        }
    }
    Ok(())
}

/// How far (m) neighbours are from having changed sides: from a `centre` to the line of the other ball's string, of this
/// `length` (m), if it is `beside` that string, which is that far (m) up from its ball.
pub(crate) fn margin_beside([centre, up]: [f64; 2], length: f64) -> f64 {
    if up > 0.0 && up < length { centre } else { f64::INFINITY }
}

/// The direction from the centre of a ball to that of the next one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line<S = f64>([S; 2]);

impl<S: Scalar> Line<S> {
    pub fn new(left: &Place<S>, right: &Place<S>, pivots: S) -> Self {
        let (width, height) = (pivots + (right.x - left.x), right.y - left.y);
        let distance = (width * width + height * height).sqrt();
        Self([width / distance, height / distance])
    }

    /// The part of its direction along the path at a place.
    pub fn along(&self, place: &Place<S>) -> S {
        self.0[0] * place.cos + self.0[1] * place.sin
    }

    /// The part away from the pivot of the ball at a place.
    pub fn outward(&self, place: &Place<S>) -> S {
        self.0[0] * place.sin - self.0[1] * place.cos
    }
}

/// Two neighbours and the law of their contact. Places and states are those along the paths (m, m/s).
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
    /// Horizontal and vertical displacement (m), right less left; of equal pendulums without cancellation.
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

    /// Horizontal and vertical distance (m) between the centres, on arcs.
    pub fn distances(&self, places: [S; 2]) -> [S; 2] {
        let [width, height] = self.relative_displacement(places);
        [self.law.pivots + width, height]
    }

    /// Their overlap, m.
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

    /// The parts along the two paths of the direction from the left to the right one.
    #[inline]
    pub fn parts_along(&self, places: [S; 2]) -> [S; 2] {
        if self.balls[0].on_arc { self.parts_on_arcs(places) } else { [S::from(1.0); 2] }
    }

    fn parts_on_arcs(&self, [l, r]: [S; 2]) -> [S; 2] {
        let [left, right] = [self.balls[0].place(l), self.balls[1].place(r)];
        let line = Line::new(&left, &right, self.law.pivots);
        [line.along(&left), line.along(&right)]
    }

    /// Whether the force of a contact with these [parts along](Self::parts_along) the paths would push each ball to its
    /// own side. False where balls that touch have gone over or through each other.
    #[inline]
    pub fn pushes_apart([left, right]: [S; 2]) -> bool {
        left.value() > 0.0 && right.value() > 0.0
    }

    /// Rate of the overlap (m/s) in these states.
    #[inline]
    pub fn overlap_rate(&self, [l, r]: [(S, S); 2]) -> S {
        let [left, right] = self.parts_along([l.0, r.0]);
        l.1 * left - r.1 * right
    }

    /// The place of the right one for that of the left and their overlap (m), by Newton's method; NaN if it has none.
    pub fn place_beside(&self, left: S, overlap: S) -> S {
        let Self { balls, law } = self;
        if !balls[0].on_arc {
            return left - (overlap + law.clearance);
        }
        let mut place = left * balls[1].length / balls[0].length;
        let (highest, mut settled) = (balls[1].length.value() * std::f64::consts::FRAC_PI_2, false);
        for _ in 0..ITERATIONS {
            let missing = self.overlap([left, place]) - overlap;
            let [_, slope] = self.parts_along([left, place]);
            let next = place + missing / slope;
            let last = std::mem::replace(&mut settled, (next - place).value().abs() <= RESOLVED * highest);
            place = S::from(next.value().clamp(-highest, highest)) + (next - S::from(next.value()));
            // Derivatives follow one iteration later.
            if last {
                return place;
            }
        }
        S::from(f64::NAN)
    }
}

impl Pair<'_> {
    /// How far (m) the two, on arcs, are from having changed sides: the distance of a centre from the other ball's
    /// string, if it is beside that; infinite if none is.
    fn margin(&self, places: [f64; 2]) -> f64 {
        let ([left, right], [width, height]) = ([0, 1].map(|k| self.balls[k].place(places[k])), self.distances(places));
        let of = |place: &Place, side: f64, length: f64| {
            let along = width * place.cos + height * place.sin;
            let up = side * (width * place.sin - height * place.cos);
            margin_beside([along, up], length)
        };
        of(&left, -1.0, self.balls[0].length).min(of(&right, 1.0, self.balls[1].length))
    }

    /// Change of the overlap (m) by these `moves` (m) from `places`, with their relative accuracy.
    #[inline]
    pub fn change_of_overlap(&self, places: [f64; 2], moves: [f64; 2]) -> f64 {
        if self.balls[0].on_arc { self.change_on_arcs(places, moves) } else { moves[0] - moves[1] }
    }

    fn change_on_arcs(&self, places: [f64; 2], moves: [f64; 2]) -> f64 {
        let [left, right] = [0, 1].map(|k| {
            let length = self.balls[k].length;
            let half = 0.5 * moves[k] / length;
            let (chord, (sin, cos)) = (2.0 * length * libm::sin(half), libm::sincos(places[k] / length + half));
            (chord * cos, chord * sin)
        });
        let [width, height] = self.distances(places);
        let (wider, higher) = (right.0 - left.0, right.1 - left.1);
        let distance = (width * width + height * height).sqrt();
        let excess = wider * (2.0 * width + wider) + higher * (2.0 * height + higher);
        -excess / ((distance * distance + excess).sqrt() + distance)
    }
}

/// Overlap of two neighbours (m) with its rate (m/s) and acceleration (m/s2) from those of `G = (touch^2 - D^2) / (2
/// touch)`, for the distance `touch` (m) of the centres at which they touch.
pub(crate) fn overlap_of_approach<S: Scalar>([g, rate, bend]: [S; 3], touch: S) -> [S; 3] {
    let (one, two) = (S::from(1.0), S::from(2.0));
    let q = (one - two * g / touch).sqrt();
    [two * g / (one + q), rate / q, bend / q + rate * rate / (touch * q * q * q)]
}
