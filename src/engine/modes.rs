//! The motion of a window whose contacts are linear springs and dashpots, in closed form: by natural modes.
//!
//! Balls joined by pressing contacts are groups; a ball that presses on none is a group of its own. A group of equal balls with
//! equal contacts is a uniform chain, whose natural modes are known (`natural`).
//!
//! Each coordinate is an oscillator in closed form, so strong damping and contacts that stay closed for minutes cost nothing: the
//! only work is to find the next switching.

use super::ball::{Flight, Rounding, degree};
use super::natural::{Group, NaturalMode, Sum, dashpot};
use super::window::{Mode, Switch, Switching, Window};
use crate::model::{ContactLaw, Damping};
use crate::solver::root::{Search, Smooth, first_positive, search};

/// Largest group that is taken apart into modes: the table of their shapes grows with the square.
const LARGEST_GROUP: usize = 32;

/// The motion of a window by natural modes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Modes {
    groups: Vec<Group>,
    /// The group of each ball.
    group_of: Vec<usize>,
    contacts: Vec<Joint>,
    /// Highest rate of any mode, 1/s.
    pace: f64,
}

/// A contact of the window.
#[derive(Clone, Debug)]
struct Joint {
    /// Overlap at the start, m, and its rate there, m/s.
    overlap: f64,
    rate: f64,
    /// Stiffness, N/m, and damping, N.s/m.
    stiffness: f64,
    damping: f64,
    /// Between two groups of equal pendulums: how their centres approach each other. Taken as one motion, for two groups
    /// that swing together differ by far less than they swing.
    approach: Option<NaturalMode>,
}

/// Whether the closed contacts of a window are linear and join equal balls under constant inputs.
pub(crate) fn apply_to(window: &Window) -> bool {
    let Window { flights, balls, contacts, laws } = window;
    let mut joined = 1;
    for (j, (contact, law)) in contacts.iter().zip(*laws).enumerate() {
        if contact.mode == Mode::Open {
            joined = 1;
            continue;
        }
        let linear = law.exponent == 1.0 && !matches!(law.damping, Damping::HuntCrossley { .. });
        let (left, right) = (&balls[j], &balls[j + 1]);
        let equal = left.mass == right.mass && left.oscillator == right.oscillator;
        let same_as_before = joined == 1 || law.stiffness == laws[j - 1].stiffness;
        joined += 1;
        if !(linear && equal && same_as_before) || joined > LARGEST_GROUP {
            return false;
        }
    }
    flights.iter().all(|flight| degree(&flight.push) == 0)
}

impl Modes {
    /// The motion from the state at the start of a segment, which [`apply_to`] allows.
    pub fn new(window: &Window) -> Self {
        let Window { flights, contacts, laws, .. } = window;
        let mut modes = Self::default();
        let mut first = 0;
        for i in 0..flights.len() {
            let joined = contacts.get(i).is_some_and(|contact| contact.mode == Mode::Pressing);
            modes.group_of.push(modes.groups.len());
            if !joined {
                modes.groups.push(Group::new(first..i + 1, window));
                first = i + 1;
            }
        }
        let rate = |mode: &NaturalMode| mode.oscillator.omega().max(mode.oscillator.gamma());
        modes.pace = modes.groups.iter().flat_map(|group| &group.modes).map(rate).fold(0.0, f64::max);
        for (j, (contact, law)) in contacts.iter().zip(*laws).enumerate() {
            let approach = modes.approach(j, window);
            let (stiffness, damping) = (law.stiffness, dashpot(law));
            let (overlap, rate) = (contact.overlap, flights[j].v - flights[j + 1].v);
            modes.contacts.push(Joint { overlap, rate, stiffness, damping, approach });
        }
        modes
    }

    /// How the centres of the two groups beside contact `j` approach each other, if their pendulums are equal.
    fn approach(&self, j: usize, window: &Window) -> Option<NaturalMode> {
        let Window { flights, contacts, laws, .. } = window;
        let (left, right) = (&self.groups[self.group_of[j]], &self.groups[self.group_of[j + 1]]);
        let oscillator = left.modes[0].oscillator;
        if std::ptr::eq(left, right) || oscillator != right.modes[0].oscillator {
            return None;
        }
        // The centres are as far apart as the balls between them are, each by its share.
        let mut flight = Flight::default();
        for c in left.first..right.first + right.size - 1 {
            let share = match c {
                _ if c < j => (c + 1 - left.first) as f64 / left.size as f64,
                _ if c > j => (right.first + right.size - 1 - c) as f64 / right.size as f64,
                _ => 1.0,
            };
            let push = flights[c].push[0] - flights[c + 1].push[0];
            flight.v += share * (flights[c].v - flights[c + 1].v);
            flight.push[0] += share * (push - oscillator.omega2() * (contacts[c].overlap + laws[c].clearance));
        }
        Some(NaturalMode { oscillator, flight, lambda: 0.0 })
    }

