//! One ball: its flight since its anchor, and what it has gathered since the start.

use std::cell::Cell;

use serde::{Deserialize, Serialize};

use super::step_start::BallStart;
use crate::model::{BallModel, ContactLaw};
use crate::solver::double_double::DoubleDouble;
use crate::solver::dual::Scalar;
use crate::solver::oscillator::{BASIS, MAX_FORCE_ORDER, Oscillator};
use crate::solver::quadrature::gauss_legendre;
use crate::solver::steady::Steady;

/// Acceleration by the inputs, as derivatives at the anchor: `push[j]` in m/s^(2+j).
pub(crate) type Push = [f64; MAX_FORCE_ORDER + 1];

/// Highest derivative of the push that is not zero.
#[inline]
pub(crate) fn degree(push: &Push) -> usize {
    // Most inputs are constant: one comparison in place of three.
    if push[1..].iter().fold(0.0, |sum, p| sum + p.abs()) == 0.0 {
        return 0;
    }
    (1..=MAX_FORCE_ORDER).rev().find(|&j| push[j] != 0.0).unwrap_or(0)
}

/// Its value `tau` (s) after the anchor, m/s2.
pub(crate) fn push_at(push: &Push, tau: f64) -> f64 {
    (0..=degree(push)).rev().fold(0.0, |sum, k| push[k] + sum * tau / (k + 1) as f64)
}

/// The same polynomial seen from `tau` (s) later.
pub(crate) fn shifted<S: Scalar>(push: &[S; MAX_FORCE_ORDER + 1], tau: S) -> [S; MAX_FORCE_ORDER + 1] {
    let mut later = *push;
    if push[1..].iter().all(|p| p.value() == 0.0 && p.tangent() == 0.0) {
        return later;
    }
    for (j, later) in later.iter_mut().enumerate() {
        let mut power = S::from(1.0);
        for (k, &p) in push.iter().enumerate().skip(j + 1) {
            power = power * (tau / S::from((k - j) as f64));
            *later += p * power;
        }
    }
    later
}

/// The positions (m) of neighbours at these distances (m), each to the left of the one before, with the centre of mass of `balls`,
/// which are given by mass (kg) and position.
pub(crate) fn spaced(
    balls: impl Iterator<Item = (f64, f64)> + Clone,
    distances: impl Iterator<Item = f64>,
) -> Vec<f64> {
    let mut places = vec![0.0];
    places.extend(distances.scan(0.0, |place, distance| {
        *place -= distance;
        Some(*place)
    }));
    let first = balls.clone().next().map_or(0.0, |(_, x)| x);
    let (mut moment, mut total) = (0.0, 0.0);
    for ((mass, x), place) in balls.zip(&places) {
        moment += mass * (x - first - place);
        total += mass;
    }
    places.into_iter().map(|place| first + moment / total + place).collect()
}

/// Contact-free motion from an anchor on: a closed form of the time since then.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Flight {
    /// Position at the anchor, m.
    pub x: f64,
    /// Velocity at the anchor, m/s.
    pub v: f64,
    /// Acceleration by the inputs.
    pub push: Push,
}

/// How far positions (m) and velocities (m/s) are known.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rounding {
    pub position: f64,
    pub velocity: f64,
}

impl Rounding {
    pub fn max(self, other: Self) -> Self {
        Self { position: self.position.max(other.position), velocity: self.velocity.max(other.velocity) }
    }

    /// Overlap (m) that is as good as none, far below the rounding: a contact that damping alone opens would never be open.
    pub fn no_overlap(&self) -> f64 {
        1e-10 * self.position
    }

    /// Force (N) that a contact may have by rounding alone.
    pub fn force(&self, law: &ContactLaw) -> f64 {
        law.unclipped_force(self.position, self.velocity)
    }
}

impl Flight {
    pub fn is_finite(&self) -> bool {
        [self.x, self.v].iter().chain(&self.push).all(|value| value.is_finite())
    }

