//! The outcome of an elastic impact of two balls on arcs: in closed form along a fixed direction, then by iteration for
//! the turn of the directions, gravity and inputs. See "Arcs" in docs/theory.md, and [`ImpactShape`].

use crate::engine::Peak;
use crate::engine::cluster::{BallOnArc, ContactDirection};
use crate::engine::flight::Flight;
use crate::model::{BallModel, ContactLaw, Pair};
use crate::solver::{DoubleDouble, NODES, Power, Stretching, Table, quadrature::gauss_legendre, weighted};

/// Most iterations. Each gains at least as many digits as `LARGEST_CHANGE`, the largest allowed change of
/// accelerations, has.
const ITERATIONS: usize = 8;
const LARGEST_CHANGE: f64 = 1e-3;

/// Negligible part of a velocity.
const NEGLIGIBLE_VELOCITY: f64 = 1e-18;

/// Steps of Newton's method for a node.
const NEWTON_STEPS: usize = 4;

/// Values at the nodes of both halves of an impact.
type NodalValues = [f64; 2 * NODES];

/// The impact along a fixed direction for one exponent p of the force law, at nodes.
///
/// Along it the overlap is `q phi(t / T0)`, with the largest overlap q and the duration `T0` in closed form. With the
/// turn of the directions, gravity and inputs, it is `q (phi + y)(x)`, `x = t / T`, `T = (1 + elongation) T0`, with a
/// small y and `y(1) = 0`. N collects the free acceleration, the turn, the effect of `elongation`, and the terms not
/// linear in y:
///
/// ```text
/// phi'' = -kappa phi^p,     phi'(0) = sigma,     kappa = sigma^2 (p+1) / 2,     e = phi + (p-1) / 2 x phi'
/// y = (e integral(phi' N) - phi' integral(e N)) / kappa + 2 elongation / (p+1) e
/// ```
///
/// Each iteration adds `y(1) / sigma` to `elongation` and `y(1) / sigma x phi'` to y. The velocities follow from twice
/// the initial rate, in double-double, plus small integrals.
#[derive(Clone, Debug)]
pub(crate) struct ImpactShape {
    p: f64,
    sigma: f64,
    kappa: f64,
    halves: [&'static Table; 2],
    /// The time over the duration, and the weights of integrals over the impact.
    times: NodalValues,
    weights: NodalValues,
    /// phi, phi', the power p of phi, and e.
    phi: NodalValues,
    slopes: NodalValues,
    powers: NodalValues,
    scalings: NodalValues,
}

impl ImpactShape {
    /// The highest exponent for which the nodes suffice.
    pub const HIGHEST: f64 = 3.0;

    /// The shape for the exponent p. `power` stretches the time so that forces are smooth where the contact closes and
    /// opens.
    pub fn new(p: f64, power: Option<Power>) -> Self {
        let (share, order) = (1.0 / (p + 1.0), 0.5 * (p + 1.0));
        let sigma = 2.0 * std::f64::consts::PI.sqrt() * libm::tgamma(1.0 + share) / libm::tgamma(0.5 + share);
        let [start, end] = [Stretching::AtStart, Stretching::AtEnd];
        let halves =
            [power.map_or(Stretching::None, start), power.map_or(Stretching::None, end)].map(Stretching::table);
        let both = |part: &dyn Fn(usize, usize) -> f64| std::array::from_fn(|m| part(m / NODES, m % NODES));
        let times: NodalValues = both(&|half, m| 0.5 * (half as f64 + halves[half].times[m]));
        let weights = both(&|half, m| 0.5 * halves[half].of_rate[m]);
        let [mut phi, mut slopes, mut powers, mut scalings] = [[0.0; 2 * NODES]; 4];
        // phi^(p+1) = sin(v^order)^2 makes the time an integral over v of a function that hardly varies, smooth in the
        // root of v.
        let angle = |root: f64| libm::pow(root, 2.0 * order);
        let pace = |root: f64| 2.0 * root * libm::pow(libm::sin(angle(root)) / angle(root), 1.0 / order - 1.0);
        let (mut root, mut before) = (0.0_f64, 0.0);
        for m in 0..NODES {
            let (from, step) = (root, sigma * times[m] - before);
            root = (from * from + step).sqrt();
            for _ in 0..NEWTON_STEPS {
                root -= (gauss_legendre(&pace, from, root, 1) - step) / pace(root);
            }
            before += step;
            let (sin, cos) = libm::sincos(angle(root));
            let mirrored = 2 * NODES - 1 - m;
            (phi[m], slopes[m]) = (libm::pow(sin, 1.0 / order), sigma * cos);
            (phi[mirrored], slopes[mirrored]) = (phi[m], -slopes[m]);
        }
        for m in 0..2 * NODES {
            powers[m] = libm::pow(phi[m], p);
            scalings[m] = phi[m] + 0.5 * (p - 1.0) * times[m] * slopes[m];
        }
        let kappa = 0.5 * sigma * sigma * (p + 1.0);
        Self { p, sigma, kappa, halves, times, weights, phi, slopes, powers, scalings }
    }

