//! The motion of balls joined by linear contacts, by their natural modes. See "Natural modes" in docs/theory.md for the
//! equations and the symbols `lambda`, `phi`, `D`, `T` and `u`.

use std::ops::Range;

use nalgebra::{DMatrix, SymmetricEigen};

use super::window::Window;
use crate::engine::flight::{ROUNDINGS, degree};
use crate::model::{ContactLaw, Mode};
use crate::solver::{ForcedOscillator, Oscillator};

/// Largest group that is decomposed into modes: the cost of its shapes grows with the cube.
const LARGEST_GROUP: usize = 40;

/// Allowed relative difference between `T u` and `lambda u`; modes beyond it are spoiled by rounding.
const TOLERANCE: f64 = 1e-12;

/// Segments by series after a switching before natural modes take over: where balls oscillate, and while a front has
/// yet to pass a contact. With fewer, the next switching ends modes too soon; with more, long motions cost more
/// (`benches/runs.rs`); too few of a front lose motions that grow from 0 (`tests/rust/stiff.rs`).
const SERIES_BEFORE_MODES: u32 = 13;
const SERIES_OF_FRONT: u32 = 64;

/// Number of segments of a linear window by series after a switching before natural modes take over, if they
/// [apply](apply_to).
pub(super) fn series_before_modes(window: &Window) -> Option<u32> {
    apply_to(window).then(|| match window.laws.iter().all(ContactLaw::is_elastic) {
        true => SERIES_BEFORE_MODES,
        // Only series keep balls that the motion has not reached exactly at rest, and resolve motions that grow from 0.
        // Modes would also be slower: tenfold for rows of 40 to 60 balls at ten times the critical damping.
        false if window.holds_front() => SERIES_OF_FRONT,
        false if window.rings() => SERIES_BEFORE_MODES,
        false => 0,
    })
}

/// Whether the contacts that press join equal pendulums and are damped in proportion to their stiffness, under constant
/// inputs. (Drag makes pendulums of unequal masses unequal.)
fn apply_to(window: &Window) -> bool {
    let Window { flights, balls, contacts, laws, .. } = window;
    let mut first = 0;
    for (j, (contact, law)) in contacts.iter().zip(*laws).enumerate() {
        if contact.mode != Mode::Pressing {
            first = j + 1;
            continue;
        }
        let (other, [left, right]) = (&laws[first], [&balls[first], &balls[j + 1]]);
        let damping = law.damping_coefficient() * other.stiffness;
        // To within rounding, for example of relaxation times multiplied by stiffnesses.
        let off = damping - other.damping_coefficient() * law.stiffness;
        if left.oscillator != right.oscillator || off.abs() > ROUNDINGS * damping || j + 2 - first > LARGEST_GROUP {
            return false;
        }
    }
    flights.iter().all(|flight| degree(&flight.forcing) == 0)
}

/// Balls joined by pressing contacts.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    /// First ball and number of balls.
    pub first: usize,
    pub size: usize,
    /// Damping c of the first contact, N.s/m.
    pub damping: f64,
    /// The coordinates of the modes, which start at 0.
    pub modes: Vec<ForcedOscillator>,
    /// `lambda` of each mode.
    pub lambda: Vec<f64>,
    /// For each mode: displacement `phi` of each ball and change `D phi` of each overlap for a unit of its coordinate.
    shapes: Vec<f64>,
    stretches: Vec<f64>,
    /// The masses over that of the first ball.
    masses: Vec<f64>,
}

impl Group {
    /// The group of these balls; `None` if their masses or stiffnesses are too far apart.
    pub fn new(members: Range<usize>, window: &Window) -> Option<Self> {
        let Window { flights, balls, contacts, laws, .. } = window;
        let (first, size) = (members.start, members.len());
        let ball = &balls[first];
        let joints = &laws[first..first + size - 1];
        let (stiffness, damping) = joints.first().map_or((0.0, 0.0), |law| (law.stiffness, law.damping_coefficient()));
        let (o, mass) = (&ball.oscillator, ball.model.mass);
        let masses: Vec<f64> = balls[members.clone()].iter().map(|ball| ball.model.mass / mass).collect();
        let stiffnesses: Vec<f64> = joints.iter().map(|law| law.stiffness / stiffness).collect();
        let [lambda, shapes, stretches] = shapes(&masses, &stiffnesses)?;
        let mut modes = Vec::with_capacity(size);
        for (j, lambda) in lambda.iter().enumerate() {
            let oscillator = match j {
                0 => *o,
                _ => Oscillator::new(o.omega2() + lambda * stiffness / mass, o.gamma() + 0.5 * lambda * damping / mass),
            };
            let weight = |i: usize| masses[i] * shapes[j * size + i];
            let stretches = &stretches[j * (size - 1)..];
            let (mut v, mut force) = (0.0, 0.0);
            for (i, flight) in flights[members.clone()].iter().enumerate() {
                force += weight(i) * flight.forcing[0];
            }
            // In the modes that stretch the group, only differences of positions and velocities count, which overlaps
            // and their rates give without rounding.
            let mut before = 0.0;
            for (i, law) in joints.iter().enumerate() {
                let contact = first + i;
                before += weight(i);
                let overlap = contacts[contact].overlap;
                let apart = if j == 0 { flights[contact].x - flights[contact + 1].x } else { overlap + law.clearance };
                v += before * (flights[contact].v - flights[contact + 1].v);
                force -= o.omega2() * before * apart + stretches[i] * law.stiffness / mass * overlap;
            }
            if j == 0 {
                let (last, all) = (&flights[first + size - 1], before + weight(size - 1));
                v += all * last.v;
                force -= o.omega2() * all * last.x;
            }
            modes.push(ForcedOscillator::new(oscillator, v, force));
        }
        Some(Self { first, size, damping, modes, lambda, shapes, stretches, masses })
    }

