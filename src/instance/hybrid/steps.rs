//! Steps that end or pause at onsets and releases, and the events between them.

use super::state::UnderWay;
use super::ticks::Recorder;
use crate::engine::Results;
use crate::instance::calls::{CLOCK_TOLERANCE, Reporter};
use crate::instance::legality::{Kind, Phase};
use crate::instance::lifecycle::Instance;
use crate::instance::refusal::Refusal;
use crate::model::{ContactModel, Inputs};

/// How a step, or a part of it, has ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepEnd {
    /// Time reached, s.
    pub time: f64,
    /// Whether that is before the end that was asked for.
    pub early: bool,
    /// Whether the host has events to take part in.
    pub events: bool,
    /// Whether the host is to be called before it goes on.
    pub pauses: bool,
}

/// What the host has to say where a step pauses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UpdateAnswer {
    /// The time at which it wants the step to end, s, if it does.
    pub end: Option<f64>,
}

/// What the host is told where it has taken part in an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Handled {
    /// Whether there is another one at once.
    pub again: bool,
    /// Whether continuous states have changed.
    pub changed: bool,
    /// When the next one is due, s, as far as that is known.
    pub next: Option<f64>,
}

impl Instance {
    /// Begins a step, as [`Instance::step`] does it all. The host is called at each onset and release if it `pauses`.
    pub fn begin_step(&mut self, current: f64, step: f64, pauses: bool) -> Result<StepEnd, Refusal> {
        let slopes = self.slopes();
        if !slopes.is_empty() {
            self.run.input_derivatives = slopes;
            self.run.inputs_changed = true;
        }
        let own = self.time();
        let Some(end) = self.begin(current, step)? else {
            return Ok(StepEnd { time: own, early: false, events: self.events_are_due(), pauses: false });
        };
        self.catch_up_rigid()?;
        self.part(UnderWay { asked: end, end, since: own }, pauses, true)
    }

    /// Goes on with a step after a pause.
    pub fn continue_step(&mut self, pause: UpdateAnswer) -> Result<StepEnd, Refusal> {
        let Some(mut step) = self.under_way() else { return Err(Refusal::Missing("no step is under way")) };
        self.run.phase = Phase::StepMode;
        let now = self.time();
        if self.run.inputs_changed || self.run.tuned_from.is_some() {
            self.run.input_derivatives = self.slopes();
            step.since = now;
            self.update_simulation()?;
            self.catch_up_rigid()?;
        }
        if let Some(end) = pause.end {
            step.end = step.end.min(end.max(now));
        }
        if step.end == now || self.may_end_early() && self.events_are_due() {
            return self.end_step(step, now);
        }
        self.part(step, true, false)
    }

    /// Moves on to the end of the step, which it may have to begin, or to the first onset or release.
    fn part(&mut self, step: UnderWay, pauses: bool, begins: bool) -> Result<StepEnd, Refusal> {
        let events = self.run.takes_part_in_events();
        let (end, stops) = (step.end, pauses || self.may_end_early());
        let (Some(simulation), Some(hybrid)) = (&mut self.run.simulation, &mut self.run.hybrid) else {
            return Err(Refusal::Missing("nothing is calculated yet"));
        };
        let (reporter, ticks) = (Reporter::new(&self.log, end), &mut hybrid.ticks);
        let mut recorder = Recorder { reporter, ticks, tells: events, stops, stopped: None };
        let moved = match begins {
            true => simulation.advance(end, &mut recorder),
            false => simulation.continue_step(end, &mut recorder),
        };
        let stopped = recorder.stopped.is_some_and(|stopped| stopped <= end);
        moved.map_err(|error| self.fail(error))?;
        let time = self.time();
        if !(pauses && stopped) {
            return self.end_step(step, time);
        }
        self.run.phase = Phase::IntermediateUpdate;
        if let Some(hybrid) = &mut self.run.hybrid {
            hybrid.under_way = Some(step);
        }
        Ok(StepEnd { time, early: time < step.asked, events: self.events_are_due(), pauses: true })
    }

    /// The step is over at `time` (s); the inputs stay at what they have reached.
    fn end_step(&mut self, step: UnderWay, time: f64) -> Result<StepEnd, Refusal> {
        if let Some(hybrid) = &mut self.run.hybrid {
            hybrid.under_way = None;
        }
        let reached = self.inputs_reached((time - step.since).max(0.0))?;
        self.keep_inputs(reached);
        Ok(StepEnd { time, early: time < step.asked, events: self.events_are_due(), pauses: false })
    }

