//! From the bytes of the fuzzer to values of everyday cradles, and some that are not.

use arbitrary::Arbitrary;
use cradle_host::extremes::extreme;
use newtons_cradle::variables::Variable;

/// A number: within the everyday range of what it is for, at the limits of what is allowed, or beyond.
#[derive(Clone, Debug, Arbitrary)]
pub enum Value {
    Everyday(u16),
    /// One of the [extremes](extreme), with which runs leave the range of doubles, or nothing happens.
    Extreme(u8),
    Min,
    Max,
    BelowMin,
    AboveMax,
    Nan,
    Infinite,
    MinusInfinite,
}

/// Where the host thinks it is.
#[derive(Clone, Debug, Arbitrary)]
pub enum Current {
    Exact,
    RoundedUp,
    RoundedDown,
    TooLate,
    TooEarly,
    Nan,
}

/// How far the host steps.
#[derive(Clone, Debug, Arbitrary)]
pub enum Step {
    /// Of any magnitude between the shortest and the longest.
    Length(u16),
    /// To the next onset, and a few nanoseconds beyond.
    Onset(u8),
    Zero,
    Back,
    Nan,
    Infinite,
}

/// Limits of [`Step::Length`], s.
const SHORTEST_STEP: f64 = 1e-9;
pub const LONGEST_STEP: f64 = 0.03;

/// The everyday ranges: family, low, high, and whether between them magnitudes rather than values are spread evenly.
const EVERYDAY: &[(&str, f64, f64, bool)] = &[
    ("gravity", 0.0, 20.0, false),
    ("ball.mass", 0.1, 10.0, true),
    ("ball.massRatio", 0.1, 10.0, true),
    ("ball.radius", 0.01, 0.1, true),
    ("ball.radiusRatio", 0.3, 3.0, true),
    ("ball.youngModulus", 1e8, 1e12, true),
    ("ball.youngModulusRatio", 0.01, 10.0, true),
    ("ball.poissonRatio", 0.0, 0.5, false),
    ("pendulum.length", 0.2, 3.0, true),
    ("pendulum.lengthRatio", 0.7, 1.4, false),
    ("pendulum.drag", 0.0, 2.0, false),
    ("contact.stiffness", 1e4, 1e10, true),
    ("contact.stiffnessRatio", 0.1, 10.0, true),
    ("contact.overlapRef", 1e-7, 1e-5, true),
    ("contact.exponent", 1.0, 5.0, false),
    ("contact.deadBand", 0.0, 1e-5, false),
    ("contact.gap", -1e-7, 1e-5, false),
    ("contact.damping", 0.0, 1e4, false),
    ("contact.huntCrossley", 0.0, 2.0, false),
    ("contact.relaxationTime", 1e-9, 1e-3, true),
    ("contact.lossRatio", 0.0, 3.0, false),
    // No ball is put far into its neighbour, wherever that one is.
    ("x_start[1]", -0.2, -0.1, false),
    ("x_start[2]", -0.1, -0.01, false),
    ("x_start[3]", -0.01, 0.0, false),
    ("x_start[4]", 0.0, 1e-7, false),
    ("x_start[5]", 1e-7, 0.1, false),
    ("v_start", -1.0, 1.0, false),
    ("solver.tolerance", 1e-14, 1e-3, true),
    ("solver.fixedStep", 1e-6, 1e-3, true),
    ("F_ext", -1.0, 1.0, false),
    ("a_support", -1.0, 1.0, false),
];

impl Value {
    /// For `variable`, or for a number that has no range.
    pub fn number(&self, variable: Option<Variable>) -> f64 {
        let (min, max) = variable.map_or((None, None), |variable| (variable.row.range.min, variable.row.range.max));
        match self {
            Self::Everyday(code) => everyday(*code, variable),
            Self::Extreme(code) => extreme(*code),
            // Without a limit there is nothing at it.
            Self::Min => min.unwrap_or(0.0),
            Self::Max => max.unwrap_or_else(|| everyday(u16::MAX, variable)),
            Self::BelowMin => min.map_or(f64::NEG_INFINITY, f64::next_down),
            Self::AboveMax => max.map_or(f64::INFINITY, f64::next_up),
            Self::Nan => f64::NAN,
            Self::Infinite => f64::INFINITY,
            Self::MinusInfinite => f64::NEG_INFINITY,
        }
    }
}

fn everyday(code: u16, variable: Option<Variable>) -> f64 {
    let part = f64::from(code) / f64::from(u16::MAX);
    let Some(variable) = variable else { return 2.0 * part - 1.0 };
    let (family, own) = (variable.row.name, variable.to_string());
    let range = EVERYDAY.iter().find(|(name, ..)| *name == own || *name == family);
    let (_, low, high, magnitudes) = range.copied().unwrap_or(("", -1.0, 1.0, false));
    if magnitudes { low * (high / low).powf(part) } else { low + part * (high - low) }
}

/// By how much a host's clock may differ from ours, s.
pub fn clock_tolerance(own: f64) -> f64 {
    1e-12 * own.abs().max(1.0)
}

impl Current {
    pub fn time(&self, own: f64) -> f64 {
        let allowed = clock_tolerance(own);
        match self {
            Self::Exact => own,
            Self::RoundedUp => own + 0.5 * allowed,
            Self::RoundedDown => own - 0.5 * allowed,
            Self::TooLate => own + 2.0 * allowed,
            Self::TooEarly => own - 2.0 * allowed,
            Self::Nan => f64::NAN,
        }
    }
}

impl Step {
    /// In s. The next onset lies `ahead`, if that is known.
    pub fn length(&self, ahead: f64, longest: f64) -> f64 {
        match self {
            Self::Length(code) => {
                SHORTEST_STEP * (LONGEST_STEP / SHORTEST_STEP).powf(f64::from(*code) / f64::from(u16::MAX))
            }
            Self::Onset(beyond) if ahead > 0.0 && ahead < longest => ahead + 1e-9 * f64::from(*beyond),
            Self::Onset(_) => 1e-6,
            Self::Zero => 0.0,
            Self::Back => -1e-3,
            Self::Nan => f64::NAN,
            Self::Infinite => f64::INFINITY,
        }
    }
}
