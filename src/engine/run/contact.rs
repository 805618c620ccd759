//! A contact of the cradle: its ledger and its role.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::engine::{
    Forecast, Ledger, cluster::WindowContact, flight::Separation, pair_impact::PairImpact, rigid::Constraint,
};
use crate::model::Mode;
use crate::solver::DoubleDouble;

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Contact {
    pub ledger: Ledger,
    pub role: ContactRole,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum ContactRole {
    /// During an event that regroups its balls, which are in flight and anchored at its time; never between events.
    Unassigned(WindowContact),
    /// Open between balls in flight, with the forecast of its onset.
    Open(Separation, Forecast<DoubleDouble>),
    /// Open beside an impact of known outcome, with the overlap (m) of its balls at their anchors, at different times.
    BesideImpact(f64),
    /// In the window of this cluster.
    Window(u32),
    /// An impact of known outcome, which a saved state does not have: it is computed anew.
    Impact(#[serde(skip)] Option<PairImpact>),
    /// A sustained contact of rigid balls, with the forecast of its end.
    Constraint(Constraint, Forecast<DoubleDouble>),
}

impl Default for ContactRole {
    fn default() -> Self {
        Self::Unassigned(WindowContact::default())
    }
}

impl Contact {
    /// Whether its sums and its motion are finite, where that is its own.
    pub fn is_finite(&self) -> bool {
        let sound = |forecast: &Forecast<DoubleDouble>| match forecast {
            Forecast::At(time) | Forecast::NotBefore(time) => time.is_sound(),
            Forecast::Never => true,
        };
        let motion = match &self.role {
            ContactRole::Open(separation, forecast) => separation.is_finite() && sound(forecast),
            ContactRole::Constraint(constraint, forecast) => constraint.is_finite() && sound(forecast),
            ContactRole::BesideImpact(overlap) => overlap.is_finite(),
            ContactRole::Unassigned(_) | ContactRole::Window(_) | ContactRole::Impact(_) => true,
        };
        motion && self.ledger.is_sound()
    }

    /// The cluster whose window it belongs to.
    pub fn cluster(&self) -> Option<u32> {
        if let ContactRole::Window(cluster) = self.role { Some(cluster) } else { None }
    }

    /// The impact of known outcome that is under way in it.
    pub fn impact(&self) -> Option<&PairImpact> {
        if let ContactRole::Impact(impact) = &self.role { impact.as_ref() } else { None }
    }

    /// The constraint between its balls, if it is one.
    pub fn constraint(&self) -> Option<&Constraint> {
        if let ContactRole::Constraint(constraint, _) = &self.role { Some(constraint) } else { None }
    }

    /// Its motion while it is open and both balls are in flight.
    pub fn separation(&self) -> Option<&Separation> {
        if let ContactRole::Open(separation, _) = &self.role { Some(separation) } else { None }
    }

    /// Its state while it is unassigned; otherwise open without overlap.
    pub fn unassigned(&self) -> WindowContact {
        if let ContactRole::Unassigned(unassigned) = self.role { unassigned } else { WindowContact::default() }
    }

    pub fn unassign(&mut self, overlap: f64, mode: Mode) {
        self.role = ContactRole::Unassigned(WindowContact { overlap, mode });
    }

    /// Overlap (m) while it is unassigned, or that between the anchors of its balls beside an impact; otherwise 0.
    pub fn overlap(&self) -> f64 {
        match self.role {
            ContactRole::Unassigned(WindowContact { overlap, .. }) | ContactRole::BesideImpact(overlap) => overlap,
            ContactRole::Open(..) | ContactRole::Window(_) | ContactRole::Impact(_) | ContactRole::Constraint(..) => {
                0.0
            }
        }
    }

    pub fn is_closed(&self) -> bool {
        self.unassigned().mode != Mode::Open
    }
}

/// Which rigid contacts last where rounding would decide.
#[derive(Clone, Copy)]
pub(crate) enum RestRule {
    Nothing,
    /// This one, where the balls part by no more than rounding.
    Contact(usize),
    /// All that did so far.
    Closed,
}

/// The range around contact `i` of neighbouring contacts that `belong`.
pub(crate) fn around(i: usize, contacts: usize, belong: impl Fn(usize) -> bool) -> Range<usize> {
    let before = (0..i).rev().take_while(|j| belong(*j)).count();
    let after = (i + 1..contacts).take_while(|j| belong(*j)).count();
    i - before..i + 1 + after
}
