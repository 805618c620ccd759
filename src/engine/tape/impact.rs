//! Elastic impacts of two balls on a line, linearised in closed form, each at its own time.
//!
//! To first order, a force that is odd in time about the middle of the impact takes energy, half of it before the
//! middle; the duration is that of an impact with the energy left in the middle. A force that is even in time adds to
//! the load. Forces that vary with the common motion are taken as linear in time. The error is of the order of
//! `(omega T)^2` times the effect of different pendulums or drags within the time T of the impact ([`SHORT`]).

use super::coefficients::{CLEARANCE, Coefficients, IMPULSE, MASS, PEAK, STATE, V, X};
use super::part::Part;
use crate::engine::pair_impact::{ImpactCoefficients, PulseShape};
use crate::model::{BallModel, Cradle, Pair};
use crate::solver::power::power;
use crate::solver::{BASIS, MAX_FORCE_ORDER, Oscillator};

/// Changes of what an impact depends on. Of the left and of the right ball: position, velocity, mass, decay rate,
/// square of the frequency, and acceleration by the inputs. Of the contact: stiffness, reference overlap, exponent and
/// clearance. And the energy lost over the reduced mass (m2/s2).
type Causes = [f64; 17];

/// Changes of positions and velocities of the left and the right ball, of impulse and of largest force.
type Effects = [f64; 6];

/// An impact in contact `contact`.
#[derive(Debug)]
pub(super) struct ImpactPart {
    pub contact: usize,
    /// Position (m) and velocity (m/s) of its balls at the onset; their accelerations by the inputs, and the part of
    /// these by the external forces, m/s2.
    pub start: [(f64, f64); 2],
    pub forcing: [f64; 2],
    pub external: [f64; 2],
    pub shape: PulseShape,
    /// The largest overlap of the impact without pendulums and inputs, m.
    pub reach: f64,
    /// The largest overlap, m, if its force exceeds all before it in the step.
    pub largest: Option<f64>,
}

/// Values of an impact: rate at the onset (m/s); total mass (kg), shares of it and reduced mass (kg); load on the
/// overlap (m/s2); duration (s) and integral of the overlap (m.s); position (m), velocity (m/s) and acceleration (m/s2)
/// of the centre of mass at the onset, position and velocity in the middle; the functions of the oscillator at the end.
struct ImpactValues {
    rate: f64,
    total: f64,
    share: [f64; 2],
    reduced: f64,
    load: f64,
    time: f64,
    sum: f64,
    motion: [f64; 3],
    middle: [f64; 2],
    u: [f64; BASIS],
    z: [f64; MAX_FORCE_ORDER + 4],
}

/// Largest square of the part of a swing (rad) that an impact takes. If changes of drag and pendulum differ between the
/// two balls, the error is up to 70 times this, relative to their effect within the impact, itself a small part of
/// their effect in a swing. With a tenth of it, the tapes of long runs of Hertz contacts take twice the time.
const SHORT: f64 = 1e-7;

