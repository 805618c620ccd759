//! What can be read at the current time.

use super::run::Exchange;
use crate::model::algebraic::{self, algebraic_results};
use crate::model::{Mode, Results, WorkCounters};
use crate::next::Next;

impl Exchange {
    fn energy_at_start(&self) -> f64 {
        self.energy_at_start
    }
}

/// See [`Results`]; what is of a step is of this instant, and what events change is as the last one left it.
impl Results for Exchange {
    algebraic_results!(self, &self.view());

    fn force(&self, i: usize) -> f64 {
        self.state.forces[i]
    }

    fn overlap(&self, i: usize) -> f64 {
        self.state.overlaps[i]
    }

    fn in_contact(&self, i: usize) -> bool {
        self.modes[i] != Mode::Open
    }

    fn impulse(&self, i: usize) -> f64 {
        self.y[self.impulse_place(i)]
    }

    fn force_mean(&self, i: usize) -> f64 {
        self.force(i)
    }

    fn force_peak(&self, i: usize) -> f64 {
        if self.at_start { self.force(i) } else { self.contacts[i].peak }
    }

    fn pulses(&self, i: usize) -> u64 {
        self.contacts[i].ledger.pulses
    }

    fn last_onset(&self, i: usize) -> f64 {
        self.contacts[i].ledger.onset
    }

    fn last_release(&self, i: usize) -> f64 {
        self.contacts[i].ledger.release
    }

    fn dissipated_energy(&self) -> f64 {
        let [loss, _] = self.sums_place();
        self.y[loss]
    }

    fn external_work(&self) -> f64 {
        let [_, work] = self.sums_place();
        self.y[work]
    }

    fn support_force_mean(&self) -> f64 {
        self.support_force()
    }

    fn next_onset(&self) -> Next {
        self.next
    }

    /// The host does the work.
    fn work(&self) -> WorkCounters {
        WorkCounters::default()
    }
}
