//! Clusters: neighbouring balls held together by closed contacts, followed from switching to switching. See "Clusters"
//! in docs/theory.md for the terms, and the sections after it for the methods from which a [`Cluster`] chooses.

mod gauss;
mod modes;
mod natural;
mod radau;
mod segment;
mod step_control;
mod taylor;
mod window;

pub(crate) use gauss::{BallOnArc, BranchPoint, ContactDirection, power_of_stretching};
pub(crate) use segment::Cluster;
pub(crate) use step_control::{Control, Method, StepHistory};
pub(crate) use taylor::{INVERSE_FACTORIAL, Series};
pub(crate) use window::{OverlapSeries, Switch, Window, WindowContact};
