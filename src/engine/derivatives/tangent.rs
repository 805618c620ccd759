//! A motion with its derivatives along a direction of inputs and parameters: exact, by dual numbers.
//!
//! It is followed by Taylor series of the whole chain from switching to switching. The time of a switching is a dual
//! number as well, so that jumps of the force at an onset or a release are accounted for (the saltation of hybrid
//! systems: di Bernardo et al., Piecewise-smooth Dynamical Systems, 2008, section 2.5). Only the derivatives are taken
//! from it. The cost of a segment grows with the number of balls, that of a motion with the number of segments.
//!
//! Impacts of rigid balls are taken in dual numbers, too, as long as the balls part. Where they stay in contact there
//! are no derivatives, nor where more balls touch that the direction would bring apart.

use super::chain_state::{ChainEquations, ChainState};
use crate::engine::cluster::{Series, Switch, clipping};
use crate::engine::flight::{Forcing, shifted};
use crate::engine::rigid::restitution;
use crate::model::algebraic;
use crate::model::{BallModel, Cradle, Mode};
use crate::solver::crossing;
use crate::solver::double_double::DoubleDouble;
use crate::solver::dual::{Dual, Scalar};
use crate::solver::series;

/// Order of the series of the forces, and the local error of the velocities over their scale.
const ORDER: usize = 24;
const LOCAL_ERROR: f64 = 1e-16;

/// Segments after which a step counts as too long to be followed.
const MAX_SEGMENTS: usize = 100_000;

/// How much of the largest derivative of a velocity on the way may be left at the end: less is its rounding.
const CANCELLATION: f64 = 1e-10;

/// An overlap about to vanish shortens the unit of time of the series by no more than this factor.
const SHORTEST_UNIT: f64 = 1e-20;

/// Approach speeds of rigid balls up to so many roundings of the fastest come to rest, as in the run itself.
const UNRESOLVED: f64 = 32.0;

/// Velocities that differ by more than this part of the largest do not belong to the same side of an impact of rigid
/// balls.
const SAME_VELOCITIES: f64 = 1e-6;

/// A step that cannot be followed again: it takes too many segments, leaves the range of numbers, passes through so
/// many bounces that the derivatives drown in rounding, or has rigid balls stay in contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotFollowed;

/// A motion followed in dual numbers.
pub(super) struct Run<'a> {
    pub(super) cradle: &'a Cradle,
    pub(super) along: Cradle<Dual>,
    pub(super) state: ChainState<Dual>,
    pub(super) forcings: Vec<Forcing<Dual>>,
    /// Time since these inputs act (s), and its derivative.
    elapsed: DoubleDouble,
    pub delay: f64,
    /// Largest derivative of any velocity so far, and how much of it must be left.
    largest: f64,
    pub cancellation: f64,
    pub(super) impulse: Vec<Dual>,
    /// At the start of the step.
    impulse_before: Vec<Dual>,
    pub peak: Vec<Dual>,
    pub support_impulse: Dual,
}

impl<'a> Run<'a> {
    pub fn new(cradle: &'a Cradle, along: Cradle<Dual>, state: ChainState<Dual>, forcings: Vec<Forcing<Dual>>) -> Self {
        let none = vec![Dual::default(); cradle.contacts.len()];
        Self {
            cradle,
            along,
            state,
            forcings,
            elapsed: DoubleDouble::default(),
            delay: 0.0,
            largest: 0.0,
            cancellation: CANCELLATION,
            impulse: none.clone(),
            impulse_before: none.clone(),
            peak: none,
            support_impulse: Dual::default(),
        }
    }

    /// The same motion from now on, under other coefficients and inputs.
    pub fn under(mut self, cradle: &'a Cradle, along: Cradle<Dual>, forcings: Vec<Forcing<Dual>>) -> Self {
        for (j, law) in cradle.contacts.iter().enumerate().filter(|_| cradle.restitution.is_none()) {
            if self.state.modes[j] != Mode::Open {
                let (overlap, rate) = (self.state.overlaps[j].value(), self.overlap_rate(j).value());
                self.state.modes[j] = law.mode_when_closed(overlap, rate);
            }
        }
        Self { cradle, along, forcings, elapsed: DoubleDouble::default(), ..self }
    }

    /// The last step begins here.
    pub fn begin_step(&mut self) {
        self.impulse_before.clone_from(&self.impulse);
        self.peak.fill(Dual::default());
        self.support_impulse = Dual::default();
    }

    /// Impulses since the last step began.
    pub fn impulse_of_step(&self) -> impl Iterator<Item = Dual> {
        self.impulse.iter().zip(&self.impulse_before).map(|(now, before)| *now - *before)
    }

