//! Explicit Gauss collocation: groups of balls with contacts that are not linear, followed by steps of some tenths of a contact's
//! duration.
//!
//! A power of the overlap that is not whole has a branch point where the contact closes or opens. A power series of the time
//! converges no further than to there; a step of collocation ends there, or starts there, with its time stretched (`solver::gauss`).
//! `step` computes one step, by the `iteration` and the `switching`s that it finds; `motion` holds it, and `output` reads off what there
//! is to be known.

mod iteration;
mod motion;
mod output;
mod step;
mod switching;

use step::{Outcome, Plan};

use super::step_control::Control;
use super::window::{Switch, Window, WindowContact};
use crate::engine::flight::Rounding;
use crate::model::{ContactLaw, Mode};
use crate::solver::gauss::{NODES, Power, Stretching};

use motion::{Tolerance, Track};
use switching::fall;

pub(crate) use motion::Motion;

/// What the two highest Legendre coefficients may be over the scale of the velocities, for the local error of the default
/// tolerance. The end of a step has twice as many digits: an error of 1e-16, within the step one of 3e-14.
const TAIL: f64 = 1e-10;
const EPSILON: f64 = 1e-17;

/// First step over the time that the fastest contact takes to stop its balls: after an onset at speed or another switching; where a
/// wave starts in balls that touch; and for a whole exponent, times that, after any of these.
const FIRST: f64 = 0.5;
const FIRST_OF_WAVE: f64 = 0.3;
const FIRST_SMOOTH: f64 = 1.6;

/// Contacts that have just closed at less than this part of the speed of the others, or that overlap by less than this part of the
/// largest overlap, do not call for a stretched step.
const FAINT: f64 = 1e-6;

/// What the rate at the release counts for in the mean rate up to there: from rest on that takes half the duration of an impact.
const LAST_IN_MEAN: f64 = 0.68;

/// A contact that is so many steps from its release may be followed up to there: in a time that is not stretched,
/// by squares, by cubes, and a contact that has no force up to its switching.
const NEAR_RELEASE: f64 = 0.9;
const NEAR_BY_SQUARES: f64 = 0.7;
const NEAR_BY_CUBES: f64 = 0.5;
const NEAR_SWITCHING: f64 = 1.2;

/// How a step follows from the last one: the part of what the error allows, and the least and largest factor. And a step after one
/// that did not reach a release, after one that failed.
const SAFETY: f64 = 0.93;
const CHANGE: [f64; 2] = [0.3, 4.0];
const SHORT_OF_RELEASE: f64 = 0.65;
const FAILED: f64 = 0.5;
const LEAST: f64 = 0.05;

/// A contact that has closed shortly before a step has a branch point there: one that has changed the speed by more than this part allows
/// a step of so many times the time since then.
const BRANCH_POINT: f64 = 1e-15;
const BEYOND: f64 = 50.0;

/// An error, in units of the one allowed, that would let the next step be much longer.
const SMALL: f64 = 1e-3;

/// Contacts whose damping acts within less than this part of their time scale are stiff: Picard's iteration allows them short steps only,
/// and what balls at rest do next is decided within much less than a step.
const STIFF: f64 = 0.1;

/// Attempts for one step, after which it is left to another method.
const ATTEMPTS: usize = 40;

/// What a step took and says about the next one.
pub(super) struct Followed {
    /// Its length and the one that the next one may have, s.
    pub length: f64,
    pub next: f64,
}

/// Whether some contacts press, the closed ones are few and not linear, the sign of a force that may be clipped is simple, damping at
/// this `speed` (m/s) is not stiff, and all pendulums are equal.
pub(super) fn applies_to(window: &Window, speed: f64) -> bool {
    let is_stiff = |(j, law): (usize, &ContactLaw)| {
        window.contacts[j].mode != Mode::Open && law.relaxes_within(STIFF, window.reduced_mass(j), speed)
    };
    let serves = |(contact, law): (&WindowContact, &ContactLaw)| {
        contact.mode == Mode::Open || (!law.is_linear() && (!law.clips() || law.sign_of_force().is_some()))
    };
    let presses = |contact: &WindowContact| contact.mode == Mode::Pressing;
    window.contacts.iter().any(presses)
        && window.contacts.iter().zip(window.laws).all(serves)
        && !window.laws.iter().enumerate().any(is_stiff)
}

