//! A motion with its derivatives along a direction of inputs and parameters, by dual numbers: series of the whole chain
//! from switching to switching, and impacts of rigid balls. See "Derivatives" in docs/theory.md.
//!
//! Only the derivatives are used. There are none where rigid balls stay in contact, nor where more than two touch whose
//! impacts the direction would separate.

use super::chain_state::ChainState;
use crate::engine::cluster::{Control, Series, Switch, WindowContact, sign_after_clip, velocity_scale};
use crate::engine::flight::{Flight, Forcing, integral_of, shifted};
use crate::engine::rigid::restitution::{self, Row};
use crate::engine::run::around;
use crate::model::{Chain, Cradle, Differential, Mode};
use crate::solver::{DoubleDouble, Dual, Scalar, crossing, series};

/// Order of the series of forces; tolerance of a run for which local errors of velocities are 1e-16 of their scale.
const ORDER: usize = 24;
const TOLERANCE: f64 = 1e-11;

/// Segments after which a step counts as too long to be followed.
const MAX_SEGMENTS: usize = 100_000;

/// Smallest derivative of a velocity at the end over the largest on the way; less is rounding.
const CANCELLATION: f64 = 1e-10;

/// Approach speeds of rigid balls up to this many roundings of the fastest come to rest, as in the run itself.
const UNRESOLVED: f64 = 32.0;

/// Velocities that differ by more than this part of the largest are on other sides of an impact of rigid balls.
const SAME_VELOCITIES: f64 = 1e-6;

pub(super) struct DualRun {
    /// The coefficients that act.
    cradle: Cradle<Dual>,
    state: ChainState<Dual>,
    /// Time since these inputs began to act (s), and its derivative.
    elapsed: DoubleDouble,
    pub delay: f64,
    /// Largest derivative of a velocity so far.
    largest: f64,
    impulse: Vec<Dual>,
    /// At the start of the step.
    impulse_before: Vec<Dual>,
    peak: Vec<Dual>,
    support_impulse: Dual,
    /// Segments so far.
    pub segments: usize,
}

impl DualRun {
    pub fn new(cradle: Cradle<Dual>, state: ChainState<Dual>) -> Self {
        let none = vec![Dual::default(); cradle.contacts.len()];
        Self {
            cradle,
            state,
            elapsed: DoubleDouble::default(),
            delay: 0.0,
            largest: 0.0,
            impulse: none.clone(),
            impulse_before: none.clone(),
            peak: none,
            support_impulse: Dual::default(),
            segments: 0,
        }
    }

    /// The same motion from now on, under other coefficients and inputs.
    pub fn under(self, cradle: Cradle<Dual>, forcings: Vec<Forcing<Dual>>) -> Self {
        let state = self.state.under(forcings);
        let mut next = Self { cradle, state, elapsed: DoubleDouble::default(), ..self };
        // Rigid contacts are open here: no others are followed.
        for j in 0..next.state.contacts.len() {
            if next.state.contacts[j].mode != Mode::Open {
                next.state.contacts[j].mode = next.mode_when_closed(j);
            }
        }
        next
    }

    /// Derivatives of the outputs that follow from the state, and of the impulses.
    pub fn outputs(&self) -> Differential {
        let mut outputs = Differential::along(self);
        outputs.impulse = self.impulse.iter().map(|impulse| impulse.tangent()).collect();
        if self.cradle.restitution.is_some() {
            // A constraint force has none.
            let pressing = outputs.force.iter_mut().zip(&self.state.contacts).filter(|(_, c)| c.mode == Mode::Pressing);
            pressing.for_each(|(force, _)| *force = f64::NAN);
        }
        outputs
    }

    /// The same, with the values over the last step, of this length (s); at length 0, those at the start of a run.
    pub fn outputs_of_step(&self, length: f64) -> Differential {
        let mut outputs = self.outputs();
        if length == 0.0 {
            if self.cradle.restitution.is_some() {
                // Rigid contacts transmit nothing yet.
                outputs.force.fill(0.0);
            }
            outputs.force_mean.clone_from(&outputs.force);
            outputs.force_peak.clone_from(&outputs.force);
            return Differential { support_force_mean: outputs.support_force, ..outputs };
        }
        let impulses = self.impulse.iter().zip(&self.impulse_before);
        Differential {
            force_mean: impulses.map(|(now, before)| (*now - *before).tangent() / length).collect(),
            force_peak: self.peak.iter().map(|peak| peak.tangent()).collect(),
            support_force_mean: self.support_impulse.tangent() / length,
            ..outputs
        }
    }

    pub fn begin_step(&mut self) {
        self.impulse_before.clone_from(&self.impulse);
        self.peak.fill(Dual::default());
        self.support_impulse = Dual::default();
    }

