//! The runs that the benches measure, as hosts that are ready for their first step.

use crate::Host;

/// Figure 6's set-up but for how far the first two of five balls are lifted, 1 m.
pub const FIGURE_6: &str = "contact.stiffness=2.9e14 contact.deadBand=1.46e-7";

/// Cubic contacts of pendulums with a period of 1 s, for two of five balls lifted by 0.05 m.
const CUBIC: &str = "gravity=39.47841760435743 pendulum.length=1 contact.stiffness=5e18 contact.overlapRef=1 \
                     contact.exponent=3 contact.deadBand=2e-5";

const HERTZ_IN_TOUCH: &str = "contact.model=hertz contact.deadBand=0";
const TWO_LIFTED: &str = "x_start[1]=-0.1 x_start[2]=-0.1";

/// All balls at rest in their rest positions but for these settings; initialized at t = 0.
fn ready(balls: usize, settings: &str) -> Host {
    let host = Host::with_balls(balls);
    host.give("x_start=0");
    host.give(settings);
    host.start();
    host
}

/// Figure 6's set-up with these settings, to be run for 600 s: 2,562 pulses.
pub fn ten_minutes(settings: &str) -> Host {
    ready(5, &format!("x_start[1]=-1 x_start[2]=-1 {FIGURE_6} {settings}"))
}

/// Cubic contacts, to be run for 600 s: 7,194 pulses.
pub fn cubic(solver: &str) -> Host {
    ready(5, &format!("x_start[1]=-0.05 x_start[2]=-0.05 {CUBIC} {solver}"))
}

/// Five touching steel balls with these settings, to be run for 60 s.
pub fn steel(settings: &str) -> Host {
    ready(5, &format!("{TWO_LIFTED} {HERTZ_IN_TOUCH} {settings}"))
}

/// Figure 3: waves that cross in thirteen balls, three lifted on the left and two on the right.
pub fn figure3() -> Host {
    let lifted = "x_start[3]=-0.1 x_start[12]=0.1 x_start[13]=0.1";
    ready(13, &format!("{TWO_LIFTED} {lifted} pendulum.length=1 contact.stiffness=4e4 contact.deadBand=0"))
}

/// A line of 1000 touching steel balls, the first struck to 1 m/s: the wave is through after 0.2 s.
pub fn hertz_line() -> Host {
    ready(1000, &format!("gravity=0 v_start[1]=1 {HERTZ_IN_TOUCH}"))
}

/// Hunt-Crossley damping with the coefficient of restitution 0.95 at the first impact, at 0.1 m sqrt(g/L): alpha v =
/// 0.0789266 from `a - ln(1 + a) = -b - ln(1 - b)` with `a = alpha v`, `b = 0.95 a`.
pub fn settling() -> Host {
    ready(5, &format!("{TWO_LIFTED} contact.dampingLaw=huntCrossley contact.huntCrossley=0.352970509"))
}

/// A chain pressed by 10 N from both ends with half-critical damping.
pub fn pressed() -> Host {
    ready(5, &format!("F_ext[1]=10 F_ext[5]=-10 {}", damping(0.5)))
}

/// The same chain with steel balls of different masses, which has no natural modes.
pub fn pressed_steel() -> Host {
    let steel = "contact.model=hertz ball.massRatio[2]=2 ball.massRatio[4]=0.7";
    ready(5, &format!("F_ext[1]=10 F_ext[5]=-10 {steel} {}", damping(0.5)))
}

/// Thirteen balls of undamped contacts, the outer ones pressed by 20 N: they rattle for ever.
pub fn rattling() -> Host {
    ready(13, "contact.exponent=1.5 contact.deadBand=0 F_ext[1]=20 F_ext[13]=-20")
}

/// Thirteen unequal balls with Hunt-Crossley damping, the outer ones pressed by 50 N: they ring for long.
pub fn ringing() -> Host {
    let law = "contact.exponent=2.3 contact.deadBand=0 contact.dampingLaw=huntCrossley contact.huntCrossley=0.3";
    let ratios = [1, 4, 7, 10, 13].map(|i| format!("ball.massRatio[{i}]=2 pendulum.lengthRatio[{i}]=0.8"));
    ready(13, &format!("{law} F_ext[1]=50 F_ext[13]=-50 {}", ratios.join(" ")))
}

/// Two elastic rigid balls on a line that a force presses together and drag brings to rest.
pub fn elastic_chatter() -> Host {
    let push = "gravity=0 pendulum.drag=2 F_ext[1]=2 x_start[1]=-0.01";
    ready(2, &format!("contact.model=rigid contact.deadBand=0 {push}"))
}

/// Kelvin-Voigt damping in units of the critical one of the default contacts, `c = 2 sqrt(k m / 2)`.
fn damping(critical: f64) -> String {
    format!("contact.damping={}", critical * 2.0 * (1e10f64 / 2.0).sqrt())
}

/// The default cradle with this damping, in units of the critical one.
pub fn damped(critical: f64) -> Host {
    ready(5, &format!("{TWO_LIFTED} {}", damping(critical)))
}

/// The default cradle.
pub fn default_cradle() -> Host {
    damped(0.0)
}

/// The default cradle with dead bands so wide that nothing ever touches.
pub fn in_flight() -> Host {
    ready(5, &format!("{TWO_LIFTED} contact.deadBand=1"))
}

/// One ball lifted, a dead band that separates all pulses: n - 1 of them in each stroke.
pub fn separated(balls: usize) -> Host {
    ready(balls, "x_start[1]=-0.1")
}
