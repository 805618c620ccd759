//! An open contact between two balls in flight: its overlap in closed form, and its next onset.

use serde::{Deserialize, Serialize};

use super::approach::Approach;
use super::ball::Ball;
use super::free_motion::{Flight, degree, time_of_change};
use super::path::Path;
use crate::engine::Forecast;
use crate::model::ContactLaw;
use crate::solver::root::{safe_step, search_within};
use crate::solver::{DoubleDouble, Oscillator, Smooth, all_finite, hypotenuse};

/// The overlap of two balls (negative while apart): its value at an anchor plus the displacements since then. So a gap
/// of 1e-12 m right after a release keeps its digits, although positions are of 1 m.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Separation {
    pub anchor: DoubleDouble,
    overlap: f64,
    /// Motion of the left ball; for equal pendulums the difference of both motions, which obeys the same equation.
    motion: FreeMotion,
    /// Motion of the right ball if its pendulum is another one.
    other: Option<FreeMotion>,
    /// Rounding of the positions over a swing, m: an overlap up to this is no onset.
    pub rounding: f64,
    /// Rounding of rate (m/s) and acceleration (m/s2) right after the anchor: an overlap that comes from these is no
    /// onset.
    resolution: [f64; 2],
    /// For balls on arcs: the overlap as a series, which replaces the two motions.
    approach: Option<Box<Approach>>,
}

/// A motion without contact: its oscillator, and its state and forcing at the anchor.
type FreeMotion = (Oscillator, Flight);

/// Most evaluations of one forecast, far more than usual; the next forecast continues.
pub(crate) const EVALUATIONS: u32 = 4_000;

/// Part of its length after which the series of balls on arcs is renewed together with a neighbour's.
const WORN: f64 = 0.6;

/// Number of evaluations for which a forecast on arcs counts.
const ON_ARCS: u32 = 20;

/// Least progress of a forecast over the time since the anchor; a search with less only follows rounding.
const LEAST_PROGRESS: f64 = 1e-6;

/// Relative rounding of several operations.
pub(crate) const ROUNDINGS: f64 = 8.0 * f64::EPSILON;

/// Part of its reach that a forecast looks at first, and least part that this look must clear to pay.
const FIRST_LOOK: f64 = 0.25;
const LEAST_CLEARED: f64 = 0.02;

/// Decay times that a forecast of free balls with drag covers.
const DECAY_TIMES: f64 = 100.0;

/// Reach of a forecast without a closed form, in periods; for overdamped pendulums, in slow decay times times 2 pi.
const PERIODS_AHEAD: f64 = 2.0;

/// Least reach of a forecast of free balls, s: doubles resolve it whatever the drag.
const SHORTEST_LOOK: f64 = 1e-12;

impl Separation {
    /// The contact between `left` and `right`, both anchored at or before `anchor`, with its overlap there (m).
    pub fn new(left: &Ball, right: &Ball, anchor: DoubleDouble, overlap: f64, law: &ContactLaw) -> Self {
        let (l, r) = (left.flight_at(anchor), right.flight_at(anchor));
        let approach = left.model.on_arc.then(|| {
            let lengths = [left, right].map(|ball| ball.model.length);
            let beside = |l: &Path| right.path(anchor, |r| Approach::new(lengths, [l, r], overlap, law));
            Box::new(left.path(anchor, beside))
        });
        let (motion, other) = if approach.is_none() && left.oscillator == right.oscillator {
            let mut forcing = l.forcing;
            forcing.iter_mut().zip(&r.forcing).for_each(|(p, r)| *p -= r);
            // Gravity pulls on the difference of the positions; the overlap gives it without their rounding.
            ((left.oscillator, Flight { x: overlap + law.clearance, v: l.v - r.v, forcing }), None)
        } else {
            ((left.oscillator, l), Some((right.oscillator, r)))
        };
        let rounding = l.rounding(&left.oscillator).max(r.rounding(&right.oscillator)).position;
        Self { anchor, overlap, motion, other, rounding, resolution: [0.0; 2], approach }
    }

