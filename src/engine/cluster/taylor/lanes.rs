//! The coefficients where contacts are elastic and their exponents not whole, of a few contacts at a time.
//!
//! The recurrences are those of `recurrences`. An order costs so little here that a high one pays: a wave in many balls takes about
//! four segments a ball, of which two end where it reaches a contact or leaves one.

use super::recurrences::{TERMS_AT_LEAST, WRONG, unit_and_negligible};
use super::series::{INVERSE_FACTORIAL, Series};
use crate::engine::cluster::dense_output::DenseOutput;
use crate::engine::cluster::step_control::Control;
use crate::engine::cluster::window::Window;
use crate::model::{ContactLaw, Mode};
use crate::solver::oscillator::MAX_FORCE_ORDER;
use crate::solver::series::{INVERSES, NUMBERS};

/// Balls, or the contacts at their right, side by side.
const LANES: usize = 4;

/// Order of the series of the velocities. A lower one takes more segments; those of a higher one are hardly longer, for most end at a
/// switching (`benches/runs.rs`).
const ORDER: usize = 32;

/// Coefficients of a row.
const ROOM: usize = ORDER + 2;

/// How often, at most, a segment is shortened for a force that is left out.
const CUTS: usize = 8;

/// A number for each ball, or for the contact at its right.
type Lanes = [f64; LANES];

/// Coefficients of each.
type Columns = [Lanes; ROOM];

/// A few neighbouring balls and the contacts at their right, side by side; zeros behind the last one.
#[derive(Clone, Copy, Debug)]
struct Block {
    /// The equations of the balls in scaled time.
    inverse_mass: Lanes,
    omega2: Lanes,
    drag: Lanes,
    /// 1 for contacts that press, else 0.
    presses: Lanes,
    /// Inverses of the overlaps, 1/m; 0 without an elastic force.
    inverse_overlap: Lanes,
    /// Positions of the balls, and distances of those of a contact from where they rest, at the start, m.
    position: Lanes,
    apart: Lanes,
    /// Coefficients of displacements and overlaps, m, and of forces, N.
    displacements: Columns,
    overlaps: Columns,
    forces: Columns,
}

impl Block {
    const ZERO: Self = Self {
        inverse_mass: [0.0; LANES],
        omega2: [0.0; LANES],
        drag: [0.0; LANES],
        presses: [0.0; LANES],
        inverse_overlap: [0.0; LANES],
        position: [0.0; LANES],
        apart: [0.0; LANES],
        displacements: [[0.0; LANES]; ROOM],
        overlaps: [[0.0; LANES]; ROOM],
        forces: [[0.0; LANES]; ROOM],
    };

    /// Sets what an expansion starts from to zero.
    fn clear(&mut self) {
        for numbers in [&mut self.inverse_mass, &mut self.omega2, &mut self.drag, &mut self.presses] {
            *numbers = [0.0; LANES];
        }
        for numbers in [&mut self.inverse_overlap, &mut self.position, &mut self.apart, &mut self.forces[0]] {
            *numbers = [0.0; LANES];
        }
        for columns in [&mut self.displacements, &mut self.overlaps] {
            columns[..2].fill([0.0; LANES]);
        }
    }

    fn has_force(&self) -> bool {
        self.inverse_overlap != [0.0; LANES]
    }

    /// Coefficient `k` of the elastic forces, by Miller's recursion (see [`power_term`](crate::solver::series::power_term)) with its
    /// `weights` from the first one on.
    fn expand_force(&mut self, k: usize, weights: &[f64]) {
        let mut sums = [0.0; LANES];
        if self.has_force() {
            let factors = self.overlaps[1..=k].iter().zip(self.forces[..k].iter().rev());
            for (weight, (overlap, force)) in weights.iter().zip(factors) {
                for lane in 0..LANES {
                    sums[lane] += weight * (overlap[lane] * force[lane]);
                }
            }
        }
        self.forces[k] = std::array::from_fn(|i| sums[i] * (INVERSES[k] * self.inverse_overlap[i]));
    }

