//! Explicit Gauss collocation, for nonlinear contacts: steps of some tenths of a contact's duration, which end and
//! begin where forces have branch points. See "Gauss collocation" in docs/theory.md.
//!
//! `plan` plans the next attempt, from forecasts or from the last attempt. `step` carries it out, with the `iteration`
//! and the `switching`s found meanwhile. `motion` holds the result, `output` is its dense output.

mod arcs;
mod branch_point;
mod iteration;
mod motion;
mod output;
mod plan;
mod step;
mod switching;

use super::step_control::Problem;
use super::window::{Window, WindowContact};
use crate::model::{ContactLaw, Mode};

use plan::{Decision, Planner};

pub(crate) use arcs::{BallOnArc, ContactDirection};
pub(crate) use branch_point::{BranchPoint, power_of_stretching};
pub(crate) use motion::GaussStep;

/// Contacts whose damping acts within less than this part of their time scale are stiff: Picard's iteration would need
/// short steps, and balls at rest would start to move within much less than a step.
const STIFF: f64 = 0.1;

/// Attempts for one step, after which it is left to another method.
const ATTEMPTS: usize = 40;

/// Whether the method applies to a window that is not linear: contacts press, laws that clip have a `sign_of_force`,
/// and damping at this `speed` (m/s) is not stiff.
pub(super) fn applies_to(window: &Window, speed: f64) -> bool {
    let is_stiff = |(j, law): (usize, &ContactLaw)| {
        window.contacts[j].mode != Mode::Open && law.relaxes_within(STIFF, window.reduced_mass(j), speed)
    };
    let serves = |(contact, law): (&WindowContact, &ContactLaw)| {
        contact.mode == Mode::Open || !law.clips() || law.sign_of_force().is_some()
    };
    let presses = |contact: &WindowContact| contact.mode == Mode::Pressing;
    window.contacts.iter().any(presses)
        && window.contacts.iter().zip(window.laws).all(serves)
        && !window.laws.iter().enumerate().any(is_stiff)
}

impl GaussStep {
    /// Describes the motion for a step of about the length `before` (s; 0 if unknown). Returns the length of this step
    /// and of the next one, s; `None` if the method does not apply. Adds to the `evaluations` of forces, each at all
    /// nodes.
    #[expect(clippy::print_stderr, reason = "attempts are printed in a build with `--features trace`")]
    pub(super) fn follow(&mut self, problem: &Problem, before: f64, evaluations: &mut u64) -> Option<(f64, f64)> {
        self.start(problem.window);
        let (mut planner, mut plan) = Planner::new(self, problem, before);
        for _ in 0..ATTEMPTS {
            if plan.length.is_nan() || plan.length < f64::MIN_POSITIVE {
                return None;
            }
            let outcome = self.attempt(&plan, &planner.tolerance, evaluations);
            let decision = planner.decide(self, &plan, outcome);
            if cfg!(feature = "trace") {
                eprintln!("{plan:?} -> {outcome:?} -> {decision:?}");
            }
            match decision {
                Decision::Retry(next) => plan = next,
                Decision::Done { length, next } => return Some((length, next)),
                Decision::LeaveToOther => return None,
            }
        }
        None
    }
}