    /// Makes it a contact of rigid balls, which may be side by side for long. Overlaps up to `rounding` (m) are then no
    /// onsets, nor are those by the rounding of two different motions, or of inputs that have varied for `age` (s).
    pub fn make_rigid(&mut self, rounding: f64, age: f64) {
        self.rounding = self.rounding.max(rounding);
        let of_time = |flight: &Flight| flight.forcing[1].abs() * age;
        let acceleration =
            |(o, flight): &FreeMotion| flight.acceleration(o, 0.0, 0.0, flight.v).abs() + of_time(flight);
        let resolution = match self.other {
            None => [0.0, of_time(&self.motion.1)],
            Some(_) => [self.motions().map(|(_, flight)| flight.v.abs()).sum(), self.motions().map(acceleration).sum()],
        };
        self.resolution = resolution.map(|size: f64| ROUNDINGS * size);
    }

    /// Whether it fits its balls at the time `now`, with finite values.
    pub fn is_sound(&self, [left, right]: [&Ball; 2], now: DoubleDouble) -> bool {
        let right_oscillator = self.other.as_ref().map_or(self.motion.0, |(o, _)| *o);
        let own = self.other.is_none() || left.oscillator != right.oscillator;
        let differ = own || self.approach.is_some();
        let pendulums = self.motion.0 == left.oscillator && right_oscillator == right.oscillator && differ;
        pendulums && self.is_finite() && self.anchor.is_sound() && self.anchor <= now
    }

    pub fn is_finite(&self) -> bool {
        let [rate, acceleration] = self.resolution;
        self.motion.1.is_finite()
            && self.other.as_ref().is_none_or(|(_, flight)| flight.is_finite())
            && all_finite([self.overlap, self.rounding, rate, acceleration])
            && self.approach.as_ref().is_none_or(|approach| approach.is_sound())
    }

    /// Overlap (m) and its rate (m/s) at the time `t`.
    pub fn at_time(&self, t: DoubleDouble) -> (f64, f64) {
        let [overlap, rate, _] = self.evaluate(t - self.anchor);
        (overlap, rate)
    }

    /// Whether the balls touch at the time `t`, within the rounding of their positions or within `rounding` (m).
    pub fn touches(&self, t: DoubleDouble, rounding: f64) -> bool {
        self.at_time(t).0 >= -self.rounding.max(rounding)
    }

    /// Whether the bounce after the onset at `t`, with the coefficient of restitution `e`, stays lower than the
    /// rounding of the positions or is shorter than `shortest` (s).
    pub fn is_last_bounce(&self, t: DoubleDouble, e: f64, shortest: f64) -> bool {
        let [_, rate, acceleration] = self.evaluate(t - self.anchor);
        let rebound = e * rate;
        rebound * rebound <= 2.0 * acceleration * self.rounding || 2.0 * rebound < acceleration * shortest
    }

    fn motions(&self) -> impl Iterator<Item = &FreeMotion> + Clone {
        std::iter::once(&self.motion).chain(&self.other)
    }

    /// Three `values` of the overlap's motion: left ball less right ball.
    fn difference(&self, values: impl Fn(&Oscillator, &Flight) -> [f64; 3]) -> [f64; 3] {
        let own = values(&self.motion.0, &self.motion.1);
        let Some((o, flight)) = &self.other else { return own };
        let other = values(o, flight);
        std::array::from_fn(|k| own[k] - other[k])
    }

    /// Overlap (m), rate (m/s) and acceleration (m/s2) `tau` after the anchor.
    fn evaluate(&self, tau: DoubleDouble) -> [f64; 3] {
        if let Some(approach) = &self.approach {
            return approach.at(tau.value());
        }
        let [d, v, a] = self.difference(|o, flight| {
            let (d, v) = flight.at(o, tau);
            [d, v, flight.acceleration(o, tau.value(), d, v)]
        });
        [self.overlap + d, v, a]
    }

