//! What the host says about the run as a whole.

use serde::{Deserialize, Serialize};

use super::refusal::Refusal;

/// Tightest relative tolerance.
const MIN_TOLERANCE: f64 = 1e-14;

/// Start, stop and tolerance of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Experiment {
    /// Start time, s, finite.
    pub start: f64,
    /// Stop time, s, after the start, if the host gave one.
    pub stop: Option<f64>,
    /// Relative tolerance, if the host gave one; nonsense is ignored.
    pub tolerance: Option<f64>,
}

impl Experiment {
    /// Refuses times that are no times.
    pub(super) fn check(&self) -> Result<(), Refusal> {
        if !self.start.is_finite() {
            return Err(Refusal::number("startTime", self.start, "s", "any finite value"));
        }
        match self.stop {
            Some(stop) if stop.is_nan() || stop <= self.start => {
                Err(Refusal::number("stopTime", stop, "s", format!("later than startTime = {} s", self.start)))
            }
            _ => Ok(()),
        }
    }

    /// `own`, the tolerance parameter, tightened to the host's where that is smaller, but not below 1e-14.
    pub(super) fn tighten(&self, own: f64) -> f64 {
        match self.tolerance {
            Some(host) if host > 0.0 => own.min(host.max(MIN_TOLERANCE)),
            _ => own,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(tolerance: f64) -> Experiment {
        Experiment { tolerance: Some(tolerance), ..Experiment::default() }
    }

    #[test]
    fn a_tolerance_only_tightens() {
        assert_eq!(with(1e-4).tighten(1e-12), 1e-12);
        assert_eq!(with(1e-13).tighten(1e-12), 1e-13);
        assert_eq!(with(1e-20).tighten(1e-12), 1e-14);
        assert_eq!(Experiment::default().tighten(1e-9), 1e-9);
        for nonsense in [f64::NAN, 0.0, -1.0, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(with(nonsense).tighten(1e-12), 1e-12);
        }
    }

    #[test]
    fn times_must_be_times() {
        let times = |start, stop| Experiment { start, stop, tolerance: None }.check();
        assert!(times(0.0, None).is_ok() && times(-5.0, Some(-4.0)).is_ok());
        for (start, stop) in
            [(f64::NAN, None), (f64::INFINITY, None), (0.0, Some(0.0)), (0.0, Some(f64::NAN)), (1.0, Some(0.5))]
        {
            assert!(times(start, stop).is_err(), "{start} {stop:?}");
        }
    }
}
