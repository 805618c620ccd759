//! The natural modes of a uniform chain of balls joined by linear contacts.
//!
//! m equal balls with equal springs and dashpots between them and free ends have, with j = 0 to m - 1,
//!
//! ```text
//! phi_j(i) = sqrt(2 / m) cos(pi j (i + 1/2) / m)    (1 / sqrt(m) for j = 0)
//! lambda_j = 4 sin^2(pi j / (2 m))
//! omega_j^2 = omega^2 + lambda_j k / mass,    gamma_j = gamma + lambda_j c / (2 mass)
//! ```
//!
//! (Meirovitch, Fundamentals of Vibrations, 2001, chapter 7: damping proportional to the stiffness leaves the modes uncoupled.)

use super::ball::Flight;
use super::window::Window;
use crate::model::{ContactLaw, Damping};
use crate::solver::oscillator::Oscillator;

/// A coordinate at one time; each value with the sum of the magnitudes that it was computed from.
pub(crate) struct Course {
    /// Change of the rate since the start. What a mode does to balls that hardly move must not be the rounding of the others'
    /// motion.
    pub change_of_rate: (f64, f64),
    /// The coordinate and its first four derivatives.
    pub derivatives: [(f64, f64); 5],
}

/// One natural mode of a group: its coordinate, which starts at 0.
#[derive(Clone, Debug)]
pub(crate) struct NaturalMode {
    pub oscillator: Oscillator,
    pub flight: Flight,
    pub lambda: f64,
}

impl NaturalMode {
    /// The coordinate `tau` (s) after the start.
    pub fn at(&self, tau: f64) -> Course {
        let (o, Flight { v: v0, push, .. }) = (&self.oscillator, &self.flight);
        let force = push[0];
        let [fourth, third, second, first, u1, u2] = o.derivatives(tau.into());
        let sum = |a: f64, b: f64| (a + b, a.abs() + b.abs());
        let slowed = -2.0 * o.gamma() * u1 - o.omega2() * u2;
        Course {
            change_of_rate: sum(v0 * slowed, force * u1),
            derivatives: [
                sum(v0 * u1, force * u2),
                sum(v0 * first, force * u1),
                sum(v0 * second, force * first),
                sum(v0 * third, force * second),
                sum(v0 * fourth, force * third),
            ],
        }
    }

    /// `integral q'^2` from the start to `tau`: what the damping takes from `q'^2/2 + omega^2 q^2/2 - f q`.
    pub fn squared_velocity_integral(&self, tau: f64) -> f64 {
        let course = self.at(tau);
        let ((change, _), (q, _)) = (course.change_of_rate, course.derivatives[0]);
        let (o, start) = (&self.oscillator, &self.flight);
        let lost = -0.5 * change * (2.0 * start.v + change) - 0.5 * o.omega2() * q * q + start.push[0] * q;
        lost / (2.0 * o.gamma())
    }
}

/// Balls joined by pressing contacts.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    /// First ball and number of balls.
    pub first: usize,
    pub size: usize,
    /// Damping c of the contacts, N.s/m.
    pub damping: f64,
    pub modes: Vec<NaturalMode>,
    /// `phi_j(i)` at `j * size + i`.
    pub shapes: Vec<f64>,
}

impl Group {
    pub fn new(members: std::ops::Range<usize>, window: &Window) -> Self {
        let Window { flights, balls, contacts, laws } = window;
        let (first, size) = (members.start, members.len());
        let ball = &balls[first];
        let (stiffness, damping) = if size > 1 { (laws[first].stiffness, dashpot(&laws[first])) } else { (0.0, 0.0) };
        let (o, mass) = (&ball.oscillator, ball.mass);
        let angle = std::f64::consts::PI / size as f64;
        let mut shapes = Vec::with_capacity(size * size);
        let mut modes = Vec::with_capacity(size);
        for j in 0..size {
            let norm = (if j == 0 { 1.0 } else { 2.0 } / size as f64).sqrt();
            shapes.extend((0..size).map(|i| norm * libm::cos(angle * j as f64 * (i as f64 + 0.5))));
            let half = libm::sin(0.5 * angle * j as f64);
            let lambda = 4.0 * half * half;
            let oscillator = match j {
                0 => *o,
                _ => Oscillator::new(o.omega2() + lambda * stiffness / mass, o.gamma() + 0.5 * lambda * damping / mass),
            };
            modes.push(NaturalMode { oscillator, flight: Flight::default(), lambda });
        }
        let mut group = Self { first, size, damping, modes, shapes };
        for j in 0..size {
            let shape = group.shapes[j * size..(j + 1) * size].to_vec();
            let mut flight = Flight::default();
            for (i, shape) in members.clone().zip(&shape) {
                flight.push[0] += shape * flights[i].push[0];
            }
            // In the modes that stretch the group only the differences of the positions and velocities count, which the
            // overlaps and their rates give without rounding.
            let mut before = 0.0;
            for contact in first..first + size - 1 {
                before += shape[contact - first];
                let overlap = contacts[contact].overlap;
                let apart = if j == 0 {
                    flights[contact].x - flights[contact + 1].x
                } else {
                    overlap + laws[contact].clearance
                };
                flight.v += before * (flights[contact].v - flights[contact + 1].v);
                flight.push[0] -=
                    o.omega2() * before * apart + group.stretch(&shape, contact) * stiffness / mass * overlap;
            }
            if j == 0 {
                let (last, all) = (&flights[first + size - 1], before + shape[size - 1]);
                flight.v += all * last.v;
                flight.push[0] -= o.omega2() * all * last.x;
            }
            group.modes[j].flight = flight;
        }
        group
    }

    /// Change of the overlap of contact `j`, which the group contains, for a unit of the coordinate with this shape.
    pub fn stretch(&self, shape: &[f64], j: usize) -> f64 {
        shape[j - self.first] - shape[j + 1 - self.first]
    }
}

pub(crate) fn dashpot(law: &ContactLaw) -> f64 {
    match law.damping {
        Damping::KelvinVoigt { c, .. } => c,
        _ => 0.0,
    }
}

/// A value with four derivatives, summed over modes, and the magnitudes that went into it.
pub(crate) struct Sum {
    pub values: [f64; 5],
    magnitudes: [f64; 5],
}

impl Sum {
    pub fn new(value: f64, rate: f64) -> Self {
        Self { values: [value, rate, 0.0, 0.0, 0.0], magnitudes: [value.abs(), rate.abs(), 0.0, 0.0, 0.0] }
    }

    pub fn add(&mut self, factor: f64, terms: &[(f64, f64); 5]) {
        for (k, (term, magnitude)) in terms.iter().enumerate() {
            self.values[k] += factor * term;
            self.magnitudes[k] += factor.abs() * magnitude;
        }
    }

    /// The values, those that are but rounding set to 0: no search for a crossing should follow noise.
    pub fn without_noise(self) -> [f64; 5] {
        std::array::from_fn(|k| {
            // The derivatives only lead a search on and may be taken for noise sooner.
            let noise = if k == 0 { 8.0 } else { 128.0 } * f64::EPSILON * self.magnitudes[k];
            if self.values[k].abs() <= noise { 0.0 } else { self.values[k] }
        })
    }
}
