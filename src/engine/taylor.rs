//! The Taylor series of all motions of a window.
//!
//! The equations are autonomous between switchings, so the coefficients follow from each other: those of the forces from those
//! of the overlaps (powers by recursion), those of the motions from those of the forces. Order and step follow Jorba and
//! Zou, A software package for the numerical integration of ODEs by means of high-order Taylor methods, Experimental
//! Mathematics 14 (2005): order `1 - ln(epsilon) / 2`, and a step on which the last terms are below epsilon times the scale
//! of the velocities. The series is its own dense output.

use super::ball::{Push, Rounding, degree};
use super::cluster::{LONGEST, Mode, Switch, Switching, Window};
use crate::model::{ContactLaw, Damping};
use crate::solver::oscillator::{MAX_FORCE_ORDER, Oscillator};
use crate::solver::series::{self, power_term, product_term};

/// What governs order and step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Control {
    /// Local error over the scale of the velocities.
    epsilon: f64,
    /// Order of the series of the velocities.
    order: usize,
    /// Relative tolerance of a whole run.
    tolerance: f64,
}

impl Control {
    /// For the relative tolerance of a whole run; local errors stay far enough below it for thousands of pulses.
    pub fn new(tolerance: f64) -> Self {
        let epsilon = (1e-5 * tolerance).max(1e-18);
        Self { epsilon, order: (1.0 - 0.5 * libm::log(epsilon)) as usize, tolerance }
    }

    /// Relative tolerance of a whole run.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }
}

/// Coefficients of the motions and forces of a window, as functions of the time since the start of the segment over `unit`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Series {
    /// Order of the velocities; displacements have one more.
    order: usize,
    /// Unit of time of the series, s: of the order of what they converge for, lest high powers overflow.
    unit: f64,
    /// A ball each: displacement since the start of the segment.
    displacements: Vec<f64>,
    /// A contact each: overlap.
    overlaps: Vec<f64>,
    /// A contact each: elastic force, and the force of the law without clipping. Zero where the contact is open.
    elastic: Vec<f64>,
    forces: Vec<f64>,
    /// Scratch: powers of the scaled overlap of a contact, one after the other.
    powers: Vec<Vec<f64>>,
    /// A contact each: the overlap up to which its elastic force is left out, 0 if it is not.
    faint: Vec<f64>,
    /// How long the series converge to the tolerance, s.
    converges_for: f64,
}

impl Series {
    fn stride(&self) -> usize {
        self.order + 2
    }

