//! Rigid balls in sustained contact move as one body. Each contact transmits a constraint force, a closed form like the
//! motion. See "Rigid contacts" in docs/theory.md for both.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::engine::flight::{Ball, Flight, Forcing, degree, forecast, reach, shifted};
use crate::engine::{Forecast, Peak};
use crate::solver::{
    BASIS, DoubleDouble, MAX_FORCE_ORDER, Oscillator, Smooth, root::falling_zero, series::of_derivatives,
};

/// Roundings in a number to which several operations have added.
const ROUNDINGS: f64 = 8.0;

/// Most panels in which the largest force is searched, 16 to a swing: some 60,000 swings.
const MOST_PANELS: f64 = 1e6;

/// A sustained contact, which constrains its balls to move as one.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Constraint {
    /// Time at which the body formed.
    pub anchor: DoubleDouble,
    /// Motion of the body from the anchor on.
    pub oscillator: Oscillator,
    flight: Flight,
    /// Derivatives at the anchor of a polynomial of the time, N/s^k. The force is this polynomial ...
    load: Forcing,
    /// ... less `stiffness` (N/m) times the displacement of the body, less `drag` (N.s/m) times its velocity.
    stiffness: f64,
    drag: f64,
    /// Rounding of the force, N.
    rounding: f64,
    /// Time at which the force would have to pull.
    pub end: Forecast<DoubleDouble>,
}

/// Rigid balls that move as one.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Body {
    /// First contact of the body.
    first: usize,
    /// The constraint of each contact between its balls.
    constraints: Vec<Constraint>,
}

/// Rounding of the acceleration (m/s2) of a ball in flight under inputs that have acted for `age` (s).
pub(crate) fn acceleration_rounding(ball: &Ball, age: f64) -> f64 {
    let o = &ball.oscillator;
    let of_motion = o.pace() * ball.flight.rounding(o).velocity;
    let forcing = ball.flight.forcing[0].abs() + ball.flight.forcing[1].abs() * age;
    ROUNDINGS * (of_motion + 2.0 * f64::EPSILON * forcing)
}

impl Body {
    /// The contacts of the body.
    pub fn contacts(&self) -> Range<usize> {
        self.first..self.first.saturating_add(self.constraints.len())
    }

    /// The constraint of contact `j` of the cradle.
    pub fn constraint(&self, j: usize) -> Option<&Constraint> {
        self.constraints.get(j.checked_sub(self.first)?)
    }

    pub fn constraint_mut(&mut self, j: usize) -> Option<&mut Constraint> {
        self.constraints.get_mut(j.checked_sub(self.first)?)
    }

    /// Whether the end of the constraint of contact `j` is known.
    pub fn releases(&self, j: usize) -> bool {
        self.constraint(j).is_some_and(|constraint| matches!(constraint.end, Forecast::At(_)))
    }

    /// The oscillator of the common motion.
    pub fn oscillator(&self) -> Option<Oscillator> {
        self.constraints.first().map(|constraint| constraint.oscillator)
    }

    /// Joins `balls`, of which the first is the left one of contact `first`. They are in flight, anchored at `anchor`,
    /// with the same velocity, and get their flights in the body. Without contact, neighbours would approach each other
    /// with the accelerations `approach` (m/s2), known to within `rounding`.
    pub fn join(first: usize, balls: &mut [Ball], approach: &[f64], rounding: f64, anchor: DoubleDouble) -> Self {
        let contact = first;
        let first = &balls[0];
        let (o, v, on_line) = (&first.oscillator, first.flight.v, !first.model.on_arc);
        let differences = Differences::from_first(balls, approach);
        let total: f64 = balls.iter().map(|ball| ball.model.mass).sum();
        let mut mean = Differences::default();
        for (ball, difference) in balls.iter().zip(&differences) {
            mean.add(ball.model.mass / total, difference);
        }
        let omega2 = (o.omega2() + mean.omega2).max(0.0);
        let oscillator = Oscillator::new(omega2, (o.gamma() + mean.gamma).max(0.0));
        let mut forcing: Forcing = std::array::from_fn(|k| first.flight.forcing[k] + mean.forcing[k]);
        // On arcs, gravity pulls them all alike.
        let shift = if on_line { 1.0 } else { 0.0 };
        forcing[0] -= shift * o.omega2() * first.flight.x;
        let flight = Flight { x: 0.0, v, forcing };
        let (mut force, mut mass) = (Differences::default(), 0.0);
        let of_contact = |(ball, difference): (&Ball, &Differences)| {
            mass += ball.model.mass;
            force.add(ball.model.mass, difference);
            force.add(-ball.model.mass, &mean);
            Constraint {
                anchor,
                oscillator,
                flight,
                load: force.forcing,
                stiffness: force.omega2,
                drag: 2.0 * force.gamma,
                rounding: 4.0 * rounding * mass * (1.0 - mass / total),
                end: Forecast::Never,
            }
        };
        let constraints = balls.iter().zip(&differences).take(balls.len() - 1).map(of_contact).collect();
        for ball in balls {
            let x = ball.flight.x;
            (ball.oscillator, ball.flight) = (oscillator, Flight { x, ..flight });
            ball.flight.forcing[0] += shift * omega2 * x;
        }
        Self { first: contact, constraints }
    }
}

