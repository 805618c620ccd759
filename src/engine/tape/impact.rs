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

impl ImpactValues {
    /// The mean by the masses of values of both balls.
    fn mean(&self, [left, right]: [f64; 2]) -> f64 {
        self.share[0] * left + self.share[1] * right
    }

    /// Their mean with each other's masses, by which they act on the overlap.
    fn across(&self, [left, right]: [f64; 2]) -> f64 {
        self.share[1] * left + self.share[0] * right
    }
}

/// Left less right.
fn difference([left, right]: [f64; 2]) -> f64 {
    left - right
}

/// Changes at the onset.
struct OnsetChanges {
    /// How much later the onset is, s; of the left and of the right ball: position (m), velocity (m/s), decay rate
    /// (1/s), square of the frequency (1/s2), acceleration by the inputs (m/s2).
    delay: f64,
    x: [f64; 2],
    v: [f64; 2],
    gamma: [f64; 2],
    frequency: [f64; 2],
    forcing: [f64; 2],
    /// Share of the left ball in the mass, and reduced mass, kg.
    share: f64,
    reduced: f64,
    /// Of the force at a given overlap, relative, other than by the exponent.
    relative_stiffness: f64,
    /// The reference overlap itself, m; changes of the exponent and of the clearance (m).
    overlap_ref: f64,
    exponent: f64,
    clearance: f64,
    /// Energy lost over the reduced mass, m2/s2.
    taken: f64,
}

impl OnsetChanges {
    /// The relative change of the force at this overlap (m) by the exponent.
    fn of_power(&self, overlap: f64) -> f64 {
        if self.exponent == 0.0 { 0.0 } else { self.exponent * libm::log(overlap / self.overlap_ref) }
    }

    /// By how much the motion of the centre of mass acts on the overlap, through different pendulums (1/s2) and drag
    /// (1/s).
    fn coupled(&self) -> f64 {
        difference(self.frequency)
    }

    fn dragged(&self) -> f64 {
        2.0 * difference(self.gamma)
    }
}

/// Changes of the motion of the overlap: of its rate at the onset, in the middle and at the end (m/s); of the load
/// (m/s2), the duration (s) and the integral of the overlap (m.s).
struct OverlapChanges {
    closing: f64,
    there: f64,
    parting: f64,
    load: f64,
    time: f64,
    sum: f64,
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

    /// Acceleration without contact of one ball at the place `x`, m/s2.
    fn free(&self, pair: &Pair, side: usize, x: f64) -> f64 {
        self.forcing[side] - pair.balls[0].omega2 * x
    }

    /// The causes with positions and velocities at the onset.
    fn at_onset(&self, pair: &Pair, values: &ImpactValues, causes: &Causes) -> OnsetChanges {
        let of_balls = |k: usize| [causes[2 * k], causes[2 * k + 1]];
        let [x, v, mass, gamma, frequency, forcing] = std::array::from_fn(of_balls);
        let [stiffness, overlap_ref, exponent, clearance, taken] = std::array::from_fn(|k| causes[12 + k]);
        let ImpactValues { rate, total, share: [l, r], .. } = *values;
        let delay = (x[1] - x[0] + clearance) / rate;
        OnsetChanges {
            delay,
            x: [0, 1].map(|side| x[side] + self.start[side].1 * delay),
            v: [0, 1].map(|side| v[side] + self.free(pair, side, self.start[side].0) * delay),
            gamma,
            frequency,
            forcing,
            share: (r * mass[0] - l * mass[1]) / total,
            reduced: r * r * mass[0] + l * l * mass[1],
            relative_stiffness: stiffness / pair.law.stiffness
                + (1.0 - pair.law.exponent) * overlap_ref / pair.law.overlap_ref,
            overlap_ref: pair.law.overlap_ref,
            exponent,
            clearance,
            taken,
        }
    }

    /// Changes of the motion of the overlap.
    fn overlap_changes(&self, pair: &Pair, values: &ImpactValues, by: &OnsetChanges) -> OverlapChanges {
        let (Pair { balls: [BallModel { omega2, .. }, _], law }, reach) = (pair, self.reach);
        let ImpactValues { rate, reduced, load, sum, motion: [.., a], middle: [centre_there, speed_there], .. } =
            *values;
        let (closing, coupled, dragged, p) = (difference(by.v), by.coupled(), by.dragged(), by.exponent);
        let (drag, frequency) = (values.across(by.gamma), values.across(by.frequency));
        let load_change = frequency * law.clearance + omega2 * by.clearance - difference(by.forcing)
            + coupled * centre_there
            + dragged * speed_there;
        let lost =
            by.taken + 4.0 * drag * rate * reach * self.shape.works[0] - (coupled * speed_there + dragged * a) * sum;
        // From the energy left in the middle and at the end.
        let (there, parting) = (closing - 0.5 * lost / rate, closing - lost / rate);
        let (relative_rate, power) = (there / rate, law.exponent + 1.0);
        let relative_reach = (by.reduced / reduced + 2.0 * relative_rate - by.relative_stiffness + p / power
            - by.of_power(reach))
            / power;
        let part = reach / rate;
        let alpha = part * part * (frequency + 2.0 * omega2 * (relative_reach - relative_rate));
        let beta = 2.0 * part / rate * (load_change + load * (relative_reach - 2.0 * relative_rate));
        let [time, sum_over_reach] = self.shape.integrals.map(|[value, by_alpha, by_beta, by_exponent]| {
            2.0 * part
                * (value * (relative_reach - relative_rate) + by_alpha * alpha + by_beta * beta + by_exponent * p)
        });
        let sum = reach * sum_over_reach + relative_reach * sum;
        OverlapChanges { closing, there, parting, load: load_change, time, sum }
    }

