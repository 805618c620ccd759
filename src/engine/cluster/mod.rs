//! Clusters: neighbouring balls held together by closed contacts, followed from switching to switching.
//!
//! A [`Cluster`] describes the motion of its window on one segment after the other. A method enters by one door,
//! `Cluster::describe` in `segment`, which chooses among them: Taylor series (`recurrences`, and `persistent` where balls have long been
//! pressed together), implicit collocation (`collocation`), which both fill in a `series`, and natural modes (`modes`, `natural`).
//! `step_control` holds the tolerances and what the segments so far say about the next one. Needs the balls in flight and the contact
//! laws; knows no run, no events and no ledgers.

mod collocation;
mod dense_output;
mod modes;
mod natural;
mod persistent;
mod recurrences;
mod segment;
mod series;
mod step_control;
mod window;

pub(crate) use segment::Cluster;
pub(crate) use step_control::{Control, StepHistory};
pub(crate) use window::{OVERLAP_TERMS, OverlapSeries, Switch, WindowContact, clipping};
