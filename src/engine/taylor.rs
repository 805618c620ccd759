//! The Taylor series of all motions of a window.
//!
//! The equations are autonomous between switchings, so the coefficients follow from each other: those of the forces from those
//! of the overlaps (powers by recursion), those of the motions from those of the forces. Order and step follow Jorba and
//! Zou, A software package for the numerical integration of ODEs by means of high-order Taylor methods, Experimental
//! Mathematics 14 (2005): order `1 - ln(epsilon) / 2`, and a step on which the last terms are below epsilon times the scale
//! of the velocities. The series is its own dense output.

use super::ball::{Ball, Flight};
use super::cluster::{Mode, Switch, WindowContact};
use crate::model::{ContactLaw, Damping};
use crate::solver::series::{self, power_term, product_term};

/// What governs order and step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Control {
    /// Local error over the scale of the velocities.
    epsilon: f64,
    /// Order of the series of the velocities.
    order: usize,
}

impl Control {
    /// For the relative tolerance of a whole run; local errors stay far enough below it for thousands of pulses.
    pub fn new(tolerance: f64) -> Self {
        let epsilon = (1e-5 * tolerance).max(1e-18);
        Self { epsilon, order: (1.0 - 0.5 * libm::log(epsilon)) as usize }
    }
}

/// Coefficients of the motions and forces of a window.
#[derive(Clone, Debug, Default)]
pub(crate) struct Series {
    /// Order of the velocities; displacements have one more.
    order: usize,
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

/// Longest segment, s, for a window in which nothing varies.
const LONGEST: f64 = 1e6;

impl Series {
    fn stride(&self) -> usize {
        self.order + 2
    }

