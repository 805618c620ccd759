//! The motion of a window whose contacts are linear springs and dashpots, in closed form: each group of balls joined by
//! pressing contacts, or single ball, by its natural modes. See "Natural modes" in docs/theory.md.

use std::cell::Cell;

use super::natural::Group;
use super::window::{DenseOutput, OverlapSeries, Switch, Window, sign_after_clip};
use crate::engine::flight::{Forcing, ROUNDINGS, Rounding};
use crate::engine::{Forecast, Peak};
use crate::solver::{ForcedOscillator, Smooth, root::search_within, series::of_derivatives};

/// Most evaluations of modes in a search for switchings, some milliseconds of work, and the least for one contact. The
/// next segment continues the search.
const SEARCH: usize = 40_000;
const LEAST_EVALUATIONS: usize = 200;

/// Relative rounding of the derivatives of an overlap, which guide a search; that of the overlap itself is
/// [`ROUNDINGS`].
const ROUNDING_OF_DERIVATIVES: f64 = 16.0 * ROUNDINGS;

/// A maximum of a force is higher than another one if it exceeds it by more than this part.
const RELATIVE_HEIGHT: f64 = 1e-12;

/// Steps of Newton's method from an end of an interval to a maximum beside it.
const TOP_STEPS: usize = 2;

/// Radians of the fastest mode that one step of a search covers at most.
const SWINGS_OF_A_LOOK: f64 = 4.0;

#[derive(Clone, Debug, Default)]
pub(crate) struct Modes {
    groups: Vec<Group>,
    group_of: Vec<usize>,
    contacts: Vec<Joint>,
    /// Highest rate of any mode, 1/s.
    fastest_rate: f64,
    /// Evaluations of a mode that the search for switchings has taken so far.
    searched: Cell<u64>,
}

#[derive(Clone, Debug)]
struct Joint {
    /// Overlap at the start, m, and its rate there, m/s.
    overlap: f64,
    rate: f64,
    /// Stiffness, N/m, and damping, N.s/m: what its law multiplies the overlap and its rate by.
    law: [f64; 2],
    /// Mechanical impedance, N.s/m.
    impedance: f64,
    /// Between two groups of equal pendulums: the approach of their centres, as one motion, because two groups that
    /// swing together differ by far less than they swing.
    approach: Option<ForcedOscillator>,
}

impl Modes {
    /// The motion from the state at the start of a segment, of a window for which `series_before_modes` allows modes;
    /// `None` if balls or contacts differ too much.
    pub fn new(window: &Window) -> Option<Self> {
        let Window { flights, contacts, laws, .. } = window;
        let mut modes = Self::default();
        let mut first = 0;
        for i in 0..flights.len() {
            modes.group_of.push(modes.groups.len());
            if !window.presses(i) {
                modes.groups.push(Group::new(first..i + 1, window)?);
                first = i + 1;
            }
        }
        let rate = |mode: &ForcedOscillator| mode.oscillator.omega().max(mode.oscillator.gamma());
        modes.fastest_rate = modes.groups.iter().flat_map(|group| &group.modes).map(rate).fold(0.0, f64::max);
        for (j, (contact, law)) in contacts.iter().zip(*laws).enumerate() {
            let approach = modes.approach(j, window);
            let (overlap, rate) = (contact.overlap, flights[j].v - flights[j + 1].v);
            let impedance = law.impedance(window.reduced_mass(j));
            let law = [law.stiffness, law.damping_coefficient()];
            modes.contacts.push(Joint { overlap, rate, law, impedance, approach });
        }
        Some(modes)
    }

    /// The approach of the centres of the two groups beside contact `j`, if their pendulums are equal.
    fn approach(&self, j: usize, window: &Window) -> Option<ForcedOscillator> {
        let Window { flights, contacts, laws, .. } = window;
        let (left, right) = (&self.groups[self.group_of[j]], &self.groups[self.group_of[j + 1]]);
        let oscillator = left.modes[0].oscillator;
        if std::ptr::eq(left, right) || oscillator != right.modes[0].oscillator {
            return None;
        }
        // The distance of the centres is a sum of distances of neighbours, weighted with mass shares.
        let (mut v, mut force) = (0.0, 0.0);
        for c in left.first..right.first + right.size - 1 {
            let share = match c {
                _ if c < j => left.share(left.first..c + 1),
                _ if c > j => right.share(c + 1..right.first + right.size),
                _ => 1.0,
            };
            let forcing = flights[c].forcing[0] - flights[c + 1].forcing[0];
            v += share * (flights[c].v - flights[c + 1].v);
            force += share * (forcing - oscillator.omega2() * (contacts[c].overlap + laws[c].clearance));
        }
        Some(ForcedOscillator::new(oscillator, v, force))
    }

