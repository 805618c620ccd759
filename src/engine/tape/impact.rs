//! Elastic impacts of two balls on a line, linearised in closed form, each at its own time.
//!
//! To first order, a force that is odd in time about the middle of the impact takes energy, half of it before the
//! middle: the duration is that of an impact with the energy left there. One that is even adds to the load. Forces that
//! vary with the common motion are taken as linear in time: what is left out is `(omega T)^2 / 24` of the effect that
//! different pendulums or drags have within the time T of the impact.

use super::coefficients::{CLEARANCE, Coefficients, IMPULSE, MASS, PEAK, STATE, V, X};
use super::part::Part;
use crate::engine::pair_impact::{ImpactCoefficients, PulseShape};
use crate::model::{BallModel, ContactLaw, Cradle, Pair};
use crate::solver::{BASIS, Dual, MAX_FORCE_ORDER, Oscillator, Scalar};

/// What an impact depends on: of the left and of the right ball position, velocity, mass, decay rate, square of the
/// frequency, and acceleration by the inputs; stiffness, reference overlap, exponent and clearance; and the energy that
/// is lost over the reduced mass (m2/s2).
type Causes = [f64; 17];

/// The functions `U_k` and `Z_k` of the pendulums at the end of an impact, from `U_0` and `Z_-1` on.
type Swing = ([f64; BASIS], [f64; MAX_FORCE_ORDER + 4]);

/// Positions and velocities of the left and of the right ball, impulse and largest force.
type Effects = [f64; 6];

/// An impact in contact `contact`.
#[derive(Debug)]
pub(super) struct ImpactPart {
    pub contact: usize,
    /// Position (m) and velocity (m/s) of its balls at the onset, and their accelerations by the inputs and by the
    /// external forces among them, m/s2.
    pub start: [(f64, f64); 2],
    pub forcing: [f64; 2],
    pub push: [f64; 2],
    pub shape: PulseShape,
    /// The largest overlap without pendulums and inputs, m.
    pub reach: f64,
    /// The largest overlap, m, if its force is larger than before in the step.
    pub largest: Option<f64>,
}

impl ImpactPart {
    /// The shape and the reach of an impact of balls in these states; `None` where too much varies.
    pub fn shape(
        pair: &Pair,
        [left, right]: [(f64, f64); 2],
        forcing: [f64; 2],
        coefficients: &ImpactCoefficients,
    ) -> Option<(PulseShape, f64)> {
        let Pair { balls: [ball, other], law } = pair;
        let (rate, reduced) = (left.1 - right.1, ball.mass * other.mass / (ball.mass + other.mass));
        let (reach, load) = (law.largest_overlap(reduced, rate), ball.omega2 * law.clearance - forcing[0] + forcing[1]);
        let part = reach / rate;
        let shape = coefficients.pulse(law.exponent, ball.omega2 * part * part, 2.0 * load * part / rate)?;
        Some((shape, reach))
    }

    fn swing(&self, pair: &Pair) -> Swing {
        let time = 2.0 * self.reach / (self.start[0].1 - self.start[1].1) * self.shape.integrals[0][0];
        let o = Oscillator::new(pair.balls[0].omega2, 0.0);
        let u = o.basis(time.into());
        (u, o.sensitivities(time, &u))
    }

    /// The energy that an impact loses over the reduced mass (m2/s2), by each of the coefficients of losses.
    fn losses(&self, pair: &Pair) -> [f64; 3] {
        let Pair { balls: [left, right], law } = pair;
        let (rate, reduced) = (self.start[0].1 - self.start[1].1, left.mass * right.mass / (left.mass + right.mass));
        let (force, [of_rate, of_force, of_slope]) = (law.elastic_force(self.reach), self.shape.works);
        let works = [self.reach * of_rate, force * self.reach * of_force, law.exponent * force * of_slope];
        works.map(|work| 2.0 * rate * work / reduced)
    }