/// Differences between the motions of balls.
#[derive(Clone, Copy, Default)]
struct Differences {
    omega2: f64,
    gamma: f64,
    forcing: Forcing,
}

impl Differences {
    /// Those of each of `balls` from the first one, exactly 0 for equal balls. Neighbours would approach each other
    /// with the accelerations `approach` (m/s2).
    fn from_first(balls: &[Ball], approach: &[f64]) -> Vec<Self> {
        let first = &balls[0];
        let (o, v) = (&first.oscillator, first.flight.v);
        // The acceleration by inputs and gravity, less that of the first ball.
        let mut free = 0.0;
        let of_ball = |(i, ball): (usize, &Ball)| {
            if i > 0 {
                free -= approach[i - 1] + 2.0 * (balls[i - 1].oscillator.gamma() - ball.oscillator.gamma()) * v;
            }
            let mut forcing: Forcing = std::array::from_fn(|k| ball.flight.forcing[k] - first.flight.forcing[k]);
            if !first.model.on_arc {
                forcing[0] = free;
            }
            let [omega2, gamma] = [Oscillator::omega2, Oscillator::gamma].map(|of| of(&ball.oscillator) - of(o));
            Self { omega2, gamma, forcing }
        };
        balls.iter().enumerate().map(of_ball).collect()
    }

    fn add(&mut self, factor: f64, other: &Self) {
        self.omega2 += factor * other.omega2;
        self.gamma += factor * other.gamma;
        self.forcing.iter_mut().zip(&other.forcing).for_each(|(sum, forcing)| *sum += factor * forcing);
    }
}

impl Constraint {
    /// Whether it fits its balls at the time `now`, with finite values.
    pub fn is_sound(&self, balls: [&Ball; 2], now: DoubleDouble) -> bool {
        let of_ball = |ball: &Ball| ball.anchor == self.anchor && ball.oscillator == self.oscillator;
        balls.into_iter().all(of_ball) && self.is_finite() && self.anchor <= now
    }

    pub fn is_finite(&self) -> bool {
        let numbers = [self.stiffness, self.drag, self.rounding];
        let of_end = self.end.until().is_none_or(|time| time.is_sound());
        of_end && numbers.iter().chain(&self.load).all(|value| value.is_finite()) && self.flight.is_finite()
    }

    /// The force at the time `t`, N.
    pub fn force(&self, t: DoubleDouble) -> f64 {
        self.force_after((t - self.anchor).value())
    }

    fn force_after(&self, tau: f64) -> f64 {
        (-self.tension(tau)[0]).max(0.0)
    }

    /// The impulse from the anchor to the time `t`, N.s.
    pub fn impulse(&self, t: DoubleDouble) -> f64 {
        self.impulse_between(self.anchor, t)
    }

    /// The impulse between two times, N.s, with all its digits however long the contact has lasted.
    pub fn impulse_between(&self, from: DoubleDouble, to: DoubleDouble) -> f64 {
        let (before, tau) = ((from - self.anchor).value(), (to - from).value());
        let (mut of_load, mut power) = (0.0, 1.0);
        for (k, load) in shifted(&self.load, before).iter().enumerate() {
            power *= tau / (k + 1) as f64;
            of_load += load * power;
        }
        if self.stiffness == 0.0 && self.drag == 0.0 {
            return of_load;
        }
        let o = &self.oscillator;
        let (moved, v) = self.flight.at(o, from - self.anchor);
        let flight = Flight { x: self.flight.x + moved, v, forcing: shifted(&self.flight.forcing, before) };
        let u: [f64; BASIS] = o.basis(to - from);
        let way = moved * tau + flight.displacement_integral(o, &u);
        of_load - self.stiffness * way - self.drag * flight.displacement(o, &u)
    }