impl Motion {
    /// Describes the motion of `window` for a step, which `before` (s, 0 if there was none) says the length of. `None` if the method
    /// does not serve. Adds the `evaluations` of forces, each at all nodes.
    pub(super) fn follow(
        &mut self,
        window: &Window,
        control: &Control,
        rounding: &Rounding,
        speed: f64,
        before: f64,
        evaluations: &mut u64,
    ) -> Option<Followed> {
        self.start(window);
        let wave = self.is_wave(rounding);
        let onset = self.onset_stretching(rounding, if wave { 0.0 } else { FAINT * speed });
        let speed = if onset.is_some() { speed.max(self.speed_from_rest(window)) } else { speed };
        let local_error = control.local_error(speed);
        let tail = TAIL * (control.epsilon / EPSILON).sqrt().max(1.0);
        let longest = self.longest().min(control.longest).min(self.reach_of_branch_points(speed));
        let tolerance = Tolerance { speed, tail, local_error, longest, rounding: *rounding };
        if let Some(j) = self.parting(rounding) {
            self.ends_at_once(j, Switch::Release);
            return Some(Followed { length: 0.0, next: before });
        }
        let power = self.stretching_power();
        let mut length = match before > 0.0 {
            true => before,
            false if power.is_none() => FIRST_SMOOTH / self.tracks[0].law.exponent * self.fastest(window, speed),
            false if wave => FIRST_OF_WAVE * self.fastest(window, speed),
            false => FIRST * self.fastest(window, speed),
        };
        let mut plan = Plan { stretching: onset.unwrap_or_default(), length, switching: None };
        let within =
            |ahead: Option<(usize, f64)>, most: f64| ahead.filter(|(_, time)| (f64::MIN_POSITIVE..most).contains(time));
        let release = self.release_ahead(rounding);
        let near_release = match power {
            None => NEAR_RELEASE,
            Some(Power::Square) => NEAR_BY_SQUARES,
            Some(Power::Cube) => NEAR_BY_CUBES,
        };
        // A step that begins with a branch point does not end with one.
        if plan.stretching == Stretching::None
            && let Some((j, time)) = within(release, near_release * length)
        {
            plan = self.to_release(j, time);
        } else if let Some((j, time)) = within(self.switching_ahead(rounding), NEAR_SWITCHING * length) {
            plan = Plan { length: time, switching: Some(j), ..plan };
        } else if let Some((_, time)) = release
            && power.is_some()
        {
            plan.length = length.min(SHORT_OF_RELEASE * time);
        }
        let (mut refused, mut crossed) = (false, false);
        for _ in 0..ATTEMPTS {
            plan.length = plan.length.min(longest);
            if plan.length.is_nan() || plan.length < f64::MIN_POSITIVE {
                return None;
            }
            let outcome = self.attempt(&plan, &tolerance, evaluations);
            // An iteration that diverges may have moved the end anywhere.
            let (reached, least) = (self.length, LEAST * plan.length);
            let tried = reached.clamp(least, plan.length);
            if plan.switching.is_none() {
                length = length.min(plan.length);
            }
            crossed |= matches!(outcome, Outcome::Within(..));
            refused |= plan.switching.is_none() && matches!(outcome, Outcome::Failed | Outcome::TooLong(_));
            plan = match outcome {
                Outcome::Stands(error) => {
                    let proposed = reached * change_for(error);
                    let next = match plan.switching {
                        // A step that ended early says nothing against long ones.
                        Some(_) => length.max(reached),
                        // A longer step has just failed, although the error is small: it is the iteration that allows no more.
                        None if refused && error < SMALL => proposed.min(reached),
                        None => proposed,
                    };
                    self.moment.get_mut().forget();
                    return Some(Followed { length: self.until, next: next.min(longest) });
                }
                // Which way a force, or an overlap at rest, goes from 0 its mean slope over a step does not tell; a series does.
                Outcome::AtOnce(_, Switch::Clip | Switch::Unclip) => return None,
                Outcome::AtOnce(j, Switch::Release) if self.tracks[j].is_resting(rounding) => return None,
                Outcome::AtOnce(j, switch) => {
                    self.ends_at_once(j, switch);
                    return Some(Followed { length: 0.0, next: before });
                }
                // It switches before the end that was found for it, and the same step would come to the same end.
                Outcome::Within(j, _, time) if plan.switching == Some(j) => Plan {
                    stretching: onset.unwrap_or_default(),
                    length: SHORT_OF_RELEASE * time.max(least),
                    switching: None,
                },
                Outcome::Within(j, Switch::Release, time) if self.tracks[j].mode == Mode::Pressing => {
                    match plan.stretching {
                        Stretching::None | Stretching::AtEnd(_) => self.to_release(j, time.max(least)),
                        // It closes and opens in one step.
                        Stretching::AtStart(_) => Plan { length: FAILED * time.max(least), switching: None, ..plan },
                    }
                }
                Outcome::Within(j, _, time) => {
                    let stretching = onset.unwrap_or_default();
                    Plan { stretching, length: time.max(least), switching: Some(j) }
                }
                Outcome::NoSwitching => {
                    if crossed || plan.switching.is_none() {
                        // It nearly opens, and the same step would come to the same end.
                        length = SHORT_OF_RELEASE * length.min(reached.max(least));
                    }
                    Plan { stretching: onset.unwrap_or_default(), length, switching: None }
                }
                Outcome::LeftEarly(time) => {
                    Plan { stretching: onset.unwrap_or_default(), length: 2.0 * time, switching: None }
                }
                Outcome::TooLong(_) | Outcome::Failed if plan.switching.is_some() => {
                    length = SHORT_OF_RELEASE * tried;
                    Plan { stretching: onset.unwrap_or_default(), length, switching: None }
                }
                Outcome::TooLong(error) => Plan { length: tried * change_for(error).min(0.7), ..plan },
                Outcome::Failed => Plan { length: FAILED * tried, ..plan },
            };
        }
        None
    }

