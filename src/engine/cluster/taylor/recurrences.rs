//! The coefficients of the Taylor series of a window; see "Series" in docs/theory.md for recurrences, order and step.

use super::series::{INVERSE_FACTORIAL, Series};
use crate::engine::cluster::step_control::{Control, Problem};
use crate::engine::cluster::window::Window;
use crate::engine::flight::{degree, forcing_at};
use crate::model::{BallModel, ContactLaw, Mode};
use crate::solver::series::{INVERSES, NUMBERS, PowerSeries, product_term, value_by_lanes};
use crate::solver::{MAX_FORCE_ORDER, crossing};

/// Allowed difference between the force by the series and by the law: its effect on the velocities, over their scale.
const WRONG: f64 = 1e-13;

/// Velocities up to this, m/s, count as a start from rest; accelerations soon cause far larger ones.
const AT_REST: f64 = 1e-20;

/// An overlap about to vanish shortens the unit of time by no more than this factor.
const SHORTEST_UNIT: f64 = 1e-20;

/// Terms from which the convergence of a series without gaps is estimated.
const TERMS_AT_LEAST: usize = 3;

/// Ratio of the order of series for linear contacts to that for others, whose coefficients cost more the higher they
/// are. A lower order needs more steps for a pulse; twice the order loses digits by cancelling terms
/// (`benches/runs.rs`, `tests/rust/reference.rs`).
const LINEAR_ORDER_RATIO: f64 = 1.5;

/// A closed contact, and the series that its force consists of.
struct Force {
    contact: usize,
    parts: [Option<(f64, PowerSeries)>; 2],
}

/// Factors in the coefficients of a ball's displacement on a line: the unit of time over its mass (s/kg; the square of
/// the unit might underflow), and its squared frequency and damping in units of time.
struct Pendulum {
    unit_over_mass: f64,
    omega2: f64,
    drag: f64,
}

impl Pendulum {
    fn new(ball: &BallModel, unit: f64) -> Self {
        Self { unit_over_mass: unit / ball.mass, omega2: unit * ball.omega2 * unit, drag: 2.0 * ball.gamma * unit }
    }

    fn is_like(&self, other: &Self) -> bool {
        (self.omega2, self.drag) == (other.omega2, other.drag)
    }
}

impl Series {
    /// Computes all coefficients from those of [`begin`](Self::begin). Contacts whose overlap is `negligible` have no
    /// elastic force. Overlaps that are `given` stay as they are, and their forces follow from them.
    pub fn fill(&mut self, window: &Window<'_>, negligible: &dyn Fn(usize) -> bool, given: &dyn Fn(usize) -> bool) {
        let closed = (0..window.laws.len()).filter(|j| window.contacts[*j].mode != Mode::Open);
        let force = |j| Force { contact: j, parts: window.laws[j].force_series(negligible(j)) };
        let mut forces: Vec<Force> = closed.map(force).collect();
        let pendulums: Vec<Pendulum> = window.models.iter().map(|ball| Pendulum::new(ball, self.unit)).collect();
        for k in 0..self.order {
            forces.iter_mut().for_each(|force| self.expand_force(force, k));
            if window.models[0].on_arc {
                self.expand_motion_along_arcs(window, k, given);
            } else {
                self.expand_motion(window, &pendulums, k, given);
            }
        }
    }

    /// Coefficient `k` of the forces of a contact.
    fn expand_force(&mut self, Force { contact, parts: [elastic, damping] }: &mut Force, k: usize) {
        let at = *contact * self.stride;
        let overlap = &self.overlaps[at..at + self.stride];
        let elastic = elastic.as_mut().map_or(0.0, |(factor, powers)| *factor * powers.term(overlap, k));
        let damping = damping.as_mut().map_or(0.0, |(factor, powers)| {
            if k == 0 {
                powers.term(overlap, 0);
            }
            *factor * powers.term(overlap, k + 1) * NUMBERS[k + 1] / self.unit
        });
        self.elastic[at + k] = elastic;
        self.forces[at + k] = elastic + damping;
    }