    fn row<'a>(&self, rows: &'a [f64], j: usize) -> &'a [f64] {
        &rows[j * self.stride()..(j + 1) * self.stride()]
    }

    /// Displacement of ball `j` of the window, m.
    pub fn displacement(&self, j: usize) -> &[f64] {
        self.row(&self.displacements, j)
    }

    /// Velocity of ball `j` of the window, m/s.
    pub fn velocity(&self, j: usize) -> Vec<f64> {
        series::differentiated(self.displacement(j))
    }

    /// Overlap of contact `j` of the window, m.
    pub fn overlap(&self, j: usize) -> &[f64] {
        self.row(&self.overlaps, j)
    }

    /// Rate of the overlap of contact `j` of the window, m/s.
    pub fn rate(&self, j: usize) -> Vec<f64> {
        series::differentiated(self.overlap(j))
    }

    /// Force of contact `j` of the window by its law without clipping, N.
    pub fn force(&self, j: usize) -> &[f64] {
        &self.row(&self.forces, j)[..self.order]
    }

    /// The force of contact `j` less its elastic part, N; `pressing` tells whether the law acts or is clipped.
    pub fn dissipative_force(&self, j: usize, pressing: bool) -> Vec<f64> {
        let elastic = &self.row(&self.elastic, j)[..self.order];
        if pressing {
            self.force(j).iter().zip(elastic).map(|(f, e)| f - e).collect()
        } else {
            elastic.iter().map(|e| -e).collect()
        }
    }

    /// How long the series converge to the tolerance, s.
    pub fn converges_for(&self) -> f64 {
        self.converges_for
    }

    /// The functions of time whose crossing of zero switches contact `j`, whether it counts when falling, and to what.
    pub fn watches(&self, j: usize, law: &ContactLaw, mode: Mode) -> Vec<(Vec<f64>, bool, Switch)> {
        let overlap = self.overlap(j);
        if mode == Mode::Open {
            return vec![(overlap.to_vec(), false, Switch::Onset)];
        }
        let mut watches = vec![(overlap.to_vec(), true, Switch::Release)];
        let push = match law.damping {
            Damping::KelvinVoigt { pull: false, .. } => self.force(j).to_vec(),
            Damping::HuntCrossley { alpha } => {
                let mut factor: Vec<f64> = self.rate(j).iter().map(|r| alpha * r).collect();
                factor[0] += 1.0;
                factor
            }
            _ => return watches,
        };
        watches.push(if mode == Mode::Pressing { (push, true, Switch::Clip) } else { (push, false, Switch::Unclip) });
        watches
    }

    /// Computes all coefficients from the state at the start of a segment.
    pub fn expand(
        &mut self,
        flights: &[Flight],
        contacts: &[WindowContact],
        balls: &[Ball],
        laws: &[ContactLaw],
        control: &Control,
    ) {
        self.begin(flights, contacts, control.order);
        let scale = velocity_scale(flights, contacts, balls, laws);
        self.find_faint(contacts, balls, laws, control.epsilon * scale, scale);
        for k in 0..self.order {
            for (j, law) in laws.iter().enumerate() {
                if contacts[j].mode != Mode::Open {
                    self.expand_force(j, law, k);
                }
            }
            self.expand_motion(flights, contacts, balls, k);
        }
        self.converges_for = self.convergence(control.epsilon * scale).min(LONGEST);
        for j in 0..contacts.len() {
            self.shorten_where_faint(j);
        }
    }

    fn begin(&mut self, flights: &[Flight], contacts: &[WindowContact], order: usize) {
        self.order = order;
        let stride = self.stride();
        self.displacements.clear();
        self.displacements.resize(flights.len() * stride, 0.0);
        for rows in [&mut self.overlaps, &mut self.elastic, &mut self.forces] {
            rows.clear();
            rows.resize(contacts.len() * stride, 0.0);
        }
        for (j, flight) in flights.iter().enumerate() {
            self.displacements[j * stride + 1] = flight.v;
        }
        for (j, contact) in contacts.iter().enumerate() {
            self.overlaps[j * stride] = contact.overlap;
            self.overlaps[j * stride + 1] = flights[j].v - flights[j + 1].v;
        }
        self.powers.resize(contacts.len(), Vec::new());
    }

    /// Where a power that is not whole starts from almost no overlap its series hardly converges, and its force does not
    /// matter: it is left out up to an overlap where it would change the velocities by the local error.
    fn find_faint(&mut self, contacts: &[WindowContact], balls: &[Ball], laws: &[ContactLaw], dv: f64, scale: f64) {
        self.faint.clear();
        for (j, (contact, law)) in contacts.iter().zip(laws).enumerate() {
            let mut faint = 0.0;
            if contact.mode != Mode::Open && law.whole_exponent().is_none() {
                let mass = reduced_mass(&balls[j], &balls[j + 1]);
                let rate = self.overlap(j)[1];
                let bound = law.faint_overlap(mass, rate, dv, law.time_scale(mass, scale));
                if contact.overlap < bound {
                    faint = 2.0 * bound;
                }
            }
            self.faint.push(faint);
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
        let rate = |k: usize| (k + 1) as f64 * overlap[k + 1];
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
    fn expand_motion(&mut self, flights: &[Flight], contacts: &[WindowContact], balls: &[Ball], k: usize) {
        let stride = self.stride();
        let acting = |j: usize| contacts[j].mode == Mode::Pressing;
        for (j, (flight, ball)) in flights.iter().zip(balls).enumerate() {
            let from_left = if j > 0 && acting(j - 1) { self.forces[(j - 1) * stride + k] } else { 0.0 };
            let from_right = if j < contacts.len() && acting(j) { self.forces[j * stride + k] } else { 0.0 };
            let d = &mut self.displacements[j * stride..(j + 1) * stride];
            let o = &ball.oscillator;
            let position = if k == 0 { flight.x } else { d[k] };
            let push = flight.push.get(k).map_or(0.0, |p| p * INVERSE_FACTORIAL[k]);
            let acceleration = (from_left - from_right) / ball.mass + push
                - o.omega2() * position
                - 2.0 * o.gamma() * (k + 1) as f64 * d[k + 1];
            d[k + 2] = acceleration / ((k + 1) * (k + 2)) as f64;
        }
        for j in 0..contacts.len() {
            let at = j * stride + k + 2;
            self.overlaps[at] = self.displacements[at] - self.displacements[at + stride];
        }
    }

    /// The time on which the last three terms of the velocities stay below `dv` (m/s).
    fn convergence(&self, dv: f64) -> f64 {
        let mut shortest = f64::INFINITY;
        for k in self.order - 2..=self.order {
            let largest = self
                .displacements
                .chunks_exact(self.stride())
                .map(|d| ((k + 1) as f64 * d[k + 1]).abs())
                .fold(0.0, f64::max);
            if largest > 0.0 {
                shortest = shortest.min(libm::pow(dv / largest, 1.0 / k as f64));
            }
        }
        shortest
    }

    /// Ends the segment where contact `j` leaves the overlaps that are left out.
    fn shorten_where_faint(&mut self, j: usize) {
        if self.faint[j] > 0.0 {
            let mut above = self.overlap(j).to_vec();
            above[0] -= self.faint[j];
            if let Some(tau) = series::first_positive(&above, self.converges_for) {
                self.converges_for = tau;
            }
        }
    }
}

const INVERSE_FACTORIAL: [f64; 4] = [1.0, 1.0, 0.5, 1.0 / 6.0];

fn reduced_mass(left: &Ball, right: &Ball) -> f64 {
    left.mass * right.mass / (left.mass + right.mass)
}

/// Scale of the velocities (m/s) that local errors are measured by: the largest velocity, and the largest closing rate that the
/// elastic energies amount to.
fn velocity_scale(flights: &[Flight], contacts: &[WindowContact], balls: &[Ball], laws: &[ContactLaw]) -> f64 {
    let moving = flights.iter().map(|f| f.v.abs()).fold(f64::MIN_POSITIVE, f64::max);
    let stored = contacts.iter().zip(laws).enumerate().map(|(j, (contact, law))| {
        let mass = reduced_mass(&balls[j], &balls[j + 1]);
        (2.0 * law.elastic_energy(contact.overlap) / mass).sqrt()
    });
    stored.fold(moving, f64::max)
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