    /// Overlap of contact `j` and its derivatives by time, up to four of them.
    fn overlap_at<const COUNT: usize>(&self, j: usize, tau: f64) -> [f64; COUNT] {
        // Early on, the sum of changes since the start, so that balls that hardly move do not get the rounding of the
        // others' motion; later, when most of the start has died out, the value itself.
        let start_has_decayed = tau * self.fastest_rate > 1.0;
        let mut sums = [0.0; COUNT];
        (sums[0], sums[1]) = (self.contacts[j].overlap, if start_has_decayed { 0.0 } else { self.contacts[j].rate });
        let mut magnitudes = sums.map(f64::abs);
        self.movers(j).for_each(|(mode, stretch)| {
            let (mut derivatives, change_of_rate) = mode.at(tau);
            if !start_has_decayed {
                derivatives[1] = change_of_rate;
            }
            for (k, derivative) in derivatives.iter().take(COUNT).enumerate() {
                sums[k] += stretch * derivative;
                magnitudes[k] += (stretch * derivative).abs();
            }
        });
        // 0 within rounding, so that no search follows it.
        std::array::from_fn(|k| {
            let rounding = if k == 0 { ROUNDINGS } else { ROUNDING_OF_DERIVATIVES } * magnitudes[k];
            if sums[k].abs() <= rounding { 0.0 } else { sums[k] }
        })
    }

    fn joining(&self, j: usize) -> Option<&Group> {
        (self.group_of[j] == self.group_of[j + 1]).then(|| &self.groups[self.group_of[j]])
    }

    /// The modes that move contact `j`, each with the change of overlap for a unit of its coordinate.
    fn movers(&self, j: usize) -> impl Iterator<Item = (&ForcedOscillator, f64)> {
        let (left, right) = (&self.groups[self.group_of[j]], &self.groups[self.group_of[j + 1]]);
        let joined = std::ptr::eq(left, right);
        let approach = self.contacts[j].approach.as_ref();
        let skipped = usize::from(joined || approach.is_some());
        let of_left = left.modes.iter().enumerate().skip(skipped).map(move |(m, mode)| match joined {
            true => (mode, left.stretch(m, j)),
            false => (mode, left.shape(m, j)),
        });
        let others = if joined { &[] } else { &right.modes[..] };
        let of_right = others.iter().enumerate().skip(skipped).map(move |(m, mode)| (mode, -right.shape(m, j + 1)));
        approach.into_iter().map(|mode| (mode, 1.0)).chain(of_left).chain(of_right)
    }

    /// Evaluations that one search about contact `j` may take.
    fn allowed(&self, j: usize) -> u32 {
        (SEARCH / (self.movers(j).count() * self.contacts.len())).max(LEAST_EVALUATIONS) as u32
    }

    /// Watches when `sign` times the overlap of contact `j` or, with its `law`, derivative `order` of its force exceeds
    /// a level.
    fn watch(&self, j: usize, law: Option<[f64; 2]>, order: usize, sign: f64, level: f64) -> Watch<'_> {
        Watch { modes: self, contact: j, law, order, sign, level, fading: 0.0 }
    }

    /// The shortest of the modes' time scales, s: 1 over the natural frequency, or the slow rate of an overdamped one.
    pub fn shortest_time(&self) -> f64 {
        let modes = self.groups.iter().flat_map(|group| &group.modes);
        modes.map(|mode| mode.oscillator.time_scale()).fold(f64::INFINITY, f64::min)
    }
}

impl DenseOutput for Modes {
    fn moved(&self, i: usize, tau: f64) -> (f64, f64) {
        let group = &self.groups[self.group_of[i]];
        let mut sum = (0.0, 0.0);
        for (m, mode) in group.modes.iter().enumerate() {
            let (shape, ([displacement, ..], change_of_rate)) = (group.shape(m, i), mode.at(tau));
            sum.0 += shape * displacement;
            sum.1 += shape * change_of_rate;
        }
        sum
    }