    fn ends_at_once(&mut self, j: usize, switch: Switch) {
        (self.length, self.until, self.end) = (0.0, 0.0, Some((j, switch)));
        self.forces.iter_mut().for_each(|forces| *forces = [0.0; NODES]);
        self.moment.get_mut().forget();
    }

    /// A closed contact without overlap whose balls part.
    fn parting(&self, rounding: &Rounding) -> Option<usize> {
        self.tracks.iter().position(|track| {
            track.mode != Mode::Open && track.overlap <= rounding.no_overlap() && track.rate < -rounding.velocity
        })
    }

    /// The stretching for contacts that have just closed at this rate (m/s) or faster, if there are any.
    fn onset_stretching(&self, rounding: &Rounding, rate: f64) -> Option<Stretching> {
        let fresh = |track: &Track| {
            track.mode == Mode::Pressing && track.overlap <= rounding.no_overlap() && track.rate >= rate
        };
        let fresh = self.tracks.iter().any(fresh);
        fresh.then(|| self.stretching_power().map_or(Stretching::None, Stretching::AtStart))
    }

    /// The power by which time is stretched where a contact opens or closes, if forces have a branch point there.
    pub(super) fn stretching_power(&self) -> Option<Power> {
        self.tracks.iter().find_map(|track| power_of_stretching(&track.law))
    }

    /// Whether all closed contacts have just closed, and some of their balls have yet to move.
    fn is_wave(&self, rounding: &Rounding) -> bool {
        let mut closed = self.tracks.iter().filter(|track| track.mode == Mode::Pressing);
        let at_rest = |track: &Track| track.is_resting(rounding);
        closed.clone().all(|track| track.overlap <= rounding.no_overlap()) && closed.any(at_rest)
    }

    /// What the other accelerations lead to from rest until a contact balances them, m/s.
    fn speed_from_rest(&self, window: &Window) -> f64 {
        let mut speed = 0.0_f64;
        for (j, track) in self.tracks.iter().enumerate().filter(|(_, track)| track.mode == Mode::Pressing) {
            let acceleration = (track.pull - track.mean[0] * track.overlap).abs();
            speed = speed.max(track.law.speed_from_rest(window.reduced_mass(j), acceleration));
        }
        speed
    }

