//! The interface, row by row. Names, units and meanings are a contract with every host: rows may be added, not changed.
//!
//! Start values are those of [`Parameters::default_for`], read through the row's own accessor.

pub(super) mod extra;
pub(super) mod row;
pub(super) mod types;

use std::slice::{from_mut, from_ref};

use super::settings::Kind;
use crate::forecast::NEVER;
use crate::model::{ContactModel, DampingLaw, ExchangedContacts, Parameters, PendulumModel, SolverMethod};
use row::Causality::{CalculatedParameter, Input, Local, Output};
use row::Shape::{Balls, Contacts, Scalar};
use row::{ANY, Access, NOT_NEGATIVE, Need, POSITIVE, Row};
use row::{between, count, enumeration, parameter, real, row};
use types::{
    ACCELERATION, ANGLE_DEG, DAMPING, DRAG, ELASTIC_MODULUS_GPA, ENERGY, FORCE, FORCE_KN, IMPULSE, LENGTH, LENGTH_MM,
    LENGTH_UM, MASS, MOMENTUM, POWER, RATIO, SLOWNESS, STIFFNESS_N_UM, TIME, TIME_US, VELOCITY, item,
};

/// A parameter that is one number of [`Parameters`].
macro_rules! one {
    ($field:ident) => {
        Access::Setting { get: |s| from_ref(&s.parameters.$field), set: |s| from_mut(&mut s.parameters.$field) }
    };
}

/// A parameter that is a vector of [`Parameters`].
macro_rules! each {
    ($field:ident) => {
        Access::Setting { get: |s| &s.parameters.$field, set: |s| &mut s.parameters.$field }
    };
}

const POWER_LAW: Need =
    Need { choice: "contact.model = powerLaw", is_met: |p, _| p.contact_model == ContactModel::PowerLaw };
const HERTZ: Need = Need { choice: "contact.model = hertz", is_met: |p, _| p.contact_model == ContactModel::Hertz };
const RESTITUTION: Need = Need {
    choice: "contact.model = rigid or contact.dampingLaw = constantRestitution",
    is_met: |p, _| p.contact_model == ContactModel::Rigid || p.damping_law == DampingLaw::ConstantRestitution,
};
const LOSSES: Need = Need {
    choice: "contacts with losses (contact.restitution below 1, or a coefficient of contact.dampingLaw above 0)",
    is_met: |p, _| p.contacts_lose(),
};
const LOSSY_CONTACT: Need = Need {
    choice: "a contact.lossRatio above 0",
    is_met: |p, _| p.balls() < 2 || p.loss_ratio.iter().any(|&q| q > 0.0),
};
const COMPLIANT: Need =
    Need { choice: "contact.model = powerLaw or hertz", is_met: |p, _| p.contact_model != ContactModel::Rigid };
const KELVIN_VOIGT: Need = Need {
    choice: "contact.dampingLaw = kelvinVoigt or kelvinVoigtNoPull",
    is_met: |p, _| matches!(p.damping_law, DampingLaw::KelvinVoigt | DampingLaw::KelvinVoigtNoPull),
};
const HUNT_CROSSLEY: Need =
    Need { choice: "contact.dampingLaw = huntCrossley", is_met: |p, _| p.damping_law == DampingLaw::HuntCrossley };
const VISCOELASTIC: Need =
    Need { choice: "contact.dampingLaw = viscoelastic", is_met: |p, _| p.damping_law == DampingLaw::Viscoelastic };
const RK4: Need = Need { choice: "solver.method = rk4", is_met: |p, _| p.method == SolverMethod::Rk4 };
// In model exchange there is no method to select.
const TOLERANT: Need = Need {
    choice: "solver.method = eventDriven, bdf or adams",
    is_met: |p, kind| p.method != SolverMethod::Rk4 || kind == Some(Kind::ModelExchange),
};
const CO_SIMULATION: Need = Need { choice: "co-simulation", is_met: |_, kind| kind != Some(Kind::ModelExchange) };
const MODEL_EXCHANGE: Need = Need { choice: "model exchange", is_met: |_, kind| kind != Some(Kind::CoSimulation) };

/// Period of ball 1, s; `NEVER` without gravity.
fn period(parameters: &Parameters) -> f64 {
    let length = parameters.length * parameters.length_ratio.first().copied().unwrap_or(1.0);
    match parameters.gravity {
        0.0 => NEVER,
        gravity => (2.0 * std::f64::consts::PI * (length / gravity).sqrt()).min(NEVER),
    }
}