    /// Displacement (m) `tau` after the anchor, and velocity (m/s).
    #[inline]
    pub fn at(&self, o: &Oscillator, tau: DoubleDouble) -> (f64, f64) {
        if degree(&self.push) == 0 {
            let u: [f64; 3] = o.basis(tau);
            (self.displacement(o, &u), self.velocity(o, &u))
        } else {
            let u: [f64; BASIS] = o.basis(tau);
            (self.displacement(o, &u), self.velocity(o, &u))
        }
    }

    /// What rounding leaves open over a swing.
    pub fn rounding(&self, o: &Oscillator) -> Rounding {
        let swing = if o.omega() > 0.0 { self.v.abs() / o.omega() } else { 0.0 };
        let (x, v) = (self.x.abs() + swing, self.v.abs() + o.omega() * self.x.abs());
        Rounding { position: 2.0 * f64::EPSILON * x, velocity: 2.0 * f64::EPSILON * v }
    }

    /// Displacement since the anchor, m, from the oscillator's functions at that time.
    pub fn displacement<const N: usize>(&self, o: &Oscillator, u: &[f64; N]) -> f64 {
        self.response(o, u, 1)
    }

    /// Integral of the displacement since the anchor, m.s.
    pub fn displacement_integral<const N: usize>(&self, o: &Oscillator, u: &[f64; N]) -> f64 {
        self.response(o, u, 2)
    }

    /// Velocity, m/s.
    pub fn velocity<const N: usize>(&self, o: &Oscillator, u: &[f64; N]) -> f64 {
        self.response(o, u, 0)
    }

    /// The displacement integrated `level - 1` times: `v U_level + A U_(level+1) + push_1 U_(level+2) + ...`. Fewer functions than
    /// [`BASIS`] do where the push is constant.
    #[inline]
    fn response<const N: usize>(&self, o: &Oscillator, u: &[f64; N], level: usize) -> f64 {
        debug_assert!(N == BASIS || degree(&self.push) == 0);
        let free = self.v * u[level] + (self.push[0] - o.omega2() * self.x) * u[level + 1];
        if N < BASIS {
            return free;
        }
        free + (1..=degree(&self.push)).map(|j| self.push[j] * u[level + 1 + j]).sum::<f64>()
    }

    /// Acceleration `tau` after the anchor, m/s2, where the displacement and the velocity are the given ones.
    pub fn acceleration(&self, o: &Oscillator, tau: f64, displacement: f64, v: f64) -> f64 {
        push_at(&self.push, tau) - o.omega2() * self.x - o.omega2() * displacement - 2.0 * o.gamma() * v
    }

    /// The work of `push` on this motion per unit of mass since the anchor, m2/s2: `integral f v = f D - f' I_1 + f'' I_2 - ...`
    /// with the repeated integrals `I_k` of the displacement D.
    pub fn work<const N: usize>(&self, push: &Push, o: &Oscillator, tau: f64, u: &[f64; N]) -> f64 {
        if N < BASIS || degree(push) == 0 {
            return if push[0] == 0.0 { 0.0 } else { push[0] * self.displacement(o, u) };
        }
        let later = shifted(push, tau);
        let terms = (0..=degree(push)).map(|j| later[j] * self.response(o, u, j + 1));
        terms.enumerate().map(|(j, term)| if j % 2 == 0 { term } else { -term }).sum()
    }

    /// Bound of the absolute derivative of this `order` (3 or 4) of the position between `t` and `span` later (s after the anchor).
    ///
    /// For a push that varies, `sqrt(a^2 + omega^2 v^2)` grows at most by the integral of its rate.
    pub fn derivative_bound(&self, o: &Oscillator, t: f64, span: f64, order: i32) -> f64 {
        let a = self.acceleration(o, 0.0, 0.0, self.v);
        if degree(&self.push) == 0 {
            return o.derivative_bound(self.v, a, t, order);
        }
        let end = t + span;
        let (mut rate, mut curvature, mut power) = (0.0, 0.0, 1.0);
        for j in 1..=degree(&self.push) {
            rate += self.push[j].abs() * power;
            curvature += self.push.get(j + 1).map_or(0.0, |push| push.abs() * power);
            power *= end / j as f64;
        }
        let amplitude = (a * a + o.omega2() * self.v * self.v).sqrt() + rate * end;
        let third = rate + (o.omega() + 2.0 * o.gamma()) * amplitude;
        let grown = if order == 3 { third } else { curvature + o.omega2() * amplitude + 2.0 * o.gamma() * third };
        // Early on that is the tighter one; once drag has made the start forgotten, the motion follows the push.
        if o.gamma() > 0.0
            && let Some(steady) = Steady::new(o, self.v, a, &self.push)
        {
            return grown.min(steady.derivative_bound(o, t, end, order));
        }
        grown
    }
}

