//! One ball: its state at its anchor, its flight from there, and its integrals since the start.

use std::cell::RefCell;
use std::f64::consts::FRAC_PI_2;

use serde::{Deserialize, Serialize};

use super::free_motion::{Flight, Forcing, RunningIntegrals, degree, integral_of, shifted};
use super::path::{Fault, Origin, Path, Piece};
use crate::model::BallModel;
use crate::solver::{BASIS, DoubleDouble, Oscillator, Steady, quadrature::gauss_legendre};

/// A ball: its state at its anchor, and its motion in closed form from there unless an interaction governs it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Ball {
    #[serde(skip)]
    pub model: BallModel,
    /// The oscillator of its pendulum or, in a body of rigid balls, of the body.
    #[serde(skip)]
    pub oscillator: Oscillator,
    /// Time to which `flight` and `integrals` refer.
    pub anchor: DoubleDouble,
    /// State at the anchor. In a body of rigid balls the forcing includes the contact forces.
    pub flight: Flight,
    pub integrals: RunningIntegrals,
    /// Number of the interaction that the ball takes part in. In a body of rigid balls the ball is still in flight.
    #[serde(skip)]
    pub interaction: Option<u32>,
    /// Whether a flight on an arc begins with a long step, because no impact is near.
    pub starts_long: bool,
    /// Parts of its flight on an arc: the farthest that was asked for, and an earlier one, such as that at the start of
    /// a step. From the anchor on there may be millions.
    #[serde(skip)]
    pieces: RefCell<Pieces>,
}

impl Ball {
    pub fn new(model: &BallModel, anchor: DoubleDouble, flight: Flight) -> Self {
        let (oscillator, integrals) = (Oscillator::new(model.omega2, model.gamma), RunningIntegrals::default());
        Self {
            model: *model,
            oscillator,
            anchor,
            flight,
            integrals,
            interaction: None,
            starts_long: false,
            pieces: RefCell::default(),
        }
    }

    /// Whether its state and its integrals are finite.
    pub fn is_finite(&self) -> bool {
        self.flight.is_finite() && self.integrals.is_finite()
    }

    /// Applies `evaluate` to the part of its flight on an arc that holds at the time `t`, and the time since the start
    /// of that part (s).
    // Inlined, it would push other code out of the processor's cache: 14 % of the misses of separate impacts.
    #[inline(never)]
    fn piece<T>(&self, t: DoubleDouble, evaluate: impl FnOnce(&Piece, f64) -> T) -> T {
        self.go_on(t, u64::MAX, |piece, _| evaluate(piece, (t - piece.start).value()))
    }

    /// Like [`Self::piece`]; `None` on a line.
    #[inline(always)]
    fn along_arc<T>(&self, t: DoubleDouble, evaluate: impl FnOnce(&Piece, f64) -> T) -> Option<T> {
        self.model.on_arc.then(|| self.piece(t, evaluate))
    }

    /// Goes on by at most so many series to the part of its flight for the time `t`. Applies `evaluate` to the part
    /// reached, and to whether that is the one for `t`.
    #[inline(always)]
    fn go_on<T>(&self, t: DoubleDouble, most: u64, evaluate: impl FnOnce(&Piece, bool) -> T) -> T {
        let (mut known, origin) = (self.pieces.borrow_mut(), (self.anchor, self.flight, self.starts_long));
        let place = if leads_to(&known[0], origin, t) { 0 } else { make_room(&mut known, origin, t) };
        let piece = known[place].get_or_insert_with(|| Box::new(Piece::first(&self.model, origin)));
        let is_there = piece.holds_at(t) || piece.go_on(&self.model, t, most);
        evaluate(piece, is_there)
    }

    /// Keeps the part reached so far, for results at the start of a step that goes on from there.
    pub fn keep_part(&self) {
        let [farthest, earlier] = &mut *self.pieces.borrow_mut();
        earlier.clone_from(farthest);
    }

