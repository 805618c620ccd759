//! The motion of a window by implicit collocation, for contacts that stay closed while the motion is slow. See
//! "Collocation" in docs/theory.md for the equations with the response `W` of a pendulum.

use super::step_control::{Problem, StepHistory};
use super::taylor::{Series, integrate};
use super::window::Window;
use crate::engine::flight::{Flight, forcing_at};
use crate::model::Mode;
use crate::solver::Oscillator;
use crate::solver::radau::{Matrix, RADAU, Row, STAGES, Stages, inverse, solve};

/// Least length of the first step of implicit collocation, over that by Taylor series and over that by explicit Gauss
/// collocation; and the part of it at which later steps still pay.
pub(super) const GAIN_OVER_SERIES: f64 = 40.0;
pub(super) const GAIN_OVER_GAUSS: f64 = 5.0;
const WORTH: f64 = 0.5;

/// The next step over the one that the error allows, the largest growth of a step, and its factors after too large an
/// error and after one that says nothing (Hairer and Wanner, Solving Ordinary Differential Equations II, 1996, IV.8).
const SAFETY: f64 = 0.9;
const GROWTH: f64 = 4.0;
const SHRINKAGE: [f64; 2] = [0.1, 0.7];
const FAILED: f64 = 0.25;

/// Smallest error allowed, in roundings, which differences of the ninth order magnify.
const NOISE: f64 = 100.0;

/// Newton iterations after which a step is given up, and the relative correction whose square is below rounding.
const ITERATIONS: usize = 8;
const SQUARE: f64 = 1e-8;

/// Error allowed over the tolerance of a whole run: of the velocities and of the overlaps, relative to the largest.
/// Larger ones make steps longer, and balls at rest less quiet (`tests/rust/stiff.rs`,
/// `tests/rust/time_derivatives.rs`).
const OF_VELOCITIES: f64 = 0.01;
const OF_OVERLAPS: f64 = 0.1;

/// Largest jump of an overlap's rate at the start of a step, over the error allowed.
const JUMP: f64 = 10.0;

/// Roundings of the rates, differences of velocities that many operations have changed.
const RATES: f64 = 16.0;

/// One step, from the state at the start of a segment.
struct Step<'a> {
    window: &'a Window<'a>,
    /// The inverse of `h A`, 1/s.
    derivative: Matrix,
    /// Times of the stages, s.
    times: Stages,
    /// For each ball: its acceleration at the stages without contact forces and displacement.
    pulls: Vec<Stages>,
    responses: Vec<Response>,
    /// For each contact: change of the overlap since the start, at the stages.
    changes: Vec<Stages>,
    /// Forces there, with one of 0 at either end.
    forces: Vec<Stages>,
    evaluations: u64,
}

/// Response of a pendulum to an acceleration given at the stages.
#[derive(Clone)]
struct Response {
    velocity: Matrix,
    displacement: Matrix,
}

impl Response {
    fn new(o: &Oscillator, integral: &Matrix) -> Self {
        let twice = integral * integral;
        let pendulum = inverse(&(Matrix::identity() + 2.0 * o.gamma() * integral + o.omega2() * twice));
        Self { velocity: integral * pendulum, displacement: twice * pendulum }
    }
}

/// Describes the motion by a step of implicit collocation, if the `history` says that one is due and it pays by a
/// `gain` over explicit steps. Returns whether it does; adds the `evaluations` of forces.
pub(super) fn follow(
    series: &mut Series,
    history: &mut StepHistory,
    problem: &Problem,
    gain: f64,
    evaluations: &mut u64,
) -> bool {
    let mut length = std::mem::take(&mut history.implicit_length);
    if length == 0.0 || history.quiet == 0 {
        if history.quiet < history.patience {
            return false;
        }
        length = gain * history.explicit_length;
    }
    while length > 0.0 && length >= WORTH * gain * history.explicit_length {
        let mut step = Step::new(problem.window, length);
        let solved = step.solve().is_some();
        *evaluations = evaluations.saturating_add(step.evaluations);
        let error = if solved { step.describe(series, length, problem) } else { f64::INFINITY };
        // The order of the error is the number of stages; a failed step says nothing about it.
        let change = SAFETY * libm::pow(error, -1.0 / STAGES as f64);
        if error <= 1.0 {
            history.implicit_length = (length * change.min(GROWTH)).min(problem.control.longest);
            return true;
        }
        length *= if change.is_finite() { change.clamp(SHRINKAGE[0], SHRINKAGE[1]) } else { FAILED };
    }
    history.patience = history.quiet.saturating_mul(2);
    false
}