impl ImpactPart {
    /// The shape and the reach of an impact of balls in these states; `None` if it lasts too long.
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
        let swing = ball.omega2 * part * part;
        if swing > SHORT {
            return None;
        }
        let shape = coefficients.pulse(law, swing, 2.0 * load * part / rate)?;
        Some((shape, reach))
    }

    /// The energy that an impact loses over the reduced mass (m2/s2), for a unit of the damping coefficient.
    fn loss(&self, pair: &Pair) -> f64 {
        let Pair { balls: [left, right], law } = pair;
        let (rate, reduced) = (self.start[0].1 - self.start[1].1, left.mass * right.mass / (left.mass + right.mass));
        let grown = power(self.reach / law.overlap_ref, law.damping_exponent());
        2.0 * rate * self.reach * grown * self.shape.works[1] / reduced
    }

    /// The values from which its map is built.
    fn values(&self, pair: &Pair) -> ImpactValues {
        let Pair { balls: [left, right], law } = pair;
        let [(x, u), (y, w)] = self.start;
        let (total, rate) = (left.mass + right.mass, u - w);
        let share = [left.mass / total, right.mass / total];
        let [time, sum] = self.shape.integrals.map(|[integral, ..]| 2.0 * self.reach / rate * integral);
        let o = Oscillator::new(left.omega2, 0.0);
        let u_k = o.basis(time.into());
        let (centre, speed) = (share[0] * x + share[1] * y, share[0] * u + share[1] * w);
        let a = share[0] * self.forcing[0] + share[1] * self.forcing[1] - left.omega2 * centre;
        let until = 0.5 * time;
        ImpactValues {
            rate,
            total,
            share,
            reduced: left.mass * share[1],
            load: left.omega2 * law.clearance - self.forcing[0] + self.forcing[1],
            time,
            sum: self.reach * sum,
            motion: [centre, speed, a],
            middle: [centre + until * (speed + 0.5 * until * a), speed + until * a],
            z: o.sensitivities(time, &u_k),
            u: u_k,
        }
    }

    /// Changes of the state after the impact, at the common time, by the `values` of its map.
    fn effects(&self, pair: &Pair, values: &ImpactValues, causes: &Causes) -> Effects {
        let (Pair { balls: [BallModel { omega2, .. }, _], law }, reach) = (pair, self.reach);
        let ImpactValues { rate, total, share: [l, r], reduced, load, time, sum, .. } = *values;
        let ([centre, speed, a], [centre_there, speed_there]) = (values.motion, values.middle);
        let of_balls = |k: usize| [causes[2 * k], causes[2 * k + 1]];
        let [x, v, mass, gamma, frequency, forcing] = std::array::from_fn(of_balls);
        let [stiffness, overlap_ref, p, clearance, taken] = std::array::from_fn(|k| causes[12 + k]);
        // The onset is later by `late`.
        let free = |side: usize, x: f64| self.forcing[side] - omega2 * x;
        let late = (x[1] - x[0] + clearance) / rate;
        let x = [0, 1].map(|side| x[side] + self.start[side].1 * late);
        let v = [0, 1].map(|side| v[side] + free(side, self.start[side].0) * late);
        // Changes of the motion of the centre of mass, of the overlap, and of their coupling.
        let more = (r * mass[0] - l * mass[1]) / total;
        let mean = |of: [f64; 2]| l * of[0] + r * of[1];
        let across = |of: [f64; 2]| r * of[0] + l * of[1];
        let differ = |[left, right]: [f64; 2]| left - right;
        let (heavier, closing) = (r * r * mass[0] + l * l * mass[1], differ(v));
        let faster = mean(v) + more * rate;
        let pushed = mean(forcing) + more * differ(self.forcing);
        let accelerated =
            pushed - mean(frequency) * centre - omega2 * (mean(x) + more * differ([self.start[0].0, self.start[1].0]));
        let (coupled, dragged) = (differ(frequency), 2.0 * differ(gamma));
        let loaded = across(frequency) * law.clearance + omega2 * clearance - differ(forcing)
            + coupled * centre_there
            + dragged * speed_there;
        let lost = taken + 4.0 * across(gamma) * rate * reach * self.shape.works[0]
            - (coupled * speed_there + dragged * a) * sum;
        // Changes of the rates from the energy left in the middle and at the end.
        let (there, parting) = (closing - 0.5 * lost / rate, closing - lost / rate);
        let quicker = there / rate;
        let firmer = stiffness / law.stiffness + (1.0 - law.exponent) * overlap_ref / law.overlap_ref;
        let power = law.exponent + 1.0;
        let sharper = |overlap: f64| if p == 0.0 { 0.0 } else { p * libm::log(overlap / law.overlap_ref) };
        let farther = (heavier / reduced + 2.0 * quicker - firmer + p / power - sharper(reach)) / power;
        let part = reach / rate;
        let alpha = part * part * (across(frequency) + 2.0 * omega2 * (farther - quicker));
        let beta = 2.0 * part / rate * (loaded + load * (farther - 2.0 * quicker));
        let [longer, larger] = self.shape.integrals.map(|[value, by_alpha, by_beta, by_exponent]| {
            2.0 * part * (value * (farther - quicker) + by_alpha * alpha + by_beta * beta + by_exponent * p)
        });
        let larger = reach * larger + farther * sum;
        // The centre of mass at the end, by the functions of the oscillator and their changes.
        let (u, z) = (&values.u, &values.z);
        let respond = |k: usize| {
            let by = |of: [f64; 2]| speed * of[0] + a * of[1];
            let later = by([if k > 0 { u[k - 1] } else { -omega2 * u[1] }, u[k]]);
            let varied = -2.0 * by([z[k], z[k + 1]]) * mean(gamma) - by([z[k + 1], z[k + 2]]) * mean(frequency);
            faster * u[k] + accelerated * u[k + 1] + later * longer + varied
        };
        let mixed = l * r * coupled * (sum + law.clearance * time);
        let moved = respond(1) - 0.5 * mixed * time - l * r * dragged * sum;
        let common = respond(0) - mixed + more * rate;
        let after = [common - r * parting, common + l * parting];
        let impulse = heavier * (2.0 * rate - load * time - omega2 * sum)
            + reduced * (closing + parting - loaded * time - load * longer - across(frequency) * sum - omega2 * larger);
        let peak = self.largest.map_or(0.0, |overlap| {
            // The energy in the middle is that of the closing balls.
            let (force, firmer) = (law.elastic_force(overlap), firmer + sharper(overlap));
            let of_law = force * overlap / power * (firmer - p / power - heavier / reduced) / reduced;
            let energy = overlap * (loaded + 0.5 * across(frequency) * overlap) + of_law - rate * there;
            let wider = -energy / (load + omega2 * overlap + force / reduced);
            force * (firmer + law.exponent * wider / overlap)
        });
        // Back at the common time, which is earlier.
        let (later, [ends, speed]) = (late + longer, [1, 0].map(|k| speed * u[k] + a * u[k + 1]));
        let place = |side: usize| {
            let v = speed + if side == 0 { -r * rate } else { l * rate };
            x[side] + moved - v * later
        };
        let velocity = |side: usize| after[side] - free(side, self.start[side].0 + ends) * later;
        [place(0), place(1), velocity(0), velocity(1), impulse, peak]
    }
}

