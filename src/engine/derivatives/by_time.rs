//! Derivatives of the outputs by time.

use crate::engine::HeldInputs;
use crate::engine::chain_state::ChainState;
use crate::engine::cluster::{INVERSE_FACTORIAL, Series};
use crate::engine::flight::{Flight, shifted};
use crate::engine::run::{Engine, Interaction, SegmentAt};
use crate::model::{Cradle, Differential, MAX_OUTPUT_DERIVATIVE, Mode};
use crate::solver::series::{of_derivatives, product_term};

impl Engine {
    /// Time derivatives of the outputs at the current time, of order 1 to [`MAX_OUTPUT_DERIVATIVE`], from the right; 0
    /// for outputs that change only at events and communication points.
    ///
    /// They are derivatives of the computed motion. For forces of contacts at rest, the second derivative keeps 7
    /// digits and the third 4 or 5. A contact that has just closed, or whose inputs have just changed, rings by 1e-12
    /// of its force from rounding; each derivative multiplies that by the angular frequency.
    pub fn time_derivative(&self, order: usize) -> Differential {
        let inputs = self.inputs.at(self.time);
        let state = self.state_of_all(self.time.into()).under(inputs.forcings(&self.cradle));
        let series =
            if self.interactions.iter().flatten().any(|interaction| matches!(interaction, Interaction::Body(_))) {
                self.series_of_bodies(&state)
            } else {
                let given = |i: usize| {
                    let SegmentAt { cluster, tau, .. } = self.segment_of_contact(i, self.time.into())?;
                    (cluster.mode(i) == Mode::Pressing).then(|| cluster.overlap_series(i, tau)).flatten()
                };
                state.series(&self.cradle, &(0..self.contacts.len()).map(given).collect::<Vec<_>>())
            };
        of_series(&self.cradle, &state, &inputs, &series, order)
    }

    /// The series of rigid balls, with the constraint forces between those that move as one body.
    fn series_of_bodies(&self, state: &ChainState) -> Series {
        let (mut bodies, mut apart) = (self.cradle.clone(), state.clone());
        apart.contacts.iter_mut().for_each(|contact| contact.mode = Mode::Open);
        for (i, ball) in self.balls.iter().enumerate().filter(|(i, _)| self.is_in_body(*i)) {
            (bodies.balls[i].omega2, bodies.balls[i].gamma) = (ball.oscillator.omega2(), ball.oscillator.gamma());
            apart.flights[i].forcing = shifted(&ball.flight.forcing, self.time - ball.anchor.value());
        }
        let mut series = apart.series(&bodies, &[]);
        for j in 0..self.contacts.len() {
            if let Some(constraint) = self.constraint(j) {
                series.set_forces(j, &[], &constraint.series(self.time.into()));
            }
        }
        series
    }
}

/// [`Engine::time_derivative`] for a chain in this state under these inputs.
pub(crate) fn by_time(cradle: &Cradle, state: ChainState, inputs: &HeldInputs, order: usize) -> Differential {
    let state = state.under(inputs.forcings(cradle));
    of_series(cradle, &state, inputs, &state.series(cradle, &[]), order)
}

/// The time derivatives of the outputs from the series of all motions and forces.
///
/// Energy and momentum are taken from their balances, `E' = sum F_ext v - a_support p - P_dissipated` and
/// `p' = sum F_ext - a_support sum m - F_support`: as sums of derivatives, large terms would cancel in a contact. Where
/// an overlap vanishes under a fractional exponent, its elastic force counts as 0 with all its derivatives.
fn of_series(cradle: &Cradle, state: &ChainState, inputs: &HeldInputs, series: &Series, order: usize) -> Differential {
    let factorial = |k: usize| (1..=k).map(|i| i as f64).product::<f64>();
    let (of_order, of_rate, last) = (factorial(order), factorial(order - 1), order - 1);
    let [support, vertical] = match cradle.on_arcs() {
        true => support_along_arcs(cradle, state, series),
        false => [support_series(cradle, state, series), [0.0; MAX_OUTPUT_DERIVATIVE + 1]],
    };
    let mut rates = Differential::all(cradle.balls.len(), 0.0);
    let mut momentum = [0.0; MAX_OUTPUT_DERIVATIVE + 1];
    for (i, (ball, Flight { x: start, forcing, .. })) in cradle.balls.iter().zip(&state.flights).enumerate() {
        let path = series.displacement(i);
        let ([x, y], along) = (series.places(i, ball, *start), series.rate(path));
        let v = series.rate(&x);
        (rates.x[i], rates.v[i]) = (of_order * x[order], of_order * v[order]);
        (rates.angle[i], rates.y[i]) = (of_order * path[order] / ball.length, of_order * y[order]);
        momentum[0] += ball.mass * v[0];
        for k in 0..order {
            momentum[k + 1] += ball.mass * forcing[k] / factorial(k + 1);
        }
        let force = inputs.series(|inputs| inputs.force[i]);
        rates.total_energy += of_rate
            * (product_term(&force, &v, last) - 2.0 * ball.gamma * ball.mass * product_term(&along, &along, last));
    }
    for k in 0..order {
        momentum[k + 1] -= support[k] / (k + 1) as f64;
    }
    (rates.momentum, rates.support_force) = (of_order * momentum[order], of_order * support[order]);
    rates.support_force_vertical = of_order * vertical[order];
    rates.total_energy -= of_rate * product_term(&inputs.series(|inputs| inputs.support_acceleration), &momentum, last);
    for (j, contact) in state.contacts.iter().enumerate() {
        let acts = if contact.mode == Mode::Pressing { 1.0 } else { 0.0 };
        let force: Vec<f64> = series.force_row(j).iter().map(|f| acts * f).collect();
        (rates.force[j], rates.impulse[j]) = (of_order * force[order], of_rate * force[last]);
        let excess: Vec<f64> = force.iter().zip(series.elastic_row(j)).map(|(f, e)| f - e).collect();
        rates.total_energy -= of_rate * product_term(&excess, &series.rate(series.overlap_row(j)), last);
    }
    rates
}

