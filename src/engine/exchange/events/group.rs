//! A group of contacts, followed within an event from its onset until all of them are open, by the event-driven engine.

use std::ops::Range;

use crate::engine::error::EngineError;
use crate::engine::exchange::run::Exchange;
use crate::engine::flight::{Ball, Separation};
use crate::engine::inputs::HeldInputs;
use crate::engine::observer::{Observer, Pulse, Unrecorded};
use crate::engine::run::{Contact, Engine, Phase};
use crate::model::{ContactLaw, Inputs, Mode, Parameters};
use crate::next::Next;
use crate::solver::double_double::DoubleDouble;

/// Part of the period of ball 1 that a group may last; without gravity of 2 pi s.
const LONGEST: f64 = 1e-3;

/// Effort, in units of about a tenth of a microsecond, that a group may take.
const EFFORT: u64 = 1_000_000;

/// What is known of a group at its end.
pub(super) struct Group {
    /// Its contacts.
    pub contacts: Range<usize>,
    /// Its pulses, their times counted from the onset (s).
    pub pulses: Vec<Pulse>,
    /// The onset and the time up to which it has been followed, from now, s.
    pub onset: f64,
    pub until: f64,
    /// The states after it, seen from now: of its balls and of the contacts that these are part of.
    pub x: Vec<f64>,
    pub v: Vec<f64>,
    pub first_overlap: usize,
    pub overlaps: Vec<f64>,
    /// What it adds to the impulses of its contacts (N.s), to the energy dissipated and to the work of the inputs (J).
    pub impulses: Vec<f64>,
    pub loss: f64,
    pub work: f64,
}

impl Group {
    /// Its balls.
    pub fn balls(&self) -> Range<usize> {
        self.contacts.start..self.contacts.end + 1
    }
}

/// Collects the pulses, and counts those that have ended in each contact.
pub(super) struct Followed {
    pub pulses: Vec<Pulse>,
    pub ended: Vec<u64>,
}

impl Followed {
    /// None yet in the contacts of `engine`.
    pub fn of(engine: &Engine) -> Self {
        Self { pulses: Vec::new(), ended: vec![0; engine.contacts.len()] }
    }
}

impl Observer for Followed {
    fn pulse(&mut self, pulse: Pulse) {
        self.ended[pulse.contact] += 1;
        self.pulses.push(pulse);
    }
}

/// The parameters of the balls `range` alone.
fn part(parameters: &Parameters, range: &Range<usize>) -> Parameters {
    let (balls, contacts) = (range.clone(), range.start..range.end - 1);
    Parameters {
        mass_ratio: parameters.mass_ratio[balls.clone()].to_vec(),
        length_ratio: parameters.length_ratio[balls.clone()].to_vec(),
        stiffness_ratio: parameters.stiffness_ratio[contacts.clone()].to_vec(),
        gap: parameters.gap[contacts].to_vec(),
        x_start: parameters.x_start[balls.clone()].to_vec(),
        v_start: parameters.v_start[balls].to_vec(),
        ..parameters.clone()
    }
}