    /// Coefficient `k` of the accelerations, hence `k + 2` of the displacements and of the overlaps that are not given.
    fn expand_motion(&mut self, window: &Window<'_>, pendulums: &[Pendulum], k: usize, given: &dyn Fn(usize) -> bool) {
        let (stride, unit, next) = (self.stride, self.unit, NUMBERS[k + 1]);
        let inverse = INVERSES[k + 1] * INVERSES[k + 2];
        let of_forcing = |inverse: &f64| inverse * (0..=k).fold(1.0, |power, _| power * self.unit);
        let of_forcing = INVERSE_FACTORIAL.get(k).map(of_forcing);
        let (mut from_left, mut driven_left) = (0.0, 0.0);
        for (i, pendulum) in pendulums.iter().enumerate() {
            let at = i * stride + k;
            let from_right = if window.presses(i) { self.forces[at] } else { 0.0 };
            let mut driven = (from_left - from_right) * pendulum.unit_over_mass * unit;
            if let Some(factor) = of_forcing {
                driven += window.flights[i].forcing[k] * unit * factor;
            }
            // The next coefficient of a pendulum from this one of position (m) and the next one.
            let term = |driven: f64, position: f64, of_rate: f64| {
                (driven - pendulum.omega2 * position - pendulum.drag * next * of_rate) * inverse
            };
            let position = if k == 0 { window.flights[i].x } else { self.displacements[at] };
            self.displacements[at + 2] = term(driven, position, self.displacements[at + 1]);
            if let Some(j) = i.checked_sub(1)
                && !given(j)
            {
                let at_contact = at - stride;
                self.overlaps[at_contact + 2] = if pendulums[j].is_like(pendulum) {
                    // Gravity pulls on the difference of the positions, which the overlap gives without rounding.
                    let clearance = if k == 0 { window.laws[j].clearance } else { 0.0 };
                    let apart = self.overlaps[at_contact] + clearance;
                    term(driven_left - driven, apart, self.overlaps[at_contact + 1])
                } else {
                    self.displacements[at_contact + 2] - self.displacements[at + 2]
                };
            }
            (from_left, driven_left) = (from_right, driven);
        }
    }

    /// Coefficient `k` of the accelerations, hence `k + 2` of the displacements and of the geometry.
    fn expand_motion_along_arcs(&mut self, window: &Window<'_>, k: usize, given: &dyn Fn(usize) -> bool) {
        let (stride, unit, next) = (self.stride, self.unit, (k + 1) as f64);
        for i in 0..window.models.len() {
            let (ball, at) = (window.models[i], i * stride);
            let by_contact = |j: usize, side: usize| match window.presses(j) {
                true => product_term(&self.forces[j * stride..], &self.arcs.along[side][j * stride..], k),
                false => 0.0,
            };
            let from_left = if i > 0 { by_contact(i - 1, 1) } else { 0.0 };
            let (mut driven, mut power) = ((from_left - by_contact(i, 0)) / ball.mass, 1.0);
            for (m, forcing) in window.flights[i].forcing.iter().enumerate().take(k.min(MAX_FORCE_ORDER) + 1) {
                driven += *forcing * (INVERSE_FACTORIAL[m] * power) * self.arcs.cos[at + k - m];
                power *= self.unit;
            }
            let gravity = ball.gravity * self.arcs.sin[at + k];
            let damped = 2.0 * ball.gamma * next * self.displacements[at + k + 1] / unit;
            let a = driven - gravity - damped;
            self.displacements[at + k + 2] = a * unit * unit / (next * (next + 1.0));
        }
        self.arcs.expand(window, k + 2, &self.displacements, &mut self.overlaps, given);
    }

