//! Elastic impacts of two balls that nothing else touches: outcome and duration in closed form.
//!
//! [`PairImpact`] is the outcome, known at the onset; what is asked for within an impact is followed like any cluster
//! once somebody asks ([`Interior`]). Needs the balls in flight and, for the interior, clusters; knows no run.

mod closed_form;
mod interior;

pub(crate) use closed_form::{ImpactCoefficients, PairImpact};
pub(crate) use interior::{Impact, Interior};
