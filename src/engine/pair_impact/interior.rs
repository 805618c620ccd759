//! The interior of an impact of known outcome, for those who look at it: segments as those of any cluster.

use std::cell::OnceCell;

use super::closed_form::PairImpact;
use crate::engine::cluster::{Cluster, Control, StepHistory, Switch, WindowContact};
use crate::engine::flight::{Ball, RunningIntegrals};
use crate::model::{ContactLaw, Mode};
use crate::solver::double_double::DoubleDouble;

/// A segment of an impact.
#[derive(Debug)]
pub(crate) struct Interior {
    pub segment: Cluster,
    /// Gathered in the segments before: the impulse of the contact, N.s, and by the left and the right ball.
    pub impulse: f64,
    pub integrals: [RunningIntegrals; 2],
}

impl Interior {
    /// The time since the start of the segment.
    pub fn since(&self, t: DoubleDouble) -> f64 {
        (t - self.segment.start).value().max(0.0)
    }
}

/// An impact under way, with all that its interior follows from.
#[derive(Clone, Copy)]
pub(crate) struct Impact<'a> {
    /// The contact that it is in.
    pub contact: usize,
    pub outcome: &'a PairImpact,
    /// All balls, the two of the impact as they were at its onset, and the laws of all contacts.
    pub balls: &'a [Ball],
    pub laws: &'a [ContactLaw],
    pub control: &'a Control,
}

impl<'a> Impact<'a> {
    /// What governs its segments: as many cover it, however slow it is.
    pub fn control(&self) -> Control {
        self.control.taking(self.outcome.duration)
    }

    /// Its balls as a cluster without spectators, from the onset on.
    pub fn first_segment(&self) -> Cluster {
        let members = self.contact..self.contact + 2;
        let flights = self.balls[members.clone()].iter().map(|ball| ball.flight).collect();
        let contacts = vec![WindowContact { overlap: 0.0, mode: Mode::Pressing }];
        let mut cluster =
            Cluster::new(members.clone(), members, self.outcome.start, flights, contacts, StepHistory::default());
        cluster.expand(self.balls, self.laws, &self.control());
        cluster
    }

    /// The segment that holds the time `t`, with what was before it; the last one for a time after the impact. All of
    /// them are computed for the first who asks, into `segments`.
    pub fn interior(&self, segments: &'a OnceCell<Vec<Interior>>, t: DoubleDouble) -> &'a Interior {
        let segments = segments.get_or_init(|| {
            let first = Interior { segment: self.first_segment(), impulse: 0.0, integrals: Default::default() };
            let mut segments = vec![first];
            while let Some(next) = segments.last().and_then(|last| self.after(last)) {
                segments.push(next);
            }
            segments
        });
        let place = segments.partition_point(|interior| interior.segment.end() <= t);
        &segments[place.min(segments.len() - 1)]
    }

    /// The segment after another one, unless the impact is over, or its segments lead no further.
    fn after(&self, last: &Interior) -> Option<Interior> {
        let over = matches!(last.segment.switch, Some((_, Switch::Release)));
        if over || last.segment.end() >= self.outcome.end() || last.segment.length <= 0.0 {
            return None;
        }
        let length = last.segment.length;
        let mut integrals = last.integrals;
        for (side, integrals) in integrals.iter_mut().enumerate() {
            let ball = self.contact + side;
            integrals.add(&last.segment.integrals(ball, &RunningIntegrals::default(), &self.balls[ball], length));
        }
        let mut segment = last.segment.clone();
        segment.move_start(length, self.balls, self.laws);
        segment.expand(self.balls, self.laws, &self.control());
        let impulse = last.impulse + last.segment.impulse(self.contact, length);
        Some(Interior { segment, impulse, integrals })
    }

    /// Largest force between two times, N. Without losses the force falls as it has risen, so that it is largest half
    /// way.
    pub fn peak(&self, segments: &'a OnceCell<Vec<Interior>>, from: DoubleDouble, to: DoubleDouble) -> f64 {
        let (start, duration) = (self.outcome.start, self.outcome.duration);
        let (from, to) = ((from - start).value().max(0.0), (to - start).value().min(duration));
        let top = 0.5 * duration;
        if from > to {
            return 0.0;
        }
        if from <= top && top <= to {
            return self.outcome.peak;
        }
        let nearest = start + if to < top { to } else { from };
        let interior = self.interior(segments, nearest);
        let (overlap, rate) = interior.segment.overlap(self.contact, interior.since(nearest));
        self.laws[self.contact].force(overlap, rate)
    }
}
