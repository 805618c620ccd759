//! The runs that the benches measure.

use crate::Host;

/// Number of balls, and how a cradle differs from the default one with all balls in their rest positions.
pub type Scene = (usize, &'static str);

/// The host of a scene with more settings, ready for its first step at t = 0.
pub fn ready((balls, settings): (usize, &str), more: &str) -> Host {
    let host = Host::with_balls(balls);
    host.give(&format!("x_start=0 {settings} {more}"));
    host.start();
    host
}

/// Figure 6's set-up, with the first two of five balls pulled 1 m aside, to be run for 600 s: 2,562 pulses.
pub const TEN_MINUTES: Scene = (5, "x_start=-1,-1,0,0,0 contact.stiffness=2.9e14 contact.deadBand=1.46e-7");

/// Cubic contacts of pendulums with a period of 1 s, for two of five balls pulled 0.05 m aside, to be run for 600 s:
/// 7,194 pulses.
pub const CUBIC: Scene = (
    5,
    "x_start=-0.05,-0.05,0,0,0 gravity=39.47841760435743 pendulum.length=1 contact.exponent=3 contact.stiffness=5e18 \
     contact.overlapRef=1 contact.deadBand=2e-5",
);

/// Five touching steel balls, to be run for 60 s.
pub const STEEL: Scene = (5, "x_start=-0.1,-0.1,0,0,0 contact.model=hertz contact.deadBand=0");

/// Five touching steel balls that lose 5 % of the speed in the first click, by Hunt and Crossley's law, to be run for
/// 60 s.
pub const STEEL_HUNT_CROSSLEY: Scene = (
    5,
    "x_start=-0.1,-0.1,0,0,0 contact.model=hertz contact.deadBand=0 contact.dampingLaw=huntCrossley \
     contact.huntCrossley=0.36",
);

/// Five touching steel balls with a coefficient of restitution of 0.95 at any speed, to be run for 60 s.
pub const STEEL_CONSTANT: Scene = (
    5,
    "x_start=-0.1,-0.1,0,0,0 contact.model=hertz contact.deadBand=0 contact.dampingLaw=constantRestitution \
     contact.restitution=0.95",
);

/// Figure 3: waves that cross in thirteen balls, three lifted on the left and two on the right.
pub const FIGURE_3: Scene =
    (13, "x_start=-0.1,-0.1,-0.1,0,0,0,0,0,0,0,0,0.1,0.1 pendulum.length=1 contact.stiffness=4e4 contact.deadBand=0");

/// A line of 1000 touching steel balls, the first struck to 1 m/s: the wave is through after 0.2 s.
pub const HERTZ_LINE: Scene = (1000, "gravity=0 v_start[1]=1 contact.model=hertz contact.deadBand=0");

/// Hunt-Crossley damping with the coefficient of restitution 0.95 at the first impact, at 0.1 m sqrt(g/L): alpha v =
/// 0.0789266 from `a - ln(1 + a) = -b - ln(1 - b)` with `a = alpha v`, `b = 0.95 a`.
pub const SETTLING: Scene =
    (5, "x_start=-0.1,-0.1,0,0,0 contact.dampingLaw=huntCrossley contact.huntCrossley=0.352970509");

/// A chain pressed by 10 N from both ends with half-critical damping.
pub const PRESSED: Scene = (5, "F_ext=10,0,0,0,-10 contact.damping=70710.67811865476");

/// A chain of steel balls of different masses, pressed by 10 N from both ends, with damping; it has no natural modes.
pub const PRESSED_STEEL: Scene =
    (5, "F_ext=10,0,0,0,-10 contact.damping=70710.67811865476 contact.model=hertz ball.massRatio=1,2,1,0.7,1");

/// Thirteen balls of undamped contacts, the outer ones pressed by 20 N: they rattle for ever.
pub const RATTLING: Scene = (13, "contact.exponent=1.5 contact.deadBand=0 F_ext[1]=20 F_ext[13]=-20");

/// Thirteen unequal balls with Hunt-Crossley damping, the outer ones pressed by 50 N: they ring for long.
pub const RINGING: Scene = (
    13,
    "contact.exponent=2.3 contact.deadBand=0 contact.dampingLaw=huntCrossley contact.huntCrossley=0.3 F_ext[1]=50 \
     F_ext[13]=-50 ball.massRatio=2,1,1,2,1,1,2,1,1,2,1,1,2 \
     pendulum.lengthRatio=0.8,1,1,0.8,1,1,0.8,1,1,0.8,1,1,0.8",
);

/// Two elastic rigid balls on a line that a force presses together and drag brings to rest.
pub const ELASTIC_CHATTER: Scene =
    (2, "contact.model=rigid contact.deadBand=0 gravity=0 pendulum.drag=2 F_ext[1]=2 x_start[1]=-0.01");

/// The default cradle.
pub const DEFAULT: Scene = (5, "x_start=-0.1,-0.1,0,0,0");

/// The default cradle with 1000 times critical damping, `c = 2 sqrt(k m / 2)`.
pub const DAMPED: Scene = (5, "x_start=-0.1,-0.1,0,0,0 contact.damping=141421356.23730952");

/// The default cradle with dead bands so wide that nothing ever touches.
pub const IN_FLIGHT: Scene = (5, "x_start=-0.1,-0.1,0,0,0 contact.deadBand=1");
