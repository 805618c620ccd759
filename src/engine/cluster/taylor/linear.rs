//! The coefficients where all contacts are linear: `F = k d + c r`, so that each follows from the ones before it by a handful of
//! products.
//!
//! An order costs so little that a high one pays: steps grow as fast as the work for them.

use super::recurrences::TERMS_AT_LEAST;
use super::series::{INVERSE_FACTORIAL, Series};
use crate::engine::cluster::step_control::Control;
use crate::engine::cluster::window::{Window, WindowContact};
use crate::engine::flight::Ball;
use crate::model::Mode;
use crate::solver::series::{INVERSES, NUMBERS};

/// Balls side by side: two numbers fill a register of every processor.
const LANES: usize = 2;

/// Order of these series over the one that `Control` has for others. A lower one takes more steps for a pulse, one of twice the
/// order loses digits, for terms that cancel (`benches/runs.rs`, `tests/rust/reference.rs`).
const HIGHER: f64 = 1.6;

/// Highest order that a tolerance leads to.
const MOST: usize = 40;

/// Coefficients that tell whether a switching is near, and the times, in units, that they are asked for. A segment that will end
/// soon gets only the order that it takes till then: more times make it shorter, more coefficients tell of later switchings.
const LOOK: usize = 8;
const LOOKS: [f64; 8] = [0.02, 0.1, 0.25, 0.5, 0.8, 1.2, 1.6, 2.1];

/// A number for each of a few balls, or for the contacts at their right.
type Lanes = [f64; LANES];

/// A few neighbouring balls and the contacts at their right, side by side.
#[derive(Clone, Debug, Default)]
struct Block {
    /// The equations of the balls in scaled time.
    inverse_mass: Lanes,
    omega2: Lanes,
    drag: Lanes,
    /// Whether the pendulum of the next ball differs.
    unlike: [bool; LANES],
    /// Stiffness and damping of the contacts, 0 unless they press.
    stiffness: Lanes,
    damping: Lanes,
    /// The last coefficients: of positions and velocities of the balls; of the distances of the balls of each contact from where
    /// they rest, and of the rates of these, m.
    position: Lanes,
    velocity: Lanes,
    apart: Lanes,
    rate: Lanes,
    /// The rates of the overlaps at the start, m.
    rate_at_start: Lanes,
    /// What the contacts push with, N, and the accelerations of the balls by that and by the inputs, m.
    push: Lanes,
    driven: Lanes,
}

impl Block {
    /// How the contacts drive the balls, the first one with `push_left` at its left. Returns what the last one pushes with.
    fn drive(&mut self, push_left: f64) -> f64 {
        for i in 0..LANES {
            let left = if i > 0 { self.push[i - 1] } else { push_left };
            self.driven[i] = (left - self.push[i]) * self.inverse_mass[i];
        }
        self.push[LANES - 1]
    }

    /// The next coefficients of balls and contacts, where the ball on the right is driven so and has this next coefficient of its
    /// velocity.
    fn advance(&mut self, [driven_right, velocity_right]: [f64; 2], inverse: f64) {
        for i in 0..LANES {
            let right = if i + 1 < LANES { self.driven[i + 1] } else { driven_right };
            let by_pendulum = self.omega2[i] * self.apart[i] + self.drag[i] * self.rate[i];
            self.apart[i] = self.rate[i] * inverse;
            self.rate[i] = ((self.driven[i] - right) - by_pendulum) * inverse;
        }
        for i in 0..LANES {
            let by_pendulum = self.omega2[i] * self.position[i] + self.drag[i] * self.velocity[i];
            self.position[i] = self.velocity[i] * inverse;
            self.velocity[i] = (self.driven[i] - by_pendulum) * inverse;
        }
        if self.unlike != [false; LANES] {
            for i in (0..LANES).filter(|i| self.unlike[*i]) {
                self.rate[i] = self.velocity[i] - self.velocity.get(i + 1).unwrap_or(&velocity_right);
            }
        }
        for i in 0..LANES {
            self.push[i] = self.stiffness[i] * self.apart[i] + self.damping[i] * self.rate[i];
        }
    }
}

/// What an expansion needs beside the series; it keeps nothing from one to the next but its memory.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    blocks: Vec<Block>,
    /// The highest order, and the coefficients of displacements and of overlaps from the second power on, m: so many of one block
    /// after the other.
    order: usize,
    columns: Vec<[Lanes; 2]>,
}

