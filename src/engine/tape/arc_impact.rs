//! Elastic impacts of two balls on arcs, linearised by a closed form in dual numbers, each at its own time.
//!
//! The overlap d is a function of the two places, with the gradient n and the second derivatives H. With the masses M,
//! `nu = n M^-1 n` and `b = M^-1 n / nu`, the velocities are `a + b d'` with a constant a along which the balls keep
//! touching. To first order in the turn of n, in gravity and in inputs
//!
//! ```text
//! d'' = A - W d + 2 B d' + C d'^2 - nu F(d) (1 + 2 B t + 2 C d),   A = n f + a H a,  B = a H b,  C = b H b
//! ```
//!
//! with the accelerations f without contact and their decrease W with the overlap. A and W load the free impact; C
//! makes it shorter; the term with B does work, and so do drag and damping, half of it before the middle. Products of
//! two of these terms are left out ([`FIRST_ORDER_LIMIT`]).

use super::coefficients::{CLEARANCE, Coefficients, GRAVITY, IMPULSE, LENGTH, MASS, OF_LAW, PEAK, STATE, V, X};
use super::part::Part;
use crate::engine::pair_impact::{ImpactCoefficients, PulseShape};
use crate::model::{BallModel, ContactLaw, Cradle, Pair};
use crate::solver::power::power;
use crate::solver::{Dual, Scalar};

/// Largest sum of the turns of the paths (rad) and of the parts that the terms without contact have in the motion of
/// the overlap. Derivatives have the square of it as their error.
const FIRST_ORDER_LIMIT: f64 = 1e-4;

/// An impact in contact `contact`.
#[derive(Debug)]
pub(super) struct ArcImpactPart {
    pub contact: usize,
    /// Position (m) and velocity (m/s) of its balls at the onset; their accelerations by the inputs, and the part of
    /// these by the external forces, m/s2.
    pub start: [(f64, f64); 2],
    pub forcing: [f64; 2],
    pub external: [f64; 2],
    pub shape: PulseShape,
    /// The largest overlap, m, if its force exceeds all before it in the step.
    pub largest: Option<f64>,
}

/// Changes of what an impact depends on. Of each ball: position, velocity, mass, decay rate, length, gravity, and
/// acceleration by the inputs. Of the contact: stiffness, reference overlap, exponent, damping coefficient, clearance,
/// and distance of the pivots.
#[derive(Clone, Copy, Default)]
struct Causes {
    balls: [[f64; 7]; 2],
    contact: [f64; 6],
}

/// Changes of positions and velocities of the left and the right ball, of impulse and of largest force.
type Effects = [f64; 6];

/// Two numbers, of the left and of the right ball.
type Both<S> = [S; 2];

/// The equation of motion of the overlap by its terms, and the largest overlap by the free impact, m.
struct OverlapEquation<S> {
    masses: Both<S>,
    /// The gradient n, n over the masses, and the products of H with a and with b.
    gradient: Both<S>,
    lightness: Both<S>,
    turned: [Both<S>; 2],
    /// The parts a (m/s) and b of the velocities, the rate at the onset (m/s), and nu (1/kg).
    a: Both<S>,
    b: Both<S>,
    rate: S,
    inverse_mass: S,
    /// Accelerations without contact, m/s2, and their derivatives by the places, 1/s2.
    free: Both<S>,
    by_place: Both<S>,
    reach: S,
    /// A (m/s2), W (1/s2), B (1/s), C (1/m).
    terms: [S; 4],
}

fn dot<S: Scalar>(a: &Both<S>, b: &Both<S>) -> S {
    a[0] * b[0] + a[1] * b[1]
}

/// The largest overlap of a free impact, m.
fn largest_overlap<S: Scalar>(law: &ContactLaw<S>, inverse_mass: S, rate: S) -> S {
    let (one, unit) = (S::from(1.0), law.stiffness * law.overlap_ref * law.overlap_ref);
    let energies = S::from(0.5) * (law.exponent + one) * rate * rate / (inverse_mass * unit);
    law.overlap_ref * energies.pow(one / (law.exponent + one))
}

