//! The next onset, with the inputs held.

use super::run::Exchange;
use crate::engine::flight::{Ball, EVALUATIONS, Separation};
use crate::model::{Mode, ONSET_PERIODS};
use crate::next::Next;
use crate::solver::double_double::DoubleDouble;
use crate::solver::queue::EventQueue;

/// Evaluations that one look ahead may take; what comes then is left to the next event.
const LOOK_AHEAD: u32 = 40_000;

impl Exchange {
    /// Finds the next onset later than now by more than the same time; a time up to which there is none where the look
    /// ends; never if there is none within 1000 periods of the first ball.
    pub(super) fn foresee(&mut self) {
        (self.next, self.next_contact) = self.next_onset();
    }

    fn next_onset(&self) -> (Next, Option<usize>) {
        let later = |tau: DoubleDouble| (DoubleDouble::from(self.time) + tau).value_up().max(self.earliest());
        if self.is_rigid() {
            let next = match self.foresee_rigid() {
                Next::At(tau) => Next::At(later(tau)),
                Next::NotBefore(tau) => Next::NotBefore(later(tau)),
                Next::Never => Next::Never,
            };
            return (next, None);
        }
        if self.modes.iter().any(|mode| *mode != Mode::Open) {
            return (Next::not_before(self.time, self.time), None);
        }
        let limit = ONSET_PERIODS * self.cradle.period();
        let balls = self.flights();
        let separations: Vec<Separation> = (0..self.modes.len()).map(|j| self.separation(&balls, j)).collect();
        let mut queue = EventQueue::new(separations.len());
        let mut settled = vec![false; separations.len()];
        let mut allowed = LOOK_AHEAD;
        let mut look = |j: usize, from: DoubleDouble, queue: &mut EventQueue, settled: &mut [bool]| {
            let mut own = allowed.min(EVALUATIONS);
            let before = own;
            let found = separations[j].forecast(from, &mut own);
            allowed -= (before - own).min(allowed - 1).max(1);
            settled[j] = matches!(found, Next::At(_));
            match found {
                Next::At(tau) | Next::NotBefore(tau) => queue.set(j, tau),
                Next::Never => queue.remove(j),
            }
            allowed > 1
        };
        let mut goes_on = true;
        for (j, separation) in separations.iter().enumerate() {
            goes_on &= look(j, separation.anchor(), &mut queue, &mut settled);
        }
        while let Some((tau, j)) = queue.first() {
            if tau.value() > limit {
                break;
            }
            if settled[j] {
                return (Next::At(later(tau)), Some(j));
            }
            if !goes_on {
                return (Next::NotBefore(later(tau)), None);
            }
            goes_on = look(j, tau, &mut queue, &mut settled);
        }
        (Next::Never, None)
    }

    /// The first time that is later than now, s.
    fn earliest(&self) -> f64 {
        (self.time + self.margin()).max(self.time.next_up())
    }

    /// The motion of the balls of contact `j` relative to each other, from where they part if they have yet to.
    fn separation(&self, balls: &[Ball], j: usize) -> Separation {
        let clearance = self.cradle.contacts[j].clearance;
        let anchor = self.parting(balls, j, 0.0).unwrap_or_default();
        let overlap = self.overlap_in_flight(balls, j, anchor).0.min(0.0);
        Separation::new(&balls[j], &balls[j + 1], anchor.into(), overlap, clearance)
    }
}
