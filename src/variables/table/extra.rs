//! The rows that only FMI 3.0 has, and the roles that variables have only there.

use std::slice::{from_mut, from_ref};

use super::row::Causality::{Independent, Input, Local, Output, StructuralParameter};
use super::row::Shape::{Balls, Contacts, Scalar};
use super::row::Type::{Binary, Boolean, Clock, Integer, Real};
use super::row::{Access, Edge, Extra, Row, between, enumeration, extra, row};
use super::types::{FORCE_KN, IMPULSE, LENGTH, TIME, TIME_US, VELOCITY, item};
use crate::variables::settings::{DerivativesOf, MAX_BALLS, MIN_BALLS};

/// Largest size of `log.pulses`, bytes.
pub const MAX_LOG: usize = 1 << 16;

/// How many of these rows come before those of the table in the description.
pub const BEFORE: usize = 3;

const ONSET: &str = "onset.clock";
const RELEASE: &str = "release.clock";

/// The variables that only FMI 3.0 has, with their value references.
#[rustfmt::skip]
pub static EXTRA: &[(u32, Row)] = &[
    (0, extra("time", Scalar, Independent, Real, Extra::Time,
        "Time").of(&TIME).continuous()),
    (1, extra("n", Scalar, StructuralParameter, Integer, Extra::Balls,
        "Number of balls; changing it resets all arrays to their defaults")
        .within(between(MIN_BALLS as f64, MAX_BALLS as f64))),
    (2, enumeration("derivatives.of", item!(derivatives_of: DerivativesOf),
        "What directional and adjoint derivatives refer to after initialization").tunable()),
    (4, row("der(F_ext)", Balls, Input, Access::Setting { get: |s| &s.slopes.force, set: |s| &mut s.slopes.force },
        "Slope of F_ext over the next steps, from the value it is set to")),
    (5, row("der(a_support)", Scalar, Input, Access::Setting {
        get: |s| from_ref(&s.slopes.support_acceleration), set: |s| from_mut(&mut s.slopes.support_acceleration),
    }, "Slope of a_support over the next steps, from the value it is set to")),
    (8, extra(ONSET, Scalar, Output, Clock, Extra::Clock(Edge::Onset),
        "Ticks when contacts close")),
    (9, extra(RELEASE, Scalar, Output, Clock, Extra::Clock(Edge::Release),
        "Ticks when contacts open")),
    (10, extra("onset.time", Scalar, Output, Real, Extra::TickTime(Edge::Onset),
        "Time of the last tick").of(&TIME).clocked(ONSET)),
    (11, extra("onset.closed", Contacts, Output, Boolean, Extra::TickOf(Edge::Onset),
        "Which contacts closed at the last tick").clocked(ONSET)),
    (12, extra("release.time", Scalar, Output, Real, Extra::TickTime(Edge::Release),
        "Time of the last tick").of(&TIME).clocked(RELEASE)),
    (13, extra("release.opened", Contacts, Output, Boolean, Extra::TickOf(Edge::Release),
        "Which contacts opened at the last tick").clocked(RELEASE)),
    (14, extra("release.impulse", Contacts, Output, Real, Extra::Ended("impulse"),
        "Impulse of the pulses that ended at the last tick").of(&IMPULSE).clocked(RELEASE)),
    (15, extra("release.peak", Contacts, Output, Real, Extra::Ended("peak"),
        "Largest force of the pulses that ended at the last tick").of(&FORCE_KN).clocked(RELEASE)),
    (16, extra("release.duration", Contacts, Output, Real, Extra::Ended("duration"),
        "Duration of the pulses that ended at the last tick").of(&TIME_US).clocked(RELEASE)),
    (22, extra("release.peakTime", Contacts, Output, Real, Extra::Ended("peakTime"),
        "When the pulses that ended at the last tick had their largest force").of(&TIME).clocked(RELEASE)),
    (17, extra("q", Balls, Local, Real, Extra::Joined("x", "overlap"),
        "Position of the first ball, then the overlaps").of(&LENGTH).continuous()
        .initially(&[&["contact.deadBand", "contact.gap", "x_start"]])),
    (18, extra("der(q)", Balls, Local, Real, Extra::Joined("v", "der(overlap)"),
        "Velocity of the first ball, then the rates of the overlaps").of(&VELOCITY).continuous()
        .initially(&[&["v_start"]]).follows(&[&["v"]])),
    (19, extra("z.contact", Contacts, Local, Real, Extra::ContactIndicator,
        "Event indicators of the contacts: negative while open").continuous()),
    (20, extra("z.clip", Contacts, Local, Real, Extra::ClipIndicator,
        "Event indicators of the laws: negative while clipped").continuous()),
    (21, extra("log.pulses", Scalar, Local, Binary, Extra::Pulses,
        "The last pulses as CSV: contact, onset, release, largest force, impulse, time of that force")),
];

/// Continuous states with their derivatives, in their order.
pub const STATES: [(&str, &str); 5] = [
    ("q", "der(q)"),
    ("v", "a"),
    ("impulse", "F"),
    ("E_dissipated", "der(E_dissipated)"),
    ("W_external", "der(W_external)"),
];

/// What a host may read or set in the middle of a step.
pub const INTERMEDIATE: [&str; 10] =
    ["time", "F_ext", "a_support", "x", "F", "v", "E_total", "p_total", "F_support", "impulse"];
