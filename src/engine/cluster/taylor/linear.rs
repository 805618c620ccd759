//! The coefficients where all contacts are linear, `F = k d + c r`: each follows from the ones before it by a handful
//! of products.
//!
//! Each order is so cheap that a high one pays: steps grow as fast as the work for them.

use std::ops::Range;

use super::recurrences::TERMS_AT_LEAST;
use super::series::{INVERSE_FACTORIAL, Series};
use crate::engine::cluster::step_control::Problem;
use crate::engine::cluster::window::{Window, WindowContact};
use crate::model::Mode;
use crate::solver::MAX_FORCE_ORDER;
use crate::solver::series::{self, INVERSES, NUMBERS};

/// Balls computed side by side: two numbers fill a register of every processor.
const LANES: usize = 2;

/// Order of these series over that of others. A lower one needs more steps for a pulse; twice the order loses digits by
/// cancelling terms (`benches/runs.rs`, `tests/rust/reference.rs`).
const HIGHER: f64 = 1.6;

/// Highest order.
const MOST: usize = 40;

/// Coefficients that show whether a switching is near, and the times, in units, at which they are evaluated. A segment
/// that will end soon gets only the order that it needs until then.
const LOOK: usize = 8;
const LOOKS: [f64; 8] = [0.02, 0.1, 0.25, 0.5, 0.8, 1.2, 1.6, 2.1];

/// Coefficients that a row has room for.
const ROOM: usize = MOST + 2;

/// A number for each of a few balls, or for the contacts at their right.
type Lanes = [f64; LANES];

/// Coefficients of the displacements of a few balls, or of the overlaps of the contacts at their right.
type Rows = [[f64; ROOM]; LANES];

/// The rows of all displacements, and those of all overlaps.
type AllRows<'a> = [&'a mut [Rows]; 2];

/// A few neighbouring balls and the contacts at their right, side by side.
#[derive(Clone, Debug, Default)]
struct Block {
    /// The equations of the balls in scaled time.
    inverse_mass: Lanes,
    omega2: Lanes,
    drag: Lanes,
    /// Stiffness and damping of the contacts, 0 unless they press.
    stiffness: Lanes,
    damping: Lanes,
    /// The last coefficients: of positions and velocities of the balls; of the distance of the balls of each contact,
    /// relative to that at rest, and of its rate, m.
    position: Lanes,
    velocity: Lanes,
    apart: Lanes,
    rate: Lanes,
    /// The forces of the contacts, N, and the accelerations of the balls by the inputs, m.
    push: Lanes,
    input: Lanes,
    /// Whether the pendulum of the next ball differs.
    unlike: [bool; LANES],
}

impl Block {
    /// The next coefficients of balls and contacts, from the push of the contact at their left, and acceleration and
    /// next velocity coefficient of the ball at their right. Returns the acceleration of the first ball.
    #[inline(always)]
    fn advance(&mut self, push_left: f64, [driven_right, velocity_right]: [f64; 2], inverse: f64) -> f64 {
        let from_left: Lanes = std::array::from_fn(|i| if i > 0 { self.push[i - 1] } else { push_left });
        let driven: Lanes =
            std::array::from_fn(|i| (from_left[i] - self.push[i]) * self.inverse_mass[i] + self.input[i]);
        let right: Lanes = std::array::from_fn(|i| *driven.get(i + 1).unwrap_or(&driven_right));
        for i in 0..LANES {
            let by_pendulum = self.omega2[i] * self.apart[i] + self.drag[i] * self.rate[i];
            self.apart[i] = self.rate[i] * inverse;
            self.rate[i] = ((driven[i] - right[i]) - by_pendulum) * inverse;
        }
        for (i, driven) in driven.iter().enumerate() {
            let by_pendulum = self.omega2[i] * self.position[i] + self.drag[i] * self.velocity[i];
            self.position[i] = self.velocity[i] * inverse;
            self.velocity[i] = (driven - by_pendulum) * inverse;
        }
        for i in (0..LANES).filter(|i| self.unlike[*i]) {
            self.rate[i] = self.velocity[i] - self.velocity.get(i + 1).unwrap_or(&velocity_right);
        }
        for i in 0..LANES {
            self.push[i] = self.stiffness[i] * self.apart[i] + self.damping[i] * self.rate[i];
        }
        driven[0]
    }
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Workspace {
    blocks: Vec<Block>,
    /// The largest coefficients of a velocity, m.
    largest: [f64; TERMS_AT_LEAST + 1],
}

impl Workspace {
    fn begin(&mut self, window: &Window, unit: f64) {
        let Window { flights, balls, contacts, laws, .. } = window;
        self.blocks.clear();
        self.blocks.resize(balls.len().div_ceil(LANES), Block::default());
        for (i, (flight, ball)) in flights.iter().zip(*balls).enumerate() {
            let (block, lane) = (&mut self.blocks[i / LANES], i % LANES);
            let o = &ball.oscillator;
            block.inverse_mass[lane] = unit * unit / ball.model.mass;
            (block.omega2[lane], block.drag[lane]) = (unit * unit * o.omega2(), 2.0 * unit * o.gamma());
            (block.position[lane], block.velocity[lane]) = (flight.x, unit * flight.v);
            let (Some(contact), Some(law), Some(right)) = (contacts.get(i), laws.get(i), balls.get(i + 1)) else {
                continue;
            };
            let rate = unit * (flight.v - flights[i + 1].v);
            if contact.mode == Mode::Pressing {
                (block.stiffness[lane], block.damping[lane]) = (law.stiffness, law.damping_coefficient() / unit);
            }
            block.push[lane] = block.stiffness[lane] * contact.overlap + block.damping[lane] * rate;
            (block.apart[lane], block.rate[lane]) = (contact.overlap + law.clearance, rate);
            block.unlike[lane] = ball.oscillator != right.oscillator;
        }
    }

