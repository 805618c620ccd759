//! A contact of the cradle: its ledger and its role.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::engine::{Forecast, Ledger, cluster::WindowContact, flight::Separation};
use crate::model::Mode;
use crate::solver::DoubleDouble;

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Contact {
    pub ledger: Ledger,
    pub role: ContactRole,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
#[expect(clippy::large_enum_variant, reason = "nearly all are open, and change their roles too often for a box")]
pub(crate) enum ContactRole {
    /// With this overlap between the places of its balls at their anchors: open beside an impact; or, during an event
    /// that regroups its balls, between balls anchored at the time of the event.
    Anchored(WindowContact),
    /// Open between balls in flight, with the forecast of its onset.
    Open(Separation, Forecast<DoubleDouble>),
    /// In the interaction with this number.
    Interacting(u32),
}

impl Default for ContactRole {
    fn default() -> Self {
        Self::Anchored(WindowContact::default())
    }
}

impl Contact {
    /// Whether its sums are finite, and its motion, unless an interaction has that.
    pub fn is_finite(&self) -> bool {
        let motion = match &self.role {
            ContactRole::Open(separation, forecast) => {
                separation.is_finite() && forecast.until().is_none_or(|time| time.is_sound())
            }
            ContactRole::Anchored(WindowContact { overlap, .. }) => overlap.is_finite(),
            ContactRole::Interacting(_) => true,
        };
        motion && self.ledger.is_sound()
    }

    /// Its motion while it is open and both balls are in flight.
    pub fn separation(&self) -> Option<&Separation> {
        if let ContactRole::Open(separation, _) = &self.role { Some(separation) } else { None }
    }

    /// Its state between the anchors of its balls; otherwise open without overlap.
    pub fn at_anchors(&self) -> WindowContact {
        if let ContactRole::Anchored(state) = self.role { state } else { WindowContact::default() }
    }

    /// Sets the overlap (m) between the anchors of its balls, and the mode.
    pub fn set_anchored(&mut self, overlap: f64, mode: Mode) {
        self.role = ContactRole::Anchored(WindowContact { overlap, mode });
    }

    /// Whether it is anchored and closed.
    pub fn is_closed(&self) -> bool {
        self.at_anchors().mode != Mode::Open
    }
}

/// Which rigid contacts at rest last where rounding would decide.
#[derive(Clone, Copy)]
pub(crate) enum RestRule {
    Nothing,
    /// This contact, if its balls part by no more than rounding.
    Contact(usize),
    /// All contacts that were closed before.
    Closed,
}

/// The longest run of neighbouring contacts about contact `i` all of which, but for `i` itself, `belong`.
pub(crate) fn contiguous_range(i: usize, contacts: usize, belong: impl Fn(usize) -> bool) -> Range<usize> {
    let before = (0..i).rev().take_while(|j| belong(*j)).count();
    let after = (i + 1..contacts).take_while(|j| belong(*j)).count();
    i - before..i + 1 + after
}