    /// The time in which the fastest contact stops balls of this `speed` (m/s), s.
    fn fastest(&self, window: &Window, speed: f64) -> f64 {
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

    /// The longest step for which the functions of the pendulum are at hand, s.
    fn longest(&self) -> f64 {
        let pace = self.pace();
        if pace > 0.0 { output::LONGEST / pace } else { f64::INFINITY }
    }

    /// How long a step may be for the branch points that lie shortly before it (s): those of contacts that have closed just now. A step
    /// that begins with another branch point has its time stretched for that one only.
    fn reach_of_branch_points(&self, speed: f64) -> f64 {
        let since =
            self.tracks.iter().filter_map(|track| self.to_branch_point(track, track.overlap, track.rate, speed));
        since.fold(f64::INFINITY, |least, since| least.min(BEYOND * since))
    }

    /// How far the branch point of a contact with this overlap (m) is, which grows from there or falls up to there at this rate (m/s), in
    /// s; `None` if its force will not change the `speed` (m/s) by what matters.
    fn to_branch_point(&self, track: &Track, overlap: f64, rate: f64, speed: f64) -> Option<f64> {
        if track.mode != Mode::Pressing || !(overlap > 0.0 && rate > 0.0) {
            return None;
        }
        power_of_stretching(&track.law)?;
        let (time, inverse_mass) = (overlap / rate, track.inverse_masses[0] + track.inverse_masses[1]);
        (track.law.elastic_force(overlap) * time * inverse_mass > BRANCH_POINT * speed).then_some(time)
    }

    /// The closed contact that is first to open, or to be clipped, and when, s. One that hardly presses has no branch point that matters,
    /// and may never open.
    fn release_ahead(&self, rounding: &Rounding) -> Option<(usize, f64)> {
        let largest = self.tracks.iter().map(|track| track.overlap).fold(0.0, f64::max);
        let faint = rounding.no_overlap().max(FAINT * largest);
        let opens = |track: &Track| track.mode == Mode::Pressing && track.rate < 0.0 && track.overlap > faint;
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

    /// The contact that is first to open of those that are clipped, or to close, and when, s: without a force there is no branch point.
    /// When those close whose balls are side by side, rounding cannot tell.
    fn switching_ahead(&self, rounding: &Rounding) -> Option<(usize, f64)> {
        self.first_at_zero(|track| {
            let switches = match track.mode {
                Mode::Open => track.overlap < 0.0 && track.rate > 0.0 && !track.is_resting(rounding),
                Mode::Clipped => track.rate < 0.0,
                Mode::Pressing => false,
            };
            switches.then_some((track.rate, track.acceleration))
        })
    }

    /// The first of the contacts whose overlap vanishes with the rate (m/s) and the acceleration (m/s2) of a `motion`, and when, s.
    fn first_at_zero(&self, motion: impl Fn(&Track) -> Option<(f64, f64)>) -> Option<(usize, f64)> {
        let at_zero = |(j, track): (usize, &Track)| {
            let side = if track.overlap > 0.0 { 1.0 } else { -1.0 };
            let (rate, acceleration) = motion(track)?;
            fall(side * track.overlap, side * rate, 0.5 * side * acceleration).map(|time| (j, time))
        };
        self.tracks.iter().enumerate().filter_map(at_zero).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// The step that ends where contact `j` opens, in about this `time` (s).
    fn to_release(&self, j: usize, time: f64) -> Plan {
        let stretching = self.stretching_power().map_or(Stretching::None, Stretching::AtEnd);
        Plan { stretching, length: time, switching: Some(j) }
    }
}

/// The power by which time is stretched where a contact with this law opens or closes. With `c^q`, the force times the pace of the
/// time goes with `c^(q p + q - 1)`: a polynomial if that is whole, nearly one if it is large. Higher powers than it takes make steps
/// shorter, and a whole exponent needs none.
fn power_of_stretching(law: &ContactLaw) -> Option<Power> {
    match law.whole_exponent() {
        Some(_) => None,
        None if law.has_root() || law.exponent > 2.0 => Some(Power::Square),
        None => Some(Power::Cube),
    }
}

/// The next step over the last one, which had this error in units of the one allowed.
fn change_for(error: f64) -> f64 {
    // The sixteenth root, which is nearly that of the order.
    let root = error.sqrt().sqrt().sqrt().sqrt();
    (SAFETY / root).clamp(CHANGE[0], CHANGE[1])
}
