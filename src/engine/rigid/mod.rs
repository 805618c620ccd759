//! Rigid contacts: instantaneous impacts, and balls that stay in contact.
//!
//! [`restitution`] computes the velocities after impacts, [`Body`] the motion of balls that move as one, [`Constraint`]
//! the force that a contact transmits meanwhile. Needs the balls in flight; knows no run.

mod body;
pub(crate) mod restitution;

pub(crate) use body::{Body, Constraint, acceleration_rounding};