    /// Follows the motion to the time `until` after these inputs began to act (s), or just beyond the next onset;
    /// `None` if that takes too many segments, leaves the range of numbers, or has rigid balls that stay in contact.
    pub fn follow(&mut self, until: Option<f64>) -> Option<()> {
        if self.cradle.restitution.is_some() && self.state.contacts.iter().any(|contact| contact.mode != Mode::Open) {
            return None;
        }
        for _ in 0..MAX_SEGMENTS {
            self.segments += 1;
            let rest = until.map_or(f64::INFINITY, |until| (DoubleDouble::from(until) - self.elapsed).value());
            let series = self.expand();
            let length = series.converges_for.min(rest);
            let switch = self.first_switch(&series, length);
            let tau = match &switch {
                Some((tau, ..)) => *tau,
                // The end of the step is fixed, whatever happened before.
                None if length == rest => Dual::with_tangent(rest, -self.delay),
                None => Dual::from(length),
            };
            self.move_by(&series, tau);
            self.largest = self.largest.max(self.fastest_change());
            if !self.state.flights.iter().all(|ball| (ball.v.value() + ball.v.tangent()).is_finite()) {
                return None;
            }
            match switch {
                None if length == rest => return Some(()),
                None => {}
                Some((_, _, Switch::Onset)) if until.is_none() => return Some(()),
                Some((_, j, Switch::Onset)) if self.cradle.restitution.is_some() => self.collide(j)?,
                Some((_, j, switch)) => self.switch(j, switch),
            }
        }
        None
    }

    fn fastest_change(&self) -> f64 {
        self.state.flights.iter().map(|ball| ball.v.tangent().abs()).fold(0.0, f64::max)
    }

    /// Whether the derivatives are only rounding.
    pub fn is_cancelled(&self) -> bool {
        self.fastest_change() < CANCELLATION * self.largest
    }

    /// The series from now on, as far as their values and derivatives converge.
    fn expand(&self) -> Series<Dual> {
        let (window, mut series) = (self.state.window(&self.cradle), Series::default());
        let control = Control { order: ORDER, ..Control::new(TOLERANCE) };
        let negligible = series.expand(&window, &control, velocity_scale(&window));
        let convergence = |part: fn(Dual) -> f64| {
            let term = |i: usize, k: usize| k as f64 * part(series.displacement(i)[k]).abs() / series.unit;
            let largest = |k: usize| (0..self.cradle.balls.len()).map(|i| term(i, k)).fold(0.0, f64::max);
            // Where nothing changes yet, a derivative may begin with a higher power.
            let first = (1..ORDER).find(|k| largest(*k) > 0.0).unwrap_or(1);
            let scale = (first..(first + 3).min(ORDER + 2)).map(largest).fold(0.0, f64::max);
            series.convergence(control.local_error(scale), part)
        };
        series.converges_for = convergence(Dual::value).min(convergence(Dual::tangent));
        series.shorten_where_above(&negligible);
        series
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
        let (law, overlap, mode) = (&self.cradle.contacts[j], series.overlap_row(j), self.state.contacts[j].mode);
        if mode == Mode::Open {
            return crossing(overlap, 1.0, until, self.rounding(j), Switch::Onset);
        }
        let release = crossing(overlap, -1.0, until, 0.0, Switch::Release);
        if !law.clips() {
            return release;
        }
        let until = release.map_or(until, |(s, _)| s.value());
        let pressing: Vec<Dual> = match law.sign_of_force() {
            Some(sign) => sign.series(overlap, &series.rate(overlap)),
            None => series.force_row(j).to_vec(),
        };
        crossing(&pressing, sign_after_clip(mode), until, 0.0, Switch::Clip).or(release)
    }

    /// Rounding of the positions beside contact `j`, m: no deeper closing is an onset.
    fn rounding(&self, j: usize) -> f64 {
        let amplitude = |i: usize| {
            let swing = self.cradle.balls[i].omega2.value().sqrt();
            let Flight { x, v, .. } = self.state.flights[i];
            x.value().abs() + if swing > 0.0 { v.value().abs() / swing } else { 0.0 }
        };
        2.0 * f64::EPSILON * amplitude(j).max(amplitude(j + 1))
    }

    fn move_by(&mut self, series: &Series<Dual>, tau: Dual) {
        let s = tau / Dual::from(series.unit);
        if self.cradle.on_arcs() {
            // What the inputs give, less the change of the momentum.
            let balls = self.state.flights.iter().zip(&self.cradle.balls);
            let given: Dual = balls.map(|(flight, ball)| ball.mass * integral_of(&flight.forcing, tau)).sum();
            self.support_impulse += given + self.momentum();
        }
        for (i, ball) in self.cradle.balls.iter().enumerate().filter(|(_, ball)| !ball.on_arc) {
            let displacement = series.displacement(i);
            let moved = series::value(displacement, s);
            let integral = self.state.flights[i].x * tau + Dual::from(series.unit) * series::integral(displacement, s);
            self.support_impulse += ball.mass * (ball.omega2 * integral + Dual::from(2.0) * ball.gamma * moved);
        }
        let pressing = |j: &usize| self.state.contacts[*j].mode == Mode::Pressing;
        for j in (0..self.cradle.contacts.len()).filter(pressing) {
            let force = series.force_row(j);
            self.impulse[j] += Dual::from(series.unit) * series::integral(force, s);
            let values: Vec<f64> = force.iter().map(|c| c.value()).collect();
            let (top, _) = crossing::maximum(&values, 0.0, s.value());
            // At the end of the segment its time counts; within it the place of the peak does not matter.
            let peak = series::value(force, if top == s.value() { s } else { Dual::from(top) });
            if peak.value() > self.peak[j].value() {
                self.peak[j] = peak;
            }
        }
        for (i, Flight { x, v, forcing }) in self.state.flights.iter_mut().enumerate() {
            let displacement = series.displacement(i);
            *x += series::value(displacement, s);
            *v = series::derivative(displacement, s) / Dual::from(series.unit);
            *forcing = shifted(forcing, tau);
        }
        for (j, contact) in self.state.contacts.iter_mut().enumerate() {
            (contact.overlap, _) = series.overlap_at(j, s);
        }
        if self.cradle.on_arcs() {
            self.support_impulse += -self.momentum();
        }
        self.elapsed += tau.value();
        self.delay += tau.tangent();
    }

