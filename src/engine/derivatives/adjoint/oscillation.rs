//! Motions that are sums of oscillations, with their derivatives by the start and the coefficients: one ball in flight,
//! or two equal pendulums in a linear contact. See "Derivatives" in docs/theory.md.

use super::map::{CLEARANCE, COEFFICIENTS, Map, OF_BALL, OF_CONTACT, STATE, V, X, law_derivatives, numbers_of_state};
use crate::engine::flight::{Flight, Forcing, degree, forcing_at};
use crate::model::{BallModel, ContactLaw};
use crate::solver::{NODES, Nodes, Oscillator, Stretching, Table, weighted};

/// Longest part, times `omega + 2 gamma`, for which the rule is exact to rounding.
pub(super) const REACH: f64 = 4.0;

/// Longest part for which two nodes suffice in a flight under constant inputs; their error grows with the fourth power.
const SHORT: f64 = 1e-3;

/// The places of the two-point rule on [0, 1], whose weights are 1/2.
const EARLY_AND_LATE: [f64; 2] = [0.211_324_865_405_187_13, 0.788_675_134_594_812_9];

/// Changing numbers of the state of two balls.
const NUMBERS: usize = 2 * STATE - 1;
type Change = [f64; NUMBERS];

/// One ball, or two equal pendulums in a linear contact.
pub(super) struct Oscillation<'a> {
    pub models: &'a [BallModel],
    /// Shares of the balls in their mass.
    shares: [f64; 2],
    /// The oscillator of the centre.
    own: Oscillator,
    contact: Option<LinearContact<'a>>,
}

/// The distance of two balls as an oscillator.
struct LinearContact<'a> {
    law: &'a ContactLaw,
    /// The inverse of the reduced mass, 1/kg.
    inverse_mass: f64,
    oscillator: Oscillator,
}

impl<'a> Oscillation<'a> {
    /// These balls, if their motion is a sum of oscillations.
    pub fn of(models: &'a [BallModel], laws: &'a [ContactLaw]) -> Option<Self> {
        let of_pendulum = |ball: &BallModel| Oscillator::new(ball.omega2, ball.gamma);
        match (models, laws) {
            ([ball], []) => Some(Self { models, shares: [1.0, 0.0], own: of_pendulum(ball), contact: None }),
            ([left, right], [law]) => {
                let equal = left.omega2 == right.omega2 && left.gamma == right.gamma;
                (equal && law.exponent == 1.0 && law.is_elastic()).then(|| {
                    let (total, inverse_mass) = (left.mass + right.mass, 1.0 / left.mass + 1.0 / right.mass);
                    let oscillator = Oscillator::new(left.omega2 + law.stiffness * inverse_mass, left.gamma);
                    let contact = Some(LinearContact { law, inverse_mass, oscillator });
                    Self { models, shares: [left.mass / total, right.mass / total], own: of_pendulum(left), contact }
                })
            }
            _ => None,
        }
    }

    /// Number of parts of a motion for the time `length` (s).
    pub fn pieces(&self, length: f64) -> f64 {
        let fastest = self.contact.as_ref().map_or(&self.own, |contact| &contact.oscillator);
        (fastest.pace() * length / REACH).ceil().max(1.0)
    }

    /// A change of the state from changes of the centre's position and velocity, and of distance, rate and impulse.
    fn state(&self, [x, v]: [f64; 2], [apart, rate, impulse]: [f64; 3]) -> Change {
        let [left, right] = self.shares;
        [x + right * apart, v + right * rate, impulse, x - left * apart, v - left * rate]
    }

