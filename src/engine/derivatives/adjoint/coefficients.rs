//! One number for each coefficient of the equations: how much it changes, or how much something changes with it.

use crate::model::{BallModel, ContactLaw, Cradle, Damping, Inputs};
use crate::solver::double_double::{DoubleDouble, Linear};
use crate::solver::dual::{Dual, Scalar};

/// Those of a ball: mass, `omega2`, `gamma`, and the external force on it.
pub(super) type OfBall<T = f64> = [T; 4];

/// Those of a contact: stiffness, reference overlap, exponent, clearance, and the coefficients of the damping laws:
/// Kelvin and Voigt's, Hunt and Crossley's, and the relaxation time of viscoelastic contacts.
pub(super) type OfContact<T = f64> = [T; 7];

/// Place of the clearance among those of a contact.
pub(super) const CLEARANCE: usize = 3;

/// Those of a whole cradle under inputs.
#[derive(Clone, Debug, Default)]
pub(super) struct Coefficients<T = f64> {
    pub balls: Vec<OfBall<T>>,
    pub contacts: Vec<OfContact<T>>,
    /// Acceleration of the support.
    pub support: T,
}

impl<T: Linear> Coefficients<T> {
    pub fn zero(balls: usize) -> Self {
        let contacts = vec![Default::default(); balls.saturating_sub(1)];
        Self { balls: vec![Default::default(); balls], contacts, support: T::default() }
    }

    fn all(&self) -> impl Iterator<Item = &T> {
        self.balls.iter().flatten().chain(self.contacts.iter().flatten()).chain([&self.support])
    }

    /// The sum of the products with others, most of which are zeros where they are changes along a direction.
    pub fn dot(&self, other: &Coefficients) -> DoubleDouble
    where
        DoubleDouble: From<T>,
    {
        let products = self.all().zip(other.all()).filter(|(_, b)| **b != 0.0);
        products.fold(DoubleDouble::ZERO, |sum, (a, b)| sum + DoubleDouble::from(*a) * *b)
    }
}

impl Coefficients {
    /// How they change along a direction, in which the inputs change by `inputs`.
    pub fn along(cradle: &Cradle<Dual>, inputs: &Inputs) -> Self {
        let ball = |(ball, force): (&BallModel<Dual>, &f64)| {
            [ball.mass.tangent(), ball.omega2.tangent(), ball.gamma.tangent(), *force]
        };
        let contact = |law: &ContactLaw<Dual>| {
            let damping = match law.damping {
                Damping::None => [0.0; 3],
                Damping::KelvinVoigt { c, .. } => [c.tangent(), 0.0, 0.0],
                Damping::HuntCrossley { alpha } => [0.0, alpha.tangent(), 0.0],
                Damping::Viscoelastic { relaxation } => [0.0, 0.0, relaxation.tangent()],
            };
            let [dashpot, hunt_crossley, relaxation] = damping;
            let elastic = [law.stiffness, law.overlap_ref, law.exponent, law.clearance].map(Dual::tangent);
            let [stiffness, overlap_ref, exponent, clearance] = elastic;
            [stiffness, overlap_ref, exponent, clearance, dashpot, hunt_crossley, relaxation]
        };
        Self {
            balls: cradle.balls.iter().zip(&inputs.force).map(ball).collect(),
            contacts: cradle.contacts.iter().map(contact).collect(),
            support: inputs.support_acceleration,
        }
    }
}

impl Coefficients<DoubleDouble> {
    /// Adds others times a weight.
    pub fn add(&mut self, weight: f64, other: &Coefficients) {
        let own = self.balls.iter_mut().flatten().chain(self.contacts.iter_mut().flatten()).chain([&mut self.support]);
        own.zip(other.all()).for_each(|(sum, other)| *sum += DoubleDouble::product(weight, *other));
    }
}