/// Sums over time that a ball carries along.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Tally {
    /// Integral of the position, m.s.
    pub x_integral: f64,
    /// Energy lost to drag, J.
    pub drag_loss: f64,
    /// Work of the inputs, J.
    pub work: f64,
}

impl Tally {
    pub fn is_finite(&self) -> bool {
        [self.x_integral, self.drag_loss, self.work].iter().all(|value| value.is_finite())
    }

    pub fn add(&mut self, more: &Self) {
        self.x_integral += more.x_integral;
        self.drag_loss += more.drag_loss;
        self.work += more.work;
    }
}

/// What a ball takes part in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Held {
    /// In flight.
    Free,
    /// Member of this cluster.
    Cluster(u32),
    /// In an impact of known outcome in this contact.
    Impact(u32),
    /// In lasting contact with rigid neighbours, with which it moves as one body.
    Bond,
}

/// A ball and its motion. While it belongs to a cluster, that cluster holds its state and `flight` is out of date; in an impact
/// of known outcome `flight` is what it came with. In a body of rigid balls `oscillator` and `flight` are those of the body, so
/// that the contacts act as a part of the push.
#[derive(Clone, Debug)]
pub(crate) struct Ball {
    pub mass: f64,
    pub oscillator: Oscillator,
    /// Time that `flight` and `tally` refer to.
    pub anchor: DoubleDouble,
    pub flight: Flight,
    pub tally: Tally,
    pub held: Held,
    /// How it stood at the start of a step, and of which.
    pub at_start: BallStart,
    /// What was calculated when it was last asked for.
    pub known: Cell<Known>,
}

/// The state of a ball at a time, calculated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    /// The time, s; NaN for none.
    pub time: f64,
    /// The anchor of its flight then.
    pub anchor: DoubleDouble,
    /// Position, m, and velocity, m/s.
    pub state: (f64, f64),
    /// The functions of the oscillator that they followed from.
    pub basis: Option<[f64; 3]>,
}

impl Ball {
    pub fn new(model: &BallModel, anchor: DoubleDouble, flight: Flight) -> Self {
        let oscillator = Oscillator::new(model.omega2, model.gamma);
        Self {
            mass: model.mass,
            oscillator,
            anchor,
            flight,
            tally: Tally::default(),
            held: Held::Free,
            at_start: BallStart::default(),
            known: Cell::new(Known { time: f64::NAN, anchor, state: (0.0, 0.0), basis: None }),
        }
    }

    /// Displacement since the anchor (m) and velocity (m/s) at the time `t`, in flight.
    #[inline]
    pub fn moved(&self, t: DoubleDouble) -> (f64, f64) {
        self.flight.at(&self.oscillator, t - self.anchor)
    }

    /// The same motion anchored at `t`.
    pub fn flight_at(&self, t: DoubleDouble) -> Flight {
        if t == self.anchor {
            return self.flight;
        }
        let (displacement, v) = self.moved(t);
        Flight { x: self.flight.x + displacement, v, push: shifted(&self.flight.push, (t - self.anchor).value()) }
    }