    /// The linearised motion from these flights on, each with its external force (N), from the overlap (m) for the
    /// time `length` (s), and its end: displacements and velocities. One ball is given twice.
    pub fn follow(
        &self,
        (first, tuning): (usize, usize),
        [(left, push_left), (right, push_right)]: [(Flight, Forcing); 2],
        overlap: f64,
        length: f64,
    ) -> (Map, [(f64, f64); 2]) {
        let mean = |left: f64, right: f64| self.shares[0] * left + self.shares[1] * right;
        let centre = Flight {
            x: mean(left.x, right.x),
            v: mean(left.v, right.v),
            forcing: std::array::from_fn(|k| mean(left.forcing[k], right.forcing[k])),
        };
        let mut forcing: Forcing = std::array::from_fn(|k| left.forcing[k] - right.forcing[k]);
        forcing[0] -= self.contact.as_ref().map_or(0.0, |contact| self.own.omega2() * contact.law.clearance);
        let overlap = Flight { x: overlap, v: left.v - right.v, forcing };
        let basis = self.own.basis(length.into());
        let (x, v) = moved(&centre, &self.own, &basis, length);
        let by_centre = swing(&self.own, &basis);
        let (mut by_distance, mut apart) = ([[0.0; 3]; 2], [0.0; 3]);
        if let Some(LinearContact { law, oscillator, .. }) = &self.contact {
            let basis: [f64; 3] = oscillator.basis(length.into());
            let (closer, rate) = moved(&overlap, oscillator, &basis, length);
            apart = [closer, rate, 0.0];
            // The integral of a distance that starts at 1 at rest is t - omega^2 U_3: nothing cancels.
            let impulse = [basis[1] + 2.0 * oscillator.gamma() * basis[2], basis[2]].map(|u| law.stiffness * u);
            let swing = swing(oscillator, &basis);
            by_distance = [X, V].map(|k| [swing[k][0], swing[k][1], impulse[k]]);
        }
        let (by_coefficients, by_support) = self.by_coefficients(&[centre, overlap], &[push_left, push_right], length);
        let mut by_start = [Change::default(); 2 * STATE];
        for (side, (share, sign)) in self.shares.into_iter().zip([1.0, -1.0]).enumerate() {
            for k in [X, V] {
                by_start[STATE * side + k] =
                    self.state(by_centre[k].map(|of| share * of), by_distance[k].map(|of| sign * of));
            }
        }
        let mut map = Map::zero(first, self.models.len(), tuning);
        for number in 0..numbers_of_state(self.models.len()) {
            let [state, coefficients] = map.row(number);
            state.iter_mut().zip(&by_start).for_each(|(to, by)| *to = by[number]);
            let support = coefficients.len() - 1;
            coefficients[..support].iter_mut().zip(&by_coefficients).for_each(|(to, by)| *to = by[number]);
            coefficients[support] = by_support[number];
        }
        let ends = self.state([x, v], apart);
        (map, [0, STATE].map(|side| (ends[side + X], ends[side + V])))
    }