/// Parameters, one of which contacts use to lose energy.
pub(super) const LOSS_PARAMETERS: &[&str] =
    &["contact.damping", "contact.huntCrossley", "contact.relaxationTime", "contact.restitution"];

// What initial values depend on. During initialization rigid contacts transmit nothing.
const MASSES: &[&str] = &["ball.mass", "ball.massRatio"];
const PENDULUMS: &[&str] = &["gravity", "pendulum.length", "pendulum.lengthRatio", "pendulum.model"];
const CLEARANCE: &[&str] = &["contact.deadBand", "contact.gap"];
const OVERLAP: &[&str] = &["contact.deadBand", "contact.gap", "x_start", "pendulum.model"];
const ELASTIC: &[&str] = &[
    "ball.radius",
    "ball.radiusRatio*",
    "ball.youngModulus",
    "ball.youngModulusRatio*",
    "ball.poissonRatio",
    "contact.model",
    "contact.stiffness",
    "contact.stiffnessRatio",
    "contact.overlapRef",
    "contact.exponent",
];
const DAMPED: &[&str] = &["contact.dampingLaw", "contact.lossRatio"];
const FORCE_AT_START: &[&[&str]] = &[OVERLAP, ELASTIC, DAMPED, LOSS_PARAMETERS, MASSES, &["v_start"]];
const SUPPORT: &[&str] = &["pendulum.drag", "x_start", "v_start"];

