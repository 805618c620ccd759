//! The next onset, from the forecasts or by a copy of the run that looks ahead; the next onset or release.

use crate::engine::run::{ContactRole, Engine, Interaction, NO_STEP};
use crate::engine::{Forecast, Unrecorded, cluster::Switch};
use crate::model::ONSET_PERIODS;
use crate::solver::DoubleDouble;

/// Effort of a look ahead ([`Engine::effort`]): some tenths of a millisecond, and the event that exceeds it.
const LOOK_AHEAD: u64 = 4_000;

/// Effort of copying a ball and its contact.
const COPY: u64 = 3;

/// The time of a queue entry, and its contact if its balls are in flight until then.
type Entry = (DoubleDouble, Option<usize>);

impl Engine {
    /// First onset strictly after the current time with the inputs continued; never if there is none within 1000
    /// periods of the first ball. After a fixed amount of work, the time up to which there is none; the next look
    /// continues there.
    pub(crate) fn find_next_onset(&self) -> Forecast {
        if let Some((asked_at, answer)) = self.caches.found.get() {
            // An onset stays the next one until it comes; "none within the horizon" is valid for now only.
            if asked_at == self.time || answer.found().is_some_and(|onset| onset > self.time) {
                return answer;
            }
        }
        // Taken out while in use, so that a copy of the run does not copy it.
        let mut copy = self.caches.ahead.take();
        let answer = self.look_ahead(&mut copy);
        self.caches.ahead.replace(copy);
        self.caches.found.set(Some((self.time, answer)));
        answer
    }

    /// Time of the next onset or release with the inputs continued, s, later than now: read off the queue if its first
    /// event is one; otherwise, if all contacts are in flight, found by looking ahead. `None` if neither tells.
    pub fn next_event(&self) -> Option<f64> {
        let (t, key) = self.queue.first()?;
        let is_known = match (&self.contacts[key].role, self.interaction_of_contact(key)) {
            (_, Some(Interaction::Cluster(cluster))) => {
                matches!(cluster.switch, Some((_, Switch::Onset | Switch::Release)))
            }
            (_, Some(Interaction::Impact(_))) => true,
            (_, Some(Interaction::Body(body))) => body.releases(key),
            (role, None) => matches!(role, ContactRole::Open(_, Forecast::At(_))),
        };
        let in_flight = || self.contacts.iter().all(|contact| matches!(contact.role, ContactRole::Open(..)));
        let next = if is_known { Some(t.value_up()) } else { self.find_next_onset().found().filter(|_| in_flight()) };
        next.filter(|next| *next > self.time)
    }

    fn copy_ahead(&self) -> Box<Self> {
        let mut copy = Box::new(self.clone());
        copy.step.time = NO_STEP;
        copy
    }

    fn look_ahead(&self, copy: &mut Option<Box<Self>>) -> Forecast {
        if self.step.number == 0 {
            // Made here, where all balls are set up anyway, so that no later look copies all of them.
            copy.get_or_insert_with(|| self.copy_ahead());
        }
        let limit = DoubleDouble::from(self.time + ONSET_PERIODS * self.cradle.period());
        let found = self.read_off(self.time, limit).unwrap_or_else(|| {
            // If it has fallen behind, a copy may be cheaper than catching up.
            let copying = COPY * self.balls.len() as u64;
            copy.take_if(|copy| copy.handled < self.handled && self.effort.saturating_sub(copy.effort) >= copying);
            let copy = copy.get_or_insert_with(|| self.copy_ahead());
            while copy.handled < self.handled
                && let Some((t, key)) = copy.queue.first()
                && copy.process(t, key, &mut Unrecorded).is_ok()
            {}
            copy.seek_onset(self.onsets, self.time, limit, LOOK_AHEAD)
        });
        // A copy that has left the range of doubles, or whose balls cannot go on, is no state to save.
        let is_lost = |copy: &Self| copy.queue.first().is_some_and(|(t, _)| !t.value().is_finite());
        copy.take_if(|copy| copy.fault.is_some() || is_lost(copy));
        match found {
            Forecast::At((t, _)) => Forecast::At(t.value_up()),
            Forecast::NotBefore((t, _)) => Forecast::not_before(t.value_down(), self.time),
            Forecast::Never => Forecast::Never,
        }
    }

