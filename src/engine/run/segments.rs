//! Which interaction a ball or a contact takes part in, and which segment of it governs them at a time.

use super::contact::ContactRole;
use super::engine::Engine;
use super::interaction::Interaction;
use crate::engine::cluster::Cluster;
use crate::engine::flight::RunningIntegrals;
use crate::engine::pair_impact::PairImpact;
use crate::engine::rigid::Constraint;
use crate::solver::DoubleDouble;

/// The motion of the balls of a cluster or an impact about a time.
pub(crate) struct SegmentAt<'a> {
    pub cluster: &'a Cluster,
    /// Time since the start of the segment, s.
    pub tau: f64,
    /// Impulse of the contact before the segment that is not yet in its ledger, N.s.
    pub impulse: f64,
    /// Integrals of the two balls of an impact before the segment, from its first ball on.
    integrals: Option<(usize, &'a [RunningIntegrals; 2])>,
}

impl SegmentAt<'_> {
    /// Adds the integrals of ball `i` before the segment that its own do not yet contain.
    pub fn add_earlier(&self, i: usize, integrals: &mut RunningIntegrals) {
        if let Some((first, earlier)) = self.integrals {
            integrals.add(&earlier[i - first]);
        }
    }
}

impl Engine {
    /// The number for a new interaction.
    pub(crate) fn number_of_next(&mut self) -> u32 {
        let free = self.interactions.iter().position(Option::is_none);
        free.unwrap_or_else(|| {
            self.interactions.push(None);
            self.interactions.len() - 1
        }) as u32
    }

    /// The interaction of ball `i`, unless it is in flight alone.
    pub(crate) fn interaction_of_ball(&self, i: usize) -> Option<&Interaction> {
        self.interactions[self.balls[i].interaction? as usize].as_ref()
    }

    pub(crate) fn interaction_of_contact(&self, j: usize) -> Option<&Interaction> {
        let ContactRole::Interacting(id) = self.contacts[j].role else { return None };
        self.interactions[id as usize].as_ref()
    }

    /// The cluster whose window contains contact `j`.
    pub(crate) fn cluster(&self, j: usize) -> Option<&Cluster> {
        if let Some(Interaction::Cluster(cluster)) = self.interaction_of_contact(j) { Some(cluster) } else { None }
    }

    /// The impact of known outcome that is under way in contact `j`.
    pub(crate) fn impact(&self, j: usize) -> Option<&PairImpact> {
        if let Some(Interaction::Impact(impact)) = self.interaction_of_contact(j) { Some(impact) } else { None }
    }

    /// The constraint between the balls of contact `j`, if they move as one.
    pub(crate) fn constraint(&self, j: usize) -> Option<&Constraint> {
        if let Some(Interaction::Body(body)) = self.interaction_of_contact(j) { body.constraint(j) } else { None }
    }

    /// Whether ball `i` is in flight, alone or as a part of a body.
    pub(crate) fn flies(&self, i: usize) -> bool {
        self.balls[i].interaction.is_none() || self.is_in_body(i)
    }

    pub(crate) fn is_in_body(&self, i: usize) -> bool {
        matches!(self.interaction_of_ball(i), Some(Interaction::Body(_)))
    }

    /// The segment of this interaction at the time `t`; a body has none.
    fn segment<'a>(&'a self, interaction: &'a Interaction, t: DoubleDouble) -> Option<SegmentAt<'a>> {
        match interaction {
            Interaction::Cluster(cluster) => {
                let tau = (t - cluster.start).value();
                Some(SegmentAt { cluster, tau, impulse: 0.0, integrals: None })
            }
            Interaction::Impact(impact) => {
                let interior = self.interior(impact, t)?;
                let (cluster, tau) = (&interior.segment, interior.since(t));
                let integrals = Some((impact.contact, &interior.integrals));
                Some(SegmentAt { cluster, tau, impulse: interior.impulse, integrals })
            }
            Interaction::Body(_) => None,
        }
    }

    /// The segment that governs ball `i` at the time `t`, if it is not in flight.
    pub(crate) fn segment_of_ball(&self, i: usize, t: DoubleDouble) -> Option<SegmentAt<'_>> {
        self.segment(self.interaction_of_ball(i)?, t)
    }

    /// The segment of contact `j` at the time `t`, also if it lies between a member of a cluster and the ball beside.
    pub(crate) fn segment_of_contact(&self, j: usize, t: DoubleDouble) -> Option<SegmentAt<'_>> {
        self.segment(self.interaction_of_contact(j)?, t)
    }
}