impl Workspace {
    fn begin(&mut self, window: &Window, order: usize, unit: f64) {
        let Window { flights, balls, contacts, laws } = window;
        self.blocks.clear();
        self.blocks.resize(balls.len().div_ceil(LANES), Block::default());
        self.order = order;
        self.columns.resize(self.blocks.len() * order, Default::default());
        for (i, (flight, ball)) in flights.iter().zip(*balls).enumerate() {
            let (block, lane) = (&mut self.blocks[i / LANES], i % LANES);
            let o = &ball.oscillator;
            block.inverse_mass[lane] = unit * unit / ball.mass;
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
            block.rate_at_start[lane] = rate;
            block.unlike[lane] = ball.oscillator != right.oscillator;
        }
    }

    /// Coefficients number `k` that follow from the last ones and the inputs (m).
    fn advance(&mut self, k: usize, input: Option<impl Fn(usize) -> f64>) {
        self.blocks.iter_mut().fold(0.0, |push_left, block| block.drive(push_left));
        if let Some(input) = input {
            let driven = self.blocks.iter_mut().flat_map(|block| &mut block.driven);
            driven.enumerate().for_each(|(i, driven)| *driven += input(i));
        }
        let (inverse, inverse_of_next) = (INVERSES[k + 1], INVERSES[k + 2]);
        let mut right = [0.0; 2];
        for (b, block) in self.blocks.iter_mut().enumerate().rev() {
            let driven = block.driven[0];
            block.advance(right, inverse);
            right = [driven, block.velocity[0]];
            let column = [block.velocity.map(|v| v * inverse_of_next), block.rate.map(|r| r * inverse_of_next)];
            self.columns[b * self.order + k] = column;
        }
    }

    /// The largest last coefficient of a velocity, m.
    fn largest(&self) -> f64 {
        let larger = |most: f64, size: f64| if size > most { size } else { most };
        let of_both = |most: Lanes, block: &Block| std::array::from_fn(|i| larger(most[i], block.velocity[i].abs()));
        let largest = self.blocks.iter().fold([0.0; LANES], of_both);
        largest.into_iter().fold(0.0, larger)
    }

    /// The first of the [`LOOKS`] by which a contact seems to have switched, by more than `noise` (m), from the first coefficients;
    /// and the contact.
    fn switching(&self, contacts: &[WindowContact], noise: f64) -> Option<(usize, usize)> {
        let seems = |(j, contact): (usize, &WindowContact)| {
            let (block, lane) = (&self.blocks[j / LANES], j % LANES);
            let columns = &self.columns[j / LANES * self.order..][..LOOK];
            let next = |sums: [f64; LOOKS.len()], c: f64| std::array::from_fn(|p| sums[p] * LOOKS[p] + c);
            let high = columns.iter().rev().fold([0.0; LOOKS.len()], |sums, [_, overlap]| next(sums, overlap[lane]));
            let overlaps = next(next(high, block.rate_at_start[lane]), contact.overlap);
            let sign = if contact.mode == Mode::Open { 1.0 } else { -1.0 };
            overlaps.iter().position(|overlap| sign * overlap > noise).map(|look| (look, j))
        };
        contacts.iter().enumerate().filter_map(seems).min()
    }

    /// Computes coefficients up to the highest order, or to that which a switching that seems to come soon takes: by then the last terms
    /// are at most `allowed` (m). Overlaps up to `noise` (m) are rounding. Returns the order and the contact that seems to switch.
    fn expand(&mut self, window: &Window, unit: f64, noise: f64, allowed: f64) -> (usize, usize) {
        let (mut unit_to_k, mut power, mut negligible, mut next) = (unit * unit, 1.0, 0, None);
        let driven = window.flights.iter().any(|flight| flight.forcing.iter().any(|&f| f != 0.0));
        for k in 0..self.order {
            let factor = INVERSE_FACTORIAL.get(k).filter(|_| driven).map(|inverse| inverse * unit_to_k);
            let flight = |i: usize| window.flights.get(i).map_or(0.0, |flight| flight.forcing[k]);
            self.advance(k, factor.map(|factor| move |i: usize| factor * flight(i)));
            unit_to_k *= unit;
            if k + 1 == LOOK {
                next = self.switching(window.contacts, noise);
                power = next.map_or(0.0, |(look, _)| (0..k).fold(1.0, |power, _| power * LOOKS[look]));
            }
            if let Some((look, contact)) = next {
                power *= LOOKS[look];
                negligible = if self.largest() * power <= allowed { negligible + 1 } else { 0 };
                if negligible > TERMS_AT_LEAST {
                    return (k + 1, contact);
                }
            }
        }
        (self.order, next.map_or(0, |(_, contact)| contact))
    }