    /// Coefficient `k + 2` of the displacements and overlaps, where the balls are `driven`, and the balls at their right, by all but
    /// their pendulums.
    fn expand_motion(&mut self, k: usize, driven: &Lanes, right: &Lanes) {
        let (next, inverse) = (NUMBERS[k + 1], INVERSES[k + 1] * INVERSES[k + 2]);
        let (position, apart) =
            if k == 0 { (&self.position, &self.apart) } else { (&self.displacements[k], &self.overlaps[k]) };
        let (velocity, rate) = (&self.displacements[k + 1], &self.overlaps[k + 1]);
        let term = |i: usize, driven: f64, position: f64, rate: f64| {
            (driven - self.omega2[i] * position - self.drag[i] * (next * rate)) * inverse
        };
        let displacements = std::array::from_fn(|i| term(i, driven[i], position[i], velocity[i]));
        let overlaps = std::array::from_fn(|i| term(i, driven[i] - right[i], apart[i], rate[i]));
        (self.displacements[k + 2], self.overlaps[k + 2]) = (displacements, overlaps);
    }

    /// A lower bound of the overlaps up to the scaled time `s`, for contacts with a force: by the signs of the coefficients about the start
    /// or, where that does not tell that they stay closed, about the end, too.
    fn least_overlaps(&self, s: f64) -> Lanes {
        let (mut terms, mut power) = (self.overlaps, 1.0);
        for column in &mut terms {
            *column = column.map(|c| c * power);
            power *= s;
        }
        let from_start = least(&terms);
        let is_low = |i: usize| self.inverse_overlap[i] > 0.0 && from_start[i] <= 0.0;
        if !(0..LANES).any(is_low) {
            return from_start;
        }
        for first in 0..ROOM {
            // Each coefficient and the sum of those behind it.
            let mut sums = [0.0; LANES];
            for column in terms[first..].iter_mut().rev() {
                for lane in 0..LANES {
                    sums[lane] += column[lane];
                }
                *column = sums;
            }
        }
        // Backwards from there.
        terms.iter_mut().skip(1).step_by(2).for_each(|column| *column = column.map(|c| -c));
        let from_end = least(&terms);
        std::array::from_fn(|i| from_start[i].max(from_end[i]))
    }
}

/// The least values that series may have on the time from 0 to 1: that of the first coefficients and all that are negative.
fn least(columns: &Columns) -> Lanes {
    let add = |sums: Lanes, column: &Lanes| std::array::from_fn(|i| sums[i] + column[i].min(0.0));
    columns[1..].iter().fold(columns[0], add)
}

/// What an expansion needs beside the series; it keeps nothing from one to the next but its memory.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    blocks: Vec<Block>,
    /// With a zero before the first one: what each contact pushes with, N. And with a zero behind the last one: the accelerations of the
    /// balls by all but their pendulums, m.
    pushes: Vec<f64>,
    driven: Vec<f64>,
    /// A contact each: the overlap up to which its elastic force is left out, m; 0 if it is not.
    negligible: Vec<f64>,
}

impl Workspace {
    fn begin(&mut self, window: &Window, unit: f64) {
        let Window { flights, balls, contacts, laws } = window;
        self.blocks.resize(balls.len().div_ceil(LANES), Block::ZERO);
        self.blocks.iter_mut().for_each(Block::clear);
        for numbers in [&mut self.pushes, &mut self.driven] {
            numbers.clear();
            numbers.resize(self.blocks.len() * LANES + 1, 0.0);
        }
        for (i, (flight, ball)) in flights.iter().zip(*balls).enumerate() {
            let (block, lane, o) = (&mut self.blocks[i / LANES], i % LANES, &ball.oscillator);
            block.inverse_mass[lane] = unit * unit / ball.mass;
            (block.omega2[lane], block.drag[lane]) = (unit * unit * o.omega2(), 2.0 * unit * o.gamma());
            (block.position[lane], block.displacements[1][lane]) = (flight.x, unit * flight.v);
            let (Some(contact), Some(law)) = (contacts.get(i), laws.get(i)) else { continue };
            block.presses[lane] = if contact.mode == Mode::Pressing { 1.0 } else { 0.0 };
            block.apart[lane] = contact.overlap + law.clearance;
            block.overlaps[0][lane] = contact.overlap;
            block.overlaps[1][lane] = unit * (flight.v - flights[i + 1].v);
            if window.needs_force(i) && self.negligible[i] == 0.0 && contact.overlap > 0.0 {
                block.inverse_overlap[lane] = 1.0 / contact.overlap;
                block.forces[0][lane] = law.elastic_force(contact.overlap);
            }
        }
    }