    /// Changes of the state afterwards, at the common time.
    fn effects(&self, pair: &Pair, swing: &Swing, causes: &Causes) -> Effects {
        let Pair { balls, law } = pair;
        let (number, two, half) = (Dual::with_tangent, Dual::from(2.0), Dual::from(0.5));
        let both = |k: usize, values: [f64; 2]| [0, 1].map(|side| number(values[side], causes[2 * k + side]));
        let of_balls = |k: usize, value: fn(&BallModel) -> f64| both(k, balls.map(value));
        let (mass, gamma, omega2) =
            (of_balls(2, |ball| ball.mass), of_balls(3, |ball| ball.gamma), of_balls(4, |ball| ball.omega2));
        let (forcing, clearance) = (both(5, self.forcing), number(law.clearance, causes[15]));
        let law = ContactLaw {
            stiffness: number(law.stiffness, causes[12]),
            overlap_ref: number(law.overlap_ref, causes[13]),
            exponent: number(law.exponent, causes[14]),
            ..law.map(Dual::from)
        };
        // At its onset, which is later.
        let free = |side: usize, x: f64| self.forcing[side] - balls[side].omega2 * x;
        let [(left, u), (right, w)] = self.start;
        let late = (causes[1] - causes[0] + causes[15]) / (u - w);
        let x = [(left, u), (right, w)].map(|(x, v)| number(x, v * late));
        let v = [(u, free(0, left)), (w, free(1, right))].map(|(v, a)| number(v, a * late));
        let [x, v] = [(0, x), (1, v)].map(|(k, of)| [0, 1].map(|side| of[side] + number(0.0, causes[2 * k + side])));
        // The motion of the centre of mass, and that of the overlap.
        let total = mass[0] + mass[1];
        let share = mass.map(|mass| mass / total);
        let mean = |of: [Dual; 2]| share[0] * of[0] + share[1] * of[1];
        let across = |of: [Dual; 2]| share[1] * of[0] + share[0] * of[1];
        let differ = |[left, right]: [Dual; 2]| left - right;
        let (reduced, closing, stiffness) = (mass[0] * share[1], differ(v), across(omega2));
        let (centre, speed) = (mean(x), mean(v));
        let (accelerated, most) = (mean(forcing) - mean(omega2) * centre, self.reach);
        // Without what changes: the middle of the impact.
        let rate = closing.value();
        let reach = |closing: Dual| {
            let [sharper, p] = [law.exponent.tangent(), law.exponent.value() + 1.0];
            let relative = |of: Dual| of.tangent() / of.value();
            let squares = relative(reduced) + 2.0 * relative(closing) - relative(law.stiffness) + sharper / p;
            let scale = (1.0 - 2.0 / p) * relative(law.overlap_ref);
            let curved = if sharper == 0.0 { 0.0 } else { sharper * libm::log(most / law.overlap_ref.value()) };
            number(most, most * (scale + (squares - curved) / p))
        };
        let [time, sum] = [0, 1].map(|k| 2.0 * most / rate * self.shape.integrals[k][0]);
        let (until, faster) = (Dual::from(0.5 * time), Dual::from(0.5 * time * accelerated.value()));
        let (speed_there, acceleration) = (Dual::from(speed.value()) + faster, Dual::from(accelerated.value()));
        let centre_there = Dual::from(centre.value()) + until * (Dual::from(speed.value()) + half * faster);
        let load =
            stiffness * clearance - differ(forcing) + differ(omega2) * centre_there + two * differ(gamma) * speed_there;
        let varying = differ(omega2) * speed_there + two * differ(gamma) * acceleration;
        let lost = number(0.0, causes[16]) + two * across(gamma) * Dual::from(2.0 * rate * most * self.shape.works[0])
            - varying * Dual::from(most * sum);
        // The energy left in the middle, and in the end.
        let (there, parting) = (closing - lost / (two * closing), closing - lost / closing);
        let largest = reach(there);
        let part = largest / (there * there);
        let (alpha, beta) = (stiffness * largest * part, two * load * part);
        let [duration, sum] = self.shape.integrals.map(|[value, by_alpha, by_beta, by_exponent]| {
            let change = by_alpha * alpha.tangent() + by_beta * beta.tangent() + by_exponent * law.exponent.tangent();
            two * largest / there * number(value, change)
        });
        let sum = largest * sum;
        // By the functions of the oscillator, and how these change.
        let (u, z) = swing;
        let respond = |k: usize| {
            let by = |of: [f64; 2]| speed.value() * of[0] + accelerated.value() * of[1];
            let before = if k > 0 { u[k - 1] } else { -mean(omega2).value() * u[1] };
            let [direct, later] = [speed.tangent() * u[k] + accelerated.tangent() * u[k + 1], by([before, u[k]])];
            let [by_decay, by_frequency] = [-2.0 * by([z[k], z[k + 1]]), -by([z[k + 1], z[k + 2]])];
            let varied = by_decay * mean(gamma).tangent() + by_frequency * mean(omega2).tangent();
            number(by([u[k], u[k + 1]]), direct + later * duration.tangent() + varied)
        };
        let mixed = share[0] * share[1] * differ(omega2) * (sum + clearance * duration);
        let drawn = two * share[0] * share[1] * differ(gamma) * sum;
        let (moved, speed) = (respond(1) - half * mixed * duration - drawn, respond(0) - mixed);
        let after = [speed - share[1] * parting, speed + share[0] * parting];
        let impulse = reduced * (closing + parting - load * duration - stiffness * sum);
        let peak = self.largest.map_or(0.0, |overlap| {
            // The energy in the middle, less that of the closing balls, is 0.
            let energy = |overlap: Dual| {
                let of_law = law.elastic_energy(overlap) / reduced;
                overlap * (load + half * stiffness * overlap) + of_law - half * there * there
            };
            let (change, slope) = (energy(overlap.into()).tangent(), load + stiffness * overlap.into());
            let slope = slope + law.elastic_force(overlap.into()) / reduced;
            law.elastic_force(number(overlap, -change / slope.value())).tangent()
        });
        let later = late + duration.tangent();
        let place = |side: usize| x[side].tangent() + moved.tangent() - after[side].value() * later;
        let velocity = |side: usize| after[side].tangent() - free(side, (x[side] + moved).value()) * later;
        [place(0), place(1), velocity(0), velocity(1), impulse.tangent(), peak]
    }
}