impl<'a> Step<'a> {
    fn new(window: &'a Window<'a>, length: f64) -> Self {
        let integral = RADAU.integral * length;
        let times = RADAU.nodes * length;
        let mut responses: Vec<Response> = Vec::with_capacity(window.balls.len());
        let mut pulls = Vec::with_capacity(window.balls.len());
        for (i, (flight, ball)) in window.flights.iter().zip(window.balls).enumerate() {
            let o = &ball.oscillator;
            let same = i > 0 && window.balls[i - 1].oscillator == *o;
            responses.push(if same { responses[i - 1].clone() } else { Response::new(o, &integral) });
            pulls.push(times.map(|t| pull(o, flight, t)));
        }
        let [changes, forces] = [0, 2].map(|more| vec![Stages::zeros(); window.contacts.len() + more]);
        let derivative = RADAU.derivative * (1.0 / length);
        Self { window, derivative, times, pulls, responses, changes, forces, evaluations: 0 }
    }

    /// Acceleration of ball `i` by the contacts, m/s2.
    fn pressed(&self, i: usize) -> Stages {
        (self.forces[i] - self.forces[i + 1]) / self.window.models[i].mass
    }

    /// The response of the overlap of contact `j`, or of its rate, to all accelerations of its balls.
    fn relative(&self, j: usize, response: fn(&Response) -> &Matrix, by_contacts: [Stages; 2]) -> Stages {
        let window = self.window;
        let (left, right) = (&window.balls[j], &window.balls[j + 1]);
        if left.oscillator == right.oscillator {
            // Gravity pulls on the difference of the positions, which the overlap gives without rounding.
            let (l, r) = (&window.flights[j], &window.flights[j + 1]);
            let forcing = std::array::from_fn(|k| l.forcing[k] - r.forcing[k]);
            let x = window.contacts[j].overlap + window.laws[j].clearance;
            let apart = Flight { x, v: window.overlap_rate(j), forcing };
            let pulls = self.times.map(|t| pull(&left.oscillator, &apart, t));
            response(&self.responses[j]) * (pulls + (by_contacts[0] - by_contacts[1]))
        } else {
            let [left, right] =
                [0, 1].map(|side| response(&self.responses[j + side]) * (self.pulls[j + side] + by_contacts[side]));
            left - right
        }
    }

    /// Solves for all pressing contacts.
    fn solve(&mut self) -> Option<()> {
        let mut first = 0;
        for end in (0..=self.window.contacts.len()).filter(|&j| !self.window.presses(j)) {
            self.solve_group(first, end)?;
            first = end + 1;
        }
        Some(())
    }