    /// Enters the displacements (`WHICH` 0) or overlaps (1) that were noted in their rows.
    fn enter<const WHICH: usize>(&self, rows: &mut [f64], stride: usize) {
        for (i, row) in rows.chunks_exact_mut(stride).enumerate() {
            let columns = &self.columns[i / LANES * self.order..][..stride - 2];
            row[2..].iter_mut().zip(columns).for_each(|(term, column)| *term = column[WHICH][i % LANES]);
        }
    }
}

impl Series {
    /// Computes all coefficients like [`Self::expand`], of no higher order than a switching that seems to come soon takes. Overlaps up
    /// to `noise` (m) are rounding.
    pub fn expand_linear(
        &mut self,
        workspace: &mut Workspace,
        window: &Window,
        control: &Control,
        scale: f64,
        noise: f64,
    ) {
        let (unit, dv) = (shortest_time(window), control.epsilon * scale);
        workspace.begin(window, ((HIGHER * control.order as f64) as usize).min(MOST), unit);
        let (order, next_to_switch) = workspace.expand(window, unit, noise, dv * unit);
        self.begin(window, order, unit);
        self.next_to_switch = next_to_switch;
        let stride = self.stride();
        workspace.enter::<0>(&mut self.displacements, stride);
        workspace.enter::<1>(&mut self.overlaps, stride);
        for (j, law) in window.laws.iter().enumerate().filter(|(j, _)| window.contacts[*j].mode != Mode::Open) {
            let rows = j * stride..(j + 1) * stride;
            self.dashpots[j] = Some(law.damping_coefficient());
            let (overlap, damping) = (&self.overlaps[rows.clone()], law.damping_coefficient() / unit);
            let terms = overlap.iter().zip(&overlap[1..]).zip(&NUMBERS[1..stride]);
            for (force, ((d, next), k)) in self.forces[rows].iter_mut().zip(terms) {
                *force = law.stiffness * d + damping * k * next;
            }
        }
        self.converges_for = self.linear_convergence(dv).min(control.longest);
    }

    /// The time on which the last terms of the velocities stay below `dv` (m/s), less a few thousandths: with logarithms as
    /// coarse as that.
    fn linear_convergence(&self, dv: f64) -> f64 {
        let mut shortest = f64::INFINITY;
        for k in self.order - TERMS_AT_LEAST..=self.order {
            let rows = self.displacements.chunks_exact(self.stride());
            let largest = rows.map(|d| d[k + 1].abs()).fold(0.0, f64::max);
            if largest > 0.0 {
                let allowed = dv * self.unit / ((k + 1) as f64 * largest);
                shortest = shortest.min(logarithm_below(allowed) * INVERSES[k]);
            }
        }
        libm::exp2(shortest) * self.unit
    }
}

/// Logarithm of `x > 0` to base 2, or up to 0.09 less: linear between powers of 2.
fn logarithm_below(x: f64) -> f64 {
    const FRACTION: u32 = f64::MANTISSA_DIGITS - 1;
    let bits = x.to_bits();
    let fraction = (bits & ((1 << FRACTION) - 1)) as f64 / (1_u64 << FRACTION) as f64;
    (bits >> FRACTION) as f64 - (f64::MAX_EXP - 1) as f64 + fraction
}

