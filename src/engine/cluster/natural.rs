//! The motion of balls joined by linear contacts, by their natural modes (`shapes`).
//!
//! Springs k, dashpots c and pendulums of the same omega and gamma give mode j of a chain
//!
//! ```text
//! omega_j^2 = omega^2 + lambda_j k / mass,    gamma_j = gamma + lambda_j c / (2 mass)
//! ```
//!
//! with stiffness, damping and mass of its first contact and ball (Meirovitch, Fundamentals of Vibrations, 2001,
//! chapter 7: damping proportional to the stiffness leaves the modes uncoupled).

use std::ops::Range;

use super::shapes::Shapes;
use super::window::Window;
use crate::engine::flight::degree;
use crate::model::{ContactLaw, Mode};
use crate::solver::{ForcedOscillator, Oscillator};

/// Largest group that is decomposed into modes: the cost of its shapes grows with the cube.
const LARGEST_GROUP: usize = 40;

/// Segments by series after a switching before natural modes take over: where balls oscillate, and while a front has
/// yet to pass a contact. With fewer, the next switching ends modes too soon; with more, long motions cost more
/// (`benches/runs.rs`); too few of a front lose motions that grow from 0 (`tests/rust/stiff.rs`).
const SERIES: u32 = 13;
const SERIES_OF_FRONT: u32 = 64;

/// Number of segments by series after a switching before natural modes take over, if they [apply](apply_to).
pub(super) fn series_before_modes(window: &Window) -> Option<u32> {
    apply_to(window).then(|| match window.laws.iter().all(ContactLaw::is_elastic) {
        true => SERIES,
        // Only series keep balls that the motion has not reached exactly at rest, and resolve motions that grow from 0.
        // Modes would also be slower: tenfold for rows of 40 to 60 balls at ten times the critical damping.
        false if window.holds_front() => SERIES_OF_FRONT,
        false if window.rings() => SERIES,
        false => 0,
    })
}

/// Whether the closed contacts of a window are linear, and those that press join equal pendulums and are damped in
/// proportion to their stiffness, under constant inputs. (Drag makes pendulums of unequal masses unequal.)
fn apply_to(window: &Window) -> bool {
    let Window { flights, balls, contacts, laws, .. } = window;
    let mut first = 0;
    for (j, (contact, law)) in contacts.iter().zip(*laws).enumerate() {
        if contact.mode != Mode::Open && !law.is_linear() {
            return false;
        }
        if contact.mode != Mode::Pressing {
            first = j + 1;
            continue;
        }
        let (other, [left, right]) = (&laws[first], [&balls[first], &balls[j + 1]]);
        let proportional = law.damping_coefficient() * other.stiffness == other.damping_coefficient() * law.stiffness;
        if !(left.oscillator == right.oscillator && proportional) || j + 2 - first > LARGEST_GROUP {
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
    pub shapes: Shapes,
    /// The masses in units of that of the first ball.
    masses: Vec<f64>,
}

impl Group {
    /// `None` if their masses or stiffnesses are too far apart.
    pub fn new(members: Range<usize>, window: &Window) -> Option<Self> {
        let Window { flights, balls, contacts, laws, .. } = window;
        let (first, size) = (members.start, members.len());
        let ball = &balls[first];
        let joints = &laws[first..first + size - 1];
        let (stiffness, damping) = joints.first().map_or((0.0, 0.0), |law| (law.stiffness, law.damping_coefficient()));
        let (o, mass) = (&ball.oscillator, ball.model.mass);
        let masses: Vec<f64> = balls[members.clone()].iter().map(|ball| ball.model.mass / mass).collect();
        let stiffnesses: Vec<f64> = joints.iter().map(|law| law.stiffness / stiffness).collect();
        let shapes = Shapes::new(&masses, &stiffnesses)?;
        let mut modes = Vec::with_capacity(size);
        for (j, &lambda) in shapes.lambda.iter().enumerate() {
            let oscillator = match j {
                0 => *o,
                _ => Oscillator::new(o.omega2() + lambda * stiffness / mass, o.gamma() + 0.5 * lambda * damping / mass),
            };
            let weight = |i: usize| masses[i] * shapes.balls[j * size + i];
            let stretches = &shapes.contacts[j * (size - 1)..];
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
        Some(Self { first, size, damping, modes, shapes, masses })
    }

    /// The smallest decay rate by the dashpots right after the start, 1/s.
    pub fn least_decay(&self) -> f64 {
        self.modes[1..].iter().map(|mode| mode.oscillator.fast_decay()).fold(f64::INFINITY, f64::min)
    }

    /// Displacement of ball `i` for a unit of the coordinate of mode `m`.
    pub fn shape(&self, m: usize, i: usize) -> f64 {
        self.shapes.balls[m * self.size + i - self.first]
    }

    /// Change of the overlap of contact `j`, which joins two of its balls, for a unit of the coordinate of mode `m`.
    pub fn stretch(&self, m: usize, j: usize) -> f64 {
        self.shapes.contacts[m * (self.size - 1) + j - self.first]
    }

    /// Mass share of these `balls`.
    pub fn share(&self, balls: Range<usize>) -> f64 {
        let masses = &self.masses[balls.start - self.first..balls.end - self.first];
        masses.iter().sum::<f64>() / self.masses.iter().sum::<f64>()
    }
}
