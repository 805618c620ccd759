//! The motion of a window by implicit collocation, for contacts that stay closed while the motion is slow. See
//! "Implicit collocation" in docs/theory.md for the equations with the response `W` of a pendulum.

use std::ops::Range;

use super::step_control::{Problem, StepHistory};
use super::taylor::{Series, integrate};
use super::window::Window;
use crate::engine::flight::{
    BallStages, Flight, LEAST_ROUNDINGS, PLACE_ITERATIONS, Response, free_acceleration, highest_terms, next_length,
};
use crate::model::Mode;
use crate::solver::radau::{BlockRow, Matrix, RADAU, STAGES, Stages, solve};

/// Least length of the first step of implicit collocation over that by Taylor series, and over that by explicit Gauss
/// collocation; and the part of this gain at which later steps still pay.
pub(super) const GAIN_OVER_SERIES: f64 = 40.0;
pub(super) const GAIN_OVER_GAUSS: f64 = 5.0;
const LEAST_PART_OF_GAIN: f64 = 0.5;

/// Newton iterations after which a step is given up, and the relative correction whose square is below rounding.
const ITERATIONS: usize = 8;
const SQUARE: f64 = 1e-8;

/// Allowed error over the tolerance of a whole run: of the velocities and of the overlaps, relative to the largest.
/// Larger values make steps longer and balls at rest less quiet (`tests/rust/stiff.rs`,
/// `tests/rust/time_derivatives.rs`).
const OF_VELOCITIES: f64 = 0.01;
const OF_OVERLAPS: f64 = 0.1;

/// Largest jump of an overlap's rate at the start of a step, over the error allowed.
const JUMP: f64 = 10.0;

/// Number of roundings in the rates, differences of velocities that many operations have changed.
const RATES: f64 = 16.0;

/// One step, from the state at the start of a segment.
struct RadauStep<'a> {
    window: &'a Window<'a>,
    /// The inverse of `h A`, 1/s.
    derivative: Matrix,
    /// Times of the stages, s.
    times: Stages,
    balls: Vec<BallStages>,
    /// For each contact, at the stages: components of its direction along the paths of its balls, and change of its
    /// overlap since the start.
    along: Vec<[Stages; 2]>,
    changes: Vec<Stages>,
    /// Contact forces at the stages, with a 0 at either end.
    forces: Vec<Stages>,
    evaluations: u64,
}

/// Describes the motion by a step of implicit collocation, if `history` says that one is due and it is longer than
/// explicit steps by the factor `gain`. Returns whether it does; adds to the `evaluations` of forces.
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
    while length > 0.0 && length >= LEAST_PART_OF_GAIN * gain * history.explicit_length {
        let mut step = RadauStep::new(problem.window, length);
        let solved = step.solve();
        *evaluations = evaluations.saturating_add(step.evaluations);
        let error = solved.and_then(|()| step.describe(series, length, problem)).unwrap_or(f64::INFINITY);
        if error <= 1.0 {
            history.implicit_length = (length * next_length(error)).min(problem.control.longest);
            return true;
        }
        length *= next_length(error);
    }
    history.patience = history.quiet.saturating_mul(2);
    false
}

impl<'a> RadauStep<'a> {
    fn new(window: &'a Window<'a>, length: f64) -> Self {
        let times = RADAU.nodes * length;
        let mut balls: Vec<BallStages> = Vec::with_capacity(window.balls.len());
        for (i, (flight, ball)) in window.flights.iter().zip(window.balls).enumerate() {
            let o = &ball.oscillator;
            let same = i > 0 && window.balls[i - 1].oscillator == *o;
            let response = if same { balls[i - 1].response.clone() } else { Response::new(o, length) };
            balls.push(BallStages::new(response, o, flight, &times));
        }
        let [changes, forces] = [0, 2].map(|more| vec![Stages::zeros(); window.contacts.len() + more]);
        let along = (0..window.contacts.len()).map(|j| window.parts_along(j).map(Stages::repeat)).collect();
        let derivative = RADAU.derivative * (1.0 / length);
        Self { window, derivative, times, balls, along, changes, forces, evaluations: 0 }
    }

    /// Acceleration of ball `i` along its path by the contacts, m/s2.
    fn pressed(&self, i: usize) -> Stages {
        let [mut sum, outer] = [0, 1].map(|more| self.forces[i + more]);
        if let Some(left) = i.checked_sub(1) {
            sum.component_mul_assign(&self.along[left][1]);
        }
        sum -= self.along.get(i).map_or(outer, |along| along[0].component_mul(&outer));
        sum / self.window.models[i].mass
    }