    /// Changes of the displacement (m) and of the velocity (m/s) of the centre of mass at the end, by the functions of
    /// the oscillator and their changes. The velocity includes that by the change of the shares of the mass.
    fn centre_changes(&self, pair: &Pair, values: &ImpactValues, by: &OnsetChanges, time_change: f64) -> [f64; 2] {
        let (omega2, clearance) = (pair.balls[0].omega2, pair.law.clearance);
        let ImpactValues { rate, share: [l, r], time, sum, motion: [centre, speed, a], u, z, .. } = values;
        let mean = |of: [f64; 2]| values.mean(of);
        let speed_change = mean(by.v) + by.share * rate;
        let forcing = mean(by.forcing) + by.share * difference(self.forcing);
        let position = mean(by.x) + by.share * difference([self.start[0].0, self.start[1].0]);
        let acceleration_change = forcing - mean(by.frequency) * centre - omega2 * position;
        let respond = |k: usize| {
            let sum = |of: [f64; 2]| speed * of[0] + a * of[1];
            let later = sum([if k > 0 { u[k - 1] } else { -omega2 * u[1] }, u[k]]);
            let varied = -2.0 * sum([z[k], z[k + 1]]) * mean(by.gamma) - sum([z[k + 1], z[k + 2]]) * mean(by.frequency);
            speed_change * u[k] + acceleration_change * u[k + 1] + later * time_change + varied
        };
        let mixed = l * r * by.coupled() * (sum + clearance * time);
        let displacement = respond(1) - 0.5 * mixed * time - l * r * by.dragged() * sum;
        [displacement, respond(0) - mixed + by.share * rate]
    }

    /// Change of the largest force; 0 if it is not wanted.
    fn peak_change(&self, pair: &Pair, values: &ImpactValues, by: &OnsetChanges, overlap_by: &OverlapChanges) -> f64 {
        let (Pair { balls: [BallModel { omega2, .. }, _], law }, reduced) = (pair, values.reduced);
        self.largest.map_or(0.0, |overlap| {
            // The energy in the middle is that of the closing balls.
            let (force, power) = (law.elastic_force(overlap), law.exponent + 1.0);
            let relative_force = by.relative_stiffness + by.of_power(overlap);
            let of_law =
                force * overlap / power * (relative_force - by.exponent / power - by.reduced / reduced) / reduced;
            let energy = overlap * (overlap_by.load + 0.5 * values.across(by.frequency) * overlap) + of_law
                - values.rate * overlap_by.there;
            let overlap_change = -energy / (values.load + omega2 * overlap + force / reduced);
            force * (relative_force + law.exponent * overlap_change / overlap)
        })
    }

    /// Changes of the state after the impact, at the common time, by the `values` of its map.
    fn effects(&self, pair: &Pair, values: &ImpactValues, causes: &Causes) -> Effects {
        let omega2 = pair.balls[0].omega2;
        let ImpactValues { rate, share: [l, r], reduced, load, time, sum, motion: [_, speed, a], u, .. } = values;
        let by = self.at_onset(pair, values, causes);
        let overlap_by = self.overlap_changes(pair, values, &by);
        let OverlapChanges { closing, parting, load: load_change, time: longer, sum: sum_change, .. } = overlap_by;
        let [moved, common] = self.centre_changes(pair, values, &by, longer);
        let after = [common - r * parting, common + l * parting];
        let impulse = by.reduced * (2.0 * rate - load * time - omega2 * sum)
            + reduced
                * (closing + parting
                    - load_change * time
                    - load * longer
                    - values.across(by.frequency) * sum
                    - omega2 * sum_change);
        let peak = self.peak_change(pair, values, &by, &overlap_by);
        // Back at the common time, which is earlier.
        let (later, [ends, speed]) = (by.delay + longer, [1, 0].map(|k| speed * u[k] + a * u[k + 1]));
        let place = |side: usize| {
            let v = speed + if side == 0 { -r * rate } else { l * rate };
            by.x[side] + moved - v * later
        };
        let velocity = |side: usize| after[side] - self.free(pair, side, self.start[side].0 + ends) * later;
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