    fn displacement_integral(&self, i: usize, tau: f64) -> f64 {
        let group = &self.groups[self.group_of[i]];
        let term = |(m, mode): (usize, &ForcedOscillator)| group.shape(m, i) * mode.displacement_integral(tau);
        group.modes.iter().enumerate().map(term).sum()
    }

    fn overlap(&self, j: usize, tau: f64) -> (f64, f64) {
        let [overlap, rate] = self.overlap_at(j, tau);
        (overlap, rate - self.contacts[j].rate)
    }

    fn overlap_series(&self, j: usize, tau: f64) -> Option<OverlapSeries> {
        Some(of_derivatives(self.overlap_at(j, tau)))
    }

    fn impulse(&self, j: usize, tau: f64) -> f64 {
        let Joint { overlap, law: [stiffness, damping], .. } = self.contacts[j];
        let change: f64 = self.movers(j).map(|(mode, stretch)| stretch * mode.displacement_integral(tau)).sum();
        stiffness * (overlap * tau + change) + damping * (self.overlap(j, tau).0 - overlap)
    }

    /// Undamped modes come ever closer to the sum of their amplitudes, so the search ends after some dozens of swings.
    fn peak(&self, j: usize, from: f64, to: f64, known: f64) -> Option<Peak> {
        let law = self.contacts[j].law;
        let force_at = |t: f64| force(&self.overlap_at::<2>(j, t), law, 0).0;
        let mut peak = Peak { force: force_at(from), time: from };
        peak.raise(force_at(to), to);
        let mut best = peak.force.max(known);
        let mut t = from;
        // From where the force exceeds the best so far, by more than rounding, to where it falls again.
        let mut allowed = self.allowed(j);
        loop {
            let above = self.watch(j, Some(law), 0, 1.0, best + RELATIVE_HEIGHT * best.abs());
            let Forecast::At(rise) = search_within(&above, t, to, &mut allowed) else { break };
            let falling = self.watch(j, Some(law), 1, -1.0, 0.0);
            let Forecast::At(top) = search_within(&falling, rise, to, &mut allowed) else { break };
            let highest = force_at(top);
            peak.raise(highest, top);
            best = best.max(highest);
            t = top;
        }
        // Beside a maximum an end may be so near that the search sees no rise.
        for _ in 0..if [from, to].contains(&peak.time) { TOP_STEPS } else { 0 } {
            let overlap: [f64; 4] = self.overlap_at(j, peak.time);
            let [slope, curvature] = [1, 2].map(|k| force(&overlap, law, k).0);
            let step = -slope / curvature;
            let near = curvature < 0.0 && slope * step <= RELATIVE_HEIGHT * peak.force;
            if near {
                peak.time = (peak.time + step).clamp(from, to);
            }
        }
        Some(peak)
    }

    /// For constant inputs.
    fn work(&self, i: usize, forcing: &Forcing, tau: f64) -> f64 {
        forcing[0] * self.moved(i, tau).0
    }

    /// Enters the loss of all contacts of a group at its first one.
    fn contact_loss(&self, j: usize, tau: f64) -> f64 {
        match self.joining(j) {
            // The shapes are orthogonal with respect to the contacts, too, so modes share no loss.
            Some(group) if j == group.first && group.damping > 0.0 => {
                let modes = group.modes[1..].iter().zip(&group.lambda[1..]);
                modes.map(|(mode, lambda)| group.damping * lambda * mode.squared_velocity_integral(tau)).sum()
            }
            _ => 0.0,
        }
    }

    /// Enters the integral of a whole group at its first ball.
    fn squared_velocity_integral(&self, i: usize, tau: f64) -> f64 {
        let group = &self.groups[self.group_of[i]];
        if i != group.first {
            return 0.0;
        }
        group.modes.iter().map(|mode| mode.squared_velocity_integral(tau)).sum()
    }

