//! A contact of the cradle: its ledger and its phase.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::engine::{
    Ledger, Next, cluster::WindowContact, flight::Separation, pair_impact::PairImpact, rigid::Constraint,
};
use crate::model::Mode;
use crate::solver::DoubleDouble;

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Contact {
    pub ledger: Ledger,
    pub phase: Phase,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum Phase {
    /// During an event that regroups its balls, which are in flight and anchored at its time; never between events.
    Unassigned(WindowContact),
    /// Open between balls in flight, with the forecast of its onset.
    Open(Separation, Next<DoubleDouble>),
    /// Open beside an impact of known outcome, with the overlap (m) of its balls at their anchors, at different times.
    BesideImpact(f64),
    /// In the window of this cluster.
    Window(u32),
    /// An impact of known outcome, which a saved state does not have: it is computed anew.
    Impact(#[serde(skip)] Option<PairImpact>),
    /// A sustained contact of rigid balls, with the forecast of its end.
    Constraint(Constraint, Next<DoubleDouble>),
}

impl Default for Phase {
    fn default() -> Self {
        Self::Unassigned(WindowContact::default())
    }
}

impl Contact {
    /// Whether its sums and its motion are finite, where that is its own.
    pub fn is_finite(&self) -> bool {
        let sound = |forecast: &Next<DoubleDouble>| match forecast {
            Next::At(time) | Next::NotBefore(time) => time.is_sound(),
            Next::Never => true,
        };
        let motion = match &self.phase {
            Phase::Open(separation, forecast) => separation.is_finite() && sound(forecast),
            Phase::Constraint(constraint, forecast) => constraint.is_finite() && sound(forecast),
            Phase::BesideImpact(overlap) => overlap.is_finite(),
            Phase::Unassigned(_) | Phase::Window(_) | Phase::Impact(_) => true,
        };
        motion && self.ledger.is_sound()
    }

    /// The cluster whose window it belongs to.
    pub fn cluster(&self) -> Option<u32> {
        if let Phase::Window(cluster) = self.phase { Some(cluster) } else { None }
    }

    /// The impact of known outcome that is under way in it.
    pub fn impact(&self) -> Option<&PairImpact> {
        if let Phase::Impact(impact) = &self.phase { impact.as_ref() } else { None }
    }

    /// The constraint between its balls, if it is one.
    pub fn constraint(&self) -> Option<&Constraint> {
        if let Phase::Constraint(constraint, _) = &self.phase { Some(constraint) } else { None }
    }

    /// Its motion while it is open and both balls are in flight.
    pub fn separation(&self) -> Option<&Separation> {
        if let Phase::Open(separation, _) = &self.phase { Some(separation) } else { None }
    }

    /// Its state while it is unassigned; otherwise open without overlap.
    pub fn unassigned(&self) -> WindowContact {
        if let Phase::Unassigned(unassigned) = self.phase { unassigned } else { WindowContact::default() }
    }

    pub fn unassign(&mut self, overlap: f64, mode: Mode) {
        self.phase = Phase::Unassigned(WindowContact { overlap, mode });
    }

    /// Overlap (m) while it is unassigned, or that between the anchors of its balls beside an impact; otherwise 0.
    pub fn overlap(&self) -> f64 {
        match self.phase {
            Phase::Unassigned(WindowContact { overlap, .. }) | Phase::BesideImpact(overlap) => overlap,
            Phase::Open(..) | Phase::Window(_) | Phase::Impact(_) | Phase::Constraint(..) => 0.0,
        }
    }

    pub fn is_closed(&self) -> bool {
        self.unassigned().mode != Mode::Open
    }
}

/// Which rigid contacts last where rounding would decide.
#[derive(Clone, Copy)]
pub(crate) enum Keep {
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
