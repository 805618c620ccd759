//! Interactions: what several neighbouring balls do together, from beginning to end.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::engine::cluster::Cluster;
use crate::engine::pair_impact::PairImpact;
use crate::engine::rigid::Body;

#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum Interaction {
    /// Balls held together by compliant contacts, followed from switching to switching.
    Cluster(Box<Cluster>),
    /// An impact of two balls whose outcome is known.
    Impact(PairImpact),
    /// Rigid balls in lasting contact, which move as one; each ball has its flight.
    Body(Body),
}

impl Interaction {
    /// The contacts of the interaction; for a cluster, also those to the balls on either side.
    pub fn contacts(&self) -> Range<usize> {
        match self {
            Self::Cluster(cluster) => cluster.window_contacts(),
            Self::Impact(impact) => impact.contact..impact.contact.saturating_add(1),
            Self::Body(body) => body.contacts(),
        }
    }
}
