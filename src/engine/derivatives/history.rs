//! The history of a run's inputs, from which it can be repeated.

use std::cell::OnceCell;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::engine::HeldInputs;
use crate::engine::tape::{Tape, Unfollowed};
use crate::model::{Parameters, Tunables};

/// Most values in a history, 128 MiB: 25 minutes of a host that sets the inputs of five balls every millisecond.
const MOST_NUMBERS: usize = 1 << 24;

/// A part of a run without changes: the inputs are polynomials of the time.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Stretch {
    /// End, s.
    pub until: f64,
    pub inputs: HeldInputs,
    pub tunables: Tunables,
}

/// Stretches, one after the other, up to the last change.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Stretches {
    list: Vec<Stretch>,
    numbers: usize,
    /// Whether a change was not kept, so that the list is incomplete.
    broken: bool,
}

impl Stretches {
    /// Adds what acted until a change, if it is `wanted`, acted for some time, and has room.
    fn keep(&mut self, wanted: bool, stretch: &Stretch) {
        self.broken |= !wanted;
        if !self.broken && self.list.last().is_none_or(|last| last.until < stretch.until) {
            let inputs = stretch.inputs.orders.iter();
            self.numbers += inputs.map(|inputs| inputs.force.len() + 1).sum::<usize>() + stretch.tunables.len();
            self.list.push(stretch.clone());
            self.broken = self.numbers > MOST_NUMBERS;
        }
        if self.broken {
            (self.list, self.numbers) = (Vec::new(), 0);
        }
    }

    /// All stretches, then `last`; `None` if some were not kept.
    fn and(&self, last: Stretch) -> Option<Vec<Stretch>> {
        (!self.broken).then(|| self.list.iter().cloned().chain([last]).collect())
    }
}

/// The inputs and tunable parameters of a run, and of its last step, up to their last change.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct History {
    of_run: Stretches,
    of_step: Stretches,
    /// The tapes of the last step and of the run up to now, if they were needed.
    #[serde(skip)]
    tapes: [OnceCell<Result<Arc<Tape>, Unfollowed>>; 2],
}

impl History {
    /// Keeps, before a change, what acted until then: for the run if that is `wanted`, for the step if that has lasted
    /// for some time.
    pub(crate) fn keep(&mut self, wanted: bool, in_step: bool, stretch: &Stretch) {
        self.forget_tapes();
        self.of_run.keep(wanted, stretch);
        if in_step {
            self.of_step.keep(true, stretch);
        }
    }

    /// Begins a step.
    pub fn begin_step(&mut self) {
        self.of_step = Stretches::default();
    }

    /// The tape of the last step, or of the run so far, recorded on first use.
    pub fn tape(
        &self,
        of_run: bool,
        record: impl FnOnce(&Self) -> Result<Tape, Unfollowed>,
    ) -> Result<Arc<Tape>, Unfollowed> {
        self.tapes[usize::from(of_run)].get_or_init(|| record(self).map(Arc::new)).clone()
    }

    /// Drops the tapes, because the run goes on.
    pub fn forget_tapes(&mut self) {
        self.tapes = Default::default();
    }

    /// Whether all changes were kept.
    pub fn is_complete(&self) -> bool {
        !self.of_run.broken
    }

    /// The stretches of the run, then `now`; `None` if some were not kept.
    pub(crate) fn of_run(&self, now: Stretch) -> Option<Vec<Stretch>> {
        self.of_run.and(now)
    }

    /// The stretches of the last step, then `now`; `None` if some were not kept.
    pub(crate) fn of_step(&self, now: Stretch) -> Option<Vec<Stretch>> {
        self.of_step.and(now)
    }

    /// Whether it fits a run of these parameters, of which only tunable ones may have changed.
    pub fn is_sound(&self, parameters: &Parameters, allowed: impl Fn(&Parameters) -> bool) -> bool {
        let (mut then, mut known) = (parameters.clone(), None::<Tunables>);
        let mut stretch = |Stretch { until, inputs, tunables }: &Stretch| {
            let tuned = known.as_ref() == Some(tunables) || {
                known = Some(tunables.clone());
                then.tune(tunables);
                allowed(&then)
            };
            let finite = inputs.are_finite() && inputs.since.is_finite() && until.is_finite();
            tuned && finite && inputs.fit(parameters.balls())
        };
        [&self.of_run, &self.of_step].into_iter().all(|Stretches { list, numbers, .. }| {
            *numbers <= MOST_NUMBERS && list.iter().all(&mut stretch) && list.is_sorted_by(|a, b| a.until <= b.until)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Inputs;

    #[test]
    fn history_drops_what_has_acted_for_no_time() {
        let (p, held) = (Parameters::default_for(3), HeldInputs::constant(Inputs::zero(3), 0.0));
        let stretch = |until| Stretch { until, inputs: held.clone(), tunables: p.tunables() };
        let mut history = History::default();
        for until in [0.5, 0.5, 0.75] {
            history.keep(true, until > 0.5, &stretch(until));
        }
        let kept = |history: &History| [history.of_run(stretch(1.0)), history.of_step(stretch(1.0))];
        assert_eq!(kept(&history).map(|of| of.map(|stretches| stretches.len())), [Some(3), Some(2)]);
        history.keep(false, true, &stretch(1.0));
        assert_eq!(kept(&history).map(|of| of.map(|stretches| stretches.len())), [None, Some(3)]);
        history.begin_step();
        assert_eq!((history.is_complete(), kept(&history)[1].as_ref().map(Vec::len)), (false, Some(1)));
    }
}