    /// Follows the motion to the time `until` after these inputs began to act (s), or just beyond the next onset.
    pub fn follow(&mut self, until: Option<f64>) -> Result<(), NotFollowed> {
        if self.cradle.restitution.is_some() && self.state.modes.iter().any(|mode| *mode != Mode::Open) {
            return Err(NotFollowed);
        }
        for _ in 0..MAX_SEGMENTS {
            let rest = until.map_or(f64::INFINITY, |until| (DoubleDouble::from(until) - self.elapsed).value());
            let (series, converges_for) = self.expand();
            let length = converges_for.min(rest);
            let switch = self.first_switch(&series, length);
            let tau = match &switch {
                Some((tau, ..)) => *tau,
                // The end of the step is fixed, whatever happened before.
                None if length == rest => Dual::with_tangent(rest, -self.delay),
                None => Dual::from(length),
            };
            self.move_by(&series, tau);
            let reached = self.state.v.iter().map(|v| v.tangent().abs()).fold(0.0, f64::max);
            self.largest = self.largest.max(reached);
            let finite = self.state.v.iter().all(|v| v.value().is_finite() && v.tangent().is_finite());
            if !finite || reached < self.cancellation * self.largest {
                return Err(NotFollowed);
            }
            match switch {
                None if length == rest => return Ok(()),
                None => {}
                Some((_, _, Switch::Onset)) if until.is_none() => return Ok(()),
                Some((_, j, Switch::Onset)) if self.cradle.restitution.is_some() => self.collide(j)?,
                Some((_, j, switch)) => self.switch(j, switch),
            }
        }
        Err(NotFollowed)
    }

    /// The series from now on and how long they converge, s.
    fn expand(&self) -> (Series<Dual>, f64) {
        let scale = self.velocity_scale();
        let negligible: Vec<f64> = (0..self.cradle.contacts.len()).map(|j| self.negligible(j, scale)).collect();
        let unit = self.unit_of_time(scale, |j| negligible[j] > 0.0);
        let Self { along, state, forcings, .. } = self;
        let equations = ChainEquations { cradle: along, state, forcings };
        let series = equations.series(ORDER, unit, |j| negligible[j] > 0.0, &[]);
        let converges_for = self.convergence(&series, Dual::value).min(self.convergence(&series, Dual::tangent));
        let mut length = converges_for * unit;
        for (j, negligible) in negligible.into_iter().enumerate().filter(|(_, negligible)| *negligible > 0.0) {
            // Up to where the elastic force begins to matter.
            let overlap: Vec<f64> = series.overlap_row(j).iter().map(|c| c.value()).collect();
            if let Some(s) = crossing::first_positive(&overlap, 1.0, negligible, length / unit) {
                length = s * unit;
            }
        }
        (series, length)
    }

    /// Scale of the velocities, m/s.
    fn velocity_scale(&self) -> f64 {
        let (state, contacts) = (&self.state, &self.cradle.contacts);
        let mut scale = state.v.iter().map(|v| v.value().abs()).fold(f64::MIN_POSITIVE, f64::max);
        for j in (0..contacts.len()).filter(|&j| state.modes[j] != Mode::Open) {
            let energy = contacts[j].elastic_energy(state.overlaps[j].value());
            let mass = self.cradle.reduced_mass(j);
            // From rest it is what the other forces bring about until the contact balances them.
            let pull = (algebraic::a(self, j) - algebraic::a(self, j + 1)).value().abs();
            let from_rest = pull * contacts[j].static_overlap(mass * pull);
            scale = scale.max((2.0 * energy / mass).max(from_rest).sqrt());
        }
        scale
    }

    /// A time (s) within a few powers of ten of the one that the series will converge for, contacts whose overlap is
    /// `negligible` left out.
    fn unit_of_time(&self, scale: f64, negligible: impl Fn(usize) -> bool) -> f64 {
        let (state, contacts) = (&self.state, &self.cradle.contacts);
        let swing = |ball: &BallModel| ball.omega2.sqrt() + 2.0 * ball.gamma;
        let fastest = self.cradle.balls.iter().map(swing).fold(0.0, f64::max);
        let mut unit = if fastest > 0.0 { 1.0 / fastest } else { 1.0 };
        for j in (0..contacts.len()).filter(|&j| state.modes[j] != Mode::Open) {
            let (law, mass) = (&contacts[j], self.cradle.reduced_mass(j));
            unit = unit.min(law.time_scale(mass, scale)).min(law.relaxation_time(mass, scale));
            let (overlap, rate) = (state.overlaps[j].value(), self.overlap_rate(j).value().abs());
            if self.along.contacts[j].whole_exponent().is_none() && !negligible(j) && overlap < unit * rate {
                unit = (overlap / rate).max(SHORTEST_UNIT * unit);
            }
        }
        unit
    }