    /// Integrals from the start to the nodes.
    fn integrate(&self, values: &NodalValues) -> NodalValues {
        let [first, second] = [0, NODES].map(|from| std::array::from_fn(|m| values[from + m]));
        let [before, after] = self.halves;
        let (before, middle, after) =
            (before.integrate(&first), weighted(&before.of_rate, &first), after.integrate(&second));
        std::array::from_fn(|m| 0.5 * if m < NODES { before[m] } else { middle + after[m - NODES] })
    }

    /// What the binomial series of `(1 + y / phi)^p` has beyond its linear terms, `1 + p y / phi`; `y` is y over phi
    /// here.
    fn remainder(&self, y: f64) -> f64 {
        let [a, b, c, d] = [self.p, self.p - 1.0, self.p - 2.0, self.p - 3.0];
        0.5 * a * b * y * y * (1.0 + c / 3.0 * y * (1.0 + d / 4.0 * y * (1.0 + (d - 1.0) / 5.0 * y)))
    }
}

/// The outcome of an impact of two.
#[derive(Clone, Debug, Default)]
pub(crate) struct ImpactResult {
    /// Duration, s.
    pub duration: f64,
    /// Displacements of the two balls along their paths, m, and velocities afterwards, m/s. The overlap is 0 again.
    pub displacements: [f64; 2],
    pub velocities: [f64; 2],
    /// Impulse, N.s, and largest force, with its time since the onset.
    pub impulse: f64,
    pub peak: Peak,
}

/// The outcome for two balls without drag, in touch, under constant inputs; `None` if directions or forces vary too
/// much.
pub(crate) fn outcome(
    balls: &[BallModel; 2],
    flights: [&Flight; 2],
    law: &ContactLaw,
    shape: &ImpactShape,
) -> Option<ImpactResult> {
    let starts = [0, 1].map(|k| BallOnArc::at_start((&balls[k], flights[k])));
    let onset = Onset::new(balls, flights, law, shape, &starts)?;
    let mut iterate = Iterate::new(&onset, &starts);
    for _ in 0..ITERATIONS {
        iterate.move_balls(&onset);
        let [change, largest] = iterate.correct(&onset);
        let goes_on = largest < LARGEST_CHANGE && iterate.elongation.abs() < LARGEST_CHANGE;
        if !goes_on {
            return None; // Also if they are NaN.
        }
        let has_converged = change * largest <= NEGLIGIBLE_VELOCITY;
        if has_converged {
            return Some(iterate.result(&onset));
        }
    }
    None
}

/// An impact at its onset, and what it would be along a fixed direction.
struct Onset<'a> {
    balls: &'a [BallModel; 2],
    flights: [&'a Flight; 2],
    law: &'a ContactLaw,
    shape: &'a ImpactShape,
    lengths: [f64; 2],
    inverse_masses: [f64; 2],
    /// Distances of the centres, horizontal and vertical, m.
    distances: [f64; 2],
    direction: ContactDirection<1>,
    /// Components of the direction along the paths.
    along: [f64; 2],
    /// 1 over the reduced mass along the line of the centres, 1/kg.
    inverse_mass: f64,
    /// Along a fixed direction: the largest overlap (m), the largest force (N) and the duration (s).
    reach: f64,
    strongest: f64,
    duration: f64,
}

impl<'a> Onset<'a> {
    /// `None` if the balls do not approach each other, or turn too much.
    #[inline]
    fn new(
        balls: &'a [BallModel; 2],
        flights: [&'a Flight; 2],
        law: &'a ContactLaw,
        shape: &'a ImpactShape,
        starts: &[BallOnArc<1>; 2],
    ) -> Option<Self> {
        let (lengths, inverse_masses) = (balls.each_ref().map(|ball| ball.length), balls.map(|ball| 1.0 / ball.mass));
        let distances = Pair { balls: balls.each_ref(), law }.distances(flights.map(|flight| flight.x));
        let direction = ContactDirection::new(&starts[0], &starts[1], lengths, distances);
        let rate = starts[0].approach(&starts[1], &direction);
        let along = direction.along.map(|[along]| along);
        let inverse_mass = along[0] * along[0] * inverse_masses[0] + along[1] * along[1] * inverse_masses[1];
        let reach = law.largest_overlap(1.0 / inverse_mass, rate);
        let (strongest, duration) = (law.elastic_force(reach), shape.sigma * reach / rate);
        let turns = [0, 1].map(|k| duration * flights[k].v.abs() / lengths[k]);
        let begins = rate > 0.0 && duration > 0.0 && turns[0].max(turns[1]) < LARGEST_CHANGE;
        // Not if they are NaN.
        begins.then_some(Self {
            balls,
            flights,
            law,
            shape,
            lengths,
            inverse_masses,
            distances,
            direction,
            along,
            inverse_mass,
            reach,
            strongest,
            duration,
        })
    }
}

/// The impact as far as the iteration has come, at the nodes of [`ImpactShape`].
struct Iterate {
    balls: [BallOnArc<{ 2 * NODES }>; 2],
    direction: ContactDirection<{ 2 * NODES }>,
    y: NodalValues,
    forces: NodalValues,
    elongation: f64,
    /// What the last iteration was computed with: the duration (s); accelerations along the paths (m/s2); decreases of
    /// the squared components of the direction along the paths since the onset.
    duration: f64,
    accelerations: [NodalValues; 2],
    decreases: [NodalValues; 2],
    /// N times phi' and times e; the integral of the former over the impact; the factor of e in y.
    by_slope: NodalValues,
    by_scaling: NodalValues,
    lost: f64,
    scaled: f64,
}

impl Iterate {
    /// The impact along the direction at its onset.
    #[inline]
    fn new(onset: &Onset, starts: &[BallOnArc<1>; 2]) -> Self {
        let none = [0.0; 2 * NODES];
        Self {
            balls: starts.map(|start| start.lasting()),
            direction: onset.direction.lasting(),
            y: none,
            forces: onset.shape.powers.map(|power| onset.strongest * power),
            elongation: 0.0,
            duration: 0.0,
            accelerations: [none; 2],
            decreases: [none; 2],
            by_slope: none,
            by_scaling: none,
            lost: 0.0,
            scaled: 0.0,
        }
    }

