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
    let ImpactShape { p, sigma, kappa, times, weights, phi, slopes, powers, scalings, .. } = shape;
    let (p, sigma, kappa) = (*p, *sigma, *kappa);
    let (lengths, inverse_masses) = (balls.each_ref().map(|ball| ball.length), balls.map(|ball| 1.0 / ball.mass));
    let distances = Pair { balls: balls.each_ref(), law }.distances(flights.map(|flight| flight.x));
    let starts = [0, 1].map(|k| BallOnArc::at_start((&balls[k], flights[k])));
    let start = ContactDirection::new(&starts[0], &starts[1], lengths, distances);
    let rate = starts[0].approach(&starts[1], &start);
    let along = start.along.map(|[along]| along);
    // 1 over the reduced mass along the line of the centres, 1/kg.
    let inverse_mass = along[0] * along[0] * inverse_masses[0] + along[1] * along[1] * inverse_masses[1];
    let reach = law.largest_overlap(1.0 / inverse_mass, rate);
    let (strongest, first) = (law.elastic_force(reach), sigma * reach / rate);
    let turns = [0, 1].map(|k| first * flights[k].v.abs() / lengths[k]);
    let begins = rate > 0.0 && first > 0.0 && turns[0].max(turns[1]) < LARGEST_CHANGE;
    if !begins {
        return None; // Also if they are NaN.
    }
    let mut moving = starts.map(|start| start.lasting());
    let mut direction = start.lasting();
    let (mut y, mut forces, mut elongation) = ([0.0; 2 * NODES], powers.map(|power| strongest * power), 0.0);
    for _ in 0..ITERATIONS {
        let duration = first * (1.0 + elongation);
        let mut accelerations = [[0.0; 2 * NODES]; 2];
        for (k, side) in [-1.0, 1.0].into_iter().enumerate() {
            for m in 0..2 * NODES {
                let pushed = side * forces[m] * direction.along[k][m] * inverse_masses[k];
                accelerations[k][m] = moving[k].free[m] + pushed;
            }
            let once = shape.integrate(&accelerations[k]);
            let (twice, v) = (shape.integrate(&once), flights[k].v);
            let way = std::array::from_fn(|m| duration * (v * times[m] + duration * twice[m]));
            let u = std::array::from_fn(|m| v + duration * once[m]);
            moving[k].follow(&balls[k], flights[k], &[way, u], &times.map(|time| time * duration));
        }
        direction = ContactDirection::new(&moving[0], &moving[1], lengths, distances);
        // Changes of the squared components along the paths, from the small components away from them, which keep the
        // digits.
        let shorter = [0, 1].map(|k| {
            let ([before], now) = (start.outward[k], &direction.outward[k]);
            now.map(|now| (now - before) * (now + before))
        });
        let (pulled, stretched) = (duration * duration / reach, elongation * (2.0 + elongation));
        let less = |m: usize| inverse_masses[0] * shorter[0][m] + inverse_masses[1] * shorter[1][m];
        let ([mut by_slope, mut by_scaling], mut largest) = ([[0.0; 2 * NODES]; 2], 0.0_f64);
        for m in 0..2 * NODES {
            let (more, part) = (-less(m) / inverse_mass, y[m] / phi[m]);
            let (eta, remainder) = (stretched + more + stretched * more, shape.remainder(part));
            let rest =
                pulled * direction.free[m] - kappa * powers[m] * (eta * (1.0 + p * part + remainder) + remainder);
            (by_slope[m], by_scaling[m]) = (slopes[m] * rest, scalings[m] * rest);
            largest = largest.max(eta.abs()).max(part.abs());
        }
        let (of_slope, of_scaling) = (shape.integrate(&by_slope), shape.integrate(&by_scaling));
        let (lost, shift) = (weighted(weights, &by_slope), weighted(weights, &by_scaling));
        let (scaled, later) = (2.0 * elongation / (p + 1.0), (shift - 0.5 * (p - 1.0) * lost) / kappa);
        let change = later - (p - 1.0) / (p + 1.0) * elongation;
        let mut moved = change.abs();
        for m in 0..2 * NODES {
            let next = scalings[m] * (of_slope[m] / kappa + scaled) - slopes[m] * of_scaling[m] / kappa;
            let next = next + change * times[m] * slopes[m];
            moved = moved.max((next - y[m]).abs());
            y[m] = next;
            let part = next / phi[m];
            forces[m] = strongest * powers[m] * (1.0 + p * part + shape.remainder(part));
            largest = largest.max(part.abs());
        }
        elongation += change;
        let goes_on = largest < LARGEST_CHANGE && elongation.abs() < LARGEST_CHANGE;
        if !goes_on {
            return None;
        }
        if moved * largest > NEGLIGIBLE_VELOCITY {
            continue;
        }
        let sum = |value: &dyn Fn(usize) -> f64| duration * weighted(weights, &std::array::from_fn(value));
        let missing = sum(&|m| direction.free[m] + less(m) * forces[m]);
        // Directions are nearly the same in each impact, so their rounding would add up.
        let product = DoubleDouble::product;
        let pushes = [0, 1].map(|k| {
            let (mass, inverse) = (balls[k].mass, inverse_masses[k]);
            let missing = inverse * (DoubleDouble::from(1.0) - product(mass, inverse)).value();
            (DoubleDouble::from(inverse) + missing) * along[k]
        });
        let twice = (product(along[0], flights[0].v) - product(along[1], flights[1].v)) * 2.0
            + (reach / (sigma * duration) * lost + missing);
        let first = twice.value() / inverse_mass;
        let rest = twice - (pushes[0] * along[0] + pushes[1] * along[1]) * first;
        let impulse = DoubleDouble::from(first) + rest.value() / inverse_mass;
        let sides = [(0, -1.0), (1, 1.0)];
        let velocities = sides.map(|(k, side)| {
            let turned = sum(&|m| -shorter[k][m] / (direction.along[k][m] + along[k]) * forces[m]);
            let more = side * turned * inverse_masses[k] + sum(&|m| moving[k].free[m]);
            (pushes[k] * impulse * side + flights[k].v + more).value()
        });
        let displacements =
            sides.map(|(k, _)| duration * (flights[k].v + sum(&|m| (1.0 - times[m]) * accelerations[k][m])));
        // At half time, where phi is 1.
        let [half_slope, half_scaling] = [by_slope, by_scaling]
            .map(|values| weights.iter().zip(&values).take(NODES).map(|(weight, value)| weight * value).sum::<f64>());
        let middle = scaled + half_slope / kappa;
        let rate_there = half_scaling - 0.25 * (p - 1.0) * kappa * middle;
        let force = law.elastic_force(reach * (1.0 + (middle + 0.5 * rate_there * rate_there / kappa)));
        // `y'' = rest - kappa p y` there, with the mean of the two nodes beside it.
        let curvature = 0.5 * (by_scaling[NODES - 1] + by_scaling[NODES]) - kappa * p * middle;
        let peak = Peak { force, time: duration * (0.5 + rate_there / (kappa - curvature)) };
        return Some(ImpactResult { duration, displacements, velocities, impulse: impulse.value(), peak });
    }
    None
}