    /// Solves for the neighbouring pressing contacts `first..end`.
    fn solve_group(&mut self, first: usize, end: usize) -> Option<()> {
        let mut rows = Vec::with_capacity(end - first);
        for _ in 0..ITERATIONS {
            // Derivatives of the displacements of the two balls of each contact with respect to its overlap.
            let mut sensitivities = Vec::with_capacity(end - first);
            for j in first..end {
                let slopes = self.evaluate(j)?;
                sensitivities
                    .push([j, j + 1].map(|i| self.responses[i].displacement * slopes / self.window.models[i].mass));
            }
            rows.clear();
            for (j, [left, right]) in (first..end).zip(&sensitivities) {
                let wanted = self.relative(j, |r| &r.displacement, [self.pressed(j), self.pressed(j + 1)]);
                let missing = self.window.overlap_rate(j) * self.times + wanted - self.changes[j];
                let beside =
                    |contact: usize, side: usize| sensitivities.get(contact).map_or_else(Matrix::zeros, |y| -y[side]);
                let lower = beside((j - first).wrapping_sub(1), 1);
                let (diagonal, upper) = (Matrix::identity() + left + right, beside(j - first + 1, 0));
                rows.push(Row { lower, diagonal, upper, known: missing });
            }
            let mut done = true;
            for (j, correction) in (first..end).zip(solve(&mut rows)?) {
                if correction.iter().any(|c| !c.is_finite()) {
                    return None;
                }
                self.changes[j] += correction;
                let size = self.window.contacts[j].overlap + self.changes[j].amax();
                // The next correction would be of the order of the square.
                done &= correction.amax() <= SQUARE * size;
            }
            if done {
                for j in first..end {
                    self.evaluate(j)?;
                }
                return Some(());
            }
        }
        None
    }

    /// Computes the forces of contact `j` from its overlaps; returns their derivatives by these.
    fn evaluate(&mut self, j: usize) -> Option<Matrix> {
        self.evaluations += STAGES as u64;
        let (law, start) = (&self.window.laws[j], self.window.contacts[j].overlap);
        let rates = self.derivative * self.changes[j];
        let mut slopes = Matrix::zeros();
        for s in 0..STAGES {
            let (force, by_overlap, by_rate) = law.continued(start + self.changes[j][s], rates[s])?;
            self.forces[j + 1][s] = force;
            slopes.set_row(s, &(self.derivative.row(s) * by_rate));
            slopes[(s, s)] += by_overlap;
        }
        slopes.iter().all(|slope| slope.is_finite()).then_some(slopes)
    }

    /// Appends to `velocities` those of the balls up to `last`, which pressing contacts join, at the stages.
    ///
    /// From the motion of the whole group, which contact forces do not change, and the overlaps; computed for each
    /// ball, it would contain the rounding of these forces.
    fn velocities_of_group(&self, last: usize, velocities: &mut Vec<Stages>) {
        let (window, first) = (self.window, velocities.len());
        let balls = &window.balls[first..=last];
        let total: f64 = balls.iter().map(|ball| ball.model.mass).sum();
        let mut whole = Stages::zeros();
        let alike = balls.iter().all(|ball| ball.oscillator == balls[0].oscillator);
        for (i, ball) in (first..).zip(balls) {
            let pulled = if alike { self.pulls[i] } else { self.pulls[i] + self.pressed(i) };
            let velocities = (self.responses[i].velocity * pulled).add_scalar(window.flights[i].v);
            whole += ball.model.mass / total * velocities;
        }
        let mut beyond = total;
        for (j, ball) in (first..last).zip(balls) {
            beyond -= ball.model.mass;
            whole += beyond / total * (self.derivative * self.changes[j]);
        }
        velocities.push(whole);
        for j in first..last {
            velocities.push(velocities[j] - self.derivative * self.changes[j]);
        }
    }

