//! The runs that the benches measure, as hosts that are ready for their first step.

use std::f64::consts::TAU;

use crate::Host;

/// A variable and the value to give it; items of enumerations by their integers.
pub type Setting<'a> = (&'a str, f64);

/// Figure 6's set-up but for how far the first two of five balls are lifted, 1 m.
pub const FIGURE_6: [Setting; 2] = [("contact.stiffness", 2.9e14), ("contact.deadBand", 1.46e-7)];

/// Cubic contacts of pendulums with a period of 1 s, for two of five balls lifted by 0.05 m.
const CUBIC: [Setting; 6] = [
    ("gravity", TAU * TAU),
    ("pendulum.length", 1.0),
    ("contact.stiffness", 5e18),
    ("contact.overlapRef", 1.0),
    ("contact.exponent", 3.0),
    ("contact.deadBand", 2e-5),
];

const HERTZ: Setting = ("contact.model", 2.0);
const RIGID: Setting = ("contact.model", 3.0);
const HUNT_CROSSLEY: Setting = ("contact.dampingLaw", 3.0);
const VISCOELASTIC: Setting = ("contact.dampingLaw", 4.0);
const NO_DEAD_BAND: Setting = ("contact.deadBand", 0.0);
const ONE_LIFTED: Setting = ("x_start[1]", -0.1);
const TWO_LIFTED: [Setting; 2] = [ONE_LIFTED, ("x_start[2]", -0.1)];

/// All balls at rest in their rest positions but for these settings; initialized at t = 0.
fn ready(balls: usize, settings: &[&[Setting]]) -> Host {
    let host = Host::with_balls(balls);
    (1..=balls).for_each(|i| host.give(&[(&format!("x_start[{i}]"), 0.0)]));
    settings.iter().for_each(|settings| host.give(settings));
    host.start();
    host
}

/// Forces that press the outer balls together.
fn pressing(last: &str, force: f64) -> [Setting<'_>; 2] {
    [("F_ext[1]", force), (last, -force)]
}

/// Figure 6's set-up with this solver, to be run for 600 s: 2,562 pulses.
pub fn ten_minutes(solver: &[Setting]) -> Host {
    ready(5, &[&[("x_start[1]", -1.0), ("x_start[2]", -1.0)], &FIGURE_6, solver])
}

/// The same on arcs.
pub fn on_arcs(solver: &[Setting]) -> Host {
    ten_minutes(&[&[("pendulum.model", 2.0)], solver].concat())
}

/// Cubic contacts, to be run for 600 s: 7,194 pulses.
pub fn cubic(solver: &[Setting]) -> Host {
    ready(5, &[&[("x_start[1]", -0.05), ("x_start[2]", -0.05)], &CUBIC, solver])
}

/// Five touching steel balls, to be run for 60 s.
pub fn steel(solver: &[Setting]) -> Host {
    steel_with(&[], solver)
}

/// The same with Hunt-Crossley damping.
pub fn steel_hunt_crossley(solver: &[Setting]) -> Host {
    steel_with(&[HUNT_CROSSLEY, ("contact.huntCrossley", 0.05)], solver)
}

/// The same, viscoelastic.
pub fn steel_viscoelastic(solver: &[Setting]) -> Host {
    steel_with(&[VISCOELASTIC, ("contact.relaxationTime", 4e-7)], solver)
}

fn steel_with(damping: &[Setting], solver: &[Setting]) -> Host {
    ready(5, &[&TWO_LIFTED, &[HERTZ, NO_DEAD_BAND], damping, solver])
}

/// Figure 3: waves that cross in thirteen balls, three lifted on the left and two on the right.
pub fn figure3() -> Host {
    let lifted = [("x_start[3]", -0.1), ("x_start[12]", 0.1), ("x_start[13]", 0.1)];
    ready(13, &[&TWO_LIFTED, &lifted, &[("pendulum.length", 1.0), ("contact.stiffness", 4e4), NO_DEAD_BAND]])
}

/// A line of 1000 touching steel balls, the first struck to 1 m/s: the wave is through after 0.2 s.
pub fn hertz_line() -> Host {
    ready(1000, &[&[("gravity", 0.0), NO_DEAD_BAND, ("v_start[1]", 1.0), HERTZ]])
}

/// Hunt-Crossley damping with the coefficient of restitution 0.95 at the first impact, at 0.1 m sqrt(g/L): alpha v =
/// 0.0789266 from `a - ln(1 + a) = -b - ln(1 - b)` with `a = alpha v`, `b = 0.95 a`.
pub fn settling() -> Host {
    ready(5, &[&TWO_LIFTED, &[HUNT_CROSSLEY, ("contact.huntCrossley", 0.352_970_509)]])
}

/// A chain pressed by 10 N from both ends with half-critical damping.
pub fn pressed() -> Host {
    ready(5, &[&[damping(0.5)], &pressing("F_ext[5]", 10.0)])
}

/// The same chain with steel balls of different masses, which has no natural modes.
pub fn pressed_steel() -> Host {
    let steel = [HERTZ, ("ball.massRatio[2]", 2.0), ("ball.massRatio[4]", 0.7)];
    ready(5, &[&[damping(0.5)], &pressing("F_ext[5]", 10.0), &steel])
}

/// Thirteen balls of undamped contacts, the outer ones pressed by 20 N: they rattle for ever.
pub fn rattling() -> Host {
    ready(13, &[&[("contact.exponent", 1.5), NO_DEAD_BAND], &pressing("F_ext[13]", 20.0)])
}

/// Thirteen unequal balls with Hunt-Crossley damping, the outer ones pressed by 50 N: they ring for long.
pub fn ringing() -> Host {
    let law = [("contact.exponent", 2.3), NO_DEAD_BAND, HUNT_CROSSLEY, ("contact.huntCrossley", 0.3)];
    let names = [1, 4, 7, 10, 13].map(|i| [format!("ball.massRatio[{i}]"), format!("pendulum.lengthRatio[{i}]")]);
    let ratios: Vec<Setting> = names.iter().flat_map(|[mass, length]| [(&**mass, 2.0), (&**length, 0.8)]).collect();
    ready(13, &[&law, &pressing("F_ext[13]", 50.0), &ratios])
}

/// Two elastic rigid balls on a line that a force presses together and drag brings to rest.
pub fn elastic_chatter() -> Host {
    let push = [("gravity", 0.0), ("pendulum.drag", 2.0), ("F_ext[1]", 2.0), ("x_start[1]", -0.01)];
    ready(2, &[&[RIGID, NO_DEAD_BAND], &push])
}

/// Kelvin-Voigt damping in units of the critical one of the default contacts, `c = 2 sqrt(k m / 2)`.
fn damping(critical: f64) -> Setting<'static> {
    ("contact.damping", critical * 2.0 * (1e10f64 / 2.0).sqrt())
}

/// The default cradle with this damping, in units of the critical one.
pub fn damped(critical: f64) -> Host {
    ready(5, &[&TWO_LIFTED, &[damping(critical)]])
}

/// The default cradle.
pub fn default_cradle() -> Host {
    damped(0.0)
}

/// The default cradle with dead bands so wide that nothing ever touches.
pub fn in_flight() -> Host {
    ready(5, &[&TWO_LIFTED, &[("contact.deadBand", 1.0)]])
}

/// One ball lifted, a dead band that separates all pulses: n - 1 of them in each stroke.
pub fn separated(balls: usize) -> Host {
    ready(balls, &[&[ONE_LIFTED]])
}