impl Part for ImpactPart {
    fn numbers(&self) -> usize {
        24
    }

    fn forward(&self, cradle: &Cradle, changes: &Coefficients, state: &mut [f64]) {
        let (j, pair, mut causes) = (self.contact, cradle.pair(self.contact), [0.0; 17]);
        let values = self.values(&pair);
        for (side, model) in pair.balls.into_iter().enumerate() {
            let (i, mass) = (j + side, changes.of_ball(j + side)[MASS]);
            let [gamma, frequency, forcing] = changes.of_motion(i, model);
            let forcing = forcing - self.external[side] / model.mass * mass;
            let own = [state[i * STATE + X], state[i * STATE + V], mass, gamma, frequency, forcing];
            own.iter().enumerate().for_each(|(k, change)| causes[2 * k + side] = *change);
        }
        let [law @ .., damping] = changes.of_law(j);
        causes[12..15].copy_from_slice(law);
        causes[15] = changes.of_ball(j)[CLEARANCE];
        causes[16] = self.loss(&pair) * damping;
        let effects = self.effects(&pair, &values, &causes);
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
        let values = self.values(&pair);
        let by_effects = [X, V].map(|number| [j, j + 1].map(|i| by_state[i * STATE + number]));
        let of_contact = [by_state[j * STATE + IMPULSE], by_state[j * STATE + PEAK]];
        let by: Causes = std::array::from_fn(|cause| {
            let mut causes = [0.0; 17];
            causes[cause] = 1.0;
            let effects = self.effects(&pair, &values, &causes);
            by_effects.iter().flatten().chain(&of_contact).zip(effects).map(|(by, effect)| by * effect).sum()
        });
        if self.largest.is_some() {
            by_state[j * STATE + PEAK] = 0.0;
        }
        for (side, model) in pair.balls.into_iter().enumerate() {
            let ([x, v, mass, motion @ ..], i): ([f64; 6], usize) =
                (std::array::from_fn(|k| by[2 * k + side]), j + side);
            (by_state[i * STATE + X], by_state[i * STATE + V]) = (x, v);
            by_changes.of_ball_mut(i)[MASS] += mass - motion[2] * self.external[side] / model.mass;
            by_changes.add_of_motion(i, model, motion);
        }
        by_changes.of_ball_mut(j)[CLEARANCE] += by[15];
        let [law @ .., damping] = by_changes.of_law_mut(j);
        law.iter_mut().zip(&by[12..15]).for_each(|(sum, by)| *sum += by);
        *damping += self.loss(&pair) * by[16];
    }
}