    /// Advances to the first onset after `now` (s) that is not among the first `passed` ones, unless it lies beyond
    /// `limit` or takes more than this effort. Returns the queue entry of the onset.
    pub(crate) fn seek_onset(
        &mut self,
        mut passed: u64,
        now: f64,
        limit: DoubleDouble,
        effort: u64,
    ) -> Forecast<Entry> {
        let enough = self.effort.saturating_add(effort);
        loop {
            let onset = self.totals.last_event;
            if self.onsets > passed && onset > limit {
                return Forecast::Never;
            }
            if self.onsets > passed && onset.value_up() > now {
                return Forecast::At((onset, None));
            }
            // Onsets that are due right now are not ahead.
            passed = self.onsets;
            if let Some(found) = self.read_off(now, limit) {
                return found;
            }
            let Some((t, key)) = self.queue.first() else { return Forecast::Never };
            // An event that fails here fails in the run, too, which reports it.
            let goes_on = self.effort < enough && self.process(t, key, &mut Unrecorded).is_ok();
            if !goes_on || self.fault.is_some() {
                return Forecast::NotBefore((t, None));
            }
        }
    }

    /// The first onset after `now` (s), if the first entry of the queue is that onset, or beyond `limit`.
    fn read_off(&self, now: f64, limit: DoubleDouble) -> Option<Forecast<Entry>> {
        let Some((t, key)) = self.queue.first().filter(|(t, _)| *t <= limit) else { return Some(Forecast::Never) };
        let onset = matches!(self.contacts[key].role, ContactRole::Open(_, Forecast::At(_)));
        (onset && t.value_up() > now).then_some(Forecast::At((t, Some(key))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Inputs, Parameters, Results};

    /// Balls side by side at rest, contacts without dead band.
    fn at_rest(balls: usize) -> Parameters {
        Parameters { x_start: vec![0.0; balls], dead_band: 0.0, ..Parameters::default_for(balls) }
    }

    /// Work of the copy that goes ahead so far.
    fn effort_ahead(engine: &Engine) -> u64 {
        engine.caches.ahead.borrow().as_ref().map_or(0, |copy| copy.effort)
    }

    #[test]
    fn look_ahead_takes_a_fixed_amount_of_work_and_continues() {
        let pressed = Parameters { damping: 3e5, exponent: 7.3, gap: vec![-1e-6; 12], ..at_rest(13) };
        // A gap that closes slowly under drag while an input of this order grows.
        let driven = |drag: f64, order: usize| {
            let p = Parameters { gravity: 0.0, drag, x_start: vec![-0.01, 0.0], ..at_rest(2) };
            let mut derivatives = vec![Inputs::zero(2); order];
            derivatives[order - 1].force[1] = 1.0;
            (p, derivatives)
        };
        let driven = [1e-9, 1e-3, 0.2, 10.0].into_iter().flat_map(|drag| [1, 2, 3].map(|order| driven(drag, order)));
        for (p, derivatives) in driven.chain([(pressed, Vec::new())]) {
            let inputs = Inputs::zero(p.balls());
            let mut engine = Engine::new(&p, &inputs, 0.0).unwrap();
            engine.hold(&inputs, &derivatives).unwrap();
            engine.advance(0.01, &mut Unrecorded).unwrap();
            let mut last = 0.0;
            for _ in 0..20 {
                let before = effort_ahead(&engine).max(engine.effort);
                let next = engine.next_onset();
                assert!(next.time() > engine.time().max(last), "{next:?} at {}", engine.time());
                // The effort of the last event within the limit depends on the number of balls.
                let taken = effort_ahead(&engine).saturating_sub(before);
                assert!(taken < 2 * LOOK_AHEAD + 200 * p.balls() as u64, "{taken} at {}", engine.time());
                if next.is_settled() {
                    break;
                }
                assert_eq!(engine.next_onset(), next);
                (last, _) = (next.time(), engine.advance(engine.time() + 1e-7, &mut Unrecorded).unwrap());
            }
        }
    }

    #[test]
    fn look_ahead_adds_nothing_to_a_step_over_an_onset() {
        let costs = [5, 1000].map(|balls| {
            // One ball lifted; the wave passes from contact to contact.
            let x_start = (0..balls).map(|i| if i == 0 { -0.1 } else { 0.0 }).collect();
            let p = Parameters { x_start, ..Parameters::default_for(balls) };
            let mut engine = Engine::new(&p, &Inputs::zero(balls), 0.0).unwrap();
            let onset = |engine: &Engine| engine.next_onset().found().unwrap();
            std::array::from_fn::<_, 3, _>(|_| {
                let before = engine.effort;
                engine.advance(onset(&engine), &mut Unrecorded).unwrap();
                let copy = effort_ahead(&engine);
                onset(&engine);
                let ahead = effort_ahead(&engine) - copy;
                (engine.effort - before, engine.step.moved.len(), ahead)
            })
        });
        assert_eq!(costs[0], costs[1]);
        assert!(costs[0].iter().all(|(effort, moved, _)| *effort < 500 && *moved <= 5), "{costs:?}");
    }
}