impl<S: Scalar> OverlapEquation<S> {
    fn new(pair: &Pair<S>, places: Both<S>, velocities: Both<S>, forcing: Both<S>) -> Self {
        let Pair { balls, law } = pair;
        let at = [0, 1].map(|k| balls[k].place(places[k]));
        let [width, height] = pair.distances(places);
        let distance = (width * width + height * height).sqrt();
        let parts = [0, 1].map(|k| pair.parts_of(k, at.each_ref()));
        let (gradient, [left, right]) = ([parts[0][0], -parts[1][0]], [parts[0][1], parts[1][1]]);
        let hessian = [
            -left / balls[0].length - left * left / distance,
            left * right / distance,
            right / balls[1].length - right * right / distance,
        ];
        let turn = |of: &Both<S>| [hessian[0] * of[0] + hessian[1] * of[1], hessian[1] * of[0] + hessian[2] * of[1]];
        let masses = balls.map(|ball| ball.mass);
        let lightness = [0, 1].map(|k| gradient[k] / masses[k]);
        let inverse_mass = dot(&gradient, &lightness);
        let (b, rate) = (lightness.map(|by_force| by_force / inverse_mass), dot(&gradient, &velocities));
        let a = [0, 1].map(|k| velocities[k] - b[k] * rate);
        let turned = [turn(&a), turn(&b)];
        let free = [0, 1].map(|k| forcing[k] * at[k].cos - balls[k].gravity * at[k].restoring);
        let by_place = [0, 1].map(|k| -(balls[k].gravity * at[k].cos + forcing[k] * at[k].sin) / balls[k].length);
        let less: Both<S> = [0, 1].map(|k| -by_place[k] * gradient[k]);
        let load = dot(&gradient, &free) + dot(&a, &turned[0]);
        let terms = [load, dot(&less, &b), dot(&a, &turned[1]), dot(&b, &turned[1])];
        let reach = largest_overlap(law, inverse_mass, rate);
        Self { masses, gradient, lightness, turned, a, b, rate, inverse_mass, free, by_place, reach, terms }
    }

    /// The dimensionless loads alpha and beta by W and A, on which the shape of the pulse depends.
    fn loads(&self) -> [S; 2] {
        let ([load, less, ..], part) = (self.terms, self.reach / self.rate);
        [less * part * part, -S::from(2.0) * load * part / self.rate]
    }
}

/// The motion of the overlap in an impact, to first order.
struct Compression {
    /// Duration (s), and integrals of the overlap (m.s) and of its squared rate (m2/s).
    time: Dual,
    sum: Dual,
    squares: Dual,
    /// A with drag and with the drift of the load until the middle, m/s2.
    load: Dual,
    /// Energy over the reduced mass that the overlap gains until the middle and in all, m2/s2.
    there: Dual,
    gained: Dual,
}

impl OverlapEquation<Dual> {
    /// Accelerations of the balls, or integrals of them, by the turn of the direction.
    fn by_turn(&self, of: impl Fn(usize) -> Dual) -> Both<Dual> {
        [0, 1].map(|k| of(k) / (self.masses[k] * self.inverse_mass))
    }

    /// Velocities after the impact (m/s) from those at the onset, and the impulse (N.s).
    fn velocities_after(&self, along: &Pair<Dual>, v: Both<Dual>, by: &Compression) -> (Both<Dual>, Dual) {
        let Self { gradient, turned, a, b, rate, free, by_place, lightness, .. } = self;
        let (half, two, &Compression { time, sum, squares, gained, .. }) = (Dual::from(0.5), Dual::from(2.0), by);
        // The contact forces act along directions that turn.
        let by_turn = self.by_turn(|k| turned[0][k] * *rate * time + turned[1][k] * squares);
        let given = [0, 1].map(|k| {
            let drag = two * along.balls[k].gamma * a[k] * time;
            free[k] * time + by_place[k] * (half * a[k] * time * time + b[k] * sum) - drag - by_turn[k]
        });
        let after = [0, 1].map(|k| v[k] + given[k]);
        let end = [0, 1].map(|k| gradient[k] + turned[0][k] * time);
        let impulse = (dot(&end, &after) + *rate + gained / *rate) / dot(&end, lightness);
        ([0, 1].map(|k| after[k] - lightness[k] * impulse), impulse)
    }