    /// Enters the solution in `series`; returns its error over the allowed one.
    fn describe(&self, series: &mut Series, length: f64, problem: &Problem) -> f64 {
        let (window, tolerance) = (self.window, problem.control.tolerance);
        series.begin(window, STAGES, length);
        let speed = window.flights.iter().map(|flight| flight.v.abs()).fold(0.0, f64::max);
        let lightest = window.models.iter().map(|ball| ball.mass).fold(f64::INFINITY, f64::min);
        let rounding = problem.rounding.velocity
            + f64::EPSILON * length * self.forces.iter().map(Stages::amax).fold(0.0, f64::max) / lightest;
        // No tighter than the Taylor series before.
        let allowed = (OF_VELOCITIES * tolerance * speed).max(NOISE * rounding).max(problem.local_error);
        let mut worst = 0.0_f64;
        let mut velocities = Vec::with_capacity(window.flights.len());
        for end in (0..=window.contacts.len()).filter(|&j| !window.presses(j)) {
            self.velocities_of_group(end, &mut velocities);
        }
        for (i, flight) in window.flights.iter().enumerate() {
            let polynomial = RADAU.polynomial_from(flight.v, &velocities[i]);
            worst = worst.max(highest_terms(&polynomial) / allowed);
            if polynomial.iter().any(|c| !c.is_finite()) {
                return f64::INFINITY;
            }
            integrate(&mut series.displacements[i * series.stride..], &polynomial, length);
        }
        let of_rates = RATES * rounding;
        for (j, contact) in window.contacts.iter().enumerate() {
            if window.presses(j) {
                // Without the start: the overlap must follow the balance of forces, not the rounding of the velocities.
                let polynomial = RADAU.polynomial(&(self.derivative * self.changes[j]));
                let size = contact.overlap + self.changes[j].amax();
                // The force must be as accurate: its relative error is `exponent` times as large.
                let relative = (OF_OVERLAPS * tolerance).max(2.0 * NOISE * f64::EPSILON) / window.laws[j].exponent;
                let stiffness = window.laws[j].elastic_continued(contact.overlap).map_or(0.0, |(_, slope)| slope);
                // The change of the overlap by the rounding of its rate.
                let change = if stiffness > 0.0 { of_rates * (window.reduced_mass(j) / stiffness).sqrt() } else { 0.0 };
                let allowed = (relative * size).max(change) / length;
                let jump = (polynomial[0] - window.overlap_rate(j)).abs() / (JUMP * allowed).max(of_rates);
                worst = worst.max(highest_terms(&polynomial) / allowed).max(jump);
                integrate(&mut series.overlaps[j * series.stride..], &polynomial, length);
                let overlaps = self.changes[j].add_scalar(contact.overlap);
                let elastic = overlaps.map(|d| window.laws[j].elastic_continued(d).map_or(0.0, |(force, _)| force));
                series.set_forces(j, &RADAU.polynomial(&elastic), &RADAU.polynomial(&self.forces[j + 1]));
            } else {
                let rate = window.overlap_rate(j);
                let accelerations = [self.pressed(j), self.pressed(j + 1)];
                let rates = self.relative(j, |r| &r.velocity, accelerations).add_scalar(rate);
                let polynomial = RADAU.polynomial_from(rate, &rates);
                integrate(&mut series.overlaps[j * series.stride..], &polynomial, length);
                if contact.mode == Mode::Clipped {
                    let changes = self.relative(j, |r| &r.displacement, accelerations);
                    let (mut forces, mut unknown) = (Stages::zeros(), 0.0_f64);
                    for s in 0..STAGES {
                        let overlap = contact.overlap + rate * self.times[s] + changes[s];
                        let Some((force, _, by_rate)) = window.laws[j].continued(overlap, rates[s]) else {
                            return f64::INFINITY;
                        };
                        (forces[s], unknown) = (force, unknown.max(NOISE * by_rate.abs() * rounding));
                    }
                    // Needed for the time at which it would push again.
                    let polynomial = RADAU.polynomial(&forces);
                    let allowed = (tolerance * forces.amax()).max(unknown);
                    worst = worst.max(if allowed > 0.0 { highest_terms(&polynomial) / allowed } else { 0.0 });
                    series.set_forces(j, &[], &polynomial);
                }
            }
        }
        worst
    }
}

/// Acceleration at the time `t` (s) without contact forces and displacement by them, m/s2.
fn pull(o: &Oscillator, flight: &Flight, t: f64) -> f64 {
    forcing_at(&flight.forcing, t) - o.omega2() * (flight.x + flight.v * t) - 2.0 * o.gamma() * flight.v
}

/// Size of the last two terms of a polynomial on [0, 1] in Legendre's polynomials, from its coefficients.
fn highest_terms(c: &[f64]) -> f64 {
    let n = c.len() - 1;
    let leading = |k: usize| (1..=k).fold(1.0, |product, i| product * (k + i) as f64 / i as f64);
    let last = c[n] / leading(n);
    let before = (c[n - 1] + 0.5 * n as f64 * c[n]) / leading(n - 1);
    last.abs().max(before.abs())
}
