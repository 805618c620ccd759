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

use step::{Outcome, Plan, Tolerance};

use super::step_control::Control;
use super::window::{Switch, Window, WindowContact};
use crate::engine::flight::Rounding;
use crate::model::{ContactLaw, Mode};
use crate::solver::gauss::{NODES, Stretching};

use motion::Track;

pub(crate) use motion::Motion;

/// What the two highest Legendre coefficients may be over the scale of the velocities, for the local error of the default
/// tolerance. The end of a step has twice as many digits: an error of 1e-16, within the step one of 1e-14.
const TAIL: f64 = 1e-11;
const EPSILON: f64 = 1e-17;

/// First step over the time that the fastest contact takes to stop its balls: after an onset at speed, and where a wave starts in
/// balls that touch.
const FIRST: f64 = 0.45;
const FIRST_OF_WAVE: f64 = 0.1;

/// Contacts that have just closed at less than this part of the speed of the others, or that overlap by less than this part of the
/// largest overlap, do not call for a stretched step.
const FAINT: f64 = 1e-6;

/// A contact that is so many steps from its release at the present rate may be followed up to there.
const NEAR_RELEASE: f64 = 1.2;

/// How a step follows from the last one: the part of what the error allows, and the least and largest factor. And a step after one
/// that did not reach a release, after one that failed.
const SAFETY: f64 = 0.9;
const CHANGE: [f64; 2] = [0.3, 4.0];
const SHORT_OF_RELEASE: f64 = 0.65;
const FAILED: f64 = 0.5;
const LEAST: f64 = 0.05;

/// Closed contacts that a window may have: of a wave that many balls pass on, series follow the faint ends for less.
const MOST_CONTACTS: usize = 8;

/// Attempts for one step, after which it is left to another method.
const ATTEMPTS: usize = 40;

/// What a step took and says about the next one.
pub(super) struct Followed {
    /// Its length and the one that the next one may have, s.
    pub length: f64,
    pub next: f64,
}