    /// Displacements in the impact (m) from the velocities at the onset (m/s). The overlap is 0 again.
    fn displacements(&self, v: Both<Dual>, by: &Compression) -> Both<Dual> {
        let (half, two, &Compression { time, sum, squares, .. }) = (Dual::from(0.5), Dual::from(2.0), by);
        let turned = self.by_turn(|k| two * self.turned[0][k] * sum + half * self.turned[1][k] * time * squares);
        let moved = [0, 1].map(|k| v[k] * time + half * self.free[k] * time * time - turned[k]);
        let way =
            (dot(&self.gradient, &moved) + half * time * time * dot(&self.a, &self.turned[0])) / self.inverse_mass;
        [0, 1].map(|k| moved[k] - self.lightness[k] * way)
    }
}

impl ArcImpactPart {
    /// The impact in `contact` of balls in these states; `None` if too much changes during it.
    pub fn new(
        pair: &Pair,
        contact: usize,
        (start, forcing, external): ([(f64, f64); 2], [f64; 2], [f64; 2]),
        coefficients: &ImpactCoefficients,
    ) -> Option<Self> {
        let equation = OverlapEquation::new(pair, start.map(|(x, _)| x), start.map(|(_, v)| v), forcing);
        let [alpha, beta] = equation.loads();
        let shape = coefficients.pulse(pair.law, alpha, beta)?;
        let ([_, _, works, shortens], time) =
            (equation.terms, 2.0 * equation.reach / equation.rate * shape.integrals[0][0]);
        let turn: f64 = pair.balls.iter().zip(start).map(|(ball, (_, v))| (v * time / ball.length).abs()).sum();
        let varies = turn + alpha.abs() + beta.abs() + (works * time).abs() + (shortens * equation.reach).abs();
        (varies < FIRST_ORDER_LIMIT).then_some(Self { contact, start, forcing, external, shape, largest: None })
    }

    /// Acceleration without contact of ball `k` at the place `x`, m/s2.
    fn free(&self, pair: &Pair, k: usize, x: f64) -> f64 {
        let place = pair.balls[k].place(x);
        self.forcing[k] * place.cos - pair.balls[k].gravity * place.restoring
    }

    /// How much later the onset is (s), and places (m) and velocities (m/s) of the balls then. `along` has the
    /// coefficients with their changes.
    fn onset(&self, pair: &Pair, along: &Pair<Dual>, causes: &Causes) -> (f64, Both<Dual>, Both<Dual>) {
        let number = Dual::with_tangent;
        let before = [0, 1].map(|k| number(self.start[k].0, causes.balls[k][0]));
        let parts = pair.parts_along(self.start.map(|(x, _)| x));
        let rate = parts[0] * self.start[0].1 - parts[1] * self.start[1].1;
        let delay = -along.overlap(before).tangent() / rate;
        let places = [0, 1].map(|k| before[k] + number(0.0, self.start[k].1 * delay));
        let change = |k: usize| causes.balls[k][1] + self.free(pair, k, self.start[k].0) * delay;
        (delay, places, [0, 1].map(|k| number(self.start[k].1, change(k))))
    }