    fn expand(&mut self, window: &Window, unit: f64) {
        let inputs = window.flights.iter().any(|flight| flight.forcing != [0.0; MAX_FORCE_ORDER + 1]);
        let (after, mut unit_to_k) = (window.laws[0].exponent + 1.0, unit * unit);
        let mut weights = [0.0; ORDER];
        for k in 0..ORDER {
            if k > 0 {
                let numbers = weights.iter_mut().zip(&NUMBERS[1..=k]);
                numbers.for_each(|(weight, j)| *weight = after * j - NUMBERS[k]);
                self.blocks.iter_mut().for_each(|block| block.expand_force(k, &weights));
            }
            let pushes = self.pushes[1..].as_chunks_mut::<LANES>().0;
            for (push, block) in pushes.iter_mut().zip(&self.blocks) {
                *push = std::array::from_fn(|i| block.forces[k][i] * block.presses[i]);
            }
            let pushes = self.pushes.as_chunks::<LANES>().0.iter().zip(self.pushes[1..].as_chunks::<LANES>().0);
            let driven_balls = self.driven.as_chunks_mut::<LANES>().0.iter_mut();
            for ((driven, (left, right)), block) in driven_balls.zip(pushes).zip(&self.blocks) {
                *driven = std::array::from_fn(|i| (left[i] - right[i]) * block.inverse_mass[i]);
            }
            if inputs && let Some(inverse) = INVERSE_FACTORIAL.get(k) {
                let balls = self.driven.iter_mut().zip(window.flights);
                balls.for_each(|(driven, flight)| *driven += inverse * unit_to_k * flight.forcing[k]);
                unit_to_k *= unit;
            }
            let driven = self.driven.as_chunks::<LANES>().0.iter().zip(self.driven[1..].as_chunks::<LANES>().0);
            for (block, (driven, right)) in self.blocks.iter_mut().zip(driven) {
                block.expand_motion(k, driven, right);
            }
        }
    }

    /// The time, in units, on which the last `terms` of the velocities stay below `allowed` (m).
    fn convergence(&self, allowed: f64, terms: usize) -> f64 {
        let mut shortest = f64::INFINITY;
        for k in ORDER + 1 - terms..=ORDER {
            let larger = |most: f64, c: &f64| if c.abs() > most { c.abs() } else { most };
            let of_blocks = self.blocks.iter().flat_map(|block| &block.displacements[k + 1]);
            let largest = of_blocks.fold(0.0, larger) * NUMBERS[k + 1];
            if largest > 0.0 {
                shortest = shortest.min(libm::log2(allowed / largest) * INVERSES[k]);
            }
        }
        libm::exp2(shortest)
    }

    /// Enters all coefficients into the rows of a series.
    fn transpose(&self, [displacements, overlaps, forces]: [&mut [f64]; 3]) {
        let enter = |rows: &mut [f64], columns: fn(&Block) -> &Columns| {
            for (block, rows) in self.blocks.iter().zip(rows.chunks_mut(LANES * ROOM)) {
                for (lane, row) in rows.chunks_exact_mut(ROOM).enumerate() {
                    row.iter_mut().zip(columns(block)).for_each(|(c, column)| *c = column[lane]);
                }
            }
        };
        enter(displacements, |block| &block.displacements);
        enter(overlaps, |block| &block.overlaps);
        enter(forces, |block| &block.forces);
    }
}

