//! The history of a run's inputs, from which it can be repeated.

use std::cell::OnceCell;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::adjoint::Tape;
use crate::engine::HeldInputs;
use crate::model::{Parameters, Tunables};

/// Most values in a history, 128 MiB: 25 minutes of a host that sets the inputs of five balls every millisecond.
const MOST_NUMBERS: usize = 1 << 24;

/// A part of a run without changes: the inputs are polynomials of the time.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Stretch {
    /// Its end, s.
    pub until: f64,
    pub inputs: HeldInputs,
    pub tunables: Tunables,
}

/// The inputs and tunable parameters of a run up to their last change.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct History {
    stretches: Vec<Stretch>,
    numbers: usize,
    /// Whether a change was not kept.
    broken: bool,
    /// The tape of the run up to now, if it was needed: recording it is most of the cost of a gradient.
    #[serde(skip)]
    tape: OnceCell<Option<Arc<Tape>>>,
}

impl History {
    /// Before a change at `until` (s): keeps inputs and parameters that acted for a time, if `wanted` and if
    /// there is room.
    pub(crate) fn keep(&mut self, wanted: bool, until: f64, inputs: &HeldInputs, tunables: Tunables) {
        self.forget_tape();
        self.broken |= !wanted;
        if !self.broken && self.stretches.last().is_none_or(|last| last.until < until) {
            self.numbers += inputs.orders.iter().map(|inputs| inputs.force.len() + 1).sum::<usize>() + tunables.len();
            self.stretches.push(Stretch { until, inputs: inputs.clone(), tunables });
            self.broken = self.numbers > MOST_NUMBERS;
        }
        if self.broken {
            (self.stretches, self.numbers) = (Vec::new(), 0);
        }
    }

    /// The tape of the run so far, recorded on first use.
    pub fn tape(&self, record: impl FnOnce(&Self) -> Option<Tape>) -> Option<Arc<Tape>> {
        self.tape.get_or_init(|| record(self).map(Arc::new)).clone()
    }

    /// Drops the tape, because the run goes on.
    pub fn forget_tape(&mut self) {
        self.tape.take();
    }

    /// Whether all changes were kept.
    pub fn is_complete(&self) -> bool {
        !self.broken
    }

    /// The stretches of a run from its start to `until` (s), the last one with these inputs and parameters.
    pub(crate) fn stretches(&self, until: f64, inputs: &HeldInputs, tunables: Tunables) -> Vec<Stretch> {
        let last = Stretch { until, inputs: inputs.clone(), tunables };
        self.stretches.iter().cloned().chain([last]).collect()
    }

    /// Whether it fits a run of these parameters, of which only tunable ones may have changed.
    pub fn is_sound(&self, parameters: &Parameters, allowed: impl Fn(&Parameters) -> bool) -> bool {
        let (mut then, mut known) = (parameters.clone(), None);
        let stretch = |Stretch { until, inputs, tunables }: &Stretch| {
            let tuned = known.replace(*tunables) == Some(*tunables) || {
                then.tune(*tunables);
                allowed(&then)
            };
            let finite = inputs.are_finite() && inputs.since.is_finite() && until.is_finite();
            tuned && finite && inputs.fit(parameters.balls())
        };
        self.numbers <= MOST_NUMBERS
            && self.stretches.iter().all(stretch)
            && self.stretches.is_sorted_by(|a, b| a.until <= b.until)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Inputs;

    #[test]
    fn what_has_acted_for_no_time_is_not_kept() {
        let (p, held) = (Parameters::default_for(3), HeldInputs::constant(Inputs::zero(3), 0.0));
        let mut history = History::default();
        for until in [0.5, 0.5, 0.75] {
            history.keep(true, until, &held, p.tunables());
        }
        assert!(history.is_complete() && history.stretches.len() == 2);
        history.keep(false, 1.0, &held, p.tunables());
        assert!(!history.is_complete() && history.stretches.is_empty());
    }
}