    /// Moves the `balls` by the forces of their contacts, and turns the contacts between them.
    fn move_balls(&mut self, balls: Range<usize>) -> Option<()> {
        let window = self.window;
        if !window.models[0].on_arc {
            return Some(()); // Places do not matter.
        }
        for _ in 0..PLACE_ITERATIONS {
            let mut done = true;
            for i in balls.clone() {
                let pressed = self.pressed(i);
                done &= self.balls[i].move_by(&window.models[i], &window.flights[i], &self.times, &pressed)?;
            }
            if done {
                return Some(());
            }
            for j in balls.start..balls.end - 1 {
                for s in 0..STAGES {
                    let places = [j, j + 1].map(|i| window.flights[i].x + self.balls[i].moved[s]);
                    let parts = window.pair(j).parts_along(places);
                    (self.along[j][0][s], self.along[j][1][s]) = (parts[0], parts[1]);
                }
            }
        }
        None
    }

    /// Displacement of ball `i` along its path by all forces on it, at the stages.
    fn by_forces(&self, i: usize) -> Stages {
        let ball = &self.balls[i];
        ball.response.displacement * (ball.free_acceleration + (ball.arc_correction + self.pressed(i)))
    }

    /// Displacement of the left ball of contact `j` less that of the right one, at the stages.
    fn relative(&self, j: usize) -> Stages {
        let window = self.window;
        let ([l, r], o) = ([j, j + 1].map(|i| &window.flights[i]), &window.balls[j].oscillator);
        let rate = l.v - r.v;
        let by_forces = if *o == window.balls[j + 1].oscillator {
            // Gravity pulls on the difference of the positions.
            let forcing = std::array::from_fn(|k| l.forcing[k] - r.forcing[k]);
            let apart = Flight { x: window.pair(j).apart([l.x, r.x], window.contacts[j].overlap), v: rate, forcing };
            let [left, right] = [j, j + 1].map(|i| self.balls[i].arc_correction + self.pressed(i));
            self.balls[j].response.displacement * (self.times.map(|t| free_acceleration(o, &apart, t)) + (left - right))
        } else {
            self.by_forces(j) - self.by_forces(j + 1)
        };
        rate * self.times + by_forces
    }

    /// The change of the overlap of contact `j` by the displacements of its balls.
    fn closer(&self, j: usize) -> Stages {
        let (places, relative) = ([j, j + 1].map(|i| self.window.flights[i].x), self.relative(j));
        let moves = |s: usize| [j, j + 1].map(|i| self.balls[i].moved[s]);
        Stages::from_fn(|s, _| self.window.pair(j).change_by_relative(places, moves(s), relative[s]))
    }

    /// Rounding in the change of the overlap of contact `j`, m: that of the two displacements whose difference it is.
    /// For equal oscillators only what their arcs add is computed for each ball; for arcs of different radii all of it.
    fn rounding_of_change(&self, j: usize) -> f64 {
        let (window, [left, right]) = (self.window, self.window.pair(j).balls);
        let same = window.balls[j].oscillator == window.balls[j + 1].oscillator;
        let displacement = |i: usize| {
            let ball = &self.balls[i];
            match left.on_arc && left.length != right.length {
                true => ball.moved,
                false if same => ball.response.displacement * ball.arc_correction,
                false => self.by_forces(i),
            }
        };
        f64::EPSILON * displacement(j).amax().max(displacement(j + 1).amax())
    }

    /// Solves the equations of all balls and pressing contacts.
    fn solve(&mut self) -> Option<()> {
        let mut first = 0;
        for end in (0..=self.window.contacts.len()).filter(|&j| !self.window.presses(j)) {
            self.solve_group(first, end)?;
            first = end + 1;
        }
        Some(())
    }

