//! Why a run cannot go on.

use super::{Observer, Progress};
use crate::solver::double_double::DoubleDouble;

/// A run that cannot go on, with the time and the values that stopped it.
#[derive(Clone, Debug, PartialEq)]
pub enum EngineError {
    /// A state became infinite or NaN.
    NotFinite {
        /// When, s.
        time: f64,
        /// Whose, from 0.
        ball: usize,
    },
    /// The energy is beyond the range of doubles.
    EnergyNotFinite {
        /// When, s.
        time: f64,
    },
    /// No progress in time: the step shrank below the resolution of the clock.
    Stalled {
        /// When, s.
        time: f64,
        /// Where, from 0.
        contact: usize,
    },
    /// At this event_rate of events, the end of the step is out of reach.
    TooFast {
        /// When, s.
        time: f64,
        /// Where, from 0.
        contact: usize,
        /// Events in a second of the run, 1/s.
        event_rate: f64,
    },
    /// A general-purpose solver does not get on even with steps so small.
    StepTooSmall {
        /// When, s.
        time: f64,
        /// The step that failed, s.
        step: f64,
    },
    /// Rigid balls overlap at the start, a ball and the next.
    Overlap {
        /// The left one, from 0.
        ball: usize,
        /// By how much, m.
        overlap: f64,
    },
    /// Rigid contacts have no force that a general-purpose solver could integrate.
    NoForceLaw,
}

impl std::fmt::Display for EngineError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match *self {
            Self::NotFinite { time, ball } => {
                write!(f, "the state of ball {} is not finite at t = {} s", ball + 1, Plain(time))
            }
            Self::EnergyNotFinite { time } => {
                write!(f, "the energy of the cradle at t = {} s is beyond the range of doubles", Plain(time))
            }
            Self::Stalled { time, contact } => {
                write!(f, "no progress in contact {} at t = {} s", contact + 1, Plain(time))
            }
            Self::TooFast { time, contact, event_rate } => write!(
                f,
                "contact {} is too fast to be followed to the end of the step: {event_rate:.1e} events a second at t = {} s",
                contact + 1,
                Plain(time)
            ),
            Self::StepTooSmall { time, step } => {
                write!(f, "the solver cannot go on at t = {} s, not even by {} s", Plain(time), Plain(step))
            }
            Self::Overlap { ball, overlap } => write!(
                f,
                "rigid balls {left} and {right} overlap by {overlap:.4e} m; allowed: x_start[{left}] - x_start[{right}] up \
                 to contact.gap[{left}] + contact.deadBand",
                left = ball + 1,
                right = ball + 2
            ),
            Self::NoForceLaw => write!(
                f,
                "contact.model = rigid has no contact force that solver.method could integrate; allowed with it: \
                 eventDriven (1)"
            ),
        }
    }
}

/// All digits of a number, with a power of ten where there would be many zeros.
struct Plain(f64);

impl std::fmt::Display for Plain {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self(value) = *self;
        if value == 0.0 || (1e-4..1e9).contains(&value.abs()) { write!(f, "{value}") } else { write!(f, "{value:e}") }
    }
}

impl std::error::Error for EngineError {}

/// Watches a call of [`advance`](super::Engine::advance): tells how far it has come, and gives up where the events follow each other
/// so fast that the end of the step would not be reached in days: the values of a cradle may be any numbers above 0.
pub(super) struct Endurance {
    until: DoubleDouble,
    /// Events so far.
    events: u64,
    /// Effort up to which nobody need be told of the progress.
    quiet_until: Option<u64>,
    /// Number and time of the events at the last look at the clock, and how often in a row it was hopeless then.
    last: (u64, DoubleDouble),
    hopeless: u32,
}

impl Endurance {
    /// Effort (see [`Engine::effort`](super::Engine)) from one report to the next: some milliseconds.
    const REPORT: u64 = 50_000;
    /// Events from one look at the clock to the next, how many to the end are hopeless, and for how many looks.
    const EVENTS: u64 = 1 << 17;
    const HOPELESS: f64 = 1e11;
    const LOOKS: u32 = 8;

    pub fn new(start: DoubleDouble, until: DoubleDouble) -> Self {
        Self { until, events: 0, quiet_until: None, last: (0, start), hopeless: 0 }
    }

    /// Counts the event of `contact` at `t`, before which the run had taken this `effort`.
    #[inline]
    pub fn check(
        &mut self,
        t: DoubleDouble,
        contact: usize,
        effort: u64,
        observer: &mut dyn Observer,
    ) -> Result<(), EngineError> {
        self.events += 1;
        let quiet_until = *self.quiet_until.get_or_insert(effort.saturating_add(Self::REPORT));
        if effort > quiet_until {
            self.quiet_until = None;
            observer.progress(Progress { time: t.value(), events: self.events, contact: Some(contact) });
        }
        let (before, since) = self.last;
        if self.events - before < Self::EVENTS {
            return Ok(());
        }
        let event_rate = (self.events - before) as f64 / (t - since).value();
        self.hopeless = if event_rate * (self.until - t).value() > Self::HOPELESS { self.hopeless + 1 } else { 0 };
        self.last = (self.events, t);
        if self.hopeless < Self::LOOKS {
            return Ok(());
        }
        Err(EngineError::TooFast { time: t.value(), contact, event_rate })
    }
}