    fn first(&self, switch: Switch, j: usize, window: &Window, until: f64, rounding: &Rounding) -> Forecast {
        let Joint { overlap, rate, law, impedance, .. } = self.contacts[j];
        let watch = match switch {
            // In touch and closing, it closes at once, not only where the overlap exceeds its rounding.
            Switch::Onset if overlap == 0.0 && rate > rounding.velocity => return Forecast::At(0.0),
            Switch::Onset => self.watch(j, None, 0, 1.0, rounding.position),
            // At rest and hardly overlapping, it opens only where its balls part by more than rounding.
            Switch::Release if overlap <= rounding.no_overlap() && rounding.is_rest(overlap, rate) => {
                self.watch(j, None, 0, -1.0, -rounding.position)
            }
            Switch::Release => self.watch(j, None, 0, -1.0, rounding.no_overlap()),
            Switch::Clip => {
                let sign = sign_after_clip(window.contacts[j].mode);
                let level = sign * impedance * rounding.velocity;
                // The rounding of the rate at the start dies out with the motion; the overlap has none.
                let fading = self.joining(j).map_or(0.0, Group::least_decay);
                Watch { fading, ..self.watch(j, Some(law), 0, sign, level) }
            }
        };
        watch.crossing(until)
    }

    fn searched(&self) -> u64 {
        self.searched.get()
    }
}

/// Derivative `k` of the force by a linear law, from the derivatives of the overlap, and its rounding.
#[inline]
fn force(overlap: &[f64], [stiffness, damping]: [f64; 2], k: usize) -> (f64, f64) {
    let (elastic, damped) = (stiffness * overlap[k], damping * overlap[k + 1]);
    let rounding = ROUNDINGS * (elastic.abs() + damped.abs());
    (if (elastic + damped).abs() <= rounding { 0.0 } else { elastic + damped }, rounding)
}

/// `sign (f - level exp(-fading t))`, where f is the overlap of a contact or, with its `law`, derivative `order` of its
/// [`force`]. If the level fades, less the rounding of f, which has no derivatives.
struct Watch<'a> {
    modes: &'a Modes,
    contact: usize,
    law: Option<[f64; 2]>,
    order: usize,
    sign: f64,
    level: f64,
    fading: f64,
}

impl Watch<'_> {
    /// When it becomes positive before `until` (s); counts the evaluations.
    fn crossing(&self, until: f64) -> Forecast {
        let most = self.modes.allowed(self.contact);
        let mut allowed = most;
        let found = search_within(self, 0.0, until, &mut allowed);
        let taken = u64::from(most - allowed) * self.modes.movers(self.contact).count() as u64;
        self.modes.searched.set(self.modes.searched.get() + taken);
        match found {
            Forecast::At(tau) | Forecast::NotBefore(tau) if tau < until => found,
            _ => Forecast::Never,
        }
    }

    fn level_at(&self, t: f64) -> f64 {
        if self.fading == 0.0 { self.level } else { self.level * libm::exp(-self.fading * t) }
    }
}

impl Smooth for Watch<'_> {
    fn at(&self, t: f64) -> [f64; 3] {
        let ([value, slope, curvature], rounding) = match self.law {
            None => (self.modes.overlap_at(self.contact, t), 0.0),
            Some(law) => {
                let overlap: [f64; 5] = self.modes.overlap_at(self.contact, t);
                let [(value, rounding), (slope, _), (curvature, _)] =
                    [0, 1, 2].map(|k| force(&overlap, law, self.order + k));
                ([value, slope, curvature], rounding)
            }
        };
        // The level fades no further than to this rounding.
        let rounding = if self.fading > 0.0 { rounding } else { 0.0 };
        let level = self.level_at(t);
        let fall = level * self.fading;
        let value = self.sign * (value - level) - rounding;
        [value, self.sign * (slope + fall), self.sign * (curvature - fall * self.fading)]
    }

    fn time_scale(&self) -> f64 {
        SWINGS_OF_A_LOOK / self.modes.fastest_rate
    }

    fn third_derivative_bound(&self, t: f64, _span: f64) -> f64 {
        let (order, [by_overlap, by_rate]) = (3 + self.order as i32, self.law.unwrap_or([1.0, 0.0]));
        let bound = |(mode, stretch): (&ForcedOscillator, f64)| {
            stretch.abs() * mode.derivative_bound(t, order, by_overlap, by_rate)
        };
        let of_level = self.level_at(t).abs() * self.fading * self.fading * self.fading;
        self.modes.movers(self.contact).map(bound).sum::<f64>() + of_level
    }
}
