//! What a run has been given since its start: all that it can be repeated from.

use serde::{Deserialize, Serialize};

use crate::engine::inputs::HeldInputs;
use crate::model::{Parameters, Tunables};

/// Numbers that a history may hold, 128 MiB of them. A host that sets the inputs of five balls at every millisecond reaches that after
/// 25 minutes.
const MOST_NUMBERS: usize = 1 << 24;

/// A part of a run over which nothing was changed: the inputs are polynomials of the time.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Stretch {
    /// Its end, s.
    pub until: f64,
    pub inputs: HeldInputs,
    pub tunables: Tunables,
}

/// The inputs and tunable parameters of a run up to their last change, as far as they were kept.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct History {
    stretches: Vec<Stretch>,
    /// Numbers held.
    numbers: usize,
    /// Whether a change was not kept.
    broken: bool,
}

impl History {
    /// Something changes at the time `until` (s); before it, these inputs and parameters acted. Kept if that is `wanted` and
    /// there is room.
    pub(crate) fn keep(&mut self, wanted: bool, until: f64, inputs: &HeldInputs, tunables: Tunables) {
        let numbers = inputs.orders().map(|inputs| inputs.force.len() + 1).sum::<usize>() + tunables.len();
        self.broken |= !wanted || self.numbers + numbers > MOST_NUMBERS;
        if self.broken {
            (self.stretches, self.numbers) = (Vec::new(), 0);
        } else {
            self.stretches.push(Stretch { until, inputs: inputs.clone(), tunables });
            self.numbers += numbers;
        }
    }

    /// Whether all changes were kept.
    pub fn is_complete(&self) -> bool {
        !self.broken
    }

    /// The stretches of a run from its start to `until` (s), the last of which goes on under these inputs and parameters.
    pub(crate) fn stretches(&self, until: f64, inputs: &HeldInputs, tunables: Tunables) -> Vec<Stretch> {
        let last = Stretch { until, inputs: inputs.clone(), tunables };
        self.stretches.iter().cloned().chain([last]).collect()
    }

    /// Whether it can be one of a run of these parameters, of which only the tunable ones have changed.
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
