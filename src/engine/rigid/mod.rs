//! Rigid contacts: instantaneous impacts, and balls that stay in contact.
//!
//! [`restitution`] has what an instant of impacts does to the velocities of balls that touch, [`Body`] the motion of
//! balls that move as one and the force that each contact transmits meanwhile ([`Constraint`]). Needs the balls in
//! flight; knows no run.

mod body;
pub(crate) mod restitution;

pub(crate) use body::{Body, Constraint, acceleration_rounding};