    /// Before inputs are set in the middle of a step: those with slopes are what they have reached by now.
    pub(super) fn keep_inputs_in_step(&mut self) -> Result<(), Refusal> {
        let Some(step) = self.under_way() else { return Ok(()) };
        let now = self.time();
        let reached = self.inputs_reached((now - step.since).max(0.0))?;
        self.keep_inputs(reached);
        if let Some(hybrid) = &mut self.run.hybrid {
            hybrid.under_way = Some(UnderWay { since: now, ..step });
        }
        Ok(())
    }

    /// To events: from a step, or from integration.
    pub fn enter_events(&mut self) -> Result<(), Refusal> {
        if self.run.kind == Kind::ModelExchange {
            return self.enter_events_of_exchange();
        }
        if !self.run.takes_part_in_events() {
            return Err(Refusal::Unsupported("the instance was created without event mode"));
        }
        self.run.phase = Phase::EventMode;
        self.reach_event()?;
        self.tick();
        Ok(())
    }

    /// The first events, of what is closed at the start.
    pub(in crate::instance) fn begin_events(&mut self) -> Result<(), Refusal> {
        if self.run.takes_part_in_events() {
            self.catch_up()?;
            self.tick();
        }
        Ok(())
    }

    /// An event that is due but for rounding of the host's clock is due now.
    fn reach_event(&mut self) -> Result<(), Refusal> {
        self.update_simulation()?;
        self.catch_up_rigid()?;
        let (own, margin) = (self.time(), CLOCK_TOLERANCE * self.time().abs().max(1.0));
        let next = self.simulation()?.next_event().filter(|next| *next - own <= margin);
        match next {
            Some(next) if !self.events_are_due() => {
                self.part(UnderWay { asked: next, end: next, since: own }, false, false).map(|_| ())
            }
            _ => Ok(()),
        }
    }

    /// The host has taken part in the event of the active clocks.
    pub fn next_event(&mut self) -> Result<Handled, Refusal> {
        if self.run.kind == Kind::ModelExchange {
            return self.next_event_of_exchange();
        }
        self.update_simulation()?;
        self.catch_up()?;
        let again = self.tick();
        let next = if again { None } else { self.simulation()?.next_event() };
        Ok(Handled { again, changed: false, next })
    }

    /// From events to steps.
    pub fn enter_step_mode(&mut self) {
        self.run.phase = Phase::StepMode;
        if let Some(hybrid) = &mut self.run.hybrid {
            hybrid.ticks.rest();
        }
    }

    /// Inputs that press rigid balls together close contacts at once: to be told where they take effect.
    fn catch_up_rigid(&mut self) -> Result<(), Refusal> {
        let rigid = self.run.settings.parameters.contact_model == ContactModel::Rigid;
        if rigid && self.run.takes_part_in_events() { self.catch_up() } else { Ok(()) }
    }

    fn catch_up(&mut self) -> Result<(), Refusal> {
        self.simulation()?;
        if let (Some(simulation), Some(hybrid)) = (&self.run.simulation, &mut self.run.hybrid) {
            hybrid.ticks.catch_up(&**simulation, simulation.time());
        }
        Ok(())
    }

    pub(super) fn tick(&mut self) -> bool {
        let Ok(work) = self.results().map(Results::work) else { return false };
        let Some(hybrid) = &mut self.run.hybrid else { return false };
        hybrid.ticks.work = work;
        hybrid.ticks.tick()
    }

    fn events_are_due(&self) -> bool {
        self.run.hybrid.as_ref().is_some_and(|hybrid| hybrid.ticks.are_due())
    }

    fn may_end_early(&self) -> bool {
        self.run.takes_part_in_events() && self.run.hybrid.as_ref().is_some_and(|hybrid| hybrid.early_return)
    }

    fn under_way(&self) -> Option<UnderWay> {
        self.run.hybrid.as_ref()?.under_way
    }

    /// Slopes of the inputs, if any is not zero.
    fn slopes(&self) -> Vec<Inputs> {
        let slopes = self.run.hybrid.as_ref().map(|hybrid| hybrid.slopes.clone());
        slopes.into_iter().filter(|slopes| *slopes != Inputs::zero(self.balls())).collect()
    }
}
