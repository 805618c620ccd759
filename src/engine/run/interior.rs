//! The interior of an impact of known outcome, for those who look at it: segments as those of any cluster.

use super::engine::Engine;
use crate::engine::cluster::{Cluster, Control, StepHistory, Switch, WindowContact};
use crate::engine::flight::RunningIntegrals;
use crate::engine::pair_impact::{Interior, PairImpact};
use crate::model::Mode;
use crate::solver::double_double::DoubleDouble;

impl Engine {
    /// What governs the segments of an impact: as many cover it, however slow it is.
    pub(crate) fn control_within(&self, impact: &PairImpact) -> Control {
        self.control.taking(impact.duration)
    }

    /// The balls of the `impact` in contact `i` as a cluster without spectators, from the onset on.
    pub(crate) fn first_segment(&self, i: usize, impact: &PairImpact) -> Cluster {
        let members = i..i + 2;
        let flights = self.balls[members.clone()].iter().map(|ball| ball.flight).collect();
        let contacts = vec![WindowContact { overlap: 0.0, mode: Mode::Pressing }];
        let mut cluster =
            Cluster::new(members.clone(), members, impact.start, flights, contacts, StepHistory::default());
        cluster.expand(&self.balls, &self.cradle.contacts, &self.control_within(impact));
        cluster
    }

    /// The segment of the impact under way in contact `i` that holds the time `t`, with what was before it; the last
    /// one for a time after the impact. All of them are computed for the first who asks.
    pub(crate) fn interior(&self, i: usize, t: DoubleDouble) -> Option<&Interior> {
        let impact = self.contacts[i].impact()?;
        let segments = impact.interior.0.get_or_init(|| {
            let segment = self.first_segment(i, impact);
            let mut segments = vec![Interior { segment, impulse: 0.0, integrals: Default::default() }];
            while let Some(next) = segments.last().and_then(|last| self.after(last, i, impact)) {
                segments.push(next);
            }
            segments
        });
        segments.get(segments.partition_point(|interior| interior.segment.end() <= t)).or(segments.last())
    }

    /// The segment after another one, unless the impact is over, or its segments lead no further.
    fn after(&self, last: &Interior, i: usize, impact: &PairImpact) -> Option<Interior> {
        let over = matches!(last.segment.switch, Some((_, Switch::Release)));
        let length = last.segment.length;
        let goes_on = last.segment.end() < impact.end() && length > 0.0; // Not where they are no numbers.
        if over || !goes_on {
            return None;
        }
        let mut integrals = last.integrals;
        for (integrals, ball) in integrals.iter_mut().zip(i..) {
            integrals.add(&last.segment.integrals(ball, &RunningIntegrals::default(), &self.balls[ball], length));
        }
        let mut segment = last.segment.clone();
        segment.move_start(length, &self.balls, &self.cradle.contacts);
        segment.expand(&self.balls, &self.cradle.contacts, &self.control_within(impact));
        Some(Interior { segment, impulse: last.impulse + last.segment.impulse(i, length), integrals })
    }

    /// Largest force of the impact under way in contact `i` between two times, N; 0 if there is none. Without losses
    /// the force falls as it has risen, so that it is largest half way.
    pub(crate) fn impact_peak(&self, i: usize, from: DoubleDouble, to: DoubleDouble) -> f64 {
        let Some(impact) = self.contacts[i].impact() else { return 0.0 };
        let (from, to) = ((from - impact.start).value().max(0.0), (to - impact.start).value().min(impact.duration));
        let top = 0.5 * impact.duration;
        if from > to {
            return 0.0;
        }
        if from <= top && top <= to {
            return impact.peak;
        }
        let nearest = impact.start + if to < top { to } else { from };
        self.interior(i, nearest).map_or(0.0, |interior| {
            let (overlap, rate) = interior.segment.overlap(i, interior.since(nearest));
            self.cradle.contacts[i].force(overlap, rate)
        })
    }
}