    /// Solves the equations of the neighbouring pressing contacts `first..end` and their balls.
    fn solve_group(&mut self, first: usize, end: usize) -> Option<()> {
        let mut rows = Vec::with_capacity(end - first);
        let along_path = |matrix: &Matrix, along: &Stages| Matrix::from_fn(|r, c| along[r] * matrix[(r, c)]);
        for _ in 0..ITERATIONS {
            // Derivatives of the displacements of the two balls of each contact with respect to its overlap.
            let mut sensitivities = Vec::with_capacity(end - first);
            for j in first..end {
                let slopes = self.evaluate(j)?;
                sensitivities.push([0, 1].map(|side| {
                    let by_force = along_path(&slopes, &self.along[j][side]);
                    self.balls[j + side].response.displacement * by_force / self.window.models[j + side].mass
                }));
            }
            self.move_balls(first..end + 1)?;
            rows.clear();
            for j in first..end {
                let along = &self.along[j];
                let part = |contact: usize, side: usize, of: usize| {
                    let moved = sensitivities.get(contact.wrapping_sub(first)).map(|moved| &moved[side]);
                    moved.map_or_else(Matrix::zeros, |moved| along_path(moved, &along[of]))
                };
                let diagonal = Matrix::identity() + part(j, 0, 0) + part(j, 1, 1);
                let [lower, upper] = [-part(j.wrapping_sub(1), 1, 0), -part(j + 1, 0, 1)];
                rows.push(BlockRow { lower, diagonal, upper, known: self.closer(j) - self.changes[j] });
            }
            let mut done = true;
            for (j, correction) in (first..end).zip(solve(&mut rows)?) {
                if correction.iter().any(|c| !c.is_finite()) {
                    return None;
                }
                self.changes[j] += correction;
                let size = self.window.contacts[j].overlap + self.changes[j].amax();
                // The next correction would be of the order of the square, or rounding.
                done &= correction.amax() <= (SQUARE * size).max(self.rounding_of_change(j));
            }
            if done {
                for j in first..end {
                    self.evaluate(j)?;
                }
                return self.move_balls(first..end + 1);
            }
        }
        None
    }

    /// Computes the forces of contact `j` from its overlaps; returns the derivatives of forces by overlaps.
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

    /// Appends to `velocities` those of the balls of one group, up to `last`, at the stages.
    ///
    /// They follow from the motion of the whole group, which contact forces hardly change, and from the overlaps.
    /// Computed ball by ball, they would contain the rounding of these forces.
    fn velocities_of_group(&self, last: usize, velocities: &mut Vec<Stages>) {
        let (window, first) = (self.window, velocities.len());
        let balls = &window.balls[first..=last];
        let alike = balls.iter().all(|ball| ball.oscillator == balls[0].oscillator);
        // The momentum; and each velocity as `share` times that of the first ball, less the part `behind` by the
        // overlaps.
        let (mut momentum, mut mass, mut less) = (Stages::zeros(), Stages::zeros(), Stages::zeros());
        let mut relative: Vec<[Stages; 2]> = Vec::with_capacity(balls.len());
        for (i, ball) in (first..).zip(balls) {
            let of_contacts = match alike {
                false => self.pressed(i),
                true if i == first => Stages::zeros(),
                true => self.forces[i].component_mul(&(self.along[i - 1][1] - self.along[i - 1][0])) / ball.model.mass,
            };
            momentum += ball.model.mass * self.balls[i].velocities(&window.flights[i], &of_contacts);
            let [share, behind] = relative.last().map_or([Stages::repeat(1.0), Stages::zeros()], |[share, behind]| {
                let ([left, right], rate) = (&self.along[i - 1], self.derivative * self.changes[i - 1]);
                [left.component_mul(share), left.component_mul(behind) + rate].map(|part| part.component_div(right))
            });
            mass += ball.model.mass * share;
            less += ball.model.mass * behind;
            relative.push([share, behind]);
        }
        let of_first = (momentum + less).component_div(&mass);
        velocities.extend(relative.iter().map(|[share, behind]| share.component_mul(&of_first) - behind));
    }

    /// Enters the solution in `series`; returns its error over the allowed one, `None` if it leaves the range of
    /// doubles or of a law.
    fn describe(&self, series: &mut Series, length: f64, problem: &Problem) -> Option<f64> {
        let (window, tolerance) = (self.window, problem.control.tolerance);
        series.begin(window, STAGES, length);
        let speed = window.flights.iter().map(|flight| flight.v.abs()).fold(0.0, f64::max);
        let lightest = window.models.iter().map(|ball| ball.mass).fold(f64::INFINITY, f64::min);
        let rounding = problem.rounding.velocity
            + f64::EPSILON * length * self.forces.iter().map(Stages::amax).fold(0.0, f64::max) / lightest;
        // Allow no less than the Taylor series before.
        let allowed = (OF_VELOCITIES * tolerance * speed).max(LEAST_ROUNDINGS * rounding).max(problem.local_error);
        let mut worst = 0.0_f64;
        let mut velocities = Vec::with_capacity(window.flights.len());
        for end in (0..=window.contacts.len()).filter(|&j| !window.presses(j)) {
            self.velocities_of_group(end, &mut velocities);
        }
        for (i, flight) in window.flights.iter().enumerate() {
            let polynomial = RADAU.polynomial_from(flight.v, &velocities[i]);
            worst = worst.max(highest_terms(&polynomial) / allowed);
            if polynomial.iter().any(|c| !c.is_finite()) {
                return None;
            }
            integrate(&mut series.displacements[i * series.stride..], &polynomial, length);
        }
        for j in 0..window.contacts.len() {
            if window.presses(j) {
                worst = worst.max(self.describe_pressing(series, j, length, tolerance, rounding));
            } else {
                let (overlaps, rates) = self.describe_apart(series, j, length, &velocities);
                if window.contacts[j].mode == Mode::Clipped {
                    worst = worst.max(self.describe_clipped(series, j, [&overlaps, &rates], tolerance, rounding)?);
                }
            }
        }
        Some(worst)
    }

