//! Rigid contacts: velocities after impacts ([`restitution`]), the motion of balls that move as one ([`Body`]), and the
//! force that a contact transmits meanwhile ([`Constraint`]).

mod body;
pub(crate) mod restitution;

pub(crate) use body::{Body, Constraint, acceleration_rounding};
