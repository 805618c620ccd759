//! What to expect of a step before any attempt: which contacts switch and when, where branch points are, how long a
//! step may be.

use super::motion::{Motion, Track};
use super::switching::fall;
use crate::engine::cluster::window::{Equations, Window};
use crate::engine::flight::Rounding;
use crate::model::{ContactLaw, Damping, Mode};
use crate::solver::gauss::{Power, Stretching};

/// Contacts that have just closed at less than this part of the speed of the others, or that overlap by less than this
/// part of the largest overlap, do not call for a stretched step.
const NEGLIGIBLE: f64 = 1e-6;

/// What the rate at the release counts for in the mean rate up to there: from rest on that takes half the duration of
/// an impact.
const LAST_IN_MEAN: f64 = 0.68;

/// Longest step, over the time scale of the pendulums: the error of their part is not looked at.
const LONGEST: f64 = 0.25;

/// See [`Motion::smoothness`]; guarded by `awkward_starts_keep_their_energy`.
const ROUGH: f64 = 0.01;

/// A contact that has closed shortly before a step has a branch point there: one that has changed the speed by more
/// than this part allows a step of so many times the time since then. Guarded by `balls_that_rattle`.
const BRANCH_POINT: f64 = 1e-15;
const BEYOND: f64 = 50.0;

impl Motion {
    /// A closed contact without overlap whose balls part.
    pub(super) fn parting(&self, rounding: &Rounding) -> Option<usize> {
        self.tracks.iter().position(|track| {
            track.mode != Mode::Open && track.overlap <= rounding.no_overlap() && track.rate < -rounding.velocity
        })
    }

    /// The stretching for contacts that have just closed, if there are any, at a rate that counts at this `speed`
    /// (m/s).
    pub(super) fn onset_stretching(&self, rounding: &Rounding, speed: f64) -> Option<Stretching> {
        let fresh = |track: &Track| {
            track.mode == Mode::Pressing && track.overlap <= rounding.no_overlap() && track.rate >= NEGLIGIBLE * speed
        };
        let fresh = self.tracks.iter().any(fresh);
        fresh.then(|| self.stretching_power().map_or(Stretching::None, Stretching::AtStart))
    }

    /// The power by which time is stretched where a contact opens or closes, if forces have a branch point there.
    pub(super) fn stretching_power(&self) -> Option<Power> {
        self.tracks.iter().find_map(|track| power_of_stretching(&track.law))
    }

    /// What the highest Legendre coefficients may be over those of smooth forces. A damping force that grows with a
    /// power below 1 remains one of `c` that is not whole, whatever the stretching: its coefficients fall slowly, and
    /// the end of the step is not as far ahead of them.
    pub(super) fn smoothness(&self) -> f64 {
        let rough = |track: &Track| {
            let relaxes = matches!(track.law.damping, Damping::Viscoelastic { .. });
            relaxes && track.law.exponent < 2.0 && !track.law.has_root()
        };
        if self.tracks.iter().any(rough) { ROUGH } else { 1.0 }
    }

    /// The time in which the fastest contact stops balls of this `speed` (m/s), s.
    pub(super) fn fastest(&self, window: &Window, speed: f64) -> f64 {
        let mut fastest = f64::INFINITY;
        let mut last = None;
        for (j, track) in self.tracks.iter().enumerate().filter(|(_, track)| track.mode == Mode::Pressing) {
            let (mass, law) = (window.reduced_mass(j), &track.law);
            if last != Some((mass, law)) {
                fastest = fastest.min(law.largest_overlap(mass, speed) / speed);
            }
            last = Some((mass, law));
        }
        fastest
    }

    /// The longest step on which the pendulums hardly act, s.
    pub(super) fn longest(&self) -> f64 {
        let pace = self.pace();
        if pace > 0.0 { LONGEST / pace } else { f64::INFINITY }
    }