    /// Applies `evaluate` to the series of its flight on an arc about the time `t`.
    pub fn path<T>(&self, t: DoubleDouble, evaluate: impl FnOnce(&Path) -> T) -> T {
        if t == self.anchor {
            return self.piece(t, |piece, _| evaluate(&piece.path));
        }
        evaluate(&Path::new(&self.model, &self.flight_at(t), self.starts_long))
    }

    /// The fault that has ended its flight on an arc by the time `t`, and when. `Err` with the time reached if `t` is
    /// more than so many series away.
    pub fn fault_within(&self, t: DoubleDouble, most: u64) -> Result<Option<(DoubleDouble, Fault)>, DoubleDouble> {
        self.go_on(t, most, |piece, is_there| match is_there {
            true => Ok(piece.fault.filter(|(time, _)| *time <= t)),
            false => Err(piece.start),
        })
    }

    /// Whether its string is beyond the horizontal at the anchor, on an arc.
    pub fn fault_at_anchor(&self) -> Option<(DoubleDouble, Fault)> {
        let beyond = self.flight.x.abs() > FRAC_PI_2 * self.model.length;
        beyond.then_some((self.anchor, Fault::Horizontal))
    }

    /// Displacement since the anchor (m) and velocity (m/s) at the time `t`, in flight.
    #[inline]
    pub fn moved(&self, t: DoubleDouble) -> (f64, f64) {
        let moved = self.along_arc(t, |piece, tau| piece.moved(tau));
        moved.unwrap_or_else(|| self.flight.at(&self.oscillator, t - self.anchor))
    }

    /// Its flight, anchored at `t`.
    pub fn flight_at(&self, t: DoubleDouble) -> Flight {
        if t == self.anchor {
            return self.flight;
        }
        if let Some(flight) = self.along_arc(t, |piece, tau| piece.flight_at(tau)) {
            return flight;
        }
        let (displacement, v) = self.moved(t);
        Flight { x: self.flight.x + displacement, v, forcing: shifted(&self.flight.forcing, (t - self.anchor).value()) }
    }

    /// A bound (m) of its distance from the chord of its motion within `tau` (s) after the anchor, without contacts.
    pub fn chord_deviation(&self, tau: f64) -> f64 {
        let (o, flight) = (&self.oscillator, &self.flight);
        let varying = flight.forcing[1..].iter().rev().fold(0.0, |sum, forcing| (sum + forcing.abs()) * tau);
        let at_rest = (flight.forcing[0] - o.omega2() * flight.x).abs() + varying;
        let acceleration = at_rest + o.omega2() * flight.v.abs() * tau;
        acceleration * tau * tau
    }

    /// Its integrals at the time `t`, in flight, if only the part `inputs` of the forcing comes from the inputs.
    pub fn integrals_under(&self, inputs: &Forcing, t: DoubleDouble) -> RunningIntegrals {
        let Some(since) = self.along_arc(t, |piece, tau| piece.integrals(&self.model, tau)) else {
            return self.on_line(inputs, t).0;
        };
        let mut integrals = self.integrals;
        integrals.add(&since);
        integrals
    }

    /// [`Self::integrals_under`] on a line, with displacement (m) and velocity (m/s). Inlined, it computes only what is
    /// used.
    #[inline(always)]
    fn on_line(&self, inputs: &Forcing, t: DoubleDouble) -> (RunningIntegrals, f64, f64) {
        let tau = t - self.anchor;
        if degree(&self.flight.forcing).max(degree(inputs)) == 0 {
            self.on_line_by(inputs, tau.value(), &self.oscillator.basis::<4>(tau))
        } else {
            self.on_line_by(inputs, tau.value(), &self.oscillator.basis::<BASIS>(tau))
        }
    }