    /// The motion of the overlap by its `equation`. `along` has the coefficients with their changes, except for the
    /// `damping` coefficient.
    fn compression(
        &self,
        pair: &Pair,
        along: &Pair<Dual>,
        equation: &OverlapEquation<Dual>,
        damping: f64,
    ) -> Compression {
        let (number, half, one, two) = (Dual::with_tangent, Dual::from(0.5), Dual::from(1.0), Dual::from(2.0));
        let OverlapEquation { gradient, a, b, rate, inverse_mass, by_place, reach, .. } = equation;
        let ([load, _, works, shortens], rate, reach) = (equation.terms, *rate, *reach);
        // For the free impact: duration, and integrals of the overlap and of its squared rate.
        let p = along.law.exponent;
        let integral = |k: usize, [alpha, beta]: [Dual; 2]| {
            let [value, by_alpha, by_beta, by_exponent] = self.shape.integrals[k];
            number(value, by_alpha * alpha.tangent() + by_beta * beta.tangent() + by_exponent * p.tangent())
        };
        let loads = equation.loads();
        let (part, none) = (two * reach / rate, [Dual::default(); 2]);
        let (time, sum) = (part * integral(0, none), part * reach * integral(1, loads));
        let squares = rate * rate * time * (p + one) / (p + one + two);
        // The free impact lacks drag and damping, which take energy, and the drift of the load, which gives some.
        let of_drag = [0, 1].map(|k| along.balls[k].gamma * gradient[k]);
        let drift = -(gradient[0] * by_place[0] * a[0] + gradient[1] * by_place[1] * a[1]);
        let load = load - two * dot(&of_drag, a) - half * time * drift;
        let grown = power(reach.value() / pair.law.overlap_ref, pair.law.damping_exponent());
        let lost = 2.0 * (rate * reach).value() * grown * self.shape.works[1] * inverse_mass.value() * damping;
        let taken = two * dot(&of_drag, b) * squares + number(0.0, lost) - drift * sum;
        let (there, gained) = (half * (works * squares - taken), works * (squares + time * rate * rate) - taken);
        let rate_there = rate + there / rate;
        let part = largest_overlap(along.law, *inverse_mass, rate_there) / rate_there;
        let beta = -two * load * reach / (rate * rate);
        let time = two * part * integral(0, [loads[0], beta]) * (one - half * works * time) - shortens * sum;
        Compression { time, sum, squares, load, there, gained }
    }

    /// Change of the largest force; 0 if it is not wanted.
    fn change_of_peak(&self, law: &ContactLaw<Dual>, equation: &OverlapEquation<Dual>, by: &Compression) -> f64 {
        self.largest.map_or(0.0, |overlap| {
            let (overlap, half, [_, less, ..]) = (Dual::from(overlap), Dual::from(0.5), equation.terms);
            let energy = half * equation.rate * equation.rate + by.there + overlap * (by.load - half * less * overlap);
            let missing = energy - equation.inverse_mass * law.elastic_energy(overlap);
            let force = law.elastic_force(overlap);
            let stiffness = equation.inverse_mass * force - by.load + less * overlap;
            force.tangent() + (law.exponent * force / overlap).value() * missing.tangent() / stiffness.value()
        })
    }

    /// Changes of the state after the impact, at the common time.
    fn effects(&self, pair: &Pair, causes: &Causes) -> Effects {
        let (balls, law) = with_changes(pair, causes);
        let along = Pair { balls: balls.each_ref(), law: &law };
        let (delay, places, v) = self.onset(pair, &along, causes);
        let forcing = [0, 1].map(|k| Dual::with_tangent(self.forcing[k], causes.balls[k][6]));
        let equation = OverlapEquation::new(&along, places, v, forcing);
        let [.., damping, _, _] = causes.contact;
        let compression = self.compression(pair, &along, &equation, damping);
        let (after, impulse) = equation.velocities_after(&along, v, &compression);
        let moved = equation.displacements(v, &compression);
        let peak = self.change_of_peak(&law, &equation, &compression);
        // Back at the common time, which is earlier.
        let later = delay + compression.time.tangent();
        let place = |k: usize| places[k].tangent() + moved[k].tangent() - after[k].value() * later;
        let velocity = |k: usize| after[k].tangent() - self.free(pair, k, (places[k] + moved[k]).value()) * later;
        [place(0), place(1), velocity(0), velocity(1), impulse.tangent(), peak]
    }
}