    fn row<'a>(&self, rows: &'a [f64], j: usize) -> &'a [f64] {
        &rows[j * self.stride()..(j + 1) * self.stride()]
    }

    fn displacement(&self, j: usize) -> &[f64] {
        self.row(&self.displacements, j)
    }

    fn overlap_row(&self, j: usize) -> &[f64] {
        self.row(&self.overlaps, j)
    }

    fn force_row(&self, j: usize) -> &[f64] {
        &self.row(&self.forces, j)[..self.order]
    }

    /// Coefficients of the derivative of a row by time.
    fn rate(&self, row: &[f64]) -> Vec<f64> {
        row.iter().enumerate().skip(1).map(|(k, c)| k as f64 * c / self.unit).collect()
    }

    /// Displacement of ball `j` of the window since the start of the segment (m) and the change of its velocity (m/s) till `tau`
    /// (s). The change: at the start, where many switchings may come at once, it must be exactly 0.
    pub fn moved(&self, j: usize, tau: f64) -> (f64, f64) {
        self.with_change_of_rate(self.displacement(j), tau)
    }

    fn with_change_of_rate(&self, row: &[f64], tau: f64) -> (f64, f64) {
        let s = tau / self.unit;
        (series::value(row, s), series::change_of_derivative(row, s) / self.unit)
    }

    /// Integral of that displacement, m.s.
    pub fn displacement_integral(&self, j: usize, tau: f64) -> f64 {
        self.unit * series::integral(self.displacement(j), tau / self.unit)
    }

    /// Overlap of contact `j` of the window (m) at `tau` (s) and the change of its rate (m/s) till then.
    pub fn overlap(&self, j: usize, tau: f64) -> (f64, f64) {
        self.with_change_of_rate(self.overlap_row(j), tau)
    }

    /// Integral of the force of contact `j` by its law without clipping, N.s.
    pub fn impulse(&self, j: usize, tau: f64) -> f64 {
        self.unit * series::integral(self.force_row(j), tau / self.unit)
    }

    /// The larger of `known` and the largest such force between two times (s), N.
    pub fn peak(&self, j: usize, from: f64, to: f64, known: f64) -> f64 {
        series::maximum(self.force_row(j), from / self.unit, to / self.unit).max(known)
    }

    /// Integral of the squared velocity of ball `j`, m2/s.
    pub fn squared_velocity_integral(&self, j: usize, tau: f64) -> f64 {
        let v = self.rate(self.displacement(j));
        self.unit * series::product_integral(&v, &v, tau / self.unit)
    }

    /// Work per unit of mass of the acceleration `push` on ball `j`, m2/s2.
    pub fn work(&self, j: usize, push: &Push, tau: f64) -> f64 {
        if degree(push) == 0 {
            return push[0] * self.moved(j, tau).0;
        }
        let mut unit = 1.0;
        let mut scaled = [0.0; MAX_FORCE_ORDER + 1];
        for (k, p) in push.iter().enumerate() {
            scaled[k] = p * unit * INVERSE_FACTORIAL[k];
            unit *= self.unit;
        }
        self.unit * series::product_integral(&scaled, &self.rate(self.displacement(j)), tau / self.unit)
    }

    /// Energy that the pressing contact `j` dissipates by the force less its elastic part, J.
    pub fn contact_loss(&self, j: usize, tau: f64) -> f64 {
        let elastic = &self.row(&self.elastic, j)[..self.order];
        let excess: Vec<f64> = self.force_row(j).iter().zip(elastic).map(|(f, e)| f - e).collect();
        self.unit * series::product_integral(&excess, &self.rate(self.overlap_row(j)), tau / self.unit)
    }

    /// How long the series converge to the tolerance, s.
    pub fn converges_for(&self) -> f64 {
        self.converges_for
    }

    /// The crossing of `row`, signed, above `level` before `until` (s).
    fn crossing(&self, row: &[f64], (sign, level): (f64, f64), until: f64, switch: Switch) -> Option<Switching> {
        let tau = series::first_positive(row, sign, level, until / self.unit)? * self.unit;
        (tau < until).then_some((tau, Some(switch)))
    }

    /// The onset of the open contact `j` before `until` (s). Balls that swing side by side approach each other by rounding: that
    /// is no onset.
    pub fn onset(&self, j: usize, until: f64, rounding: &Rounding) -> Option<Switching> {
        let overlap = self.overlap_row(j);
        let onset = self.crossing(overlap, (1.0, 0.0), until, Switch::Onset)?;
        // Where a wave arrives, a ball in touch and at rest may take longer than this segment to be pressed any deeper.
        let noise = rounding.position;
        let deep = series::first_positive(overlap, 1.0, noise, until / self.unit).is_some();
        let wave = || overlap[1] == 0.0 && self.overlaps.chunks_exact(self.stride()).any(|d| d[0] + d[1] > noise);
        (deep || wave()).then_some(onset)
    }

    /// The release of the closed contact `j` before `until` (s).
    pub fn release(&self, j: usize, until: f64, rounding: &Rounding) -> Option<Switching> {
        self.crossing(self.overlap_row(j), (-1.0, rounding.no_overlap()), until, Switch::Release)
    }

    /// The beginning or, in mode `Clipped`, the end of the clipping of contact `j` before `until` (s), by more than `rounding`.
    pub fn clip(&self, j: usize, law: &ContactLaw, mode: Mode, until: f64, rounding: &Rounding) -> Option<Switching> {
        let (push, noise) = match law.damping {
            Damping::HuntCrossley { alpha } => {
                let mut factor: Vec<f64> = self.rate(self.overlap_row(j)).iter().map(|r| alpha * r).collect();
                factor[0] += 1.0;
                (factor, alpha * rounding.velocity)
            }
            _ => (self.force_row(j).to_vec(), rounding.force(law)),
        };
        let (sign, switch) = mode.clipping();
        self.crossing(&push, (sign, 0.0), until, switch)
            .filter(|_| series::first_positive(&push, sign, sign * noise, until / self.unit).is_some())
    }

    /// Computes all coefficients from the state at the start of a segment.
    pub fn expand(&mut self, window: &Window, control: &Control) {
        let Window { contacts, laws, .. } = window;
        let scale = velocity_scale(window);
        self.begin(window, control.order, unit_of_time(window, scale));
        self.find_faint(window, control.epsilon * scale, scale);
        for k in 0..self.order {
            for (j, law) in laws.iter().enumerate() {
                if contacts[j].mode != Mode::Open {
                    self.expand_force(j, law, k);
                }
            }
            self.expand_motion(window, k);
        }
        self.converges_for = self.convergence(control.epsilon * scale, laws).min(LONGEST);
        for (j, law) in laws.iter().enumerate() {
            self.shorten_where_faint(j);
            if contacts[j].mode != Mode::Open && law.exponent > 1.0 {
                self.shorten_where_wrong(j, law, window.reduced_mass(j), scale);
            }
        }
    }

    /// Rows of the given order and unit of time with nothing but the state at the start.
    pub(super) fn begin(&mut self, window: &Window, order: usize, unit: f64) {
        let Window { flights, contacts, .. } = window;
        (self.order, self.unit, self.converges_for) = (order, unit, unit);
        let stride = self.stride();
        self.displacements.clear();
        self.displacements.resize(flights.len() * stride, 0.0);
        for rows in [&mut self.overlaps, &mut self.elastic, &mut self.forces] {
            rows.clear();
            rows.resize(contacts.len() * stride, 0.0);
        }
        for (j, flight) in flights.iter().enumerate() {
            self.displacements[j * stride + 1] = flight.v * self.unit;
        }
        for (j, contact) in contacts.iter().enumerate() {
            self.overlaps[j * stride] = contact.overlap;
            self.overlaps[j * stride + 1] = (flights[j].v - flights[j + 1].v) * self.unit;
        }
        self.powers.resize(contacts.len(), Vec::new());
        self.faint.clear();
        self.faint.resize(contacts.len(), 0.0);
    }

    /// Gives ball `j` of the window this polynomial of the scaled time as its velocity, m/s.
    pub(super) fn set_velocity(&mut self, j: usize, velocity: &[f64]) {
        let (stride, unit) = (self.stride(), self.unit);
        integrate(&mut self.displacements[j * stride..(j + 1) * stride], velocity, unit);
    }

    /// Gives contact `j` this polynomial of the scaled time as the rate of its overlap, m/s.
    pub(super) fn set_rate(&mut self, j: usize, rate: &[f64]) {
        let (stride, unit) = (self.stride(), self.unit);
        integrate(&mut self.overlaps[j * stride..(j + 1) * stride], rate, unit);
    }

    /// Gives contact `j` these polynomials of the scaled time as its forces, N: elastic, and by the law without clipping.
    pub(super) fn set_forces(&mut self, j: usize, elastic: &[f64], force: &[f64]) {
        let at = j * self.stride();
        self.elastic[at..at + elastic.len()].copy_from_slice(elastic);
        self.forces[at..at + force.len()].copy_from_slice(force);
    }

    /// Where a power that is not whole starts from almost no overlap its series hardly converges, and its force does not
    /// matter: it is left out up to an overlap where it would change the velocities by the local error.
    fn find_faint(&mut self, window: &Window, dv: f64, scale: f64) {
        for (j, (contact, law)) in window.contacts.iter().zip(window.laws).enumerate() {
            if contact.mode != Mode::Open && law.whole_exponent().is_none() {
                let mass = window.reduced_mass(j);
                let rate = self.overlap_row(j)[1] / self.unit;
                let bound = law.faint_overlap(mass, rate, dv, law.time_scale(mass, scale));
                if contact.overlap < bound {
                    self.faint[j] = 2.0 * bound;
                }
            }
        }
    }

    /// Coefficient `k` of the forces of contact `j`.
    fn expand_force(&mut self, j: usize, law: &ContactLaw, k: usize) {
        let at = j * self.stride();
        let overlap = &self.overlaps[at..at + self.stride()];
        let elastic = if self.faint[j] > 0.0 {
            0.0
        } else {
            law.stiffness * law.overlap_ref * power(&mut self.powers[j], overlap, law, k)
        };
        self.elastic[at + k] = elastic;
        let rate = |k: usize| (k + 1) as f64 * overlap[k + 1] / self.unit;
        self.forces[at + k] = match law.damping {
            Damping::None => elastic,
            Damping::KelvinVoigt { c, .. } => elastic + c * rate(k),
            Damping::HuntCrossley { alpha } => {
                let product: f64 = (0..=k).map(|i| self.elastic[at + i] * rate(k - i)).sum();
                elastic + alpha * product
            }
        };
    }

    /// Coefficient `k` of the accelerations, hence `k + 2` of the displacements and overlaps.
    fn expand_motion(&mut self, window: &Window, k: usize) {
        let Window { flights, balls, contacts, laws } = window;
        let (stride, unit) = (self.stride(), self.unit);
        let unit_to_k = (0..k.min(MAX_FORCE_ORDER)).fold(1.0, |power, _| power * unit);
        let forces = &self.forces;
        let acting = |j: usize| if window.presses(j) { forces[j * stride + k] } else { 0.0 };
        let next = (k + 1) as f64;
        // What a pendulum makes of this coefficient of a position (m) and this one of a rate, under the acceleration `driven`.
        let term = |o: &Oscillator, driven: f64, position: f64, of_rate: f64| {
            let acceleration = driven - o.omega2() * position - 2.0 * o.gamma() * next * of_rate / unit;
            acceleration * unit * unit / (next * (next + 1.0))
        };
        let (mut from_left, mut driven_left) = (0.0, 0.0);
        for (j, (flight, ball)) in flights.iter().zip(*balls).enumerate() {
            let from_right = acting(j);
            let push = flight.push.get(k).map_or(0.0, |p| p * INVERSE_FACTORIAL[k] * unit_to_k);
            let driven = (from_left - from_right) / ball.mass + push;
            let at = j * stride + k;
            let position = if k == 0 { flight.x } else { self.displacements[at] };
            self.displacements[at + 2] = term(&ball.oscillator, driven, position, self.displacements[at + 1]);
            if let Some(i) = j.checked_sub(1) {
                let at = i * stride + k;
                self.overlaps[at + 2] = if balls[i].oscillator == ball.oscillator {
                    // Gravity pulls on the difference of the positions, which the overlap gives without rounding.
                    let apart = if k == 0 { contacts[i].overlap + laws[i].clearance } else { self.overlaps[at] };
                    term(&ball.oscillator, driven_left - driven, apart, self.overlaps[at + 1])
                } else {
                    self.displacements[at + 2] - self.displacements[at + 2 + stride]
                };
            }
            (from_left, driven_left) = (from_right, driven);
        }
    }

    /// The time on which the last terms of the velocities stay below `dv` (m/s).
    ///
    /// After an onset, series have gaps: the overlap is `d = u t + c t^(p+2) + ...`, with nothing in between. So many terms
    /// are looked at that they cannot all fall into a gap.
    fn convergence(&self, dv: f64, laws: &[ContactLaw]) -> f64 {
        let gap = laws.iter().map(|law| libm::ceil(law.exponent) as usize).fold(1, usize::max) + 2;
        let mut shortest = f64::INFINITY;
        for k in self.order.saturating_sub(gap).max(2)..=self.order {
            let largest = self
                .displacements
                .chunks_exact(self.stride())
                .map(|d| ((k + 1) as f64 * d[k + 1]).abs())
                .fold(0.0, f64::max);
            if largest > 0.0 {
                shortest = shortest.min(libm::pow(dv * self.unit / largest, 1.0 / k as f64));
            }
        }
        shortest * self.unit
    }

    /// Ends the segment where the series of the elastic force of contact `j` is still the force of the law. From rest the
    /// force starts with a high power of the time, which may lie beyond the order.
    fn shorten_where_wrong(&mut self, j: usize, law: &ContactLaw, mass: f64, scale: f64) {
        if self.faint[j] > 0.0 {
            return;
        }
        // Bounded, for states that are not finite.
        for _ in 0..64 {
            let s = self.converges_for / self.unit;
            let overlap = series::value(self.overlap_row(j), s);
            let by_series = series::value(&self.row(&self.elastic, j)[..self.order], s);
            if let Some((by_law, _)) = law.elastic_continued(overlap) {
                let speed_up = |force: f64| force.abs() * self.converges_for / mass;
                let allowed = 1e-13 * (scale + speed_up(by_law));
                // Far beyond their convergence both may be infinite.
                if allowed.is_finite() && speed_up(by_law - by_series) <= allowed {
                    return;
                }
            }
            // Halves reach what is left out where the overlap vanishes.
            self.converges_for *= 0.5;
        }
    }

    /// Ends the segment where contact `j` leaves the overlaps that are left out.
    fn shorten_where_faint(&mut self, j: usize) {
        if self.faint[j] > 0.0 {
            let until = self.converges_for / self.unit;
            if let Some(s) = series::first_positive(self.overlap_row(j), 1.0, self.faint[j], until) {
                self.converges_for = s * self.unit;
            }
        }
    }
}