    fn mode_when_closed(&self, j: usize) -> Mode {
        self.cradle.contacts[j].mode_when_closed(self.overlap(j), self.overlap_rate(j))
    }

    fn switch(&mut self, j: usize, switch: Switch) {
        if matches!(switch, Switch::Onset | Switch::Release) {
            self.state.contacts[j].overlap = Dual::default();
        }
        self.state.contacts[j].mode = match switch {
            Switch::Onset => self.mode_when_closed(j),
            Switch::Release => Mode::Open,
            Switch::Clip if self.state.contacts[j].mode == Mode::Pressing => Mode::Clipped,
            Switch::Clip => Mode::Pressing,
        };
    }

    /// The rigid balls of contact `j` meet, and those that touch there.
    fn collide(&mut self, j: usize) -> Option<()> {
        let e = self.cradle.restitution?;
        let touch = |j: usize| self.state.contacts[j].overlap.value() >= -self.rounding(j);
        let contacts = around(j, self.cradle.contacts.len(), touch);
        let (first, balls) = (contacts.start, contacts.start..contacts.end + 1);
        self.state.contacts[j].overlap = Dual::default();
        if self.state.contacts[contacts].iter().any(|contact| contact.overlap.tangent() != 0.0) {
            return None;
        }
        let row = Row::new(&self.cradle, balls.clone(), |i| self.state.flights[i].x).ok()?;
        let before = self.momentum();
        let mut v: Vec<Dual> = self.state.flights[balls.clone()].iter().map(|ball| ball.v).collect();
        let scale = v.iter().map(|v| v.value().abs()).fold(0.0, f64::max);
        let unresolved = UNRESOLVED * f64::EPSILON * scale;
        for impact in restitution::collide(&row, &mut v, e, unresolved, unresolved).impacts {
            self.impulse[first + impact.contact] += impact.impulse;
            self.state.contacts[first + impact.contact].overlap = Dual::default();
        }
        self.state.flights[balls].iter_mut().zip(v).for_each(|(ball, v)| ball.v = v);
        if self.cradle.on_arcs() {
            self.support_impulse += before - self.momentum();
        }
        // Without relative velocity they may stay in contact.
        if self.overlap_rate(j).value() < 0.0 { Some(()) } else { None }
    }

    /// Takes the modes from `end`, because rounding decides the side of a switching at the end of the step. Refuses a
    /// step that ends with an impact of rigid balls.
    pub fn agree_with(&mut self, end: &ChainState) -> Option<()> {
        let scale = end.flights.iter().fold(0.0, |most: f64, ball| most.max(ball.v.abs()));
        let differs = |(end, own): (&Flight, &Flight<Dual>)| (end.v - own.v.value()).abs() > SAME_VELOCITIES * scale;
        if self.cradle.restitution.is_some() && end.flights.iter().zip(&self.state.flights).any(differs) {
            return None;
        }
        for (end, own) in end.contacts.iter().zip(&mut self.state.contacts) {
            if own.mode != end.mode {
                *own =
                    WindowContact { overlap: Dual::with_tangent(end.overlap, own.overlap.tangent()), mode: end.mode };
            }
        }
        Some(())
    }
}

impl Chain<Dual> for DualRun {
    fn cradle(&self) -> &Cradle<Dual> {
        &self.cradle
    }

    fn state_of(&self, i: usize) -> (Dual, Dual) {
        (self.state.flights[i].x, self.state.flights[i].v)
    }

    fn forcing_of(&self, i: usize) -> Dual {
        self.state.flights[i].forcing[0]
    }

    fn overlap(&self, j: usize) -> Dual {
        self.state.contacts[j].overlap
    }

    fn force(&self, j: usize) -> Dual {
        match self.state.contacts[j].mode {
            Mode::Pressing => self.cradle.contacts[j].unclipped_force(self.overlap(j), self.overlap_rate(j)),
            Mode::Open | Mode::Clipped => Dual::default(),
        }
    }
}