    /// How long a step may be for the branch points that lie shortly before it (s): those of contacts that have closed
    /// just now. A step that begins with another branch point has its time stretched for that one only.
    pub(super) fn reach_of_branch_points(&self, speed: f64) -> f64 {
        let since =
            self.tracks.iter().filter_map(|track| self.to_branch_point(track, track.overlap, track.rate, speed));
        since.fold(f64::INFINITY, |least, since| least.min(BEYOND * since))
    }

    /// How far the branch point of a contact with this overlap (m) is, which grows from there or falls up to there at
    /// this rate (m/s), in s; `None` if its force will not change the `speed` (m/s) by what matters.
    fn to_branch_point(&self, track: &Track, overlap: f64, rate: f64, speed: f64) -> Option<f64> {
        if track.mode != Mode::Pressing || !(overlap > 0.0 && rate > 0.0) {
            return None;
        }
        power_of_stretching(&track.law)?;
        let (time, inverse_mass) = (overlap / rate, track.inverse_masses[0] + track.inverse_masses[1]);
        (track.law.elastic_force(overlap) * time * inverse_mass > BRANCH_POINT * speed).then_some(time)
    }

    /// The closed contact that is first to open, or to be clipped, and when, s. One that hardly presses has no branch
    /// point that matters, and may never open.
    pub(super) fn release_ahead(&self, rounding: &Rounding) -> Option<(usize, f64)> {
        let largest = self.tracks.iter().map(|track| track.overlap).fold(0.0, f64::max);
        let negligible = rounding.no_overlap().max(NEGLIGIBLE * largest);
        let opens = |track: &Track| track.mode == Mode::Pressing && track.rate < 0.0 && track.overlap > negligible;
        self.first_at_zero(|track| {
            if !opens(track) {
                return None;
            }
            let inverse_mass = track.inverse_masses[0] + track.inverse_masses[1];
            let own = inverse_mass * track.law.unclipped_force(track.overlap, track.rate).max(0.0);
            // Its own force drives the balls apart and vanishes on the way: by the energy that it has yet to give them.
            let last = (track.rate * track.rate + 2.0 * own * track.overlap / (track.law.exponent + 1.0)).sqrt();
            let rate = (1.0 - LAST_IN_MEAN) * track.rate - LAST_IN_MEAN * last;
            Some((rate, (track.acceleration + own).max(0.0)))
        })
    }

    /// The contact that is first to open of those that are clipped, or to close, and when, s: without a force there is
    /// no branch point. When those close whose balls are side by side, rounding cannot tell.
    pub(super) fn switching_ahead(&self, rounding: &Rounding) -> Option<(usize, f64)> {
        self.first_at_zero(|track| {
            let switches = match track.mode {
                Mode::Open => track.overlap < 0.0 && track.rate > 0.0 && !track.is_resting(rounding),
                Mode::Clipped => track.rate < 0.0,
                Mode::Pressing => false,
            };
            switches.then_some((track.rate, track.acceleration))
        })
    }

    /// The first of the contacts whose overlap vanishes with the rate (m/s) and the acceleration (m/s2) of a `motion`,
    /// and when, s.
    fn first_at_zero(&self, motion: impl Fn(&Track) -> Option<(f64, f64)>) -> Option<(usize, f64)> {
        let at_zero = |(j, track): (usize, &Track)| {
            let side = if track.overlap > 0.0 { 1.0 } else { -1.0 };
            let (rate, acceleration) = motion(track)?;
            fall(side * track.overlap, side * rate, 0.5 * side * acceleration).map(|time| (j, time))
        };
        self.tracks.iter().enumerate().filter_map(at_zero).min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// The power by which time is stretched where a contact with this law opens or closes. With `c^q`, the force times the
/// pace of the time goes with `c^(q p + q - 1)`: a polynomial if that is whole, nearly one if it is large. Higher
/// powers than it takes make steps shorter, and a whole exponent needs none.
fn power_of_stretching(law: &ContactLaw) -> Option<Power> {
    match law.whole_exponent() {
        Some(_) => None,
        None if law.has_root() || law.exponent > 2.0 => Some(Power::Square),
        None => Some(Power::Cube),
    }
}