    /// Computes the coefficients of these numbers from the last ones, of displacements and overlaps two orders higher.
    fn advance(&mut self, numbers: Range<usize>, [displacements, overlaps]: &mut AllRows) {
        let blocks = &mut self.blocks[..];
        let (displacements, overlaps) = (&mut displacements[..], &mut overlaps[..]);
        let count = blocks.len().min(displacements.len()).min(overlaps.len());
        for k in numbers.start..numbers.end.min(MOST) {
            let (inverse, inverse_of_next) = (INVERSES[k + 1], INVERSES[k + 2]);
            let mut right = [0.0; 2];
            for b in (0..count).rev() {
                let push_left = if b > 0 { blocks[b - 1].push[LANES - 1] } else { 0.0 };
                let block = &mut blocks[b];
                right = [block.advance(push_left, right, inverse), block.velocity[0]];
                for i in 0..LANES {
                    displacements[b][i][k + 2] = block.velocity[i] * inverse_of_next;
                    overlaps[b][i][k + 2] = block.rate[i] * inverse_of_next;
                }
            }
        }
    }

    /// Computes the first coefficients, which contain the inputs. Returns how many.
    fn advance_driven(&mut self, window: &Window, unit: f64, rows: &mut AllRows) -> usize {
        let mut unit_to_k = unit * unit;
        for (k, inverse) in INVERSE_FACTORIAL.into_iter().enumerate() {
            let inputs = self.blocks.iter_mut().flat_map(|block| &mut block.input);
            inputs.zip(window.flights).for_each(|(input, flight)| *input = inverse * unit_to_k * flight.forcing[k]);
            self.advance(k..k + 1, rows);
            unit_to_k *= unit;
        }
        self.blocks.iter_mut().for_each(|block| block.input = Lanes::default());
        INVERSE_FACTORIAL.len()
    }

    /// The largest last coefficient of a velocity, m.
    fn largest(&self) -> f64 {
        let larger = |most: f64, size: f64| if size > most { size } else { most };
        let of_both = |most: Lanes, block: &Block| std::array::from_fn(|i| larger(most[i], block.velocity[i].abs()));
        let largest = self.blocks.iter().fold([0.0; LANES], of_both);
        largest.into_iter().fold(0.0, larger)
    }

    /// Computes coefficients up to the order `most` or, if a switching is near, to a lower one at which the last terms
    /// are at most `allowed` (m) by then. Returns the order.
    fn expand(&mut self, rows: &mut AllRows, problem: &Problem, most: usize, unit: f64, allowed: f64) -> usize {
        let window = problem.window;
        let driven = window.flights.iter().any(|flight| flight.forcing != [0.0; MAX_FORCE_ORDER + 1]);
        let first = if driven { self.advance_driven(window, unit, rows) } else { 0 };
        self.advance(first..LOOK, rows);
        let switching = switching(rows[1].as_flattened(), window.contacts, problem.rounding.position);
        let mut known = LOOK;
        if switching.is_none() {
            known = known.max(most - TERMS_AT_LEAST);
            self.advance(LOOK..known, rows);
        }
        let look = switching.map_or(f64::INFINITY, |look| LOOKS[look]);
        let (mut power, mut negligible) = ((1..known).fold(1.0, |power, _| power * look), 0);
        loop {
            self.largest.rotate_left(1);
            self.largest[TERMS_AT_LEAST] = self.largest();
            power *= look;
            let is_negligible = switching.is_some() && self.largest[TERMS_AT_LEAST] * power <= allowed;
            negligible = if is_negligible { negligible + 1 } else { 0 };
            if negligible > TERMS_AT_LEAST || known >= most {
                return known;
            }
            self.advance(known..known + 1, rows);
            known += 1;
        }
    }