impl Part for ImpactPart {
    fn numbers(&self) -> usize {
        24
    }

    fn forward(&self, cradle: &Cradle, changes: &Coefficients, state: &mut [f64]) {
        let (j, pair, mut causes) = (self.contact, cradle.pair(self.contact), [0.0; 17]);
        let swing = self.swing(&pair);
        for (side, model) in pair.balls.into_iter().enumerate() {
            let (i, mass) = (j + side, changes.of_ball(j + side)[MASS]);
            let [gamma, frequency, forcing] = changes.of_motion(i, model);
            let forcing = forcing - self.push[side] / model.mass * mass;
            let own = [state[i * STATE + X], state[i * STATE + V], mass, gamma, frequency, forcing];
            own.iter().enumerate().for_each(|(k, change)| causes[2 * k + side] = *change);
        }
        let (law, losses) = changes.of_law(j).split_at(3);
        causes[12..15].copy_from_slice(law);
        causes[15] = changes.of_ball(j)[CLEARANCE];
        causes[16] = self.losses(&pair).iter().zip(losses).map(|(by, change)| by * change).sum();
        let effects = self.effects(&pair, &swing, &causes);
        for side in 0..2 {
            let state = &mut state[(j + side) * STATE..];
            (state[X], state[V]) = (effects[side], effects[2 + side]);
        }
        state[j * STATE + IMPULSE] += effects[4];
        if self.largest.is_some() {
            state[j * STATE + PEAK] = effects[5];
        }
    }

    fn backward(&self, cradle: &Cradle, by_changes: &mut Coefficients, by_state: &mut [f64]) {
        let (j, pair) = (self.contact, cradle.pair(self.contact));
        let swing = self.swing(&pair);
        let by_effects = [X, V].map(|number| [j, j + 1].map(|i| by_state[i * STATE + number]));
        let of_contact = [by_state[j * STATE + IMPULSE], by_state[j * STATE + PEAK]];
        let by: Causes = std::array::from_fn(|cause| {
            let mut causes = [0.0; 17];
            causes[cause] = 1.0;
            let effects = self.effects(&pair, &swing, &causes);
            by_effects.iter().flatten().chain(&of_contact).zip(effects).map(|(by, effect)| by * effect).sum()
        });
        if self.largest.is_some() {
            by_state[j * STATE + PEAK] = 0.0;
        }
        for (side, model) in pair.balls.into_iter().enumerate() {
            let ([x, v, mass, motion @ ..], i): ([f64; 6], usize) =
                (std::array::from_fn(|k| by[2 * k + side]), j + side);
            (by_state[i * STATE + X], by_state[i * STATE + V]) = (x, v);
            by_changes.of_ball_mut(i)[MASS] += mass - motion[2] * self.push[side] / model.mass;
            by_changes.add_of_motion(i, model, motion);
        }
        by_changes.of_ball_mut(j)[CLEARANCE] += by[15];
        let (law, losses) = by_changes.of_law_mut(j).split_at_mut(3);
        law.iter_mut().zip(&by[12..15]).for_each(|(sum, by)| *sum += by);
        losses.iter_mut().zip(self.losses(&pair)).for_each(|(sum, loss)| *sum += loss * by[16]);
    }
}