    /// Computes all coefficients from the state at the start of a segment with velocities of this `scale` (m/s), to the
    /// accuracy of `control`. Returns for each contact the overlap (m) up to which its elastic force is left out, or 0.
    pub fn expand(&mut self, window: &Window<'_>, control: &Control, scale: f64) -> Vec<f64> {
        let (contacts, dv) = (0..window.laws.len(), control.local_error(scale));
        let negligible: Vec<f64> = contacts.clone().map(|j| negligible_overlap(j, window, dv, scale)).collect();
        self.begin(window, control.order, unit_of_time(window, scale, |j| negligible[j] > 0.0));
        self.fill(window, &|j| negligible[j] > 0.0 || !window.needs_force(j), &|_| false);
        // After an onset, series have gaps: the overlap is `d = u t + c t^(p+2) + ...`. So more terms are checked.
        let gap = contacts.map(|j| libm::ceil(window.laws[j].exponent) as usize).fold(1, usize::max);
        self.terms = gap + TERMS_AT_LEAST;
        negligible
    }

    /// The time (s) up to which the last terms of the velocities stay below `dv` (m/s).
    fn convergence(&self, dv: f64) -> f64 {
        let mut shortest = f64::INFINITY;
        for k in (self.order + 1).saturating_sub(self.terms).max(2)..=self.order {
            let rows = self.displacements.chunks_exact(self.stride);
            let largest = rows.map(|d| ((k + 1) as f64 * d[k + 1]).abs()).fold(0.0, f64::max);
            let largest = self.arcs.term(k + 1).max(largest);
            if largest > 0.0 {
                shortest = shortest.min(libm::pow(dv * self.unit / largest, 1.0 / k as f64));
            }
        }
        shortest * self.unit
    }

    /// Ends the segment where an overlap rises above what is `negligible`.
    fn shorten_where_above(&mut self, negligible: &[f64]) {
        for (j, level) in negligible.iter().enumerate().filter(|(_, level)| **level > 0.0) {
            if let Some(s) = crossing::first_positive(self.overlap_row(j), 1.0, *level, self.converges_for / self.unit)
            {
                self.converges_for = s * self.unit;
            }
        }
    }
}

impl Series {
    /// Computes all coefficients for a window. The segment ends where last terms, or forces left out, would change
    /// velocities too much.
    pub fn expand_window(&mut self, &Problem { window, control, speed, local_error, .. }: &Problem) {
        let order = if window.is_linear() { LINEAR_ORDER_RATIO * control.order as f64 } else { control.order as f64 };
        let negligible = self.expand(window, &Control { order: order as usize, ..*control }, speed);
        self.converges_for = self.convergence(local_error).min(control.longest);
        self.shorten_where_above(&negligible);
        for (j, law) in window.laws.iter().enumerate() {
            if window.needs_force(j) && negligible[j] == 0.0 && !law.is_linear() {
                self.shorten_where_wrong(j, law, window.reduced_mass(j), speed);
            }
        }
    }

    /// Shortens the segment until, at its end, the series of both parts of the force of contact `j` equal the law; each
    /// on its own, because the parts may cancel. From rest the force starts with a high power of the time, which may
    /// lie beyond the order.
    fn shorten_where_wrong(&mut self, j: usize, law: &ContactLaw, mass: f64, scale: f64) {
        // Bounded, for states that are not finite.
        for _ in 0..64 {
            let s = self.converges_for / self.unit;
            let (overlap, rate) = self.overlap_at(j, s);
            let [elastic, force] = [self.elastic_row(j), self.force_row(j)].map(|row| value_by_lanes(row, s));
            if let Some((by_law, by_rate)) = law.parts(overlap) {
                let speed_up = |force: f64| force.abs() * self.converges_for / mass;
                let allowed = WRONG * (scale + speed_up(by_law));
                // A dashpot has the series of the rate, so it is not compared.
                let damping = if law.has_dashpot() { 0.0 } else { force - elastic - by_rate * rate };
                let wrong = speed_up(by_law - elastic).max(speed_up(damping));
                // Far beyond their convergence both may be infinite.
                if allowed.is_finite() && wrong <= allowed {
                    return;
                }
            }
            // Also if the overlap vanishes there, where a fractional power has no value.
            self.converges_for *= 0.5;
        }
    }
}