/// A time (s) near the inverse of the fastest rate of a window: that of a spring, a dashpot or a pendulum.
fn shortest_time(window: &Window) -> f64 {
    let Window { balls, contacts, laws, .. } = window;
    let swing = |ball: &Ball| ball.oscillator.omega() + 2.0 * ball.oscillator.gamma();
    let mut fastest = balls.iter().map(swing).fold(0.0, f64::max);
    for (j, law) in laws.iter().enumerate().filter(|(j, _)| contacts[*j].mode == Mode::Pressing) {
        let mass = window.reduced_mass(j);
        fastest = fastest.max((law.stiffness / mass).sqrt()).max(law.damping_coefficient() / mass);
    }
    if fastest > 0.0 { 1.0 / fastest } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::super::recurrences::{self, velocity_scale};
    use super::*;
    use crate::engine::cluster::dense_output::DenseOutput;
    use crate::engine::flight::Flight;
    use crate::model::{BallModel, ContactLaw, Damping};
    use crate::solver::double_double::DoubleDouble;

    /// Six balls, more than a block, pressed, clipped and apart, equal and unequal pendulums, under inputs that change: the same
    /// follows from either kind of series.
    #[test]
    fn the_motion_is_that_of_the_other_series() {
        let flights = [(-3e-4, 2e-3), (-1e-4, -1e-3), (2e-4, 5e-4), (3e-4, 0.0), (4e-4, -2e-3), (5e-4, 1e-3)];
        let flights = flights.map(|(x, v)| Flight { x, v, forcing: [0.3, 0.0, 20.0, 1e3] });
        let contact = |overlap, mode| WindowContact { overlap, mode };
        let contacts = [
            contact(3e-7, Mode::Pressing),
            contact(1e-7, Mode::Clipped),
            contact(2e-7, Mode::Pressing),
            contact(5e-7, Mode::Pressing),
            contact(-1e-7, Mode::Open),
        ];
        for (damping, alike) in [(None, true), (Some(300.0), true), (Some(300.0), false), (Some(1e6), true)] {
            let pendulum = |i: usize| if alike { [5.0, 0.4] } else { [5.0 + i as f64, 0.4 + 0.1 * i as f64] };
            let model = |i: usize| {
                let [omega2, gamma] = pendulum(i / 2);
                BallModel { mass: [1.0, 2.0, 0.7, 1.3, 0.5, 1.0][i], omega2, gamma }
            };
            let ball = |i: usize| Ball::new(&model(i), DoubleDouble::from(0.0), flights[i]);
            let balls: [Ball; 6] = std::array::from_fn(ball);
            let damping = damping.map_or(Damping::None, |c| Damping::KelvinVoigt { c, pull: false });
            let law = |j: usize| {
                let stiffness = 1e10 * (1 + j) as f64;
                ContactLaw { stiffness, overlap_ref: 1e-6, exponent: 1.0, clearance: 1e-7, damping }
            };
            let laws: [ContactLaw; 5] = std::array::from_fn(law);
            let window = Window { flights: &flights, balls: &balls, contacts: &contacts, laws: &laws };
            let (control, scale) = (Control::new(1e-12), velocity_scale(&window));
            let (mut other, mut linear) = (Series::default(), Series::default());
            other.expand(&mut recurrences::Workspace::default(), &window, &control, scale);
            linear.expand_linear(&mut Workspace::default(), &window, &control, scale, f64::INFINITY);
            assert!(linear.converges_for() > 1.8 * other.converges_for());
            let until = other.converges_for();
            let of = |series: &Series| {
                let contact = |j| {
                    let (overlap, change) = series.overlap(j, until);
                    [overlap, change, series.impulse(j, until), series.contact_loss(j, until)]
                };
                let ball = |i| {
                    let ((moved, change), squares) =
                        (series.moved(i, until), series.squared_velocity_integral(i, until));
                    [moved, change, series.displacement_integral(i, until), squares]
                };
                [(0..5).map(contact).collect::<Vec<_>>(), (0..6).map(ball).collect()].concat()
            };
            for (k, (other, linear)) in of(&other).concat().into_iter().zip(of(&linear).concat()).enumerate() {
                let error = (linear - other).abs() / other.abs();
                assert!(linear == other || error < 1e-12, "{damping:?}, alike: {alike}, {k} is off by {error:e}");
            }
        }
    }

    #[test]
    fn a_logarithm_is_at_most_a_tenth_too_small() {
        for x in [1e-300, 3.7e-17, 0.5, 1.0, 1.5, 1e200] {
            let off = libm::log2(x) - logarithm_below(x);
            assert!((-1e-12..0.09).contains(&off), "{x:e}: {off}");
        }
    }
}