/// Coefficients of the force on the support, `sum m (omega2 x + 2 gamma v)`. Contact forces change it only as far as
/// pendulums differ, so their parts are summed contact by contact, where they cancel exactly.
fn support_series(cradle: &Cradle, state: &ChainState, series: &Series) -> [f64; MAX_OUTPUT_DERIVATIVE + 1] {
    let mut support = [0.0; MAX_OUTPUT_DERIVATIVE + 1];
    // Adds coefficients of accelerations times mass, with the factors omega2 and gamma.
    let mut add = |omega2: f64, gamma: f64, accelerations: &[f64]| {
        for (k, a) in accelerations.iter().enumerate() {
            let next = (k + 1) as f64;
            if let Some(support) = support.get_mut(k + 1) {
                *support += 2.0 * gamma * a / next;
            }
            if let Some(support) = support.get_mut(k + 2) {
                *support += omega2 * a / (next * (next + 1.0));
            }
        }
    };
    for (j, pair) in cradle.balls.windows(2).enumerate().filter(|(j, _)| state.contacts[*j].mode == Mode::Pressing) {
        add(pair[1].omega2 - pair[0].omega2, pair[1].gamma - pair[0].gamma, series.force_row(j));
    }
    let mut at_once = [0.0; 2];
    for (i, (ball, Flight { x: start, forcing, .. })) in cradle.balls.iter().zip(&state.flights).enumerate() {
        let (mut x, forcing) = (series.displacement(i).to_vec(), of_derivatives(*forcing));
        let v = series.rate(&x);
        x[0] = *start;
        let without_contacts = |k: usize| ball.mass * (forcing[k] - ball.omega2 * x[k] - 2.0 * ball.gamma * v[k]);
        let accelerations: Vec<f64> = (0..forcing.len()).map(without_contacts).collect();
        add(ball.omega2, ball.gamma, &accelerations);
        at_once[0] += ball.mass * (ball.omega2 * x[0] + 2.0 * ball.gamma * v[0]);
        at_once[1] += ball.mass * ball.omega2 * v[0];
    }
    support[0] += at_once[0];
    support[1] += at_once[1];
    support
}

/// Coefficients of the horizontal and the vertical force of balls on arcs on the support, by the tensions and the drag.
fn support_along_arcs(cradle: &Cradle, state: &ChainState, series: &Series) -> [[f64; MAX_OUTPUT_DERIVATIVE + 1]; 2] {
    let mut support = [[0.0; MAX_OUTPUT_DERIVATIVE + 1]; 2];
    for (i, (ball, Flight { forcing, .. })) in cradle.balls.iter().zip(&state.flights).enumerate() {
        let ([sin, cos], u) = (series.directions(i), series.rate(series.displacement(i)));
        let forcing: Vec<f64> = (0..forcing.len()).map(|k| forcing[k] * INVERSE_FACTORIAL[k]).collect();
        let mut tensions: Vec<f64> = (0..=MAX_OUTPUT_DERIVATIVE)
            .map(|k| {
                let round = product_term(&u, &u, k) / ball.length + ball.gravity * cos[k];
                ball.mass * (round + product_term(&forcing, sin, k))
            })
            .collect();
        for (j, sign) in [(i.wrapping_sub(1), 1.0), (i, -1.0)] {
            if state.contacts.get(j).is_some_and(|contact| contact.mode == Mode::Pressing) {
                let outward = series.outward(j, i);
                let add_outward =
                    |(k, tension): (usize, &mut f64)| *tension += sign * product_term(series.force_row(j), &outward, k);
                tensions.iter_mut().enumerate().for_each(add_outward);
            }
        }
        let drag: Vec<f64> = u.iter().map(|u| 2.0 * ball.gamma * ball.mass * u).collect();
        (0..=MAX_OUTPUT_DERIVATIVE).for_each(|k| {
            support[0][k] += product_term(&tensions, sin, k) + product_term(&drag, cos, k);
            support[1][k] += product_term(&drag, sin, k) - product_term(&tensions, cos, k);
        });
    }
    support
}