/// The balls and the law of a contact with their changes; all but that of the damping coefficient.
fn with_changes(pair: &Pair, causes: &Causes) -> ([BallModel<Dual>; 2], ContactLaw<Dual>) {
    let number = Dual::with_tangent;
    let ball = |k: usize| {
        let ([_, _, mass, gamma, length, gravity, _], ball) = (causes.balls[k], pair.balls[k].map(Dual::from));
        BallModel {
            mass: number(ball.mass.value(), mass),
            gamma: number(ball.gamma.value(), gamma),
            length: number(ball.length.value(), length),
            gravity: number(ball.gravity.value(), gravity),
            ..ball
        }
    };
    let [stiffness, overlap_ref, exponent, _, clearance, pivots] = causes.contact;
    let law = ContactLaw {
        stiffness: number(pair.law.stiffness, stiffness),
        overlap_ref: number(pair.law.overlap_ref, overlap_ref),
        exponent: number(pair.law.exponent, exponent),
        clearance: number(pair.law.clearance, clearance),
        pivots: number(pair.law.pivots, pivots),
        ..pair.law.map(Dual::from)
    };
    ([ball(0), ball(1)], law)
}

impl Part for ArcImpactPart {
    fn numbers(&self) -> usize {
        24
    }

    fn forward(&self, cradle: &Cradle, changes: &Coefficients, state: &mut [f64]) {
        let (j, pair) = (self.contact, cradle.pair(self.contact));
        let balls = [0, 1].map(|k| {
            let (i, of) = (j + k, changes.of_ball(j + k));
            let [gamma, _, forcing] = changes.of_motion(i, pair.balls[k]);
            let forcing = forcing - self.external[k] / pair.balls[k].mass * of[MASS];
            [state[i * STATE + X], state[i * STATE + V], of[MASS], gamma, of[LENGTH], of[GRAVITY], forcing]
        });
        let [stiffness, overlap_ref, exponent, damping] = *changes.of_law(j);
        let (clearance, [.., pivots]) = (changes.of_ball(j)[CLEARANCE], changes.of_linkage(j));
        let contact = [stiffness, overlap_ref, exponent, damping, clearance, pivots];
        let effects = self.effects(&pair, &Causes { balls, contact });
        for k in 0..2 {
            let state = &mut state[(j + k) * STATE..];
            (state[X], state[V]) = (effects[k], effects[2 + k]);
        }
        state[j * STATE + IMPULSE] += effects[4];
        if self.largest.is_some() {
            state[j * STATE + PEAK] = effects[5];
        }
    }

    fn backward(&self, cradle: &Cradle, by_changes: &mut Coefficients, by_state: &mut [f64]) {
        let (j, pair) = (self.contact, cradle.pair(self.contact));
        let [x, v] = [X, V].map(|number| [j, j + 1].map(|i| by_state[i * STATE + number]));
        let by_peak = if self.largest.is_some() { std::mem::take(&mut by_state[j * STATE + PEAK]) } else { 0.0 };
        let by_effects = [x[0], x[1], v[0], v[1], by_state[j * STATE + IMPULSE], by_peak];
        let by = |cause: &dyn Fn(&mut Causes)| {
            let mut causes = Causes::default();
            cause(&mut causes);
            let effects = self.effects(&pair, &causes);
            by_effects.iter().zip(effects).map(|(by, effect)| by * effect).sum::<f64>()
        };
        for k in 0..2 {
            let [x, v, mass, gamma, length, gravity, forcing] =
                std::array::from_fn(|n| by(&|causes| causes.balls[k][n] = 1.0));
            let i = j + k;
            (by_state[i * STATE + X], by_state[i * STATE + V]) = (x, v);
            by_changes.add_of_motion(i, pair.balls[k], [gamma, 0.0, forcing]);
            let of = by_changes.of_ball_mut(i);
            of[MASS] += mass - forcing * self.external[k] / pair.balls[k].mass;
            of[LENGTH] += length;
            of[GRAVITY] += gravity;
        }
        let [law @ .., clearance, pivots]: [f64; OF_LAW + 2] =
            std::array::from_fn(|n| by(&|causes| causes.contact[n] = 1.0));
        by_changes.of_law_mut(j).iter_mut().zip(law).for_each(|(sum, by)| *sum += by);
        by_changes.of_ball_mut(j)[CLEARANCE] += clearance;
        by_changes.add_of_linkage(j, &[0.0, 0.0, 0.0, 0.0, pivots]);
    }
}