/// Whether the series of a window are expanded here: all contacts have the same exponent, which is not whole, and no losses, and all
/// balls the same pendulum.
pub(in super::super) fn applies_to(window: &Window) -> bool {
    let Window { balls, laws, .. } = window;
    let serves =
        |law: &ContactLaw| law.exponent == laws[0].exponent && law.whole_exponent().is_none() && law.is_elastic();
    laws.iter().all(serves) && balls.iter().all(|ball| ball.oscillator == balls[0].oscillator)
}

impl Series {
    /// Computes all coefficients like [`Self::expand`].
    pub fn expand_lanes(&mut self, workspace: &mut Workspace, window: &Window, control: &Control, scale: f64) {
        let dv = control.epsilon * scale;
        let unit = unit_and_negligible(window, scale, dv, &mut workspace.negligible);
        workspace.begin(window, unit);
        workspace.expand(window, unit);
        self.begin_unset(window.balls.len(), window.contacts.len(), ROOM, unit, None);
        (self.order, self.next_to_switch) = (ORDER, 0);
        workspace.transpose([&mut self.displacements, &mut self.overlaps, &mut self.forces]);
        // As many terms as in `expand`.
        let gap = libm::ceil(window.laws[0].exponent) as usize;
        self.converges_for = (unit * workspace.convergence(dv * unit, gap + TERMS_AT_LEAST)).min(control.longest);
        for (b, block) in workspace.blocks.iter().enumerate().filter(|(_, block)| block.has_force()) {
            self.shorten_where_block_wrong(block, b * LANES, window, scale);
        }
        for (j, level) in workspace.negligible.iter().enumerate().filter(|(_, level)| **level > 0.0) {
            self.shorten_where_felt(j, *level, window, scale, dv);
        }
        let s = self.converges_for / unit;
        self.least_overlaps.extend(workspace.blocks.iter().flat_map(|block| block.least_overlaps(s)));
    }

    /// Ends the segment where the series of a force is still that of the law, for the contacts of a `block` from `first` on; see
    /// [`Self::expand`].
    fn shorten_where_block_wrong(&mut self, block: &Block, first: usize, window: &Window, scale: f64) {
        // Bounded, for states that are not finite.
        for _ in 0..64 {
            let s = self.converges_for / self.unit;
            let value = |columns: &[Lanes]| {
                let add = |sums: Lanes, c: &Lanes| std::array::from_fn(|i| sums[i] * s + c[i]);
                columns.iter().rev().fold([0.0; LANES], add)
            };
            let (overlaps, forces) = (value(&block.overlaps), value(&block.forces[..ORDER]));
            let right = |i: usize| {
                let by_law = window.laws[first + i].elastic_continued(overlaps[i]);
                by_law.is_some_and(|(by_law, _)| {
                    let speed_up = |force: f64| force.abs() * self.converges_for / window.reduced_mass(first + i);
                    let allowed = WRONG * (scale + speed_up(by_law));
                    // Far beyond their convergence both may be infinite.
                    allowed.is_finite() && speed_up(by_law - forces[i]) <= allowed
                })
            };
            if (0..LANES).all(|i| block.inverse_overlap[i] == 0.0 || right(i)) {
                return;
            }
            self.converges_for *= 0.5;
        }
    }