    /// As [`Self::on_line`], `tau` (s) after the anchor, from the oscillator's functions `u` at that time.
    #[inline(always)]
    fn on_line_by<const N: usize>(&self, inputs: &Forcing, tau: f64, u: &[f64; N]) -> (RunningIntegrals, f64, f64) {
        let (o, flight, mut integrals) = (&self.oscillator, &self.flight, self.integrals);
        let (displacement, v) = (flight.displacement(o, u), flight.velocity(o, u));
        integrals.support += self.on_support(flight, tau, u, (displacement, v));
        integrals.work += self.model.mass * flight.work(inputs, o, tau, u);
        integrals.drag_loss += self.drag_loss(tau, u);
        (integrals, displacement, v)
    }

    /// Impulse on the support over the mass, m/s, between the times `from` and `to`, in flight, with all its digits
    /// however long the flight is. On an arc, only the impulse of the inputs.
    pub fn support_between(&self, from: DoubleDouble, to: DoubleDouble) -> f64 {
        let (flight, tau) = (self.flight_at(from), to - from);
        if self.model.on_arc {
            return integral_of(&flight.forcing, tau.value());
        }
        let o = &self.oscillator;
        if degree(&flight.forcing) == 0 {
            let u: [f64; 4] = o.basis(tau);
            return self.on_support(&flight, tau.value(), &u, (flight.displacement(o, &u), flight.velocity(o, &u)));
        }
        let u: [f64; BASIS] = o.basis(tau);
        self.on_support(&flight, tau.value(), &u, (flight.displacement(o, &u), flight.velocity(o, &u)))
    }

    /// Impulse on the support over the mass, m/s, within `tau` (s) of a `flight` on a line; `moved` is the
    /// displacement, m, and the velocity then, m/s.
    #[inline(always)]
    fn on_support<const N: usize>(&self, flight: &Flight, tau: f64, u: &[f64; N], moved: (f64, f64)) -> f64 {
        let (model, (displacement, v)) = (&self.model, moved);
        let pendulum = model.omega2 * (flight.x * tau + flight.displacement_integral(&self.oscillator, u));
        if model.gamma == 0.0 {
            return pendulum;
        }
        let drag = 2.0 * model.gamma * displacement;
        // The impulse of the inputs less the change of momentum equals the sum of both. If they nearly cancel, it has
        // the smaller terms.
        let given = if N < BASIS { flight.forcing[0] * tau } else { integral_of(&flight.forcing, tau) };
        let small = given.abs() + v.abs() + flight.v.abs() < pendulum.abs() + drag.abs();
        if small && self.interaction.is_none() { given - (v - flight.v) } else { pendulum + drag }
    }

    /// Energy lost to drag within `tau` (s) after the anchor, in flight, J, from the oscillator's functions `u` at that
    /// time.
    fn drag_loss<const N: usize>(&self, tau: f64, u: &[f64; N]) -> f64 {
        let (o, flight) = (&self.oscillator, &self.flight);
        if o.gamma() == 0.0 {
            return 0.0;
        }
        if o.gamma() * tau > 0.5 {
            // The loss is a good part of the energy, so a difference of energies is exact enough.
            let (displacement, v) = (flight.displacement(o, u), flight.velocity(o, u));
            let kinetic = 0.5 * (flight.v - v) * (flight.v + v);
            let potential = o.omega2() * displacement * (flight.x + 0.5 * displacement);
            return self.model.mass * (kinetic - potential + flight.work(&flight.forcing, o, tau, u));
        }
        let (swung, varying) = (o.omega() * tau, degree(&flight.forcing) > 0);
        if swung > if varying { 8.0 } else { 1.0 }
            && let Some(steady) = Steady::new(o, flight.v, flight.acceleration(o, 0.0, 0.0, flight.v), &flight.forcing)
        {
            return 2.0 * o.gamma() * self.model.mass * steady.squared_velocity_integral(o, tau);
        }
        // Both other forms would cancel.
        let power = |s: f64| {
            let (_, v) = flight.at(o, s.into());
            2.0 * o.gamma() * self.model.mass * v * v
        };
        gauss_legendre(&power, 0.0, tau, 1 + swung as usize)
    }

