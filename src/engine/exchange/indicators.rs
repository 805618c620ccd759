//! Event indicators: where a contact opens, closes, or where its law begins or ends to clip.

use super::run::Exchange;
use super::scales::SHIFT;
use crate::model::Mode;

impl Exchange {
    /// The indicators: those of the n-1 contacts, which are negative while apart and positive while closed, then n-1
    /// that are negative while a contact is clipped. An event is due where one of them changes its sign.
    pub fn indicators(&self) -> Vec<f64> {
        let contacts = 0..self.modes.len();
        contacts.clone().map(|j| self.contact_indicator(j)).chain(contacts.map(|j| self.clip_indicator(j))).collect()
    }

    /// Whether an indicator says other than the flags.
    pub(super) fn is_event_due(&self) -> bool {
        (0..self.modes.len()).any(|j| {
            (self.contact_indicator(j) > 0.0) != (self.modes[j] != Mode::Open) && !self.is_virtual(j)
                || (self.clip_indicator(j) < 0.0) != (self.modes[j] == Mode::Clipped)
        })
    }

    /// Whether an event has left contact `j` with an overlap that is none, because its balls have yet to part or their
    /// flight to begin.
    fn is_virtual(&self, j: usize) -> bool {
        let (overlap, rate) = self.overlap_and_rate(j);
        self.is_mapped() && self.modes[j] == Mode::Open && (overlap > 0.0 && rate <= 0.0 || self.is_followed(j))
    }

    fn contact_indicator(&self, j: usize) -> f64 {
        let ((overlap, rate), shift) = (self.overlap_and_rate(j), self.scales.shift(j));
        if self.modes[j] != Mode::Open {
            return overlap + shift;
        }
        if !self.is_mapped() || self.is_beside_closed(j) {
            return overlap - shift;
        }
        let time = self.scales.overlap(j) / self.scales.speed;
        overlap.min(time * rate) - shift
    }

    /// Whether a neighbour of contact `j` is closed, so that it is not left to an event.
    pub(super) fn is_beside_closed(&self, j: usize) -> bool {
        let closed = |j: usize| self.modes.get(j).is_some_and(|mode| *mode != Mode::Open);
        !self.is_rigid() && (closed(j + 1) || j > 0 && closed(j - 1))
    }

    /// What the law of a closed contact, or the force of a rigid one, has left before it would pull; 1 for all others.
    pub(super) fn clip_indicator(&self, j: usize) -> f64 {
        let law = &self.cradle.contacts[j];
        let shift = match self.modes[j] {
            Mode::Open => return 1.0,
            Mode::Pressing => SHIFT,
            Mode::Clipped => -SHIFT,
        };
        let (overlap, rate) = self.overlap_and_rate(j);
        if self.is_rigid() {
            return self.state.forces[j] / self.scales.forces[j] + shift;
        }
        if !law.clips() {
            return 1.0;
        }
        match law.sign_of_force() {
            Some(sign) => sign.at(overlap, rate) / sign.at(self.scales.overlap(j), 0.0) + shift,
            None => law.unclipped_force(overlap.max(f64::MIN_POSITIVE), rate) / self.scales.forces[j] + shift,
        }
    }
}