    /// The largest force between two times, with its time since the anchor; 0 if the second time is before the first.
    pub fn peak(&self, from: DoubleDouble, to: DoubleDouble) -> Peak {
        let (from, to) = ((from - self.anchor).value().max(0.0), (to - self.anchor).value());
        let mut peak = Peak { force: 0.0, time: from };
        if to < from {
            return peak;
        }
        peak.raise(self.force_after(from), from);
        peak.raise(self.force_after(to), to);
        if self.is_constant() || to <= from {
            return peak;
        }
        let o = &self.oscillator;
        let swings = (to - from) * (o.omega() + o.gamma()) / std::f64::consts::TAU;
        if swings <= 8.0 || o.gamma() < o.omega() {
            let panels = (4.0 + 16.0 * swings).min(MOST_PANELS);
            self.rise_to_maximum(&mut peak, from, to, panels as usize);
            return peak;
        }
        // Overdamped: the force changes ever more slowly.
        let (mut low, mut width) = (from, 0.25 / (o.omega() + o.gamma()));
        while low < to && width > 0.0 {
            let high = (low + width).min(to);
            self.rise_to_maximum(&mut peak, low, high, 1);
            (low, width) = (high, 1.25 * width);
        }
        peak
    }

    /// Raises `peak` to the largest maximum of the force between two times (s after the anchor); a panel has at most
    /// one.
    fn rise_to_maximum(&self, peak: &mut Peak, from: f64, to: f64, panels: usize) {
        let rate = |tau: f64| -self.tension(tau)[1];
        let node = |panel: usize| from + (to - from) * panel as f64 / panels as f64;
        let mut before = rate(from);
        for (low, high) in (0..panels).map(|panel| (node(panel), node(panel + 1))) {
            let after = rate(high);
            if before > 0.0 && after < 0.0 {
                let top = falling_zero(rate, low, high);
                // The place has half the digits; a step of Newton's method adds the rest.
                let [_, slope, curvature, _] = self.tension(top);
                let way = if curvature > 0.0 { -slope / curvature } else { 0.0 };
                peak.raise_to_maximum(self.force_after(top), (top + way).clamp(low, high), [low, high]);
            }
            before = after;
        }
    }

    fn is_constant(&self) -> bool {
        self.stiffness == 0.0 && self.drag == 0.0 && degree(&self.load) == 0
    }

    /// When, from `from` on, the force would pull by more than rounding; counts down the evaluations `allowed`.
    pub fn forecast(&self, from: DoubleDouble, allowed: &mut u32) -> Forecast<DoubleDouble> {
        let start = (from - self.anchor).value();
        if self.at(start)[0] > 0.0 {
            return Forecast::At(from);
        }
        if self.is_constant() {
            return Forecast::Never;
        }
        let horizon = start + reach(std::iter::once(&self.oscillator), start);
        forecast(self, self.anchor, [start, horizon], allowed, DoubleDouble::from)
    }

    /// The force as a power series of the time from `t` on, N.
    pub fn series(&self, t: DoubleDouble) -> Forcing {
        of_derivatives(self.tension((t - self.anchor).value()).map(|tension| -tension))
    }

    /// The reversed force and its first derivatives by time, `tau` (s) after the anchor: N, N/s, ...
    fn tension(&self, tau: f64) -> Forcing {
        let (o, [forcing, load]) = (&self.oscillator, [&self.flight.forcing, &self.load].map(|f| shifted(f, tau)));
        let mut motion = [0.0; MAX_FORCE_ORDER + 2];
        (motion[0], motion[1]) = self.flight.at(o, tau.into());
        for k in 0..MAX_FORCE_ORDER {
            motion[k + 2] = forcing[k] - o.omega2() * motion[k] - 2.0 * o.gamma() * motion[k + 1];
        }
        std::array::from_fn(|k| self.stiffness * motion[k] + self.drag * motion[k + 1] - load[k])
    }
}

impl Smooth for Constraint {
    /// Tension beyond rounding.
    fn at(&self, tau: f64) -> [f64; 3] {
        let [tension, rate, curvature, _] = self.tension(tau);
        [tension - self.rounding, rate, curvature]
    }

    fn third_derivative_bound(&self, t: f64, span: f64) -> f64 {
        let [third, fourth] = [3, 4].map(|order| self.flight.derivative_bound(&self.oscillator, t, span, order));
        self.load[MAX_FORCE_ORDER].abs() + self.stiffness.abs() * third + self.drag.abs() * fourth
    }
}