    pub(super) fn overlap_rate(&self, j: usize) -> Dual {
        self.state.v[j] - self.state.v[j + 1]
    }

    /// The overlap (m) up to which the elastic force of contact `j` is left out, 0 if it is not: next to none, a power
    /// that is not whole has no series to speak of, and no effect.
    fn negligible(&self, j: usize, scale: f64) -> f64 {
        let law = &self.cradle.contacts[j];
        if self.state.modes[j] == Mode::Open || self.along.contacts[j].whole_exponent().is_some() {
            return 0.0;
        }
        let (mass, rate) = (self.cradle.reduced_mass(j), self.overlap_rate(j).value());
        let bound = law.largest_negligible_overlap(mass, rate, LOCAL_ERROR * scale, law.time_scale(mass, scale));
        if self.state.overlaps[j].value() < bound { 2.0 * bound } else { 0.0 }
    }

    /// How long the values or the tangents of the series converge, in its unit: after an onset, series have gaps, so
    /// that more of the last terms are looked at than a gap is long.
    fn convergence(&self, series: &Series<Dual>, part: fn(Dual) -> f64) -> f64 {
        let exponent = self.cradle.contacts.first().map_or(1.0, |law| law.exponent);
        let gap = libm::ceil(exponent) as usize + 2;
        let balls = 0..self.cradle.balls.len();
        let term = |i: usize, k: usize| k as f64 * part(series.displacement(i)[k]).abs();
        let largest = |k: usize| balls.clone().map(|i| term(i, k.min(ORDER + 1))).fold(0.0, f64::max);
        // Where nothing changes yet, a derivative may begin with a higher power.
        let first = (1..=ORDER).find(|k| largest(*k) > 0.0).unwrap_or(1);
        let scale = (first..first + 3).map(largest).fold(0.0, f64::max);
        let reach = |k: usize| {
            let term = largest(k + 1);
            if term > 0.0 { libm::pow(LOCAL_ERROR * scale / term, 1.0 / k as f64) } else { f64::INFINITY }
        };
        (ORDER - gap..=ORDER).filter(|k| *k > first + 1).map(reach).fold(f64::INFINITY, f64::min)
    }

    /// The first switching within `length` (s): when, in which contact, and what.
    fn first_switch(&self, series: &Series<Dual>, length: f64) -> Option<(Dual, usize, Switch)> {
        let mut first: Option<(Dual, usize, Switch)> = None;
        for j in 0..self.cradle.contacts.len() {
            let until = first.map_or(length, |(tau, ..)| tau.value()) / series.unit;
            if let Some((s, switch)) = self.switch_of(series, j, until) {
                first = Some((s * Dual::from(series.unit), j, switch));
            }
        }
        first
    }

    /// The first switching of contact `j` before `until`, both in the unit of the series.
    fn switch_of(&self, series: &Series<Dual>, j: usize, until: f64) -> Option<(Dual, Switch)> {
        let crossing = |row: &[Dual], sign: f64, until: f64, noise: f64, switch: Switch| {
            let values: Vec<f64> = row.iter().map(|c| c.value()).collect();
            let s = crossing::first_positive(&values, sign, 0.0, until).filter(|s| *s < until)?;
            if noise > 0.0 {
                crossing::first_positive(&values, sign, sign * noise, until)?;
            }
            // The place where the row vanishes moves by -(its tangent) / (its slope).
            let slope = series::derivative(&values, s);
            let shift = if slope == 0.0 { 0.0 } else { -series::value(row, Dual::from(s)).tangent() / slope };
            Some((Dual::with_tangent(s, shift), switch))
        };
        let (law, overlap) = (&self.along.contacts[j], series.overlap_row(j));
        let mode = self.state.modes[j];
        if mode == Mode::Open {
            return crossing(overlap, 1.0, until, self.rounding(j), Switch::Onset);
        }
        let release = crossing(overlap, -1.0, until, 0.0, Switch::Release);
        if !self.cradle.contacts[j].clips() {
            return release;
        }
        let until = release.map_or(until, |(s, _)| s.value());
        let pressing: Vec<Dual> = match law.sign_of_force() {
            Some(sign) => sign.series(overlap, &series.rate(overlap)),
            None => series.force_row(j).to_vec(),
        };
        let (sign, switch) = clipping(mode);
        crossing(&pressing, sign, until, 0.0, switch).or(release)
    }

    /// Rounding of the positions beside contact `j`, m: no deeper closing is an onset.
    fn rounding(&self, j: usize) -> f64 {
        let amplitude = |i: usize| {
            let swing = self.cradle.balls[i].omega2.sqrt();
            let of_velocity = if swing > 0.0 { self.state.v[i].value().abs() / swing } else { 0.0 };
            self.state.x[i].value().abs() + of_velocity
        };
        2.0 * f64::EPSILON * amplitude(j).max(amplitude(j + 1))
    }

