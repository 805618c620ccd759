//! Why a run cannot go on.

pub use super::flight::Fault;

/// Why a run cannot go on, with the time and the values.
#[derive(Clone, Debug, PartialEq)]
pub enum EngineError {
    /// A state became infinite or NaN.
    NotFinite {
        /// When, s.
        time: f64,
        /// Whose, from 0.
        ball: usize,
    },
    /// A ball cannot go on along its arc.
    OffArc {
        /// When, s.
        time: f64,
        /// Which, from 0.
        ball: usize,
        /// Why.
        fault: Fault,
    },
    /// Balls on arcs cannot start like this; the text says why, and what is allowed.
    NoArc(String),
    /// Rigid contacts cannot start like this, or not by this method; the text says why, and what is allowed.
    NotRigid(String),
    /// The energy is beyond the range of doubles.
    EnergyNotFinite {
        /// When, s.
        time: f64,
    },
    /// No progress in time: the step shrank below the resolution of doubles.
    Stalled {
        /// When, s.
        time: f64,
        /// Where, from 0.
        contact: usize,
    },
    /// Events and searches are so frequent that the end of the step is out of reach.
    TooFast {
        /// When, s.
        time: f64,
        /// Where, from 0.
        contact: usize,
        /// Events in a second of the run, 1/s.
        event_rate: f64,
    },
    /// A general-purpose solver fails even with such small steps.
    StepTooSmall {
        /// When, s.
        time: f64,
        /// The step that failed, s.
        step: f64,
    },
}

impl std::fmt::Display for EngineError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match *self {
            Self::NotFinite { time, ball } => {
                write!(f, "the state of ball {} is not finite at t = {} s", ball + 1, Plain(time))
            }
            Self::OffArc { time, ball, fault } => {
                let (ball, time) = (ball + 1, Plain(time));
                let next = ball + 1;
                let what = match fault {
                    Fault::Horizontal => format!("pendulum {ball} swings beyond 90 degrees"),
                    Fault::Slack => format!("the string of ball {ball} goes slack"),
                    Fault::Held => format!("rigid balls {ball} and {next} are pressed together"),
                    Fault::Across => format!("balls {ball} and {next} change sides"),
                };
                let allowed = match fault {
                    Fault::Horizontal | Fault::Slack => "angles up to 90 degrees and tensions of 0 or more",
                    Fault::Held => {
                        "that of balls with equal pendulum.lengthRatio, contact.gap + contact.deadBand = 0, \
                         and pendulum.drag = 0 or equal ball.massRatio, which swing as one"
                    }
                    Fault::Across => "neighbours each of which stays on its side of the other one's string",
                };
                write!(f, "{what} at t = {time} s; allowed with pendulum.model = circular: {allowed}")
            }
            Self::NoArc(ref text) => write!(f, "with pendulum.model = circular, {text}"),
            Self::NotRigid(ref text) => f.write_str(text),
            Self::EnergyNotFinite { time } => {
                write!(f, "the energy of the cradle at t = {} s is beyond the range of doubles", Plain(time))
            }
            Self::Stalled { time, contact } => {
                write!(f, "no progress in contact {} at t = {} s", contact + 1, Plain(time))
            }
            Self::TooFast { time, contact, event_rate } => write!(
                f,
                "contact {} keeps the run too busy to reach the end of the step: {event_rate:.1e} events per second at \
                 t = {} s",
                contact + 1,
                Plain(time)
            ),
            Self::StepTooSmall { time, step } => {
                write!(f, "the solver cannot go on at t = {} s, even with a step of {} s", Plain(time), Plain(step))
            }
        }
    }
}

/// All digits of a number, with a power of ten instead of many zeros.
struct Plain(f64);

impl std::fmt::Display for Plain {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self(value) = *self;
        if value == 0.0 || (1e-4..1e9).contains(&value.abs()) { write!(f, "{value}") } else { write!(f, "{value:e}") }
    }
}

impl std::error::Error for EngineError {}