    /// How far it can leave the chord of its motion within `tau` (s) after the anchor, but for contacts, m.
    pub fn bend(&self, tau: f64) -> f64 {
        let (o, flight) = (&self.oscillator, &self.flight);
        let varying = flight.push[1..].iter().rev().fold(0.0, |sum, push| (sum + push.abs()) * tau);
        let at_rest = (flight.push[0] - o.omega2() * flight.x).abs() + varying;
        let acceleration = at_rest + o.omega2() * flight.v.abs() * tau;
        acceleration * tau * tau
    }

    /// The sums at the time `t`, in flight.
    pub fn tally_at(&self, t: DoubleDouble) -> Tally {
        self.tally_under(&self.flight.push, t)
    }

    /// The sums at the time `t`, where only the part `inputs` of the push is by the inputs.
    pub fn tally_under(&self, inputs: &Push, t: DoubleDouble) -> Tally {
        let tau = t - self.anchor;
        if degree(&self.flight.push).max(degree(inputs)) == 0 {
            self.tally_after(inputs, tau.value(), &self.oscillator.basis::<4>(tau))
        } else {
            self.tally_after(inputs, tau.value(), &self.oscillator.basis::<BASIS>(tau))
        }
    }

    /// The sums `tau` after the anchor, from the oscillator's functions at that time.
    fn tally_after<const N: usize>(&self, inputs: &Push, tau: f64, u: &[f64; N]) -> Tally {
        let (o, flight) = (&self.oscillator, &self.flight);
        let mut tally = self.tally;
        tally.x_integral += flight.x * tau + flight.displacement_integral(o, u);
        tally.work += self.mass * flight.work(inputs, o, tau, u);
        tally.drag_loss += self.drag_loss(tau, u);
        tally
    }

    /// Energy lost to drag within `tau` (s) after the anchor, in flight, J; `u` are the oscillator's functions at that time.
    fn drag_loss<const N: usize>(&self, tau: f64, u: &[f64; N]) -> f64 {
        let (o, flight) = (&self.oscillator, &self.flight);
        if o.gamma() == 0.0 {
            return 0.0;
        }
        if o.gamma() * tau > 0.5 {
            // What is missing of the energy, which is a good part of it.
            let (displacement, v) = (flight.displacement(o, u), flight.velocity(o, u));
            let kinetic = 0.5 * (flight.v - v) * (flight.v + v);
            let potential = o.omega2() * displacement * (flight.x + 0.5 * displacement);
            return self.mass * (kinetic - potential + flight.work(&flight.push, o, tau, u));
        }
        let (swung, varying) = (o.omega() * tau, degree(&flight.push) > 0);
        if swung > if varying { 8.0 } else { 1.0 }
            && let Some(steady) = Steady::new(o, flight.v, flight.acceleration(o, 0.0, 0.0, flight.v), &flight.push)
        {
            return 2.0 * o.gamma() * self.mass * steady.squared_velocity_integral(o, tau);
        }
        // Both of these would cancel.
        let power = |s: f64| {
            let (_, v) = flight.at(o, s.into());
            2.0 * o.gamma() * self.mass * v * v
        };
        gauss_legendre(power, 0.0, tau, 3 + swung as usize)
    }

    /// Moves the anchor to `t` along the flight; returns the displacement, m.
    pub fn land(&mut self, t: DoubleDouble) -> f64 {
        if t == self.anchor {
            return 0.0;
        }
        let tau = t - self.anchor;
        let displacement = if degree(&self.flight.push) == 0 {
            self.land_after(tau.value(), &self.oscillator.basis::<4>(tau))
        } else {
            self.land_after(tau.value(), &self.oscillator.basis::<BASIS>(tau))
        };
        self.anchor = t;
        displacement
    }

    /// Takes flight and sums to `tau` after the anchor, from the oscillator's functions at that time; returns the displacement, m.
    fn land_after<const N: usize>(&mut self, tau: f64, u: &[f64; N]) -> f64 {
        let displacement = self.flight.displacement(&self.oscillator, u);
        self.tally = self.tally_after(&self.flight.push, tau, u);
        self.flight = Flight {
            x: self.flight.x + displacement,
            v: self.flight.velocity(&self.oscillator, u),
            push: shifted(&self.flight.push, tau),
        };
        displacement
    }
}