    /// Moves the balls by the present forces along the present direction, and turns the direction between them.
    #[inline]
    fn move_balls(&mut self, onset: &Onset) {
        let Onset { balls, flights, shape, inverse_masses, .. } = onset;
        let duration = onset.duration * (1.0 + self.elongation);
        for (k, side) in [-1.0, 1.0].into_iter().enumerate() {
            for m in 0..2 * NODES {
                let pushed = side * self.forces[m] * self.direction.along[k][m] * inverse_masses[k];
                self.accelerations[k][m] = self.balls[k].free[m] + pushed;
            }
            let once = shape.integrate(&self.accelerations[k]);
            let (twice, v) = (shape.integrate(&once), flights[k].v);
            let way = std::array::from_fn(|m| duration * (v * shape.times[m] + duration * twice[m]));
            let u = std::array::from_fn(|m| v + duration * once[m]);
            self.balls[k].follow(&balls[k], flights[k], &[way, u], &shape.times.map(|time| time * duration));
        }
        self.direction = ContactDirection::new(&self.balls[0], &self.balls[1], onset.lengths, onset.distances);
        // From the small components away from the paths, which keep the digits.
        self.decreases = [0, 1].map(|k| {
            let ([before], now) = (onset.direction.outward[k], &self.direction.outward[k]);
            now.map(|now| (now - before) * (now + before))
        });
        self.duration = duration;
    }

    /// Decrease of the inverse reduced mass since the onset, at a node, 1/kg.
    #[inline(always)]
    fn decrease(&self, onset: &Onset, m: usize) -> f64 {
        onset.inverse_masses[0] * self.decreases[0][m] + onset.inverse_masses[1] * self.decreases[1][m]
    }