    /// Moves the anchor to `t` along the flight; returns the displacement, m.
    pub fn reanchor(&mut self, t: DoubleDouble) -> f64 {
        if t == self.anchor {
            return 0.0;
        }
        let evaluate =
            |piece: &Piece, tau| (piece.flight_at(tau), piece.moved(tau).0, piece.integrals(&self.model, tau));
        if let Some((flight, displacement, sums)) = self.along_arc(t, evaluate) {
            self.integrals.add(&sums);
            (self.flight, self.anchor, self.starts_long) = (flight, t, false);
            return displacement;
        }
        let (integrals, displacement, v) = self.on_line(&self.flight.forcing, t);
        let forcing = shifted(&self.flight.forcing, (t - self.anchor).value());
        self.flight = Flight { x: self.flight.x + displacement, v, forcing };
        (self.integrals, self.anchor) = (integrals, t);
        displacement
    }
}

/// Parts of a flight, the farthest first.
type Pieces = [Option<Box<Piece>>; 2];

#[inline(always)]
fn leads_to(piece: &Option<Box<Piece>>, origin: Origin, t: DoubleDouble) -> bool {
    piece.as_ref().is_some_and(|piece| piece.leads_to(origin, t))
}

/// The index for a part on the way to the time `t`, if the farthest part does not lead there; emptied if its part does
/// not.
fn make_room(known: &mut Pieces, origin: Origin, t: DoubleDouble) -> usize {
    let place = usize::from(known[0].as_ref().is_some_and(|piece| piece.origin == origin));
    known[place].take_if(|piece| !piece.leads_to(origin, t));
    place
}

/// The places (m) of neighbours, each at a distance (m) to the left of the one before; the first is at 0.
pub(crate) fn places(distances: impl Iterator<Item = f64> + Clone) -> impl Iterator<Item = f64> + Clone {
    let place = |place: &mut f64, distance| {
        *place -= distance;
        Some(*place)
    };
    std::iter::once(0.0).chain(distances.scan(0.0, place))
}

/// The position (m) of the first ball that keeps the centre of mass, from mass (kg), position (m) and [place](places).
pub(crate) fn start_by_centre(balls: impl Iterator<Item = ((f64, f64), f64)> + Clone) -> f64 {
    let first = balls.clone().next().map_or(0.0, |((_, x), _)| x);
    let (mut moment, mut total) = (0.0, 0.0);
    for ((mass, x), place) in balls {
        moment += mass * (x - first - place);
        total += mass;
    }
    first + moment / total
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Cradle, Parameters, PendulumModel};

    /// Strong gravity makes the series of a flight short. The way from the anchor is computed only once, even if
    /// results at the start of the step are asked for in between.
    #[test]
    fn flight_over_long_times_is_followed_once() {
        let p = Parameters { pendulum: PendulumModel::Circular, gravity: 1e10, ..Parameters::default_for(1) };
        let flight = Flight { x: -0.1, v: 0.0, forcing: Forcing::default() };
        let ball = Ball::new(&Cradle::new(&p).balls[0], DoubleDouble::ZERO, flight);
        let [before, start, end] = [0.25, 0.5, 1.0].map(DoubleDouble::from);
        let reached = ball.fault_within(start, 100).unwrap_err();
        assert!(reached > DoubleDouble::ZERO && reached < before, "{reached:?}");
        let to_the_end = |t: DoubleDouble| ball.fault_within(t, u64::MAX);
        assert_eq!((to_the_end(start), ball.fault_within(start, 1)), (Ok(None), Ok(None)));
        ball.keep_part();
        assert!(ball.fault_within(end, 100).is_err() && to_the_end(end) == Ok(None));
        let at_once = |t: DoubleDouble| ball.fault_within(t, 1).is_ok();
        assert!([end, start, end, start].into_iter().all(at_once));
        assert!(!at_once(before) && to_the_end(before) == Ok(None));
        assert!([end, before, end].into_iter().all(at_once));
        // Backwards there are other parts.
        assert!(!at_once(DoubleDouble::from(-1e-3)));
    }
}