    /// The time, in units, on which the last terms up to this order stay below `allowed` (m).
    fn convergence(&self, order: usize, allowed: f64) -> f64 {
        let orders = order - TERMS_AT_LEAST..=order;
        let logarithm = |(k, largest): (usize, &f64)| match *largest > 0.0 {
            true => libm::log2(allowed / largest) * INVERSES[k],
            false => f64::INFINITY,
        };
        libm::exp2(orders.zip(&self.largest).map(logarithm).fold(f64::INFINITY, f64::min))
    }
}

/// The first of the [`LOOKS`] at which a contact has switched, by more than `noise` (m), by the first coefficients.
fn switching(overlaps: &[[f64; ROOM]], contacts: &[WindowContact], noise: f64) -> Option<usize> {
    let seems = |(contact, row): (&WindowContact, &[f64; ROOM])| {
        let sign = if contact.mode == Mode::Open { 1.0 } else { -1.0 };
        let overlaps = series::sample(&row[..LOOK + 2], &LOOKS);
        overlaps.iter().position(|overlap| sign * overlap > noise)
    };
    contacts.iter().zip(overlaps).filter_map(seems).min()
}

impl Series {
    /// Computes all coefficients like [`Self::expand`], with a lower order if a switching is near.
    pub fn expand_linear(&mut self, workspace: &mut Workspace, problem: &Problem) {
        let &Problem { window, control, .. } = problem;
        let unit = shortest_time(window);
        let allowed = problem.local_error * unit;
        workspace.begin(window, unit);
        let most = ((HIGHER * control.order as f64) as usize).min(MOST);
        self.begin_unset(workspace.blocks.len() * LANES, window.contacts.len(), ROOM, unit);
        let mut rows = [&mut self.displacements, &mut self.overlaps]
            .map(|rows| rows.as_chunks_mut::<ROOM>().0.as_chunks_mut::<LANES>().0);
        for (b, block) in workspace.blocks.iter().enumerate() {
            for (rows, starts) in rows.iter_mut().zip([block.velocity, block.rate]) {
                rows[b].iter_mut().zip(starts).for_each(|(row, start)| row[..2].copy_from_slice(&[0.0, start]));
            }
        }
        let starts = rows[1].as_flattened_mut().iter_mut().zip(window.contacts);
        starts.for_each(|(row, contact)| row[0] = contact.overlap);
        self.order = workspace.expand(&mut rows, problem, most, unit, allowed);
        self.converges_for = (unit * workspace.convergence(self.order, allowed)).min(control.longest);
        for (j, law) in window.laws.iter().enumerate().filter(|(j, _)| window.contacts[*j].mode != Mode::Open) {
            let (damping, terms) = (law.damping_coefficient(), self.order + 2);
            self.linear[j] = Some([law.stiffness, damping]);
            if law.is_elastic() {
                continue;
            }
            let rows = j * ROOM..j * ROOM + terms;
            let (overlap, damping) = (&self.overlaps[rows.clone()], damping / unit);
            let terms = overlap.iter().zip(&overlap[1..]).zip(&NUMBERS[1..terms]);
            for (force, ((d, next), k)) in self.forces[rows].iter_mut().zip(terms) {
                *force = law.stiffness * d + damping * k * next;
            }
        }
    }
}

/// A time (s) near the inverse of the fastest rate of a window: that of a spring, a dashpot or a pendulum.
fn shortest_time(window: &Window) -> f64 {
    let Window { balls, laws, .. } = window;
    let mut fastest = balls.iter().map(|ball| ball.oscillator.pace()).fold(0.0, f64::max);
    for (j, law) in laws.iter().enumerate().filter(|(j, _)| window.presses(*j)) {
        let mass = window.reduced_mass(j);
        fastest = fastest.max((law.stiffness / mass).sqrt()).max(law.damping_coefficient() / mass);
    }
    if fastest > 0.0 { 1.0 / fastest } else { 1.0 }
}
