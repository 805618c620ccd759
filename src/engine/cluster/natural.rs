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

use std::cell::Cell;

use super::window::Window;
use crate::solver::oscillator::{ForcedOscillator, Oscillator, Response};

/// One natural mode of a group: its coordinate, which starts at 0.
#[derive(Clone, Debug)]
pub(crate) struct NaturalMode {
    pub motion: ForcedOscillator,
    pub lambda: f64,
    /// When it was asked for last, and the answer: all balls and contacts of a group ask for the same time.
    last: Cell<Option<(f64, Response)>>,
}

impl NaturalMode {
    pub fn new(motion: ForcedOscillator, lambda: f64) -> Self {
        Self { motion, lambda, last: Cell::new(None) }
    }

    /// The oscillator of the coordinate.
    pub fn oscillator(&self) -> &Oscillator {
        self.motion.oscillator()
    }

    /// The coordinate `tau` (s) after the start.
    pub fn at(&self, tau: f64) -> Response {
        match self.last.get() {
            Some((time, response)) if time == tau => response,
            _ => {
                let response = self.motion.at(tau);
                self.last.set(Some((tau, response)));
                response
            }
        }
    }

    /// A bound of the absolute derivative of order `k` >= 2 of `a` times the coordinate and `b` times its rate from `tau` (s) on.
    pub fn derivative_bound(&self, tau: f64, k: i32, a: f64, b: f64) -> f64 {
        self.motion.derivative_bound(&self.at(tau), tau, k, a, b)
    }

    /// `integral q'^2` from the start to `tau`.
    pub fn squared_velocity_integral(&self, tau: f64) -> f64 {
        self.motion.squared_velocity_integral(&self.at(tau))
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
    shapes: Vec<f64>,
}

impl Group {
    pub fn new(members: std::ops::Range<usize>, window: &Window) -> Self {
        let Window { flights, balls, contacts, laws } = window;
        let (first, size) = (members.start, members.len());
        let ball = &balls[first];
        let (stiffness, damping) =
            if size > 1 { (laws[first].stiffness, laws[first].damping_coefficient()) } else { (0.0, 0.0) };
        let (o, mass) = (&ball.oscillator, ball.mass);
        let angle = std::f64::consts::PI / size as f64;
        let mut shapes = Vec::with_capacity(size * size);
        let mut modes = Vec::with_capacity(size);
        for j in 0..size {
            let norm = (if j == 0 { 1.0 } else { 2.0 } / size as f64).sqrt();
            shapes.extend((0..size).map(|i| norm * libm::cos(angle * j as f64 * (i as f64 + 0.5))));
            let shape = &shapes[j * size..];
            let half = libm::sin(0.5 * angle * j as f64);
            let lambda = 4.0 * half * half;
            let oscillator = match j {
                0 => *o,
                _ => Oscillator::new(o.omega2() + lambda * stiffness / mass, o.gamma() + 0.5 * lambda * damping / mass),
            };
            let (mut v, mut force) = (0.0, 0.0);
            for (flight, shape) in flights[members.clone()].iter().zip(shape) {
                force += shape * flight.forcing[0];
            }
            // In the modes that stretch the group only the differences of the positions and velocities count, which the
            // overlaps and their rates give without rounding.
            let mut before = 0.0;
            for i in 0..size - 1 {
                let contact = first + i;
                before += shape[i];
                let overlap = contacts[contact].overlap;
                let apart = if j == 0 {
                    flights[contact].x - flights[contact + 1].x
                } else {
                    overlap + laws[contact].clearance
                };
                v += before * (flights[contact].v - flights[contact + 1].v);
                force -= o.omega2() * before * apart + (shape[i] - shape[i + 1]) * stiffness / mass * overlap;
            }
            if j == 0 {
                let (last, all) = (&flights[first + size - 1], before + shape[size - 1]);
                v += all * last.v;
                force -= o.omega2() * all * last.x;
            }
            modes.push(NaturalMode::new(ForcedOscillator::new(oscillator, v, force), lambda));
        }
        Self { first, size, damping, modes, shapes }
    }

    /// The least rate at which what the dashpots act on decays right after the start, 1/s.
    pub fn least_decay(&self) -> f64 {
        self.modes[1..].iter().map(|mode| mode.oscillator().fast_decay()).fold(f64::INFINITY, f64::min)
    }

    /// Displacement of ball `i` for a unit of the coordinate of mode `m`.
    pub fn shape(&self, m: usize, i: usize) -> f64 {
        self.shapes[m * self.size + i - self.first]
    }
}

/// A value and its derivatives, summed over modes, and the magnitudes that went into them.
pub(crate) struct Sum<const COUNT: usize> {
    values: [f64; COUNT],
    magnitudes: [f64; COUNT],
}

impl<const COUNT: usize> Sum<COUNT> {
    pub fn new(value: f64, rate: f64) -> Self {
        let mut values = [0.0; COUNT];
        (values[0], values[1]) = (value, rate);
        Self { values, magnitudes: values.map(f64::abs) }
    }

    pub fn add(&mut self, factor: f64, terms: &[(f64, f64); 5]) {
        for (k, (term, magnitude)) in terms.iter().take(COUNT).enumerate() {
            self.values[k] += factor * term;
            self.magnitudes[k] += factor.abs() * magnitude;
        }
    }

    /// The values, those that are but rounding set to 0: no search for a crossing should follow noise.
    pub fn without_noise(self) -> [f64; COUNT] {
        std::array::from_fn(|k| {
            // The derivatives only lead a search on and may be taken for noise sooner.
            let noise = if k == 0 { 8.0 } else { 128.0 } * f64::EPSILON * self.magnitudes[k];
            if self.values[k].abs() <= noise { 0.0 } else { self.values[k] }
        })
    }
}