    /// Derivatives of the state by the coefficients and the acceleration of the support along these motions of the
    /// centre and of the overlap: integrals of a coefficient's effect times the response to it at the end.
    fn by_coefficients(
        &self,
        [centre, overlap]: &[Flight; 2],
        pushes: &[Forcing; 2],
        length: f64,
    ) -> ([Change; COEFFICIENTS + OF_BALL], Change) {
        let constant = degree(&centre.forcing) == 0 && pushes.iter().all(|push| degree(push) == 0);
        let short = self.contact.is_none() && constant && self.own.pace() * length <= SHORT;
        let Table { times: mut places, of_rate: mut weights, .. } = *Stretching::None.table();
        let mut count = NODES;
        if short {
            count = EARLY_AND_LATE.len();
            places[..count].copy_from_slice(&EARLY_AND_LATE);
            weights[..count].fill(0.5);
        } else if self.contact.is_some() {
            weights = std::array::from_fn(|m| weights[m] * 6.0 * places[m] * (1.0 - places[m]));
            places = places.map(|c| c * c * (3.0 - 2.0 * c));
        }
        let bases = |o: &Oscillator| -> [[f64; 3]; NODES] {
            std::array::from_fn(|m| if m < count { o.basis((length * places[m]).into()) } else { [0.0; 3] })
        };
        let (of_centre, of_distance) =
            (bases(&self.own), self.contact.as_ref().map(|contact| bases(&contact.oscillator)));
        // For the acceleration of each ball and the contact force: its effect on the state, and its derivatives.
        let (mut to_balls, mut of_balls) = ([[[0.0; NODES]; NUMBERS]; 2], [[[0.0; NODES]; OF_BALL]; 2]);
        let (mut to_force, mut of_force) = ([[0.0; NODES]; NUMBERS], [[0.0; NODES]; OF_CONTACT]);
        let mut to_centre = [0.0; 2];
        for m in 0..count {
            let enter =
                |to: &mut [Nodes], values: &[f64]| to.iter_mut().zip(values).for_each(|(to, value)| to[m] = *value);
            // Nodes and weights are symmetric: the time left to the end is that of the mirrored node.
            let (s, weight, left) = (length * places[m], length * weights[m], count - 1 - m);
            let (moved_centre, v_centre) = moved(centre, &self.own, &of_centre[m], s);
            let [v, x, _] = of_centre[left].map(|response| weight * response);
            to_centre = [to_centre[0] + x, to_centre[1] + v];
            let (mut distance, mut rate, mut force) = (0.0, 0.0, 0.0);
            let mut apart = [0.0; 3];
            if let Some((LinearContact { law, inverse_mass, oscillator }, basis)) =
                self.contact.as_ref().zip(of_distance.as_ref())
            {
                let (closer, closing) = moved(overlap, oscillator, &basis[m], s);
                let now = overlap.x + closer;
                (distance, rate, force) = (now + law.clearance, closing, law.stiffness * now);
                let [faster, farther, twice] = basis[left].map(|response| weight * response);
                apart = [farther, faster, law.stiffness * twice];
                let [r, faster, impulse] = apart.map(|apart| -inverse_mass * apart);
                enter(&mut to_force, &self.state([0.0; 2], [r, faster, weight + impulse]));
                enter(&mut of_force, &law_derivatives(law, now, rate, force, law.stiffness));
            }
            for (side, (model, sign)) in self.models.iter().zip([1.0, -1.0]).enumerate() {
                let (mass, share, other) = (model.mass, self.shares[side], self.shares[1 - side]);
                let total = forcing_at(&pushes[side], s) - sign * force;
                let x_ball = centre.x + moved_centre + sign * other * distance;
                let v_ball = v_centre + sign * other * rate;
                enter(&mut to_balls[side], &self.state([share * x, share * v], apart.map(|apart| sign * apart)));
                enter(&mut of_balls[side], &[-total / (mass * mass), -x_ball, -2.0 * v_ball, 1.0 / mass]);
            }
        }
        let mut by = [Change::default(); COEFFICIENTS + OF_BALL];
        let mut integrate = |first: usize, sources: &[Nodes], responses: &[Nodes; NUMBERS]| {
            for (by, source) in by[first..].iter_mut().zip(sources) {
                for (by, response) in by.iter_mut().zip(responses).take(numbers_of_state(self.models.len())) {
                    *by = weighted(source, response);
                }
            }
        };
        (0..self.models.len()).for_each(|side| integrate(COEFFICIENTS * side, &of_balls[side], &to_balls[side]));
        if let Some(LinearContact { law, .. }) = &self.contact {
            of_force[CLEARANCE].fill(-law.stiffness);
            integrate(OF_BALL, &of_force, &to_force);
        }
        (by, self.state(to_centre.map(|to| -to), [0.0; 3]))
    }
}

/// Derivatives of an oscillator's state by that at the start, minus the identity, for these function values.
fn swing(o: &Oscillator, [_, u1, u2]: &[f64; 3]) -> [[f64; 2]; 2] {
    let turn = o.omega2() * u2;
    [[-turn, -o.omega2() * u1], [*u1, -turn - 2.0 * o.gamma() * u1]]
}

/// Displacement and velocity on a flight at the time `t` (s), from the oscillator's functions there.
fn moved(flight: &Flight, o: &Oscillator, basis: &[f64; 3], t: f64) -> (f64, f64) {
    if degree(&flight.forcing) == 0 {
        (flight.displacement(o, basis), flight.velocity(o, basis))
    } else {
        flight.at(o, t.into())
    }
}
