//! One number for each coefficient of the equations: how much it changes, or how much something changes with it.

use crate::model::{BallModel, ContactLaw, Cradle, Damping, Inputs};
use crate::solver::dual::{Dual, Scalar};

/// Those of a ball.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OfBall {
    pub mass: f64,
    pub omega2: f64,
    pub gamma: f64,
    /// External force.
    pub force: f64,
}

/// Those of a contact.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OfContact {
    pub stiffness: f64,
    pub overlap_ref: f64,
    pub exponent: f64,
    pub clearance: f64,
    /// Coefficients of the damping laws: Kelvin and Voigt's, Hunt and Crossley's, and the relaxation time of viscoelastic contacts.
    pub dashpot: f64,
    pub hunt_crossley: f64,
    pub relaxation: f64,
}

/// Those of a whole cradle under inputs.
#[derive(Clone, Debug, Default)]
pub(super) struct Coefficients {
    pub balls: Vec<OfBall>,
    pub contacts: Vec<OfContact>,
    /// Acceleration of the support.
    pub support: f64,
}

impl OfContact {
    /// All of them.
    pub fn array(&self) -> [f64; 7] {
        let Self { stiffness, overlap_ref, exponent, clearance, dashpot, hunt_crossley, relaxation } = *self;
        [stiffness, overlap_ref, exponent, clearance, dashpot, hunt_crossley, relaxation]
    }

    /// Adds others to them.
    pub fn add_array(&mut self, others: &[f64; 7]) {
        let Self { stiffness, overlap_ref, exponent, clearance, dashpot, hunt_crossley, relaxation } = self;
        let all = [stiffness, overlap_ref, exponent, clearance, dashpot, hunt_crossley, relaxation];
        all.into_iter().zip(others).for_each(|(sum, other)| *sum += other);
    }
}

impl Coefficients {
    pub fn zero(balls: usize) -> Self {
        let contacts = vec![OfContact::default(); balls.saturating_sub(1)];
        Self { balls: vec![OfBall::default(); balls], contacts, support: 0.0 }
    }

    /// How they change along a direction, in which the inputs change by `inputs`.
    pub fn along(cradle: &Cradle<Dual>, inputs: &Inputs) -> Self {
        let ball = |(ball, force): (&BallModel<Dual>, &f64)| OfBall {
            mass: ball.mass.tangent(),
            omega2: ball.omega2.tangent(),
            gamma: ball.gamma.tangent(),
            force: *force,
        };
        let contact = |law: &ContactLaw<Dual>| {
            let mut of_contact = OfContact {
                stiffness: law.stiffness.tangent(),
                overlap_ref: law.overlap_ref.tangent(),
                exponent: law.exponent.tangent(),
                clearance: law.clearance.tangent(),
                ..OfContact::default()
            };
            match law.damping {
                Damping::None => {}
                Damping::KelvinVoigt { c, .. } => of_contact.dashpot = c.tangent(),
                Damping::HuntCrossley { alpha } => of_contact.hunt_crossley = alpha.tangent(),
                Damping::Viscoelastic { relaxation } => of_contact.relaxation = relaxation.tangent(),
            }
            of_contact
        };
        Self {
            balls: cradle.balls.iter().zip(&inputs.force).map(ball).collect(),
            contacts: cradle.contacts.iter().map(contact).collect(),
            support: inputs.support_acceleration,
        }
    }

    /// The sum of the products with others.
    pub fn dot(&self, other: &Self) -> f64 {
        let ball = |(a, b): (&OfBall, &OfBall)| {
            (a.mass * b.mass + a.omega2 * b.omega2) + (a.gamma * b.gamma + a.force * b.force)
        };
        let contact =
            |(a, b): (&OfContact, &OfContact)| a.array().iter().zip(b.array()).map(|(a, b)| a * b).sum::<f64>();
        let balls: f64 = self.balls.iter().zip(&other.balls).map(ball).sum();
        let contacts: f64 = self.contacts.iter().zip(&other.contacts).map(contact).sum();
        balls + contacts + self.support * other.support
    }

    /// Adds others times a weight.
    pub fn add(&mut self, weight: f64, other: &Self) {
        for (to, from) in self.balls.iter_mut().zip(&other.balls) {
            to.mass += weight * from.mass;
            to.omega2 += weight * from.omega2;
            to.gamma += weight * from.gamma;
            to.force += weight * from.force;
        }
        for (to, from) in self.contacts.iter_mut().zip(&other.contacts) {
            to.add_array(&from.array().map(|from| weight * from));
        }
        self.support += weight * other.support;
    }
}
