//! The runs that the benches measure, as hosts that are ready for their first step.

use newtons_cradle::variables::ENUMERATIONS;

use crate::{CUBIC, FIGURE_6, Host, fmi2OK};

/// A real variable and the value to give it.
pub type Setting<'a> = (&'a str, f64);

/// All balls at rest in their rest positions, then `settings`.
pub fn at_rest(balls: usize, settings: &[Setting]) -> Host {
    let host = Host::with_balls(balls);
    let rest = (1..=balls).map(|i| (format!("x_start[{i}]"), 0.0));
    for (name, value) in rest.chain(settings.iter().map(|(name, value)| ((*name).to_owned(), *value))) {
        assert_eq!(host.set(&name, value), fmi2OK, "{name} = {value}: {:?}", host.log());
    }
    host
}

/// Selects an item of an enumeration by its name.
pub fn choose(host: &Host, variable: &str, type_name: &str, item: &str) {
    assert_eq!(host.set_integer(variable, choice(type_name, item).unwrap()), fmi2OK, "{variable} = {item}");
}

/// The integer of an item, if this build has it.
pub fn choice(type_name: &str, item: &str) -> Option<i32> {
    let enumeration = ENUMERATIONS.iter().find(|enumeration| enumeration.type_name == type_name)?;
    enumeration.named(item).map(|item| item.value)
}

/// Initialized at t = 0.
pub fn started(host: Host) -> Host {
    host.start();
    host
}

/// Five balls, the first two lifted by `height` (m), with a solver by its name and further settings.
fn two_lifted(height: f64, set_up: &[Setting], method: &str, settings: &[Setting]) -> Host {
    with_method(at_rest(5, &[&[("x_start[1]", -height), ("x_start[2]", -height)], set_up].concat()), method, settings)
}

/// Initialized with a solver by its name and further settings.
fn with_method(host: Host, method: &str, settings: &[Setting]) -> Host {
    choose(&host, "solver.method", "SolverMethod", method);
    for (name, value) in settings {
        assert_eq!(host.set(name, *value), fmi2OK, "{name} = {value}");
    }
    started(host)
}

/// Figure 6's set-up, to be run for 600 s: 2,562 pulses.
pub fn ten_minutes(method: &str, settings: &[Setting]) -> Host {
    two_lifted(1.0, &FIGURE_6, method, settings)
}

/// Cubic contacts, to be run for 600 s: 7,194 pulses.
pub fn cubic(method: &str, settings: &[Setting]) -> Host {
    two_lifted(0.05, &CUBIC, method, settings)
}

/// Five touching steel balls, to be run for 60 s.
pub fn steel(method: &str, settings: &[Setting]) -> Host {
    damped_steel("kelvinVoigt", &[], method, settings)
}

/// The same with Hunt-Crossley damping.
pub fn steel_hunt_crossley(method: &str, settings: &[Setting]) -> Host {
    damped_steel("huntCrossley", &[("contact.huntCrossley", 0.05)], method, settings)
}

/// The same, viscoelastic.
pub fn steel_viscoelastic(method: &str, settings: &[Setting]) -> Host {
    damped_steel("viscoelastic", &[("contact.relaxationTime", 4e-7)], method, settings)
}

fn damped_steel(law: &str, damping: &[Setting], method: &str, settings: &[Setting]) -> Host {
    let host =
        at_rest(5, &[&[("x_start[1]", -0.1), ("x_start[2]", -0.1), ("contact.deadBand", 0.0)], damping].concat());
    choose(&host, "contact.model", "ContactModel", "hertz");
    choose(&host, "contact.dampingLaw", "DampingLaw", law);
    with_method(host, method, settings)
}

/// Figure 3: waves that cross in thirteen balls, three lifted on the left and two on the right.
pub fn figure3() -> Host {
    started(at_rest(
        13,
        &[
            ("pendulum.length", 1.0),
            ("contact.stiffness", 4e4),
            ("contact.deadBand", 0.0),
            ("x_start[1]", -0.1),
            ("x_start[2]", -0.1),
            ("x_start[3]", -0.1),
            ("x_start[12]", 0.1),
            ("x_start[13]", 0.1),
        ],
    ))
}

/// A line of touching steel balls, the first struck to 1 m/s: the wave is through after 0.2 s.
pub fn hertz_line(balls: usize) -> Host {
    let host = at_rest(balls, &[("gravity", 0.0), ("contact.deadBand", 0.0), ("v_start[1]", 1.0)]);
    choose(&host, "contact.model", "ContactModel", "hertz");
    started(host)
}