    /// End of the series of balls on arcs on the way to the time `t`, if it does not hold until then.
    pub fn end_before(&self, t: DoubleDouble) -> Option<DoubleDouble> {
        let (approach, tau) = (self.approach.as_ref()?, (t - self.anchor).value());
        let length = if tau < 0.0 { approach.before } else { approach.length };
        let end = self.anchor + length.copysign(tau);
        (tau.abs() > length && end != self.anchor).then_some(end)
    }

    /// When balls on arcs change sides, as far as their series holds.
    pub fn crossing(&self) -> Option<DoubleDouble> {
        self.approach.as_ref()?.crossing.map(|tau| self.anchor + tau)
    }

    /// Whether the series of balls on arcs will not hold for long after the time `t`.
    pub fn nears_end(&self, t: DoubleDouble) -> bool {
        self.approach.as_ref().is_some_and(|approach| (t - self.anchor).value() > WORN * approach.length)
    }

    /// The next onset after `from`, at or after the anchor; counts down the evaluations that are `allowed`.
    pub fn forecast(&self, from: DoubleDouble, allowed: &mut u32) -> Forecast<DoubleDouble> {
        if let Some(approach) = &self.approach {
            *allowed = allowed.saturating_sub(ON_ARCS);
            let onset = approach.onset(self.rounding, self.resolution);
            if let Some(crossing) = self.crossing()
                && onset.is_none_or(|onset| crossing < self.anchor + onset)
            {
                return Forecast::NotBefore(crossing);
            }
            return match onset {
                Some(tau) => Forecast::At(self.anchor + tau),
                None if approach.is_constant() => Forecast::Never,
                None => Forecast::NotBefore(self.anchor + approach.length),
            };
        }
        if self.stays_apart() {
            return Forecast::Never;
        }
        let start = (from - self.anchor).value();
        let reach = reach(self.motions().map(|(o, _)| o), start);
        let mut clear = start;
        if start == 0.0 {
            // Events overtake most forecasts, so a cheap bound comes first, over half a period, where it is tight.
            clear = safe_step(self, 0.0, self.at_anchor(), FIRST_LOOK * reach);
            if clear > LEAST_CLEARED * reach {
                return Forecast::NotBefore(self.anchor + clear);
            }
        } else if let Some(tau) = self.next_wave(start) {
            return Forecast::At(self.anchor + tau);
        }
        let horizon = start + reach;
        // Up to `clear` there is no onset.
        forecast(self, self.anchor, [clear, horizon], allowed, |tau| self.polished(tau))
    }

    /// Overlap (m), rate (m/s) and acceleration (m/s2) at the anchor.
    pub fn at_anchor(&self) -> [f64; 3] {
        if self.approach.is_some() {
            return self.evaluate(DoubleDouble::ZERO);
        }
        let at_anchor = |o: &Oscillator, flight: &Flight| [0.0, flight.v, flight.acceleration(o, 0.0, 0.0, flight.v)];
        let [_, v, a] = self.difference(at_anchor);
        [self.overlap, v, a]
    }

    /// The next rise through zero from `start` (s) on if the overlap is a plain wave; `None` if not, or if it only
    /// grazes.
    fn next_wave(&self, start: f64) -> Option<DoubleDouble> {
        let (o, flight) = &self.motion;
        if self.other.is_some() || o.gamma() > 0.0 || o.omega2() == 0.0 || degree(&flight.forcing) > 0 {
            return None;
        }
        // overlap + equilibrium + sine sin(omega t) - equilibrium cos(omega t)
        let equilibrium = flight.forcing[0] / o.omega2() - flight.x;
        let sine = flight.v / o.omega();
        let amplitude = hypotenuse(sine * sine + equilibrium * equilibrium, sine, equilibrium);
        let level = -(self.overlap + equilibrium) / amplitude;
        if level.is_nan() || level.abs() > 0.999_999 {
            return None;
        }
        let turn = std::f64::consts::TAU;
        let phase = libm::atan2(sine, -equilibrium) - libm::acos(level);
        let turns = libm::ceil((o.omega() * start - 1e-9 - phase) / turn);
        let mut tau = DoubleDouble::from((phase + turns * turn) / o.omega());
        for _ in 0..4 {
            let [overlap, rate, _] = self.evaluate(tau);
            let correction = -overlap / rate;
            tau += correction;
            if correction.abs() <= ROUNDINGS * tau.value() {
                return Some(tau);
            }
        }
        None
    }