const INVERSE_FACTORIAL: [f64; MAX_FORCE_ORDER + 1] = [1.0, 1.0, 0.5, 1.0 / 6.0];

/// Enters the integral of a polynomial of the scaled time, behind the constant term of `row`.
fn integrate(row: &mut [f64], rate: &[f64], unit: f64) {
    for (k, (term, rate)) in row[1..].iter_mut().zip(rate).enumerate() {
        *term = rate * unit / (k + 1) as f64;
    }
}

/// Scale of the velocities (m/s) that local errors are measured by: the largest velocity, and the largest closing rate that the
/// elastic energies amount to, or, from rest, what the other accelerations lead to until a contact balances them.
fn velocity_scale(window: &Window) -> f64 {
    let Window { flights, balls, contacts, laws } = window;
    let moving = flights.iter().map(|f| f.v.abs()).fold(f64::MIN_POSITIVE, f64::max);
    let stored = contacts.iter().zip(*laws).enumerate().map(|(j, (contact, law))| {
        let mass = window.reduced_mass(j);
        let from_energy = (2.0 * law.elastic_energy(contact.overlap) / mass).sqrt();
        if moving > 1e-100 || from_energy > 1e-100 {
            return from_energy;
        }
        let pull = |j: usize| (flights[j].push[0] - balls[j].oscillator.omega2() * flights[j].x).abs();
        let acceleration = pull(j).max(pull(j + 1));
        (acceleration * law.static_overlap(mass * acceleration)).sqrt()
    });
    stored.fold(moving, f64::max)
}