    /// The smallest decay rate that the dashpots give a mode right after the start, 1/s.
    pub fn least_decay(&self) -> f64 {
        self.modes[1..].iter().map(|mode| mode.oscillator.fast_decay()).fold(f64::INFINITY, f64::min)
    }

    /// Displacement of ball `i` for a unit of the coordinate of mode `m`.
    pub fn shape(&self, m: usize, i: usize) -> f64 {
        self.shapes[m * self.size + i - self.first]
    }

    /// Change of the overlap of contact `j`, which joins two of its balls, for a unit of the coordinate of mode `m`.
    pub fn stretch(&self, m: usize, j: usize) -> f64 {
        self.stretches[m * (self.size - 1) + j - self.first]
    }

    /// Mass share of these `balls`.
    pub fn share(&self, balls: Range<usize>) -> f64 {
        let masses = &self.masses[balls.start - self.first..balls.end - self.first];
        masses.iter().sum::<f64>() / self.masses.iter().sum::<f64>()
    }
}

/// `lambda`, `phi` and `D phi` of all modes for these `masses` and, one less, `stiffnesses`; `None` if too far apart.
fn shapes(masses: &[f64], stiffnesses: &[f64]) -> Option<[Vec<f64>; 3]> {
    let (size, contacts) = (masses.len(), stiffnesses.len());
    let roots: Vec<f64> = stiffnesses.iter().map(|k| k.sqrt()).collect();
    let matrix = DMatrix::from_fn(contacts, contacts, |r, c| match r.abs_diff(c) {
        0 => stiffnesses[r] * (1.0 / masses[r] + 1.0 / masses[r + 1]),
        1 => -roots[r] * roots[c] / masses[r.max(c)],
        _ => 0.0,
    });
    if !matrix.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let total: f64 = masses.iter().sum();
    let (mut lambdas, mut shapes, mut stretches) = (vec![0.0], vec![1.0 / total.sqrt(); size], vec![0.0; contacts]);
    if contacts == 0 {
        return Some([lambdas, shapes, stretches]);
    }
    // It takes about two iterations per eigenvalue.
    let vectors = SymmetricEigen::try_new(matrix, f64::EPSILON, 30 * size)?.eigenvectors;
    for u in vectors.column_iter() {
        let force = |i: usize| roots.get(i).map_or(0.0, |root| root * u[i]);
        let pushed = |i: usize| (force(i) - force(i.wrapping_sub(1))) / masses[i];
        // From the vector, the eigenvalue has twice its digits (Rayleigh's quotient).
        let lambda: f64 = (0..size).map(|i| masses[i] * pushed(i) * pushed(i)).sum();
        let root = lambda.sqrt();
        let good = |i: usize| (roots[i] * (pushed(i) - pushed(i + 1)) - lambda * u[i]).abs() <= TOLERANCE * lambda;
        if !(0..contacts).all(good) {
            return None;
        }
        lambdas.push(lambda);
        shapes.extend((0..size).map(|i| pushed(i) / root));
        stretches.extend((0..contacts).map(|i| root * u[i] / roots[i]));
    }
    Some([lambdas, shapes, stretches])
}

#[cfg(test)]
mod tests {
    use super::shapes;

    #[test]
    fn modes_exist_only_for_similar_balls() {
        assert!(shapes(&[1.0, 1e-300, 2.0], &[1.0, 1.5]).is_none());
        assert!(shapes(&[1.0, 1e-30, 1.0], &[1.0, 1e300]).is_none());
        assert!(shapes(&[1.0, 1e-2, 2.0], &[1.0, 1.5]).is_some());
    }
}