    /// Overlap of contact `j` and its first four derivatives.
    fn overlap_at(&self, j: usize, tau: f64) -> [f64; 5] {
        // Early on, changes since the start; once they have undone most of the start, what is left.
        let late = tau * self.pace > 1.0;
        let mut sum = Sum::new(self.contacts[j].overlap, if late { 0.0 } else { self.contacts[j].rate });
        for (mode, stretch) in self.movers(j) {
            let mut course = mode.at(tau);
            if !late {
                course.derivatives[1] = course.change_of_rate;
            }
            sum.add(stretch, &course.derivatives);
        }
        sum.without_noise()
    }

    /// The group that contact `j` joins.
    fn joining(&self, j: usize) -> Option<&Group> {
        (self.group_of[j] == self.group_of[j + 1]).then(|| &self.groups[self.group_of[j]])
    }

    /// The modes that move contact `j`, each with the change of overlap that a unit of its coordinate makes.
    fn movers(&self, j: usize) -> impl Iterator<Item = (&NaturalMode, f64)> {
        let (left, right) = (&self.groups[self.group_of[j]], &self.groups[self.group_of[j + 1]]);
        let joined = std::ptr::eq(left, right);
        let approach = self.contacts[j].approach.as_ref();
        let skipped = usize::from(joined || approach.is_some());
        let of_left = left.modes.iter().zip(left.shapes.chunks_exact(left.size)).skip(skipped);
        let of_left = of_left.map(move |(mode, shape)| match joined {
            true => (mode, left.stretch(shape, j)),
            false => (mode, shape[j - left.first]),
        });
        let others = if joined { 0 } else { right.modes.len() };
        let of_right = right.modes.iter().zip(right.shapes.chunks_exact(right.size)).take(others).skip(skipped);
        let of_right = of_right.map(move |(mode, shape)| (mode, -shape[j + 1 - right.first]));
        approach.into_iter().map(|mode| (mode, 1.0)).chain(of_left).chain(of_right)
    }

    /// Displacement of ball `i` (m) and the change of its velocity (m/s) till `tau` (s).
    pub fn moved(&self, i: usize, tau: f64) -> (f64, f64) {
        let group = &self.groups[self.group_of[i]];
        let shapes = group.shapes.chunks_exact(group.size).map(|shape| shape[i - group.first]);
        let term = |(mode, shape): (&NaturalMode, f64)| {
            let course = mode.at(tau);
            (shape * course.derivatives[0].0, shape * course.change_of_rate.0)
        };
        group.modes.iter().zip(shapes).map(term).fold((0.0, 0.0), |sum, term| (sum.0 + term.0, sum.1 + term.1))
    }

    /// Integral of that displacement, m.s.
    pub fn displacement_integral(&self, i: usize, tau: f64) -> f64 {
        let group = &self.groups[self.group_of[i]];
        let term = |(mode, shape): (&NaturalMode, &[f64])| {
            let u: [f64; 4] = mode.oscillator.basis(tau.into());
            shape[i - group.first] * mode.flight.displacement_integral(&mode.oscillator, &u)
        };
        group.modes.iter().zip(group.shapes.chunks_exact(group.size)).map(term).sum()
    }

    /// Overlap of contact `j` (m) at `tau` (s) and the change of its rate (m/s) till then.
    pub fn overlap(&self, j: usize, tau: f64) -> (f64, f64) {
        let [overlap, rate, ..] = self.overlap_at(j, tau);
        (overlap, rate - self.contacts[j].rate)
    }

    /// Impulse of the pressing contact `j`, N.s.
    pub fn impulse(&self, j: usize, tau: f64) -> f64 {
        let &Joint { overlap, stiffness, damping, .. } = &self.contacts[j];
        let change: f64 = self
            .movers(j)
            .map(|(mode, stretch)| {
                let u: [f64; 4] = mode.oscillator.basis(tau.into());
                stretch * mode.flight.displacement_integral(&mode.oscillator, &u)
            })
            .sum();
        stiffness * (overlap * tau + change) + damping * (self.overlap(j, tau).0 - overlap)
    }

    /// The larger of `known` and the largest force of the pressing contact `j` between two times (s), N.
    pub fn peak(&self, j: usize, from: f64, to: f64, known: f64) -> f64 {
        let force = |t: f64| self.force_at(j, t)[0];
        let mut best = force(from).max(force(to)).max(known);
        let mut t = from;
        // From where the force passes the best so far, by more than rounding, up to where it falls again.
        for _ in 0..1000 {
            let above =
                Watch { modes: self, contact: j, kind: Watched::Force, sign: 1.0, level: best + 1e-12 * best.abs() };
            let Some(rise) = first_positive(&above, t, to) else { break };
            let falling = Watch { modes: self, contact: j, kind: Watched::ForceRate, sign: -1.0, level: 0.0 };
            let Some(top) = first_positive(&falling, rise, to) else { break };
            best = best.max(force(top));
            t = top;
        }
        best
    }