/// Hunt-Crossley damping with the coefficient of restitution 0.95 at the first impact, at 0.1 m sqrt(g/L): alpha v =
/// 0.0789266 from `a - ln(1 + a) = -b - ln(1 - b)` with `a = alpha v`, `b = 0.95 a`.
pub fn settling() -> Host {
    let set_up = [("x_start[1]", -0.1), ("x_start[2]", -0.1), ("contact.huntCrossley", 0.352_970_509)];
    let host = at_rest(5, &set_up);
    choose(&host, "contact.dampingLaw", "DampingLaw", "huntCrossley");
    started(host)
}

/// A chain pressed by 10 N from both ends with half-critical damping.
pub fn pressed() -> Host {
    let half_critical = (1e10f64 / 2.0).sqrt();
    started(at_rest(5, &[("contact.damping", half_critical), ("F_ext[1]", 10.0), ("F_ext[5]", -10.0)]))
}

/// The same chain with steel balls of different masses, which has no natural modes.
pub fn pressed_steel() -> Host {
    let half_critical = (1e10f64 / 2.0).sqrt();
    let host = at_rest(
        5,
        &[
            ("contact.damping", half_critical),
            ("F_ext[1]", 10.0),
            ("F_ext[5]", -10.0),
            ("ball.massRatio[2]", 2.0),
            ("ball.massRatio[4]", 0.7),
        ],
    );
    choose(&host, "contact.model", "ContactModel", "hertz");
    started(host)
}

/// Thirteen balls of undamped contacts, the outer ones pressed by 20 N: they rattle for ever.
pub fn rattling(exponent: f64) -> Host {
    let forces = [("F_ext[1]", 20.0), ("F_ext[13]", -20.0)];
    started(at_rest(13, &[&[("contact.exponent", exponent), ("contact.deadBand", 0.0)], &forces[..]].concat()))
}

/// Thirteen unequal balls with Hunt-Crossley damping, the outer ones pressed by 50 N: they ring for long.
pub fn ringing() -> Host {
    let set_up = [("contact.exponent", 2.3), ("contact.deadBand", 0.0), ("contact.huntCrossley", 0.3)];
    let host = at_rest(13, &[&set_up[..], &[("F_ext[1]", 50.0), ("F_ext[13]", -50.0)]].concat());
    choose(&host, "contact.dampingLaw", "DampingLaw", "huntCrossley");
    for i in (1..=13).step_by(3) {
        assert_eq!(host.set(&format!("ball.massRatio[{i}]"), 2.0), fmi2OK);
        assert_eq!(host.set(&format!("pendulum.lengthRatio[{i}]"), 0.8), fmi2OK);
    }
    started(host)
}

/// Two elastic rigid balls on a line that a force presses together and drag brings to rest.
pub fn elastic_chatter() -> Host {
    let push = [("gravity", 0.0), ("pendulum.drag", 2.0), ("F_ext[1]", 2.0), ("x_start[1]", -0.01)];
    let host = at_rest(2, &[&[("contact.deadBand", 0.0)], &push[..]].concat());
    choose(&host, "contact.model", "ContactModel", "rigid");
    started(host)
}

/// The default cradle with Kelvin-Voigt damping in units of the critical one, `c = 2 sqrt(k m / 2)`.
pub fn damped(critical: f64) -> Host {
    let c = critical * 2.0 * (1e10f64 / 2.0).sqrt();
    started(at_rest(5, &[("x_start[1]", -0.1), ("x_start[2]", -0.1), ("contact.damping", c)]))
}

/// The default cradle.
pub fn default_cradle() -> Host {
    damped(0.0)
}

/// The default cradle with dead bands so wide that nothing ever touches.
pub fn in_flight() -> Host {
    started(at_rest(5, &[("x_start[1]", -0.1), ("x_start[2]", -0.1), ("contact.deadBand", 1.0)]))
}

/// One ball lifted, a dead band that separates all pulses: n - 1 of them in each stroke.
pub fn separated(balls: usize) -> Host {
    started(at_rest(balls, &[("x_start[1]", -0.1)]))
}

/// Five balls of masses in the ratios 1 2 1 0.5 1 that touch, on linear contacts with this damping (N.s/m): the first
/// one lifted, or the outer ones pressed by 20 N.
pub fn unequal(damping: f64, pressed: bool) -> Host {
    let lifted = [("x_start[1]", -0.1)];
    let forces = [("F_ext[1]", 20.0), ("F_ext[5]", -20.0)];
    let set_up = if pressed { &forces[..] } else { &lifted };
    let ratios = [("ball.massRatio[2]", 2.0), ("ball.massRatio[4]", 0.5)];
    started(at_rest(5, &[set_up, &ratios, &[("contact.deadBand", 0.0), ("contact.damping", damping)]].concat()))
}

/// Onsets so far.
pub fn pulses(host: &Host) -> u64 {
    (1..host.balls).map(|i| host.get_integer(&format!("pulses[{i}]")) as u64).sum()
}