impl Exchange {
    /// Follows the group that contact `first` belongs to from its onset, which is `onset` (s) from now; contacts that
    /// are `closed` are closed already. Nothing if it does not end before long, or if a contact that is closed for the
    /// host takes part.
    pub(super) fn follow(
        &self,
        balls: &[Ball],
        first: usize,
        onset: f64,
        closed: &[usize],
    ) -> Result<Option<Group>, EngineError> {
        let around = self.free_around(first, closed);
        let mut engine = self.engine_at(balls, &around, onset);
        let start = DoubleDouble::default();
        let local = |j: usize| j - around.start;
        for j in closed.iter().filter(|j| around.contains(j)).map(|j| local(*j)) {
            let law = &engine.cradle.contacts[j];
            let overlap = self.state.overlaps[around.start + j];
            let rate = engine.balls[j].flight.v - engine.balls[j + 1].flight.v;
            let mode = law.mode_when_closed(overlap, rate);
            engine.contacts[j].unassign(overlap, mode);
            engine.begin_pulse(j, start, &mut Unrecorded);
        }
        engine.form(0..engine.contacts.len(), start);
        for j in 0..engine.contacts.len() {
            // Balls that have yet to part are apart from then on.
            if let Some(parting) =
                self.parting(balls, around.start + j, onset).filter(|_| engine.contacts[j].separation().is_some())
            {
                let (anchor, clearance) = (DoubleDouble::from(parting - onset), engine.cradle.contacts[j].clearance);
                let overlap = self.overlap_in_flight(balls, around.start + j, parting).0.min(0.0);
                let separation = Separation::new(&engine.balls[j], &engine.balls[j + 1], anchor, overlap, clearance);
                engine.contacts[j].phase = Phase::Open(separation, Next::Never);
                engine.forecast(j, anchor);
            }
        }
        if closed.is_empty() && !engine.begin_impact(local(first), start, &mut Unrecorded) {
            engine.close(local(first), start, local(first)..local(first) + 1, &mut Unrecorded);
        }
        let mut followed = Followed::of(&engine);
        let Some((contacts, end)) = self.to_the_end(&mut engine, local(first), &mut followed)? else {
            return Ok(None);
        };
        // A ball at the edge that a closed contact acts on was not in flight.
        let edge = |inside: bool, beside: Option<usize>| {
            inside && beside.and_then(|j| self.modes.get(j)).is_some_and(|mode| *mode != Mode::Open)
        };
        let last = around.end - around.start - 1;
        if edge(contacts.start == 0, around.start.checked_sub(1))
            || edge(contacts.end == last, Some(around.end - 1).filter(|j| *j < self.modes.len()))
        {
            return Ok(None);
        }
        Ok(Some(self.outcome(balls, &engine, &around, contacts, (onset, end), followed)))
    }

    /// The balls about contact `first` between contacts that are closed for the host, with those of `open`, which are
    /// not.
    fn free_around(&self, first: usize, open: &[usize]) -> Range<usize> {
        let free = |j: &usize| self.modes[*j] == Mode::Open || open.contains(j);
        let start = (0..first).rev().take_while(free).last().unwrap_or(first);
        let end = (first + 1..self.modes.len()).take_while(free).last().unwrap_or(first);
        start..end + 2
    }

    /// An engine for the balls of `range`, all in flight, `onset` (s) from now; that is its time 0.
    fn engine_at(&self, balls: &[Ball], range: &Range<usize>, onset: f64) -> Engine {
        let mut parameters = part(&self.parameters, range);
        for (k, ball) in balls[range.clone()].iter().enumerate() {
            let (displacement, v) = ball.moved(onset.into());
            (parameters.x_start[k], parameters.v_start[k]) = (ball.flight.x + displacement, v);
        }
        let force = self.inputs.force[range.clone()].to_vec();
        let values = Inputs { force, support_acceleration: self.inputs.support_acceleration };
        let mut engine = Engine::apart(&parameters, HeldInputs { since: 0.0, values, derivatives: Vec::new() }, 0.0);
        for (j, contact) in (range.start..).zip(&mut engine.contacts) {
            contact.unassign(self.overlap_in_flight(balls, j, onset).0.min(0.0), Mode::Open);
        }
        engine
    }

    /// Moves `engine` on until the group of contact `first` is open and has stayed so for as long as it lasted. Answers
    /// its contacts and that time.
    fn to_the_end(
        &self,
        engine: &mut Engine,
        first: usize,
        followed: &mut Followed,
    ) -> Result<Option<(Range<usize>, DoubleDouble)>, EngineError> {
        let limit = DoubleDouble::from(LONGEST * std::f64::consts::TAU * self.cradle.balls[0].unit_of_time());
        let enough = engine.effort.saturating_add(EFFORT);
        let pulses = |engine: &Engine, j: usize| engine.contacts[j].ledger.pulses;
        let mut group = first..first + 1;
        loop {
            while group.start > 0 && pulses(engine, group.start - 1) > 0 {
                group.start -= 1;
            }
            while group.end < engine.contacts.len() && pulses(engine, group.end) > 0 {
                group.end += 1;
            }
            let open = group.clone().all(|j| pulses(engine, j) == followed.ended[j]);
            let last = group.clone().map(|j| engine.contacts[j].ledger.release).fold(0.0, f64::max);
            let (event, quiet) = (engine.queue.first(), DoubleDouble::from(2.0 * last));
            match event.filter(|(t, _)| !open || *t <= quiet) {
                None if open => return Ok(Some((group, quiet))),
                None => return Ok(None),
                Some((t, _)) if t > limit || engine.effort > enough => return Ok(None),
                Some((t, key)) => engine.process(t, key, followed)?,
            }
        }
    }