/// Every variable of the FMU. The position of a row is part of its variables' value references.
#[rustfmt::skip]
pub static TABLE: &[Row] = &[
    parameter("gravity", Scalar, &ACCELERATION, NOT_NEGATIVE, one!(gravity),
        "Gravity g; 0 gives free balls on a line"),
    parameter("ball.mass", Scalar, &MASS, POSITIVE, one!(mass),
        "Mass of a ball with mass ratio 1"),
    parameter("ball.massRatio", Balls, &RATIO, POSITIVE, each!(mass_ratio),
        "Mass of ball {i}, as a multiple of ball.mass"),
    parameter("ball.radius", Scalar, &LENGTH_MM, POSITIVE, one!(radius),
        "Radius of a ball with radius ratio 1, for hertz contacts, circular pendulums and animations").nominal(0.01),
    parameter("ball.youngModulus", Scalar, &ELASTIC_MODULUS_GPA, POSITIVE, one!(young_modulus),
        "Young's modulus E of a ball with ratio 1, for hertz contacts").nominal(1e11).used_if(&[HERTZ]),
    parameter("ball.poissonRatio", Scalar, &RATIO, between(0.0, 0.5), one!(poisson_ratio),
        "Poisson's ratio of the balls, for hertz contacts").used_if(&[HERTZ]),
    parameter("pendulum.length", Scalar, &LENGTH, POSITIVE, one!(length),
        "Length L of a pendulum with length ratio 1"),
    parameter("pendulum.lengthRatio", Balls, &RATIO, POSITIVE, each!(length_ratio),
        "Length of pendulum {i}, as a multiple of pendulum.length"),
    parameter("pendulum.drag", Scalar, &DRAG, NOT_NEGATIVE, one!(drag),
        "Viscous drag b on every ball; the reaction acts on the support").tunable(),
    enumeration("contact.model", item!(parameters.contact_model: ContactModel),
        "Force law of the contacts"),
    parameter("contact.stiffness", Scalar, &STIFFNESS_N_UM, POSITIVE, one!(stiffness),
        "Secant stiffness k at the overlap contact.overlapRef, for powerLaw contacts").nominal(1e10)
        .used_if(&[POWER_LAW]),
    parameter("contact.stiffnessRatio", Contacts, &RATIO, POSITIVE, each!(stiffness_ratio),
        "Stiffness ratio r of the contact between balls {i} and {j}: a factor on its elastic force")
        .used_if(&[COMPLIANT]),
    parameter("contact.overlapRef", Scalar, &LENGTH_UM, POSITIVE, one!(overlap_ref),
        "Overlap d_ref at which the secant stiffness is contact.stiffness").nominal(1e-6).used_if(&[POWER_LAW]),
    parameter("contact.exponent", Scalar, &RATIO, between(1.0, 10.0), one!(exponent),
        "Exponent p of the powerLaw contacts").used_if(&[POWER_LAW]),
    parameter("contact.deadBand", Scalar, &LENGTH_UM, NOT_NEGATIVE, one!(dead_band),
        "Distance that neighbours travel beyond the gap before their contact acts").nominal(1e-6),
    parameter("contact.gap", Contacts, &LENGTH_UM, ANY, each!(gap),
        "Gap between balls {i} and {j} at rest; negative if they are pre-compressed").nominal(1e-6),
    enumeration("contact.dampingLaw", item!(parameters.damping_law: DampingLaw),
        "Damping law of the contacts").used_if(&[COMPLIANT]),
    parameter("contact.damping", Scalar, &DAMPING, NOT_NEGATIVE, one!(damping),
        "Damping c of the kelvinVoigt laws").tunable().used_if(&[COMPLIANT, KELVIN_VOIGT, LOSSY_CONTACT]),
    parameter("contact.huntCrossley", Scalar, &SLOWNESS, NOT_NEGATIVE, one!(hunt_crossley),
        "Damping factor alpha of the huntCrossley law").tunable()
        .used_if(&[COMPLIANT, HUNT_CROSSLEY, LOSSY_CONTACT]),
    parameter("contact.relaxationTime", Scalar, &TIME_US, NOT_NEGATIVE, one!(relaxation_time),
        "Relaxation time A of the viscoelastic law").nominal(1e-6).tunable()
        .used_if(&[COMPLIANT, VISCOELASTIC, LOSSY_CONTACT]),
    parameter("contact.restitution", Scalar, &RATIO, between(0.0, 1.0), one!(restitution),
        "Coefficient of restitution of rigid contacts and of the constantRestitution law, which refuses 0").tunable()
        .used_if(&[RESTITUTION, LOSSY_CONTACT]),
    parameter("x_start", Balls, &LENGTH, ANY, each!(x_start),
        "Position x[{i}] of ball {i} at the start time; for circular pendulums less than the length"),
    parameter("v_start", Balls, &VELOCITY, ANY, each!(v_start),
        "Velocity v[{i}] of ball {i} at the start time"),
    enumeration("solver.method", item!(parameters.method: SolverMethod),
        "Solution method").used_if(&[CO_SIMULATION]),
    parameter("solver.tolerance", Scalar, &RATIO, between(1e-14, 1e-3), one!(tolerance),
        "Relative tolerance of all methods except rk4; a host's own tolerance can only tighten it").nominal(1e-12)
        .used_if(&[TOLERANT]),
    parameter("solver.fixedStep", Scalar, &TIME_US, POSITIVE, one!(fixed_step),
        "Step of the rk4 method").nominal(1e-6).used_if(&[CO_SIMULATION, RK4]),
    enumeration("exchange.contacts", item!(parameters.exchange_contacts: ExchangedContacts),
        "Who follows the contacts in model exchange; resolved needs a tolerance of 1e-10 for contacts in touch")
        .used_if(&[MODEL_EXCHANGE]),
    row("pendulum.period", Scalar, CalculatedParameter, Access::Calculated(period),
        "Period of ball 1 for small angles; 1e30 without gravity").of(&TIME)
        .initially(&[&["gravity", "pendulum.length", "pendulum.lengthRatio[1]"]])
        .derivative(|d, _| d.period),

    row("F_ext", Balls, Input, Access::Setting { get: |s| &s.inputs.force, set: |s| &mut s.inputs.force },
        "External force on ball {i}, to the right").of(&FORCE),
    row("a_support", Scalar, Input, Access::Setting {
        get: |s| from_ref(&s.inputs.support_acceleration), set: |s| from_mut(&mut s.inputs.support_acceleration),
    }, "Acceleration of the support, to the right").of(&ACCELERATION),

    real("x", Balls, Output, &LENGTH, |s, i| s.x(i),
        "Horizontal position of ball {i}, to the right of its rest position, relative to the support")
        .initially(&[&["x_start", "pendulum.model"]]).follows(&[&["position"]])
        .derivative(|d, i| d.x[i]),
    real("F", Contacts, Output, &FORCE_KN, |s, i| s.force(i),
        "Contact force between balls {i} and {j} at this instant, pushing them apart")
        .initially(FORCE_AT_START).follows(&[&["overlap", "v"]])
        .derivative(|d, i| d.force[i]),
    real("v", Balls, Output, &VELOCITY, |s, i| s.v(i),
        "Rate of x[{i}]").initially(&[&["v_start", "pendulum.model"]])
        .follows(&[&["v"]])
        .derivative(|d, i| d.v[i]),
    real("E_total", Scalar, Output, &ENERGY, |s, _| s.total_energy(),
        "Kinetic, gravitational and contact energy of all balls")
        .initially(&[MASSES, PENDULUMS, OVERLAP, ELASTIC, &["v_start"]]).follows(&[&["position", "v"]])
        .derivative(|d, _| d.total_energy),
    real("p_total", Scalar, Output, &MOMENTUM, |s, _| s.momentum(),
        "Sum of mass times horizontal velocity").initially(&[MASSES, &["v_start", "pendulum.model"]]).follows(&[&["v"]])
        .derivative(|d, _| d.momentum),
    real("F_support", Scalar, Output, &FORCE, |s, _| s.support_force(),
        "Horizontal force on the support, by the pendulums and the drag").initially(&[MASSES, PENDULUMS, SUPPORT])
        .follows(&[&["position", "v"]])
        .derivative(|d, _| d.support_force),
    real("t_next", Scalar, Output, &TIME, |s, _| s.next_onset().time(),
        "First onset of any contact strictly after the current time; 1e30 if there is none within 1000 periods; where \
         the look ahead ends before an onset, a time up to which there is none").discrete()
        .derivative(|d, _| d.next_onset),
    real("impulse", Contacts, Output, &IMPULSE, |s, i| s.impulse(i),
        "Integral of F[{i}] since the start").initially(&[]).follows(&[&["impulse"]])
        .derivative(|d, i| d.impulse[i]),
    real("F_mean", Contacts, Output, &FORCE, |s, i| s.force_mean(i),
        "Mean of F[{i}] over the last step; F[{i}] in model exchange").initially(FORCE_AT_START)
        .follows(&[&["overlap", "v"]])
        .derivative(|d, i| d.force_mean[i]),
    real("F_peak", Contacts, Output, &FORCE_KN, |s, i| s.force_peak(i),
        "Largest F[{i}] in the last step, in model exchange in the last pulse; 0 if the contact stayed open")
        .discrete().initially(FORCE_AT_START)
        .derivative(|d, i| d.force_peak[i]),
    real("F_support_mean", Scalar, Output, &FORCE, |s, _| s.support_force_mean(),
        "Mean of F_support over the last step; F_support in model exchange")
        .initially(&[MASSES, PENDULUMS, SUPPORT]).follows(&[&["position", "v"]])
        .derivative(|d, _| d.support_force_mean),
    count("pulses", Contacts, Output, |s, i| s.pulses(i),
        "Number of onsets so far of the contact between balls {i} and {j}").initially(&[CLEARANCE, &["x_start"]]),
    row("inContact", Contacts, Output, Access::Flag(|s, i| s.in_contact(i)),
        "Whether balls {i} and {j} overlap or, if rigid, press on each other").initially(&[CLEARANCE, &["x_start"]]),

    row("t_next_isOnset", Scalar, Local, Access::Flag(|s, _| s.next_onset().is_settled()),
        "True if t_next is an onset, or 1e30 because there is none; false if the look ahead ended before an onset"),
    real("t_onset", Contacts, Local, &TIME, |s, i| s.last_onset(i),
        "Last onset of the contact between balls {i} and {j}; -1e30 before the first").discrete(),
    real("t_release", Contacts, Local, &TIME, |s, i| s.last_release(i),
        "Last release of the contact between balls {i} and {j}; -1e30 before the first").discrete(),
    real("overlap", Contacts, Local, &LENGTH_UM, |s, i| s.overlap(i),
        "x[{i}] - x[{j}] - contact.gap[{i}] - contact.deadBand, of circular pendulums along the line of the centres; \
         negative while the contact is open").nominal(1e-6)
        .initially(&[OVERLAP]).derivative(|d, i| d.overlap[i]),
    real("a", Balls, Local, &ACCELERATION, |s, i| s.a(i),
        "Rate of v[{i}]")
        .initially(&[PENDULUMS, CLEARANCE, ELASTIC, DAMPED, LOSS_PARAMETERS,
            &["ball.mass", "ball.massRatio*", "pendulum.drag", "x_start*", "v_start*", "F_ext", "a_support"]])
        .follows(&[&["position", "overlap", "v*", "F_ext", "a_support"]]).derivative(|d, i| d.a[i]),
    real("E_kinetic", Balls, Local, &ENERGY, |s, i| s.kinetic_energy(i),
        "Kinetic energy of ball {i}").within(NOT_NEGATIVE),
    real("E_gravity", Balls, Local, &ENERGY, |s, i| s.gravity_energy(i),
        "Gravitational energy of ball {i}").within(NOT_NEGATIVE),
    real("E_contact", Contacts, Local, &ENERGY, |s, i| s.contact_energy(i),
        "Elastic energy of the contact between balls {i} and {j}").within(NOT_NEGATIVE),
    real("E_dissipated", Scalar, Local, &ENERGY, |s, _| s.dissipated_energy(),
        "Energy dissipated by drag and contacts since the start").initially(&[]).derivative(|d, _| d.dissipated_energy),
    real("W_external", Scalar, Local, &ENERGY, |s, _| s.external_work(),
        "Work done by the external forces and the moving support since the start").initially(&[])
        .derivative(|d, _| d.external_work),
    real("E_residual", Scalar, Local, &ENERGY, |s, _| s.energy_residual(),
        "E_total + E_dissipated - W_external - E_total at the start: the energy error of the solver").nominal(1e-12),
    count("solver.steps", Scalar, Local, |s, _| s.work().steps,
        "Integration steps accepted since the start"),
    count("solver.evaluations", Scalar, Local, |s, _| s.work().evaluations,
        "Evaluations of the contact forces since the start"),
    count("solver.events", Scalar, Local, |s, _| s.work().events,
        "Onsets, releases and other switchings of contacts since the start"),

    real("der(overlap)", Contacts, Local, &VELOCITY, |s, i| s.overlap_rate(i),
        "Rate of overlap[{i}], with linear pendulums v[{i}] - v[{j}]").initially(&[&["v_start", "pendulum.model"]])
        .follows(&[&["v"]]).derivative(|d, i| d.overlap_rate[i]),
    real("der(E_dissipated)", Scalar, Local, &POWER, |s, _| s.dissipation(),
        "Power dissipated by drag and contacts")
        .initially(&[OVERLAP, ELASTIC, DAMPED, LOSS_PARAMETERS, MASSES, &["v_start", "pendulum.drag"]])
        .follows(&[&["overlap", "v"]]).derivative(|d, _| d.dissipation),
    real("der(W_external)", Scalar, Local, &POWER, |s, _| s.external_power(),
        "Power of the external forces and the moving support")
        .initially(&[MASSES, &["v_start", "F_ext", "a_support", "pendulum.model"]])
        .follows(&[&["v", "F_ext", "a_support"]]).derivative(|d, _| d.external_power),

    enumeration("pendulum.model", item!(parameters.pendulum: PendulumModel),
        "How the balls hang"),
    real("angle", Balls, Output, &ANGLE_DEG, |s, i| s.angle(i),
        "Angle of pendulum {i}; x[{i}] over its length with pendulum.model = linear")
        .initially(&[&["pendulum.length", "pendulum.lengthRatio", "pendulum.model", "x_start"]])
        .follows(&[&["position"]])
        .derivative(|d, i| d.angle[i]),
    real("y", Balls, Output, &LENGTH, |s, i| s.y(i),
        "Height of ball {i} above its rest position; x[{i}]^2/2 over its length with pendulum.model = linear")
        .initially(&[&["pendulum.length", "pendulum.lengthRatio", "pendulum.model", "x_start"]])
        .follows(&[&["position"]])
        .derivative(|d, i| d.y[i]),
    real("F_support_vertical", Scalar, Output, &FORCE, |s, _| s.support_force_vertical(),
        "Vertical force on the support, upwards, by the pendulums and the drag: minus the weight of the balls at rest, \
         and always with pendulum.model = linear")
        .initially(&[MASSES, &["gravity", "pendulum.model"]])
        .derivative(|d, _| d.support_force_vertical),

    parameter("contact.lossRatio", Contacts, &RATIO, NOT_NEGATIVE, each!(loss_ratio),
        "Losses of the contact between balls {i} and {j}: a factor on its damping, the exponent of its restitution")
        .tunable().used_if(&[LOSSES]),
    parameter("ball.radiusRatio", Balls, &RATIO, POSITIVE, each!(radius_ratio),
        "Radius of ball {i}, as a multiple of ball.radius"),
    parameter("ball.youngModulusRatio", Balls, &RATIO, POSITIVE, each!(young_modulus_ratio),
        "Young's modulus of ball {i}, as a multiple of ball.youngModulus").used_if(&[HERTZ]),
];