/// A time (s) within a few powers of ten of the one that the series will converge for: that of the fastest contact, or of an
/// overlap about to vanish, whose power is singular there; without contact that of the pendulums.
fn unit_of_time(window: &Window, scale: f64) -> f64 {
    let Window { flights, balls, contacts, laws } = window;
    let swing = balls.iter().map(|b| b.oscillator.omega() + 2.0 * b.oscillator.gamma()).fold(0.0, f64::max);
    let mut unit = if swing > 0.0 { 1.0 / swing } else { 1.0 };
    for (j, (contact, law)) in contacts.iter().zip(*laws).enumerate().filter(|(_, (c, _))| c.mode != Mode::Open) {
        unit = unit.min(law.time_scale(window.reduced_mass(j), scale));
        let rate = (flights[j].v - flights[j + 1].v).abs();
        if law.whole_exponent().is_none() && contact.overlap < unit * rate {
            unit = unit.min((contact.overlap / rate).max(1e-6 * unit));
        }
    }
    unit
}

/// Coefficient `k` of `(overlap / overlap_ref)^p`, with the lower powers kept in `table`.
fn power(table: &mut Vec<f64>, overlap: &[f64], law: &ContactLaw, k: usize) -> f64 {
    let scale = 1.0 / law.overlap_ref;
    let stride = overlap.len();
    match law.whole_exponent() {
        Some(1) => overlap[k] * scale,
        Some(p) => {
            table.resize(p * stride, 0.0);
            table[k] = overlap[k] * scale;
            for q in 1..p {
                let (base, lower) = (&table[..stride], &table[(q - 1) * stride..q * stride]);
                table[q * stride + k] = product_term(base, lower, k);
            }
            table[(p - 1) * stride + k]
        }
        None => {
            table.resize(stride, 0.0);
            table[k] = if k == 0 {
                law.elastic_force(overlap[0]) / (law.stiffness * law.overlap_ref)
            } else {
                power_term(overlap, table, law.exponent, k)
            };
            table[k]
        }
    }
}