    /// Moves the state on by `tau` and adds what happens till then.
    fn move_by(&mut self, series: &Series<Dual>, tau: Dual) {
        let s = tau / Dual::from(series.unit);
        for (i, ball) in self.along.balls.iter().enumerate() {
            let displacement = series.displacement(i);
            let moved = series::value(displacement, s);
            let integral = self.state.x[i] * tau + Dual::from(series.unit) * series::integral(displacement, s);
            self.support_impulse += ball.mass * (ball.omega2 * integral + Dual::from(2.0) * ball.gamma * moved);
        }
        let pressing = |j: &usize| self.state.modes[*j] == Mode::Pressing;
        for j in (0..self.cradle.contacts.len()).filter(pressing) {
            let force = series.force_row(j);
            self.impulse[j] += Dual::from(series.unit) * series::integral(force, s);
            let values: Vec<f64> = force.iter().map(|c| c.value()).collect();
            let (top, _) = crossing::maximum(&values, 0.0, s.value());
            // At the end of the segment its time counts, within it the force does not change with the place.
            let peak = series::value(force, if top == s.value() { s } else { Dual::from(top) });
            if peak.value() > self.peak[j].value() {
                self.peak[j] = peak;
            }
        }
        for (i, forcing) in self.forcings.iter_mut().enumerate() {
            let displacement = series.displacement(i);
            self.state.x[i] += series::value(displacement, s);
            self.state.v[i] = series::derivative(displacement, s) / Dual::from(series.unit);
            *forcing = shifted(forcing, tau);
        }
        for (j, overlap) in self.state.overlaps.iter_mut().enumerate() {
            *overlap = series::value(series.overlap_row(j), s);
        }
        self.elapsed += tau.value();
        self.delay += tau.tangent();
    }

    fn switch(&mut self, j: usize, switch: Switch) {
        if matches!(switch, Switch::Onset | Switch::Release) {
            self.state.overlaps[j] = Dual::default();
        }
        self.state.modes[j] = match switch {
            Switch::Onset => self.cradle.contacts[j].mode_when_closed(0.0, self.overlap_rate(j).value()),
            Switch::Release => Mode::Open,
            Switch::Clip => Mode::Clipped,
            Switch::Unclip => Mode::Pressing,
        };
    }

    /// The rigid balls of contact `j` meet, and those that touch there.
    fn collide(&mut self, j: usize) -> Result<(), NotFollowed> {
        let e = self.along.restitution.ok_or(NotFollowed)?;
        let touch = |j: &usize| self.state.overlaps[*j].value() >= -self.rounding(*j);
        let first = (0..j).rev().take_while(touch).last().unwrap_or(j);
        let last = (j + 1..self.cradle.contacts.len()).take_while(touch).last().unwrap_or(j);
        self.state.overlaps[j] = Dual::default();
        if self.state.overlaps[first..=last].iter().any(|overlap| overlap.tangent() != 0.0) {
            return Err(NotFollowed);
        }
        let masses: Vec<Dual> = self.along.balls[first..last + 2].iter().map(|ball| ball.mass).collect();
        let v = &mut self.state.v[first..last + 2];
        let scale = v.iter().map(|v| v.value().abs()).fold(0.0, f64::max);
        let unresolved = UNRESOLVED * f64::EPSILON * scale;
        for impact in restitution::collide(&masses, v, e, unresolved, unresolved).impacts {
            self.impulse[first + impact.contact] += impact.impulse;
            self.state.overlaps[first + impact.contact] = Dual::default();
        }
        // Without relative velocity they may stay in contact.
        if self.overlap_rate(j).value() < 0.0 { Ok(()) } else { Err(NotFollowed) }
    }

    /// Takes the modes from `end`: where the step ends at a switching, rounding decides on which side. Refuses a step
    /// that ends with an impact of rigid balls.
    pub fn agree_with(&mut self, end: &ChainState) -> Result<(), NotFollowed> {
        let scale = end.v.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let differs = |(v, own): (&f64, &Dual)| (v - own.value()).abs() > SAME_VELOCITIES * scale;
        if self.cradle.restitution.is_some() && end.v.iter().zip(&self.state.v).any(differs) {
            return Err(NotFollowed);
        }
        for (j, mode) in end.modes.iter().enumerate() {
            if self.state.modes[j] != *mode {
                self.state.modes[j] = *mode;
                self.state.overlaps[j] = Dual::with_tangent(end.overlaps[j], self.state.overlaps[j].tangent());
            }
        }
        Ok(())
    }
}
