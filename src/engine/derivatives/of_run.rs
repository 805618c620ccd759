//! Derivatives of the outputs of an event-driven run.

use super::by_time::{by_time, of_series};
use super::chain_state::ChainEquations;
use super::last_step::LastStep;
use crate::engine::cluster::Series;
use crate::engine::flight::{Regime, shifted};
use crate::engine::run::Engine;
use crate::model::{Differential, MAX_OUTPUT_DERIVATIVE, Mode};

impl Engine {
    /// Derivatives of the outputs by time at the current time, of order 1 to [`MAX_OUTPUT_DERIVATIVE`], from the right.
    /// What changes only at events and communication points has derivative 0.
    ///
    /// They are those of the motion as it is followed. Of the forces of contacts that have come to rest, the second
    /// keep 7 digits and the third 4 or 5. A contact that rings, by 1e-12 of its force from rounding alone where it has
    /// just closed or the inputs have just changed, rings in its derivatives, too, times the angular frequency for each
    /// order.
    pub fn time_derivative(&self, order: usize) -> Differential {
        let (state, inputs) = (self.state_of_all(self.time.into()), self.inputs.at(self.time));
        if self.contacts.iter().all(|contact| contact.constraint().is_none()) {
            let pressed: Vec<_> = (0..self.contacts.len()).map(|i| self.pressed_series(i)).collect();
            return by_time(&self.cradle, &state, &inputs, &pressed, order);
        }
        let chain = ChainEquations { cradle: &self.cradle, state: &state, forcings: &inputs.forcings(&self.cradle) };
        of_series(&chain, &inputs, &self.series_of_bodies(&chain), order)
    }

    /// The series of rigid balls from `state` on, some of which move as one body: as such, and with the forces that
    /// this takes.
    fn series_of_bodies(&self, chain: &ChainEquations<f64>) -> Series {
        let (mut bodies, mut apart, mut common) = (self.cradle.clone(), chain.state.clone(), chain.forcings.to_vec());
        apart.modes.fill(Mode::Open);
        for (i, ball) in self.balls.iter().enumerate().filter(|(_, ball)| ball.regime == Regime::Body) {
            (bodies.balls[i].omega2, bodies.balls[i].gamma) = (ball.oscillator.omega2(), ball.oscillator.gamma());
            common[i] = shifted(&ball.flight.forcing, self.time - ball.anchor.value());
        }
        let equations = ChainEquations { cradle: &bodies, state: &apart, forcings: &common };
        let mut series = equations.series(MAX_OUTPUT_DERIVATIVE + 1, 1.0, |_| false, &[]);
        // The motions as they are, and as forces in the contacts that press what they need beside gravity, drag and
        // inputs.
        let ChainEquations { state, forcings, .. } = chain;
        for (j, mode) in state.modes.iter().enumerate() {
            if *mode != Mode::Pressing {
                continue;
            }
            let (ball, mut x, mut factorial) = (&self.cradle.balls[j], series.displacement(j).to_vec(), 1.0);
            let v = series.rate(&x);
            let a = series.rate(&v);
            x[0] = state.x[j];
            let left = (j > 0 && state.modes[j - 1] == Mode::Pressing).then(|| series.force_row(j - 1));
            let force = |k: usize| {
                factorial *= k.max(1) as f64;
                let forcing = forcings[j].get(k).map_or(0.0, |forcing| forcing / factorial);
                let free = forcing - ball.omega2 * x[k] - 2.0 * ball.gamma * v[k];
                left.map_or(0.0, |left| left[k]) + ball.mass * (free - a[k])
            };
            let forces: Vec<f64> = (0..series.order).map(force).collect();
            series.set_forces(j, &[], &forces);
        }
        series
    }

    /// The last step.
    pub(crate) fn last_step(&self) -> LastStep<'_> {
        LastStep {
            cradle: &self.cradle,
            start: self.state_at_start(),
            inputs: self.inputs.at(self.step.time),
            length: self.step_length(),
            end: self.state_of_all(self.time.into()),
            onset_ahead: self.find_next_onset().found().is_some(),
        }
    }
}