/// Scale of the velocities (m/s) for local errors: the largest velocity and closing rate by the elastic energies or,
/// from rest, the speed that the other accelerations cause until a contact balances them.
pub(crate) fn velocity_scale(window: &Window<'_>) -> f64 {
    let moving = window.flights.iter().map(|flight| flight.v.abs()).fold(f64::MIN_POSITIVE, f64::max);
    // Rigid contacts store nothing.
    let stores = |j: &usize| window.laws[*j].stiffness > 0.0;
    let stored = (0..window.laws.len()).filter(stores).map(|j| {
        let energy = window.laws[j].elastic_energy(window.contacts[j].overlap);
        let from_energy = (2.0 * energy / window.reduced_mass(j)).sqrt();
        if moving > AT_REST { from_energy } else { from_energy.max(speed_from_rest(window, j)) }
    });
    stored.fold(moving, f64::max)
}

/// Speed (m/s) that the other accelerations of the balls of contact `j` cause from rest until the contact balances
/// them. If these grow from 0, the time until then is found by iteration, to within a power of ten.
fn speed_from_rest(window: &Window<'_>, j: usize) -> f64 {
    let bounds = [j, j + 1].map(|i| {
        let mut sizes = window.flights[i].forcing;
        sizes[0] -= window.models[i].omega2 * window.flights[i].x;
        sizes.map(f64::abs)
    });
    let (law, mass) = (&window.laws[j], window.reduced_mass(j));
    let acceleration = |time: f64| bounds.iter().map(|sizes| forcing_at(sizes, time)).fold(0.0, f64::max);
    let speed = |acceleration: f64| law.speed_from_rest(mass, acceleration);
    if bounds.iter().all(|sizes| degree(sizes) == 0) {
        return speed(acceleration(0.0));
    }
    let mut time = 1.0;
    for _ in 0..4 {
        let acceleration = acceleration(time);
        time = speed(acceleration) / acceleration;
    }
    speed(acceleration(time))
}

/// The overlap (m) up to which the elastic force of contact `j` is left out: it changes the velocities by less than the
/// local error `dv` (m/s), and its series, a fractional power, would hardly converge. 0 if it is not left out.
fn negligible_overlap(j: usize, window: &Window<'_>, dv: f64, scale: f64) -> f64 {
    if window.needs_force(j) && !window.laws[j].is_smooth() {
        let (law, mass, rate) = (&window.laws[j], window.reduced_mass(j), window.overlap_rate(j));
        let bound = law.largest_negligible_overlap(mass, rate, dv, law.time_scale(mass, scale));
        if window.contacts[j].overlap < bound {
            return 2.0 * bound;
        }
    }
    0.0
}

/// A time (s) within a few powers of ten of the radius of convergence: the time unit of the fastest contact, or of the
/// pendulums without contact; less if an overlap that is not `negligible` vanishes sooner, where its power is singular.
fn unit_of_time(window: &Window<'_>, scale: f64, negligible: impl Fn(usize) -> bool) -> f64 {
    let swing = |ball: &BallModel| ball.omega2.sqrt() + 2.0 * ball.gamma;
    let swing = window.models.iter().map(swing).fold(0.0, f64::max);
    let mut unit = if swing > 0.0 { 1.0 / swing } else { 1.0 };
    for j in (0..window.laws.len()).filter(|j| window.needs_force(*j)) {
        let (law, mass) = (&window.laws[j], window.reduced_mass(j));
        unit = unit.min(law.time_scale(mass, scale)).min(law.relaxation_time(mass, scale));
        let (overlap, rate) = (window.contacts[j].overlap, window.overlap_rate(j).abs());
        if !window.laws[j].is_smooth() && !negligible(j) && overlap < unit * rate {
            unit = (overlap / rate).max(SHORTEST_UNIT * unit);
        }
    }
    unit
}
