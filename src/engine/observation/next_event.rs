//! The next onset or release.

use crate::engine::cluster::Switch;
use crate::engine::run::{Engine, Phase};
use crate::next::Next;

impl Engine {
    /// When the next onset or release of any contact is due with the inputs continued, s, later than now, as far as it
    /// can be told without going ahead: in flight always, while a contact is closed if the event that comes first is
    /// known to be one.
    pub fn next_event(&self) -> Option<f64> {
        let (t, key) = self.queue.first()?;
        let is_known = match &self.contacts[key].phase {
            Phase::Window(id) => {
                let switch = self.clusters[*id as usize].as_ref().and_then(|cluster| cluster.switch);
                matches!(switch, Some((_, Switch::Onset | Switch::Release)))
            }
            Phase::Impact(_) | Phase::Open(_, Next::At(_)) | Phase::Constraint(_, Next::At(_)) => true,
            _ => false,
        };
        let in_flight = || self.contacts.iter().all(|contact| matches!(contact.phase, Phase::Open(..)));
        let next = if is_known { Some(t.value_up()) } else { self.find_next_onset().found().filter(|_| in_flight()) };
        next.filter(|next| *next > self.time)
    }
}
