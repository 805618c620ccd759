//! The inside of an impact of known outcome, for those who look at it: segments as those of any cluster, computed as far as somebody
//! has asked for.

use std::cell::OnceCell;

use super::Engine;
use super::ball::Tally;
use super::cluster::Cluster;
use super::pace::Pace;
use super::pair::PairImpact;
use super::taylor::Control;
use super::window::{Mode, Switch, WindowContact};
use crate::solver::double_double::DoubleDouble;

/// The first segment, once it is asked for. What has been computed is not copied with an impact.
#[derive(Debug, Default)]
pub(crate) struct Lookup(OnceCell<Box<Inside>>);

impl Clone for Lookup {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// A segment of an impact and, once it is asked for, the next.
#[derive(Debug)]
pub(crate) struct Inside {
    pub segment: Cluster,
    /// Gathered in the segments before: the impulse of the contact, N.s, and by the left and the right ball.
    pub impulse: f64,
    pub tallies: [Tally; 2],
    next: OnceCell<Option<Box<Inside>>>,
}

/// One after the other: there may be more than a stack holds.
impl Drop for Inside {
    fn drop(&mut self) {
        let mut next = self.next.take().flatten();
        while let Some(mut inside) = next {
            next = inside.next.take().flatten();
        }
    }
}

impl Inside {
    /// The time since the start of the segment.
    fn since(&self, t: DoubleDouble) -> f64 {
        (t - self.segment.start).value().max(0.0)
    }
}

impl Engine {
    /// The segment of the impact under way in contact `i` that holds the time `t`, with what was before it; the last one for a time
    /// after the impact.
    pub(super) fn inside(&self, i: usize, t: DoubleDouble) -> Option<&Inside> {
        let impact = self.contacts[i].impact.as_ref()?;
        let mut inside = impact.inside.0.get_or_init(|| {
            let (mut segment, _) = self.alone(i, impact);
            segment.forget_scratch();
            Box::new(Inside { segment, impulse: 0.0, tallies: Default::default(), next: OnceCell::new() })
        });
        while inside.segment.end() <= t
            && let Some(next) = inside.next.get_or_init(|| self.next_inside(i, impact, inside).map(Box::new))
        {
            inside = next;
        }
        Some(inside)
    }

    /// The same as a segment and the time since its start, s.
    pub(super) fn inside_at(&self, i: usize, t: DoubleDouble) -> Option<(&Cluster, f64)> {
        self.inside(i, t).map(|inside| (&inside.segment, inside.since(t)))
    }

    /// The segment after another one, unless the impact is over, or its segments lead no further.
    fn next_inside(&self, i: usize, impact: &PairImpact, last: &Inside) -> Option<Inside> {
        let over = |switch: Option<(usize, Switch)>| matches!(switch, Some((_, Switch::Release)));
        if over(last.segment.switch) || last.segment.end() >= impact.end() || last.segment.length <= 0.0 {
            return None;
        }
        let length = last.segment.length;
        let mut tallies = last.tallies;
        for (side, tally) in tallies.iter_mut().enumerate() {
            let ball = i + side;
            tally.add(&last.segment.tally(ball, &Tally::default(), &self.balls[ball], length));
        }
        let mut segment = last.segment.clone();
        segment.move_start(length, &self.balls, &self.cradle.contacts);
        segment.expand(&self.balls, &self.cradle.contacts, &self.control.taking(impact.duration));
        segment.forget_scratch();
        let impulse = last.impulse + last.segment.impulse(i, length);
        Some(Inside { segment, impulse, tallies, next: OnceCell::new() })
    }

    /// The balls of contact `i` as a cluster without spectators, from the onset of `impact` on, and what governs its segments.
    pub(super) fn alone(&self, i: usize, impact: &PairImpact) -> (Cluster, Control) {
        let members = i..i + 2;
        let flights = vec![self.balls[i].flight, self.balls[i + 1].flight];
        let contacts = vec![WindowContact { overlap: 0.0, mode: Mode::Pressing }];
        let mut cluster = Cluster::new(members.clone(), members, impact.start, flights, contacts, Pace::default());
        let control = self.control.taking(impact.duration);
        cluster.expand(&self.balls, &self.cradle.contacts, &control);
        (cluster, control)
    }

    /// Largest force of the impact under way in contact `i` between two times, N. Without losses the force falls as it has risen, so
    /// that it is largest half way.
    pub(super) fn impact_peak(&self, i: usize, from: DoubleDouble, to: DoubleDouble) -> f64 {
        let Some(impact) = &self.contacts[i].impact else { return 0.0 };
        let (from, to) = ((from - impact.start).value().max(0.0), (to - impact.start).value().min(impact.duration));
        let top = 0.5 * impact.duration;
        if from > to {
            return 0.0;
        }
        if from <= top && top <= to {
            return impact.peak;
        }
        let nearest = impact.start + if to < top { to } else { from };
        self.inside_at(i, nearest).map_or(0.0, |(segment, tau)| {
            let (overlap, rate) = segment.overlap(i, tau);
            self.cradle.contacts[i].force(overlap, rate)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Unrecorded;
    use crate::model::{Inputs, Parameters};

    /// Segments computed so far.
    fn segments(engine: &Engine) -> usize {
        let mut inside = engine.contacts[0].impact.as_ref().and_then(|impact| impact.inside.0.get());
        let mut count = 0;
        while let Some(segment) = inside {
            count += 1;
            inside = segment.next.get().and_then(Option::as_ref);
        }
        count
    }

    #[test]
    fn an_impact_too_slow_for_its_square_still_moves() {
        for (speed, exponent) in [(1e-165, 1.0), (1e-165, 10.0), (1e-250, 1.5)] {
            let p = Parameters {
                gravity: 0.0,
                exponent,
                dead_band: 0.0,
                x_start: vec![0.0; 2],
                v_start: vec![speed, 0.0],
                ..Parameters::default_for(2)
            };
            let mut engine = Engine::new(&p, &Inputs::zero(2), 0.0).unwrap();
            engine.advance(1e-3, &mut Unrecorded).unwrap();
            let moved = (engine.x(0) + engine.x(1)) / (speed * 1e-3);
            assert!((moved - 1.0).abs() < 1e-12, "{speed} {exponent}: {moved}");
            assert!(engine.force(0).is_finite() && engine.next_onset().time > 1e-3);
        }
    }

    #[test]
    fn an_impact_of_any_duration_has_as_many_segments() {
        let counts = [1.0, 1e-8, 1e-20, 1e-30].map(|speed| {
            let p = Parameters {
                gravity: 0.0,
                exponent: 10.0,
                dead_band: 0.0,
                x_start: vec![0.0; 2],
                v_start: vec![speed, 0.0],
                ..Parameters::default_for(2)
            };
            let mut engine = Engine::new(&p, &Inputs::zero(2), 0.0).unwrap();
            let duration = {
                engine.advance(1e-12, &mut Unrecorded).unwrap();
                engine.contacts[0].impact.as_ref().unwrap().duration
            };
            // Only what is asked for is computed.
            engine.x(0);
            assert_eq!(segments(&engine), 1);
            engine.advance(0.5 * duration, &mut Unrecorded).unwrap();
            let energy = 0.25 * speed * speed;
            assert!((engine.contact_energy(0) / energy - 1.0).abs() < 1e-12, "{speed}");
            assert!((engine.x(0) + engine.x(1)) / (0.5 * speed * duration) - 1.0 < 1e-12);
            segments(&engine)
        });
        assert!(counts.iter().all(|count| count.abs_diff(counts[0]) <= 2) && counts[0] < 500, "{counts:?}");
    }
}