    /// Enters overlap and force of the pressing contact `j`; returns the error of the overlap, or its jump at the
    /// start, over the allowed one. The velocities are known to within `rounding` (m/s).
    fn describe_pressing(&self, series: &mut Series, j: usize, length: f64, tolerance: f64, rounding: f64) -> f64 {
        let (window, contact, of_rates) = (self.window, &self.window.contacts[j], RATES * rounding);
        // Without the start: the overlap must follow the balance of forces, not the rounding of the velocities.
        let polynomial = RADAU.polynomial(&(self.derivative * self.changes[j]));
        let size = contact.overlap + self.changes[j].amax();
        // The force must be as accurate, and its relative error is `exponent` times as large.
        let relative = (OF_OVERLAPS * tolerance).max(2.0 * LEAST_ROUNDINGS * f64::EPSILON) / window.laws[j].exponent;
        let stiffness = window.laws[j].elastic_continued(contact.overlap).map_or(0.0, |(_, slope)| slope);
        // The change of the overlap by the rounding of its rate.
        let change = if stiffness > 0.0 { of_rates * (window.reduced_mass(j) / stiffness).sqrt() } else { 0.0 };
        let allowed = (relative * size).max(change).max(RATES * self.rounding_of_change(j)) / length;
        let jump = (polynomial[0] - window.overlap_rate(j)).abs() / (JUMP * allowed).max(of_rates);
        integrate(&mut series.overlaps[j * series.stride..], &polynomial, length);
        let overlaps = self.changes[j].add_scalar(contact.overlap);
        let elastic = overlaps.map(|d| window.laws[j].elastic_continued(d).map_or(0.0, |(force, _)| force));
        series.set_forces(j, &RADAU.polynomial(&elastic), &RADAU.polynomial(&self.forces[j + 1]));
        (highest_terms(&polynomial) / allowed).max(jump)
    }

    /// Enters the overlap of contact `j`, which does not press, from the motion of its balls with these `velocities`
    /// (m/s). Returns overlaps (m) and rates (m/s) at the stages.
    fn describe_apart(&self, series: &mut Series, j: usize, length: f64, velocities: &[Stages]) -> (Stages, Stages) {
        let (window, overlap) = (self.window, self.window.contacts[j].overlap);
        let overlaps = self.closer(j).add_scalar(overlap);
        let rate = |s: usize| {
            let [left, right] = [j, j + 1].map(|i| (window.flights[i].x + self.balls[i].moved[s], velocities[i][s]));
            window.pair(j).overlap_rate([left, right])
        };
        let rates = Stages::from_fn(|s, _| rate(s));
        let of_row = |overlap: f64, rate: f64| series.rate_of_row(j, overlap, rate);
        let start = of_row(overlap, window.overlap_rate(j));
        let polynomial = RADAU.polynomial_from(start, &overlaps.zip_map(&rates, of_row));
        integrate(&mut series.overlaps[j * series.stride..], &polynomial, length);
        (overlaps, rates)
    }

    /// Enters the force that contact `j` would have if it were not clipped, for the time at which it would push again.
    /// Returns its error over the allowed one.
    fn describe_clipped(
        &self,
        series: &mut Series,
        j: usize,
        [overlaps, rates]: [&Stages; 2],
        tolerance: f64,
        rounding: f64,
    ) -> Option<f64> {
        let (mut forces, mut unknown) = (Stages::zeros(), 0.0_f64);
        for s in 0..STAGES {
            let (force, _, by_rate) = self.window.laws[j].continued(overlaps[s], rates[s])?;
            (forces[s], unknown) = (force, unknown.max(LEAST_ROUNDINGS * by_rate.abs() * rounding));
        }
        let polynomial = RADAU.polynomial(&forces);
        let allowed = (tolerance * forces.amax()).max(unknown);
        series.set_forces(j, &[], &polynomial);
        Some(if allowed > 0.0 { highest_terms(&polynomial) / allowed } else { 0.0 })
    }
}