    /// Ends the segment where the force of contact `j`, which is left out, is about to matter: above this `level` of its overlap (m), or
    /// above that of the rate which it has there, and so on.
    fn shorten_where_felt(&mut self, j: usize, mut level: f64, window: &Window, scale: f64, dv: f64) {
        let (law, mass) = (&window.laws[j], window.reduced_mass(j));
        let (rate, duration) = (window.flights[j].v - window.flights[j + 1].v, law.time_scale(mass, scale));
        let until = self.converges_for;
        for cuts in 0..CUTS {
            let last = std::mem::replace(&mut self.converges_for, until);
            self.shorten_where_above(j, level);
            let is_above = self.converges_for < until;
            let rate = rate + self.overlap(j, self.converges_for).1;
            let felt = 2.0 * law.largest_negligible_overlap(mass, rate, dv, duration);
            if cuts > 0 && !(is_above && felt >= level) {
                self.converges_for = last; // It does not close that fast for long.
                return;
            }
            if !is_above {
                return;
            }
            self.front = Some(j);
            if felt <= 2.0 * level {
                return;
            }
            level = felt;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::recurrences::{self, velocity_scale};
    use super::*;
    use crate::engine::cluster::window::WindowContact;
    use crate::engine::flight::{Ball, Flight};
    use crate::model::{BallModel, Damping};
    use crate::solver::double_double::DoubleDouble;

    /// A window of six balls, of which the fourth touches the fifth, and no one the last one; and both expansions of it.
    fn expanded(exponent: f64, fourth_overlap: f64) -> (Series, Series) {
        let flights = [(-3e-4, 2e-3), (-1e-4, -1e-3), (2e-4, 5e-4), (3e-4, 1e-6), (4e-4, 0.0), (5e-4, 0.0)];
        let flights = flights.map(|(x, v)| Flight { x, v, forcing: [0.3, 0.0, 20.0, 0.0] });
        let model = |i: usize| BallModel { mass: [1.0, 2.0, 0.7, 1.3, 0.9, 1.0][i], omega2: 5.0, gamma: 0.4 };
        let balls: Vec<Ball> = (0..6).map(|i| Ball::new(&model(i), DoubleDouble::from(0.0), flights[i])).collect();
        let contacts = [(3e-7, true), (1e-7, true), (5e-8, true), (fourth_overlap, true), (-1e-7, false)];
        let mode = |pressing| if pressing { Mode::Pressing } else { Mode::Open };
        let contacts = contacts.map(|(overlap, pressing)| WindowContact { overlap, mode: mode(pressing) });
        let law = ContactLaw { stiffness: 1e10, overlap_ref: 1e-6, exponent, clearance: 1e-7, damping: Damping::None };
        let laws = [law, ContactLaw { stiffness: 2e10, ..law }, law, law, law];
        let window = Window { flights: &flights, balls: &balls, contacts: &contacts, laws: &laws };
        assert!(applies_to(&window));
        let (control, scale) = (Control::new(1e-12), velocity_scale(&window));
        let (mut plain, mut by_lanes) = (Series::default(), Series::default());
        plain.expand(&mut recurrences::Workspace::default(), &window, &control, scale);
        by_lanes.expand_lanes(&mut Workspace::default(), &window, &control, scale);
        (plain, by_lanes)
    }

    #[test]
    fn the_motion_is_that_of_the_other_series() {
        for exponent in [1.2, 1.5, 2.3, 3.5] {
            for fourth_overlap in [2e-8, 0.0] {
                let (plain, by_lanes) = expanded(exponent, fourth_overlap);
                let until = plain.converges_for().min(by_lanes.converges_for());
                let of = |series: &Series| {
                    let contact =
                        |j| [series.overlap(j, until).0, series.overlap(j, until).1, series.impulse(j, until)];
                    let ball = |j| {
                        [series.moved(j, until).0, series.moved(j, until).1, series.displacement_integral(j, until)]
                    };
                    [(0..5).flat_map(contact).collect::<Vec<f64>>(), (0..6).flat_map(ball).collect()].concat()
                };
                for (k, (plain, by_lanes)) in of(&plain).into_iter().zip(of(&by_lanes)).enumerate() {
                    let error = (by_lanes - plain).abs() / plain.abs();
                    assert!(plain == by_lanes || error < 1e-11, "p = {exponent}: {k} is off by {error:e}");
                }
            }
        }
    }

    #[test]
    fn no_overlap_is_less_than_its_bound() {
        for exponent in [1.5, 2.3] {
            let (_, series) = expanded(exponent, 2e-8);
            for j in 0..4 {
                let overlaps = (0..=100).map(|k| series.overlap(j, 0.01 * k as f64 * series.converges_for()).0);
                let (least, bound) = (overlaps.fold(f64::INFINITY, f64::min), series.least_overlaps[j]);
                assert!(bound <= least && bound > 0.5 * least, "p = {exponent}, {j}: {least:e}, not {bound:e}");
            }
        }
    }
}