/// Whether the closed contacts are few, their exponents a whole number and a half, the sign of a force that may be clipped is simple,
/// and all pendulums are equal.
pub(super) fn applies_to(window: &Window) -> bool {
    let serves = |(contact, law): (&WindowContact, &ContactLaw)| {
        contact.mode == Mode::Open || (law.has_root() && (!law.clips() || law.sign_of_force().is_some()))
    };
    let oscillator = &window.balls[0].oscillator;
    window.closed() <= MOST_CONTACTS
        && window.contacts.iter().zip(window.laws).all(serves)
        && window.balls.iter().all(|ball| ball.oscillator == *oscillator)
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
        let longest = self.longest().min(control.longest);
        let tolerance = Tolerance { speed, tail, local_error, longest, rounding: *rounding };
        if let Some(j) = self.parting(rounding) {
            self.ends_at_once(j, Switch::Release);
            return Some(Followed { length: 0.0, next: before });
        }
        let mut length = match before > 0.0 {
            true => before,
            false if wave => FIRST_OF_WAVE * self.fastest(window, speed),
            false => FIRST * self.fastest(window, speed),
        };
        let mut plan = Plan { stretching: onset.unwrap_or_default(), length, ends_at_switching: false };
        if let Some(time) = self.release_ahead()
            && (f64::MIN_POSITIVE..NEAR_RELEASE * length).contains(&time)
        {
            plan = to_release(time);
        } else if let Some(time) = self.release_of_clipped()
            && (f64::MIN_POSITIVE..NEAR_RELEASE * length).contains(&time)
        {
            plan = Plan { length: time, ends_at_switching: true, ..plan };
        }
        for _ in 0..ATTEMPTS {
            plan.length = plan.length.min(longest);
            if plan.length.is_nan() || plan.length < f64::MIN_POSITIVE {
                return None;
            }
            let outcome = self.attempt(&plan, &tolerance, evaluations);
            // An iteration that diverges may have moved the end anywhere.
            let (reached, least) = (self.length, LEAST * plan.length);
            if !plan.ends_at_switching {
                length = length.min(plan.length);
            }
            plan = match outcome {
                Outcome::Stands(error) => {
                    let proposed = reached * change_for(error);
                    // A step that ended early says nothing against long ones.
                    let next = if plan.ends_at_switching { length.max(reached) } else { proposed };
                    self.moment.get_mut().forget();
                    return Some(Followed { length: self.until, next: next.min(longest) });
                }
                // Which way a force goes from 0 its mean slope over a step does not tell; a series does.
                Outcome::AtOnce(_, Switch::Clip | Switch::Unclip) => return None,
                Outcome::AtOnce(j, switch) => {
                    self.ends_at_once(j, switch);
                    return Some(Followed { length: 0.0, next: before });
                }
                Outcome::Within(j, Switch::Release, time) if self.tracks[j].mode == Mode::Pressing => {
                    match plan.stretching {
                        Stretching::None => to_release(time.max(least)),
                        // It closes and opens in one step.
                        _ => Plan { length: FAILED * time.max(least), ..plan },
                    }
                }
                Outcome::Within(_, _, time) => Plan { length: time.max(least), ends_at_switching: true, ..plan },
                Outcome::NoSwitching => {
                    Plan { stretching: onset.unwrap_or_default(), length, ends_at_switching: false }
                }
                Outcome::TooLong(_) | Outcome::Failed if plan.ends_at_switching => {
                    length = SHORT_OF_RELEASE * reached.clamp(least, plan.length);
                    Plan { stretching: onset.unwrap_or_default(), length, ends_at_switching: false }
                }
                Outcome::TooLong(error) => Plan { length: plan.length * change_for(error).min(0.7), ..plan },
                Outcome::Failed => Plan { length: FAILED * plan.length, ..plan },
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
        fresh.then_some(Stretching::AtStart(if rate > 0.0 { 2 } else { 4 }))
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
            let acceleration = (track.pull - self.oscillator.omega2() * track.overlap).abs();
            let balanced = track.law.static_overlap(window.reduced_mass(j) * acceleration);
            speed = speed.max((acceleration * balanced).sqrt());
        }
        speed
    }

    /// The time in which the fastest contact stops balls of this `speed` (m/s), s.
    fn fastest(&self, window: &Window, speed: f64) -> f64 {
        let mut fastest = f64::INFINITY;
        for (j, track) in self.tracks.iter().enumerate().filter(|(_, track)| track.mode == Mode::Pressing) {
            fastest = fastest.min(track.law.largest_overlap(window.reduced_mass(j), speed) / speed);
        }
        fastest
    }

    /// The longest step for which the functions of the pendulum are at hand, s.
    fn longest(&self) -> f64 {
        let pace = self.oscillator.omega() + 2.0 * self.oscillator.gamma();
        if pace > 0.0 { output::LONGEST / pace } else { f64::INFINITY }
    }

    /// How long the first closed contact that is opening would take at its present rate, s, or to where it is clipped. One that hardly
    /// presses has no branch point that matters, and may never open.
    fn release_ahead(&self) -> Option<f64> {
        let largest = self.tracks.iter().map(|track| track.overlap).fold(0.0, f64::max);
        let opens =
            |track: &&Track| track.mode == Mode::Pressing && track.rate < 0.0 && track.overlap > FAINT * largest;
        self.first_opening(opens)
    }

    /// The same of the contacts that are clipped: without a force there is no branch point.
    fn release_of_clipped(&self) -> Option<f64> {
        self.first_opening(|track| track.mode == Mode::Clipped && track.rate < 0.0)
    }

    /// How long the first of the contacts that `opens` would take at its present rate, s.
    fn first_opening(&self, opens: impl Fn(&&Track) -> bool) -> Option<f64> {
        let opening = self.tracks.iter().filter(opens);
        opening.map(|track| track.overlap / -track.rate).min_by(f64::total_cmp)
    }
}

/// The step that ends where a contact opens, in about this `time` (s).
fn to_release(time: f64) -> Plan {
    Plan { stretching: Stretching::AtEnd, length: time, ends_at_switching: true }
}

/// The next step over the last one, which had this error in units of the one allowed.
fn change_for(error: f64) -> f64 {
    let exponent = -1.0 / (NODES - 1) as f64;
    if error > 0.0 { (SAFETY * libm::pow(error, exponent)).clamp(CHANGE[0], CHANGE[1]) } else { CHANGE[1] }
}