    /// The crossing near `tau` (s), in double-double.
    fn polished(&self, tau: f64) -> DoubleDouble {
        let [overlap, rate, _] = self.evaluate(tau.into());
        let correction = -overlap / rate;
        if rate > 0.0 && correction.abs() <= 1e-6 * tau { DoubleDouble::from(tau) + correction } else { tau.into() }
    }

    /// Whether the amplitudes alone rule out a contact.
    fn stays_apart(&self) -> bool {
        // Highest displacement times `side`: equilibrium plus amplitude, which drag only reduces.
        let highest = |((o, flight), side): (&FreeMotion, f64)| {
            if degree(&flight.forcing) > 0 || o.omega2() == 0.0 {
                return f64::INFINITY;
            }
            let equilibrium = flight.forcing[0] / o.omega2() - flight.x;
            let squares = equilibrium * equilibrium + flight.v * flight.v / o.omega2();
            side * equilibrium + hypotenuse(squares, equilibrium, flight.v / o.omega())
        };
        let reach: f64 = self.motions().zip([1.0, -1.0]).map(highest).sum();
        self.overlap + reach <= self.rounding
    }
}

/// Reach of a forecast of these motions from `start` after their anchor, s.
pub(crate) fn reach<'a>(oscillators: impl Iterator<Item = &'a Oscillator> + Clone, start: f64) -> f64 {
    let slowest = oscillators.clone().map(Oscillator::gamma).fold(f64::INFINITY, f64::min);
    let shortest = oscillators.map(Oscillator::time_scale).fold(f64::INFINITY, f64::min);
    if shortest.is_finite() {
        PERIODS_AHEAD * std::f64::consts::TAU * shortest
    } else if slowest > 0.0 {
        // Free balls with drag settle within some dozens of decay times; after that the reach grows.
        (DECAY_TIMES / slowest).max(start).max(SHORTEST_LOOK)
    } else {
        UNBOUNDED_REACH
    }
}

/// Forecast of the time at which `g`, a function of the time since `anchor`, becomes positive within these limits (s),
/// with at most `allowed` evaluations. `polished` refines the time.
pub(crate) fn forecast(
    g: &impl Smooth,
    anchor: DoubleDouble,
    [from, until]: [f64; 2],
    allowed: &mut u32,
    polished: impl Fn(f64) -> DoubleDouble,
) -> Forecast<DoubleDouble> {
    match search_within(g, from, until, allowed) {
        Forecast::At(tau) => Forecast::At(anchor + polished(tau)),
        Forecast::NotBefore(tau) if tau - from > LEAST_PROGRESS * from => Forecast::NotBefore(anchor + tau),
        // A search without progress has followed only rounding.
        _ if until < UNBOUNDED_REACH => Forecast::NotBefore(anchor + until),
        _ => Forecast::Never,
    }
}

/// Further than any simulation goes, s.
const UNBOUNDED_REACH: f64 = 1e15;

impl Smooth for Separation {
    fn at(&self, t: f64) -> [f64; 3] {
        let ([overlap, rate, acceleration], [resolution, growth]) = (self.evaluate(t.into()), self.resolution);
        [overlap - t * (resolution + 0.5 * growth * t), rate - (resolution + growth * t), acceleration - growth]
    }

    fn third_derivative_bound(&self, t: f64, span: f64) -> f64 {
        self.motions().map(|(o, flight)| flight.derivative_bound(o, t, span, 3)).sum()
    }

    fn time_scale(&self) -> f64 {
        self.motions().map(|(_, flight)| time_of_change(&flight.forcing)).fold(f64::INFINITY, f64::min)
    }
}