    /// Force of the pressing contact `j` by its law and its first three derivatives.
    fn force_at(&self, j: usize, tau: f64) -> [f64; 4] {
        let &Joint { stiffness, damping, .. } = &self.contacts[j];
        let d = self.overlap_at(j, tau);
        std::array::from_fn(|k| {
            let (elastic, damped) = (stiffness * d[k], damping * d[k + 1]);
            let force = elastic + damped;
            if force.abs() <= 8.0 * f64::EPSILON * (elastic.abs() + damped.abs()) { 0.0 } else { force }
        })
    }

    /// Energy that the pressing contact `j` dissipates in `tau`, J; all that a group's contacts lose is entered at its first one.
    pub fn contact_loss(&self, j: usize, tau: f64) -> f64 {
        match self.joining(j) {
            // The shapes are orthogonal also to the contacts: no loss is shared between modes.
            Some(group) if j == group.first && group.damping > 0.0 => {
                let loss = |mode: &NaturalMode| group.damping * mode.lambda * mode.squared_velocity_integral(tau);
                group.modes[1..].iter().map(loss).sum()
            }
            _ => 0.0,
        }
    }

    /// Sum of `integral v^2` over the balls of a group, entered at its first ball `i`, m2/s.
    pub fn squared_velocity_integral(&self, i: usize, tau: f64) -> f64 {
        let group = &self.groups[self.group_of[i]];
        if i != group.first {
            return 0.0;
        }
        group.modes.iter().map(|mode| mode.squared_velocity_integral(tau)).sum()
    }

    /// The crossing of a function of contact `j`, signed, above `level` before `until` (s).
    fn crossing(
        &self,
        j: usize,
        kind: Watched,
        (sign, level): (f64, f64),
        until: f64,
        switch: Switch,
    ) -> Option<Switching> {
        let watch = Watch { modes: self, contact: j, kind, sign, level };
        match search(&watch, 0.0, until) {
            Search::At(tau) if tau < until => Some((tau, Some(switch))),
            Search::NotBefore(tau) if tau < until => Some((tau, None)),
            _ => None,
        }
    }

    /// The onset of the open contact `j` before `until` (s). Groups that swing side by side approach each other by rounding: that
    /// is no onset.
    pub fn onset(&self, j: usize, until: f64, rounding: &Rounding) -> Option<Switching> {
        self.crossing(j, Watched::Overlap, (1.0, rounding.position), until, Switch::Onset)
    }

    /// The release of the closed contact `j` before `until` (s).
    pub fn release(&self, j: usize, until: f64, rounding: &Rounding) -> Option<Switching> {
        self.crossing(j, Watched::Overlap, (-1.0, rounding.no_overlap()), until, Switch::Release)
    }

    /// The beginning or, in mode `Clipped`, the end of the clipping of contact `j` before `until` (s), by more than `rounding`.
    pub fn clip(&self, j: usize, law: &ContactLaw, mode: Mode, until: f64, rounding: &Rounding) -> Option<Switching> {
        let (sign, switch) = mode.clipping();
        self.crossing(j, Watched::Force, (sign, sign * rounding.force(law)), until, switch)
    }

    /// Highest natural frequency, rad/s.
    pub fn highest_frequency(&self) -> f64 {
        let modes = self.groups.iter().flat_map(|group| &group.modes);
        modes.map(|mode| mode.oscillator.omega()).fold(0.0, f64::max)
    }
}

/// Which function of a contact is watched.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Watched {
    Overlap,
    Force,
    ForceRate,
}

/// `sign (f - level)` for a function f of contact `contact`.
struct Watch<'a> {
    modes: &'a Modes,
    contact: usize,
    kind: Watched,
    sign: f64,
    level: f64,
}

/// The first three of some derivatives.
fn leading(d: &[f64]) -> [f64; 3] {
    [d[0], d[1], d[2]]
}

impl Smooth for Watch<'_> {
    fn at(&self, t: f64) -> [f64; 3] {
        let [value, slope, curvature] = match self.kind {
            Watched::Overlap => leading(&self.modes.overlap_at(self.contact, t)),
            Watched::Force => leading(&self.modes.force_at(self.contact, t)),
            Watched::ForceRate => leading(&self.modes.force_at(self.contact, t)[1..]),
        };
        [self.sign * (value - self.level), self.sign * slope, self.sign * curvature]
    }

    fn third_derivative_bound(&self, t: f64, _span: f64) -> f64 {
        let &Joint { stiffness, damping, .. } = &self.modes.contacts[self.contact];
        let bound = |(mode, stretch): (&NaturalMode, f64)| {
            let (o, start) = (&mode.oscillator, &mode.flight);
            let a = start.acceleration(o, 0.0, 0.0, start.v);
            let order = |k| o.derivative_bound(start.v, a, t, k);
            stretch.abs()
                * match self.kind {
                    Watched::Overlap => order(3),
                    Watched::Force => stiffness * order(3) + damping * order(4),
                    Watched::ForceRate => stiffness * order(4) + damping * order(5),
                }
        };
        self.modes.movers(self.contact).map(bound).sum()
    }
}
