//! Clusters: neighbouring balls held together by closed contacts, followed from switching to switching.
//!
//! A [`Cluster`] describes the motion of its window on one segment after the other. `Cluster::describe` in `segment`
//! chooses a method, whose result implements `DenseOutput`: Taylor series (`taylor`), implicit collocation
//! (`collocation`), which fills in such a series, explicit collocation (`gauss`) where contacts follow Hertz or another
//! power, and natural modes (`modes`, `natural`). `step_control` holds the tolerances and the history of steps. Needs
//! the balls in flight and the contact laws; knows no run, no events and no ledgers.

mod collocation;
mod gauss;
mod modes;
mod natural;
mod segment;
mod step_control;
mod taylor;
mod window;

pub(crate) use gauss::{Course, Direction, power_of_stretching};
pub(crate) use segment::Cluster;
pub(crate) use step_control::{Control, Method, StepHistory};
pub(crate) use taylor::{INVERSE_FACTORIAL, Series, velocity_scale};
pub(crate) use window::{OverlapSeries, Switch, Window, WindowContact, sign_after_clip};
