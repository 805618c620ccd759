//! How the outputs at the current time depend on the parameters and on the inputs of the whole run.

use super::chain_state::ChainState;
use super::history::Stretch;
use super::last_step::{LastStep, forcings_along, start_along};
use super::tangent::{NotFollowed, Run};
use crate::model::{Cradle, Differential, Inputs, Parameters};

/// A run from its start to the current time, by whichever method: all that its derivatives follow from.
pub(crate) struct WholeRun<'a> {
    /// The parameters that act now.
    pub parameters: &'a Parameters,
    /// Time at the start, s, and the state then.
    pub start_time: f64,
    pub start: ChainState,
    /// What acted since.
    pub stretches: Vec<Stretch>,
    /// Its last step.
    pub last: LastStep<'a>,
}

impl WholeRun<'_> {
    /// Derivatives of the outputs at its end along a direction of parameters and inputs. The inputs change by the same
    /// over the whole run, tunable parameters too.
    pub fn along(&self, tangent: &Parameters, inputs: &Inputs) -> Result<Differential, NotFollowed> {
        // Inputs may change at every step, parameters hardly do.
        let parts: Vec<&[Stretch]> = self.stretches.chunk_by(|a, b| a.tunables == b.tunables).collect();
        let tuned = |part: &&[Stretch]| {
            let mut parameters = self.parameters.clone();
            parameters.tune(part[0].tunables);
            let cradle = Cradle::new(&parameters);
            (parameters, cradle)
        };
        let acting: Vec<(Parameters, Cradle)> = parts.iter().map(tuned).collect();
        let step_start = self.last.inputs.since;
        let (mut run, mut since): (Option<Run>, f64) = (None, self.start_time);
        for (part, (parameters, cradle)) in parts.iter().zip(&acting) {
            let along = Cradle::along(parameters, tangent);
            for stretch in *part {
                let forcings = forcings_along(&along, &stretch.inputs.at(since), inputs);
                let begun = match run.take() {
                    None => {
                        let state = start_along(&self.start, &along, tangent);
                        let mut begun = Run::new(cradle, along.clone(), state, forcings);
                        // What a stiffness changes is large while a contact acts, small after it.
                        begun.cancellation = 0.0;
                        begun
                    }
                    Some(run) => run.under(cradle, along.clone(), forcings),
                };
                let run = run.insert(begun);
                if (since..stretch.until).contains(&step_start) {
                    run.follow(Some(step_start - since))?;
                    run.begin_step();
                }
                run.follow(Some(stretch.until - since))?;
                since = stretch.until;
            }
        }
        let run = run.ok_or(NotFollowed)?;
        self.last.outputs_of(run)
    }
}