    /// Corrects y, the elongation and the forces by the present motion. Returns the largest change of y or the
    /// elongation, and the largest relative change of accelerations from those along a fixed direction.
    #[inline]
    fn correct(&mut self, onset: &Onset) -> [f64; 2] {
        let ImpactShape { p, kappa, times, weights, phi, slopes, powers, scalings, .. } = onset.shape;
        let (p, kappa, elongation) = (*p, *kappa, self.elongation);
        let (scale, stretched) = (self.duration * self.duration / onset.reach, elongation * (2.0 + elongation));
        let mut largest = 0.0_f64;
        for m in 0..2 * NODES {
            let (more, part) = (-self.decrease(onset, m) / onset.inverse_mass, self.y[m] / phi[m]);
            let (eta, remainder) = (stretched + more + stretched * more, onset.shape.remainder(part));
            let free = scale * self.direction.free[m];
            let rest = free - kappa * powers[m] * (eta * (1.0 + p * part + remainder) + remainder);
            (self.by_slope[m], self.by_scaling[m]) = (slopes[m] * rest, scalings[m] * rest);
            largest = largest.max(eta.abs()).max(part.abs());
        }
        let (of_slope, of_scaling) = (onset.shape.integrate(&self.by_slope), onset.shape.integrate(&self.by_scaling));
        let (lost, shift) = (weighted(weights, &self.by_slope), weighted(weights, &self.by_scaling));
        let (scaled, later) = (2.0 * elongation / (p + 1.0), (shift - 0.5 * (p - 1.0) * lost) / kappa);
        let longer = later - (p - 1.0) / (p + 1.0) * elongation;
        let mut change = longer.abs();
        for m in 0..2 * NODES {
            let next = scalings[m] * (of_slope[m] / kappa + scaled) - slopes[m] * of_scaling[m] / kappa;
            let next = next + longer * times[m] * slopes[m];
            change = change.max((next - self.y[m]).abs());
            self.y[m] = next;
            let part = next / phi[m];
            self.forces[m] = onset.strongest * powers[m] * (1.0 + p * part + onset.shape.remainder(part));
            largest = largest.max(part.abs());
        }
        (self.elongation, self.lost, self.scaled) = (elongation + longer, lost, scaled);
        [change, largest]
    }

    /// Integral over the impact of a quantity with these values at the nodes.
    #[inline(always)]
    fn integral(&self, onset: &Onset, value: impl Fn(usize) -> f64) -> f64 {
        self.duration * weighted(&onset.shape.weights, &std::array::from_fn(value))
    }

    /// The outcome by the last iteration.
    #[inline]
    fn result(&self, onset: &Onset) -> ImpactResult {
        let Onset { balls, flights, along, inverse_masses, inverse_mass, .. } = onset;
        let duration = self.duration;
        let missing = self.integral(onset, |m| self.direction.free[m] + self.decrease(onset, m) * self.forces[m]);
        // Directions are nearly the same in each impact, so their rounding would add up.
        let product = DoubleDouble::product;
        let by_impulse = [0, 1].map(|k| {
            let (mass, inverse) = (balls[k].mass, inverse_masses[k]);
            let missing = inverse * (DoubleDouble::from(1.0) - product(mass, inverse)).value();
            (DoubleDouble::from(inverse) + missing) * along[k]
        });
        let twice_rate = (product(along[0], flights[0].v) - product(along[1], flights[1].v)) * 2.0
            + (onset.reach / (onset.shape.sigma * duration) * self.lost + missing);
        let first = twice_rate.value() / inverse_mass;
        let rest = twice_rate - (by_impulse[0] * along[0] + by_impulse[1] * along[1]) * first;
        let impulse = DoubleDouble::from(first) + rest.value() / inverse_mass;
        let sides = [(0, -1.0), (1, 1.0)];
        let velocities = sides.map(|(k, side)| {
            let now = &self.direction.along[k];
            let turned = self.integral(onset, |m| -self.decreases[k][m] / (now[m] + along[k]) * self.forces[m]);
            let more = side * turned * inverse_masses[k] + self.integral(onset, |m| self.balls[k].free[m]);
            (by_impulse[k] * impulse * side + flights[k].v + more).value()
        });
        let displacements = sides.map(|(k, _)| {
            let times = &onset.shape.times;
            duration * (flights[k].v + self.integral(onset, |m| (1.0 - times[m]) * self.accelerations[k][m]))
        });
        ImpactResult { duration, displacements, velocities, impulse: impulse.value(), peak: self.peak(onset) }
    }

    /// The largest force, by Newton's method from half time, where phi is 1.
    #[inline]
    fn peak(&self, onset: &Onset) -> Peak {
        let ImpactShape { p, kappa, weights, .. } = onset.shape;
        let [half_slope, half_scaling] = [self.by_slope, self.by_scaling]
            .map(|values| weights.iter().zip(&values).take(NODES).map(|(weight, value)| weight * value).sum::<f64>());
        let middle = self.scaled + half_slope / kappa;
        let rate_there = half_scaling - 0.25 * (p - 1.0) * kappa * middle;
        let overlap = onset.reach * (1.0 + (middle + 0.5 * rate_there * rate_there / kappa));
        // `y'' = rest - kappa p y` there, with the mean of the two nodes beside it.
        let curvature = 0.5 * (self.by_scaling[NODES - 1] + self.by_scaling[NODES]) - kappa * p * middle;
        Peak { force: onset.law.elastic_force(overlap), time: self.duration * (0.5 + rate_there / (kappa - curvature)) }
    }
}
