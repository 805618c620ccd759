//! The inputs as polynomials of the time.

use serde::{Deserialize, Serialize};

use super::flight::Forcing;
use crate::model::{Cradle, Inputs, MAX_INPUT_DERIVATIVE};
use crate::solver::{MAX_FORCE_ORDER, series::of_derivatives};

// The degree of the inputs is that of the closed forms.
const _: () = assert!(MAX_INPUT_DERIVATIVE == MAX_FORCE_ORDER);

#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct HeldInputs {
    /// Time to which values and derivatives refer, s.
    pub since: f64,
    /// The values, then their derivatives by time; higher ones are zero.
    pub orders: Vec<Inputs>,
}

impl HeldInputs {
    /// Constant inputs from the time `since` (s) on.
    pub fn constant(values: Inputs, since: f64) -> Self {
        Self { since, orders: vec![values] }
    }

    /// Inputs with these values and derivatives from the time `since` (s) on; `None` if they are constant and act
    /// already.
    pub fn changed(&self, since: f64, values: &Inputs, derivatives: &[Inputs]) -> Option<Self> {
        let values = std::slice::from_ref(values);
        let same = derivatives.is_empty() && self.orders == values;
        (!same).then(|| Self { since, orders: [values, derivatives].concat() })
    }

    /// Whether the number of orders is allowed and all have forces for `balls` balls.
    pub fn fit(&self, balls: usize) -> bool {
        let orders = (1..=MAX_INPUT_DERIVATIVE + 1).contains(&self.orders.len());
        orders && self.orders.iter().all(|inputs| inputs.force.len() == balls)
    }

    pub fn are_finite(&self) -> bool {
        self.orders.iter().all(Inputs::is_finite)
    }

    /// An input, or a linear function of the inputs, with its derivatives.
    pub fn derivatives(&self, input: impl Fn(&Inputs) -> f64) -> Forcing {
        let mut derivatives = Forcing::default();
        derivatives.iter_mut().zip(&self.orders).for_each(|(to, inputs)| *to = input(inputs));
        derivatives
    }

    /// Acceleration of ball `i` of the mass `mass` (kg) by the inputs, with its derivatives.
    pub fn forcing(&self, i: usize, mass: f64) -> Forcing {
        self.derivatives(|inputs| inputs.force[i] / mass - inputs.support_acceleration)
    }

    /// Accelerations of all balls by the inputs.
    pub fn forcings(&self, cradle: &Cradle) -> Vec<Forcing> {
        cradle.balls.iter().enumerate().map(|(i, ball)| self.forcing(i, ball.mass)).collect()
    }

    /// These inputs, expanded about the time `t` (s).
    pub fn at(&self, t: f64) -> Self {
        let later = |k: usize| self.orders[k].continued(&self.orders[k + 1..], t - self.since);
        Self { since: t, orders: (0..self.orders.len()).map(later).collect() }
    }

    /// The values of the inputs at the time `t` (s).
    pub fn values(&self, t: f64) -> Inputs {
        self.orders[0].continued(&self.orders[1..], t - self.since)
    }

    /// Coefficients of the power series of an input.
    pub fn series(&self, input: impl Fn(&Inputs) -> f64) -> Forcing {
        of_derivatives(self.derivatives(input))
    }
}