    /// What has become of the group of `contacts`, which began at `times.0` (s from now) and was open at `times.1`
    /// after that, where `engine`, which has the balls `around`, is now.
    fn outcome(
        &self,
        balls: &[Ball],
        engine: &Engine,
        around: &Range<usize>,
        contacts: Range<usize>,
        times: (f64, DoubleDouble),
        followed: Followed,
    ) -> Group {
        let (onset, end) = times;
        let back = (DoubleDouble::from(-onset) - end).value();
        let shift = around.start;
        let members = contacts.start..contacts.end + 1;
        // With the balls on either side, if there are any.
        let wide = members.start.saturating_sub(1)..(members.end + 1).min(engine.balls.len());
        // Free flight through the states at the end, anchored there.
        let after = |i: usize| {
            let ((x, v), mut ball) = (engine.state_at(i, end), engine.balls[i].clone());
            (ball.flight.x, ball.flight.v, ball.anchor) = (x, v, DoubleDouble::default());
            ball.integrals = engine.integrals_at(i, end);
            let moved = ball.moved(back.into());
            (ball, moved)
        };
        let flights: Vec<(Ball, (f64, f64))> = wide.clone().map(after).collect();
        let own = &flights[members.start - wide.start..members.end - wide.start];
        let x: Vec<f64> = own.iter().map(|(ball, (displacement, _))| ball.flight.x + displacement).collect();
        let (mut loss, mut work) = (0.0, 0.0);
        for ((ball, _), before) in own.iter().zip(&balls[shift + members.start..]) {
            let (there, before) = (ball.integrals_at(back.into()), before.integrals_at(onset.into()));
            loss += there.drag_loss + before.drag_loss;
            work += there.work + before.work;
        }
        let beyond = |(j, contact): (usize, &Contact)| !contacts.contains(&j) && contact.ledger.pulses > 0;
        let alone = !engine.contacts.iter().enumerate().any(beyond);
        let overlap = |j: usize| {
            if !alone && !contacts.contains(&j) {
                // The other ball may have met others: only that of the group has changed its motion here.
                let changed = |i: usize| x[i - members.start] - self.state.x[shift + i];
                let change = if j < contacts.start { -changed(j + 1) } else { changed(j) };
                return self.state.overlaps[shift + j] + change;
            }
            let displacement = |i: usize| flights[i - wide.start].1.0;
            engine.overlap_at(j, end).0 + (displacement(j) - displacement(j + 1))
        };
        let overlaps = (wide.start..wide.end - 1).map(overlap).collect();
        loss += match alone {
            true => engine.totals.contact_loss,
            false => contact_loss(engine, own, &balls[shift + members.start..], onset),
        };
        let in_group = |pulse: &Pulse| contacts.contains(&pulse.contact);
        let pulses = followed.pulses.into_iter().filter(in_group);
        Group {
            impulses: contacts.clone().map(|j| engine.impulse_at(j, end).value()).collect(),
            contacts: contacts.start + shift..contacts.end + shift,
            pulses: pulses.map(|pulse| Pulse { contact: pulse.contact + shift, ..pulse }).collect(),
            onset,
            until: -back,
            v: own.iter().map(|(_, (_, v))| *v).collect(),
            first_overlap: shift + wide.start,
            overlaps,
            x,
            loss,
            work,
        }
    }
}

/// The loss in the contacts of a group where others have had pulses as well: what is missing of the energy of its balls
/// between the onset, `onset` (s) from where they were `before`, and the end, which `after` is anchored at, J.
fn contact_loss(engine: &Engine, after: &[(Ball, (f64, f64))], before: &[Ball], onset: f64) -> f64 {
    let of_ball = |((ball, _), before): (&(Ball, (f64, f64)), &Ball)| {
        let (displacement, v) = before.moved(onset.into());
        let (x, omega2) = (before.flight.x + displacement, ball.oscillator.omega2());
        let kinetic = (v - ball.flight.v) * (v + ball.flight.v);
        let potential = omega2 * (x - ball.flight.x) * (x + ball.flight.x);
        0.5 * ball.mass * (kinetic + potential) + ball.integrals.work - ball.integrals.drag_loss
    };
    if engine.cradle.contacts.iter().all(ContactLaw::is_elastic) {
        return 0.0;
    }
    after.iter().zip(before).map(of_ball).sum()
}
