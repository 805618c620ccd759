//! Why a run cannot go on.

pub use super::flight::Fault;
use super::observer::Activity;
use crate::number::Number;

/// Why a run cannot go on, with the time and the values.
#[derive(Clone, Debug, PartialEq)]
pub enum EngineError {
    /// A state became infinite or NaN.
    NotFinite {
        /// Time, s.
        time: f64,
        /// Ball, from 0.
        ball: usize,
    },
    /// In model exchange: no place of a ball on its arc fits the states.
    NoPlace {
        /// Time, s.
        time: f64,
        /// Ball, from 0.
        ball: usize,
    },
    /// The overlap, the force or the impulse of a contact became infinite or NaN.
    ContactNotFinite {
        /// Time, s.
        time: f64,
        /// Contact, from 0.
        contact: usize,
    },
    /// A ball cannot go on along its arc.
    OffArc {
        /// Time, s.
        time: f64,
        /// Ball, from 0.
        ball: usize,
        /// Reason.
        fault: Fault,
    },
    /// A coefficient of the equations is beyond the range of doubles; the text says which, and what is allowed.
    NoCoefficient(String),
    /// Balls on arcs cannot start like this; the text says why, and what is allowed.
    NoArc(String),
    /// Rigid contacts cannot start like this, or not by this method; the text says why, and what is allowed.
    NotRigid(String),
    /// The energy, or a sum over all balls, is beyond the range of doubles.
    EnergyNotFinite {
        /// Time, s.
        time: f64,
    },
    /// No progress in time: the step shrank below the resolution of doubles.
    Stalled {
        /// Time, s.
        time: f64,
        /// Contact, from 0.
        contact: usize,
    },
    /// The rest of the step would take days to compute.
    OutOfReach {
        /// Time, s.
        time: f64,
        /// What the run was computing.
        activity: Activity,
        /// Steps and events in a second of the run, 1/s.
        rate: f64,
    },
    /// A general-purpose solver fails even with its smallest steps.
    StepTooSmall {
        /// Time, s.
        time: f64,
        /// The step that failed, s.
        step: f64,
    },
}

impl std::fmt::Display for EngineError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match *self {
            Self::NotFinite { time, ball } => {
                write!(f, "the state of ball {} is not finite at t = {} s", ball + 1, Number(time))
            }
            Self::NoPlace { time, ball: 0 } => {
                write!(f, "x[1] lies farther out than its pendulum is long at t = {} s", Number(time))
            }
            Self::NoPlace { time, ball: j } => {
                let (ball, time) = (j + 1, Number(time));
                write!(f, "no place of ball {ball} within 90 degrees gives overlap[{j}] at t = {time} s")
            }
            Self::ContactNotFinite { time, contact } => {
                let (contact, time) = (contact + 1, Number(time));
                write!(f, "the overlap, the force or the impulse of contact {contact} is not finite at t = {time} s")
            }
            Self::OffArc { time, ball, fault } => {
                let ((what, allowed), time) = (off_arc(fault, ball), Number(time));
                write!(f, "{what} at t = {time} s; allowed with pendulum.model = circular: {allowed}")
            }
            Self::NoArc(ref text) => write!(f, "with pendulum.model = circular, {text}"),
            Self::NoCoefficient(ref text) | Self::NotRigid(ref text) => f.write_str(text),
            Self::EnergyNotFinite { time } => {
                let what = "the energy, the work or the impulse on the support";
                write!(f, "{what} is beyond the range of doubles at t = {} s", Number(time))
            }
            Self::Stalled { time, contact } => {
                write!(f, "no progress in contact {} at t = {} s", contact + 1, Number(time))
            }
            Self::OutOfReach { time, activity, rate } => {
                let (who, rounds) = match activity {
                    Activity::Contact(contact) => (format!("contact {}", contact + 1), "steps and events"),
                    Activity::Flight(ball) => (format!("the flight of ball {}", ball + 1), "steps"),
                    Activity::Solver => ("the solver".to_owned(), "steps"),
                };
                let time = Number(time);
                write!(
                    f,
                    "the step would take days: at t = {time} s, {who} needs {rate:.1e} {rounds} per second of the run"
                )
            }
            Self::StepTooSmall { time, step } => {
                write!(f, "the solver cannot go on at t = {} s, even with a step of {} s", Number(time), Number(step))
            }
        }
    }
}

/// What happens to `ball`, counted from 0, by this fault, and what is allowed instead.
fn off_arc(fault: Fault, ball: usize) -> (String, &'static str) {
    let (ball, next) = (ball + 1, ball + 2);
    let angles = "angles up to 90 degrees and tensions of 0 or more";
    match fault {
        Fault::Horizontal => (format!("pendulum {ball} swings beyond 90 degrees"), angles),
        Fault::Slack => (format!("the string of ball {ball} goes slack"), angles),
        Fault::Held => (
            format!("rigid balls {ball} and {next} are pressed together"),
            "that of balls with equal pendulum.lengthRatio, contact.gap + contact.deadBand = 0, and pendulum.drag = 0 \
             or equal ball.massRatio, which swing as one",
        ),
        Fault::Across => (
            format!("rigid balls {ball} and {next} meet across their arcs"),
            "impacts that push all balls in touch along their arcs in one sense",
        ),
        Fault::Sides => (
            format!("balls {ball} and {next} change sides"),
            "neighbours each of which stays on its side of the other one's string",
        ),
    }
}

impl std::error::Error for EngineError {}
