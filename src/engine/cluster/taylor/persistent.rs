//! The coefficients for balls that have been pressed together for long: series of a higher order, with less arithmetic.
//!
//! While all balls move, no series has gaps, and the last terms alone tell how far it converges. Powers are squared and multiplied
//! where the exponent is whole, nothing is divided that can be multiplied, and sums of products are taken four at a time. All this
//! gives other bits than `recurrences`, which impacts are followed by.

use super::recurrences::{TERMS_AT_LEAST, negligible_overlap, unit_of_time, velocity_scale_by};
use super::series::{INVERSE_FACTORIAL, Series};
use crate::engine::cluster::step_control::Control;
use crate::engine::cluster::window::Window;
use crate::engine::flight::Ball;
use crate::model::ContactLaw;
use crate::solver::series::{LANES, sum_of_products};

/// Order of the series of the velocities, a multiple of the terms that are summed side by side.
const ORDER: usize = 28;

/// Rows that the largest whole exponent takes, 10: two for each binary digit but the first.
const MOST_ROWS: usize = 6;

/// The first coefficients of a series, with zeros behind them, and the same backwards: `backward[ORDER - i]` is `forward[i]`.
#[derive(Clone, Copy, Debug)]
struct Row {
    forward: [f64; ORDER + LANES],
    backward: [f64; ORDER + LANES],
}

impl Row {
    const ZERO: Self = Self { forward: [0.0; ORDER + LANES], backward: [0.0; ORDER + LANES] };

    fn set(&mut self, k: usize, c: f64) {
        (self.forward[k], self.backward[ORDER - k]) = (c, c);
    }

    /// Coefficient `k` of the product with `other`, from the coefficients before that one and these, which are not set yet: what is
    /// loaded with others right after it has been stored makes a processor wait.
    #[inline]
    fn times(&self, other: &Self, k: usize, [own, others]: [f64; 2]) -> f64 {
        if k == 0 {
            return own * others;
        }
        let before = sum_of_products(k, |i| self.forward[i], &other.backward[ORDER - k..]);
        before + (own * other.forward[0] + self.forward[0] * others)
    }
}

/// The forces of a contact as they are expanded.
#[derive(Clone, Debug)]
pub(super) struct Force {
    /// Overlap over `overlap_ref`.
    ratio: Row,
    /// What leads to its power, the last one of them; of an exponent that is not whole the power itself and the derivative of the
    /// overlap, multiplied by the exponent plus 1.
    powers: Vec<Row>,
    /// The exponent, if it is whole.
    whole: Option<usize>,
    elastic: Row,
    rate: Row,
    /// Inverses of `overlap_ref` and of the ratio at the start.
    inverses: [f64; 2],
    /// An overlap (m) and the elastic force there (N): the end of a segment is mostly the start of the next one.
    known: [f64; 2],
}

impl Default for Force {
    fn default() -> Self {
        Self {
            ratio: Row::ZERO,
            powers: Vec::new(),
            whole: None,
            elastic: Row::ZERO,
            rate: Row::ZERO,
            inverses: [0.0; 2],
            known: [0.0; 2],
        }
    }
}

impl Force {
    fn begin(&mut self, law: &ContactLaw, overlap: f64) {
        self.whole = law.whole_exponent();
        let rows = self.whole.map_or(2, |p| 2 * p.ilog2() as usize);
        self.powers.clear();
        self.powers.resize(rows, Row::ZERO);
        (self.ratio, self.elastic, self.rate) = (Row::ZERO, Row::ZERO, Row::ZERO);
        self.inverses = [1.0 / law.overlap_ref, law.overlap_ref / overlap];
    }

    /// Elastic force at `overlap` (m), N.
    pub(super) fn elastic_at(&mut self, law: &ContactLaw, overlap: f64) -> f64 {
        if self.known[0] != overlap {
            self.known = [overlap, law.elastic_force(overlap)];
        }
        self.known[1]
    }

    /// The same without overlap: the formula of the law where it goes on, else zero.
    fn elastic_continued(&mut self, law: &ContactLaw, overlap: f64) -> f64 {
        match overlap > 0.0 {
            true => self.elastic_at(law, overlap),
            false => law.elastic_continued(overlap).map_or(0.0, |(force, _)| force),
        }
    }

    /// Coefficient `k` of `(overlap / overlap_ref)^p`, where that of the ratio is `term`.
    fn power(&mut self, law: &ContactLaw, k: usize, term: f64) -> f64 {
        let power = match self.whole {
            Some(p) => self.whole_power(p, k, term),
            None => self.real_power(law, k, term),
        };
        self.ratio.set(k, term);
        power
    }

    /// By the binary digits of the exponent `p` from the second one on, each a square and, if it is 1, a product.
    fn whole_power(&mut self, p: usize, k: usize, term: f64) -> f64 {
        let (mut terms, mut rows) = ([0.0; MOST_ROWS], 0);
        let (mut base, mut last) = (&self.ratio, term);
        for digit in (0..p.ilog2()).rev() {
            for by_ratio in [false, true].into_iter().take(1 + (p >> digit & 1)) {
                let (factor, of_factor) = if by_ratio { (&self.ratio, term) } else { (base, last) };
                last = base.times(factor, k, [last, of_factor]);
                base = &self.powers[rows];
                terms[rows] = last;
                rows += 1;
            }
        }
        self.powers.iter_mut().zip(terms).for_each(|(row, term)| row.set(k, term));
        last
    }

    /// Miller's recursion, see [`power_term`](crate::solver::series::power_term).
    fn real_power(&mut self, law: &ContactLaw, k: usize, term: f64) -> f64 {
        let [power, weighted] = &mut self.powers[..] else { return f64::NAN };
        let (ratio, order, [_, start]) = (&self.ratio.forward, k as f64, self.known);
        let weight = (law.exponent + 1.0) * order * term;
        let of_power = if k == 0 {
            start / (law.stiffness * law.overlap_ref)
        } else {
            let factor = |i: usize| weighted.forward[i] - order * ratio[i];
            let before = sum_of_products(k, factor, &power.backward[ORDER - k..]);
            (before + (weight - order * term) * power.forward[0]) * (self.inverses[1] * INVERSE[k])
        };
        weighted.set(k, weight);
        power.set(k, of_power);
        of_power
    }
}

/// What a ball brings into the equations.
struct Coefficients {
    inverse_mass: f64,
    omega2: f64,
    /// Twice the decay rate, 1/s.
    drag: f64,
    /// Whether its left neighbour has the same pendulum.
    alike: bool,
}

impl Coefficients {
    fn new(ball: &Ball, alike: bool) -> Self {
        let o = &ball.oscillator;
        Self { inverse_mass: 1.0 / ball.mass, omega2: o.omega2(), drag: 2.0 * o.gamma(), alike }
    }
}

/// `1 / k`.
const INVERSE: [f64; ORDER + 3] = {
    let (mut inverse, mut k) = ([0.0; ORDER + 3], 1);
    while k < inverse.len() {
        inverse[k] = 1.0 / k as f64;
        k += 1;
    }
    inverse
};

/// What an expansion needs beside the series: the forces of the contacts, of which only memory and known values are kept.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    forces: Vec<Force>,
    /// A contact each: the overlap up to which its elastic force is left out, m; 0 if it is not.
    negligible: Vec<f64>,
}

impl Workspace {
    /// Scale of the velocities like [`velocity_scale`](super::recurrences::velocity_scale), before [`Series::expand_persistent`].
    pub fn velocity_scale(&mut self, window: &Window) -> f64 {
        self.forces.resize(window.contacts.len(), Force::default());
        velocity_scale_by(window, |j| {
            let (law, overlap) = (&window.laws[j], window.contacts[j].overlap);
            self.forces[j].elastic_at(law, overlap) * overlap / (law.exponent + 1.0)
        })
    }
}

impl Series {
    /// Computes all coefficients like [`Self::expand`], after a segment that converged for `before` (s; 0 if that is not known).
    pub fn expand_persistent(
        &mut self,
        workspace: &mut Workspace,
        window: &Window,
        control: &Control,
        scale: f64,
        before: f64,
    ) {
        let Window { flights, contacts, laws, .. } = window;
        let Workspace { forces, negligible } = workspace;
        negligible.clear();
        negligible.resize(contacts.len(), 0.0);
        let dv = control.epsilon * scale;
        for (j, force) in forces.iter_mut().enumerate() {
            let (law, overlap, change) = (&laws[j], contacts[j].overlap, window.reduced_mass(j) * dv);
            let (elastic, rate) = (force.elastic_at(law, overlap), flights[j].v - flights[j + 1].v);
            // Most overlaps are so large that no power has to be taken to see it.
            if elastic * before < change || elastic * overlap < change * rate.abs() {
                negligible[j] = negligible_overlap(j, window, dv, scale);
            }
            force.begin(law, overlap);
        }
        let unit = if before > 0.0 { before } else { unit_of_time(window, scale, |j| negligible[j] > 0.0) };
        self.begin(window, ORDER, unit);
        let balls = window.balls;
        let alike = |j: usize| j > 0 && balls[j - 1].oscillator == balls[j].oscillator;
        let coefficients: Vec<Coefficients> =
            (0..balls.len()).map(|j| Coefficients::new(&balls[j], alike(j))).collect();
        for k in 0..ORDER {
            for (j, force) in forces.iter_mut().enumerate() {
                if window.needs_force(j) {
                    self.expand_persistent_force(j, &laws[j], force, negligible[j] > 0.0, k);
                }
            }
            self.expand_persistent_motion(window, &coefficients, k);
        }
        self.end_where_wrong(negligible, window, control, scale, TERMS_AT_LEAST, |j, overlap| {
            Some(forces[j].elastic_continued(&laws[j], overlap))
        });
    }

    /// Coefficient `k` of the forces of contact `j`; without the elastic force if that is `negligible`.
    fn expand_persistent_force(&mut self, j: usize, law: &ContactLaw, force: &mut Force, negligible: bool, k: usize) {
        let first = j * self.stride();
        let at = first + k;
        for k in if negligible { 0..0 } else { law.elastic_terms_due(k) } {
            let ratio = self.overlaps[first + k] * force.inverses[0];
            self.elastic[first + k] = law.stiffness * law.overlap_ref * force.power(law, k, ratio);
        }
        let by_time = |c: f64| (k + 1) as f64 * c / self.unit;
        let (elastic, rate) = (self.elastic[at], by_time(self.overlaps[at + 1]));
        let product = || {
            let product = force.elastic.times(&force.rate, k, [elastic, rate]);
            force.elastic.set(k, elastic);
            force.rate.set(k, rate);
            product
        };
        self.forces[at] = law.force_coefficient(elastic, rate, product, || by_time(self.elastic[at + 1]));
    }

    /// Coefficient `k` of the accelerations, hence `k + 2` of the displacements and overlaps.
    fn expand_persistent_motion(&mut self, window: &Window, coefficients: &[Coefficients], k: usize) {
        let Window { flights, contacts, laws, .. } = window;
        let (stride, next) = (self.stride(), (k + 1) as f64);
        let by_position = self.unit * self.unit * INVERSE[k + 1] * INVERSE[k + 2];
        let by_rate = next * by_position / self.unit;
        let input = match INVERSE_FACTORIAL.get(k) {
            Some(inverse) => (0..k).fold(*inverse, |product, _| product * self.unit),
            None => 0.0,
        };
        let (mut from_left, mut driven_left) = (0.0, 0.0);
        for (j, (flight, ball)) in flights.iter().zip(coefficients).enumerate() {
            let from_right = if window.presses(j) { self.forces[j * stride + k] } else { 0.0 };
            let mut driven = (from_left - from_right) * ball.inverse_mass;
            if input != 0.0 {
                driven += input * flight.forcing[k];
            }
            let term = |driven: f64, position: f64, of_rate: f64| {
                (driven - ball.omega2 * position) * by_position - ball.drag * of_rate * by_rate
            };
            let at = j * stride + k;
            let position = if k == 0 { flight.x } else { self.displacements[at] };
            self.displacements[at + 2] = term(driven, position, self.displacements[at + 1]);
            if let Some(i) = j.checked_sub(1) {
                let at = i * stride + k;
                self.overlaps[at + 2] = if ball.alike {
                    // As in `expand_motion`.
                    let apart = if k == 0 { contacts[i].overlap + laws[i].clearance } else { self.overlaps[at] };
                    term(driven_left - driven, apart, self.overlaps[at + 1])
                } else {
                    self.displacements[at + 2] - self.displacements[at + 2 + stride]
                };
            }
            (from_left, driven_left) = (from_right, driven);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::cluster::dense_output::DenseOutput;
    use crate::engine::cluster::taylor::recurrences::{self, velocity_scale};
    use crate::engine::cluster::window::WindowContact;
    use crate::engine::flight::Flight;
    use crate::model::{BallModel, Damping, Mode};
    use crate::solver::double_double::DoubleDouble;

    /// Both expansions of four balls, the last one beside the others, and how long both converge.
    fn expanded(exponent: f64, damping: Damping, omega2: [f64; 4]) -> (Series, Series, f64) {
        let flights = [(-3e-4, 2e-3), (-1e-4, -1e-3), (2e-4, 5e-4), (3e-4, 0.0)];
        let flights = flights.map(|(x, v)| Flight { x, v, forcing: [0.3, 0.0, 20.0, 0.0] });
        let model = |i: usize| BallModel { mass: [1.0, 2.0, 0.7, 1.3][i], omega2: omega2[i], gamma: 0.4 };
        let balls: Vec<Ball> = (0..4).map(|i| Ball::new(&model(i), DoubleDouble::from(0.0), flights[i])).collect();
        let pressing = |overlap| WindowContact { overlap, mode: Mode::Pressing };
        let contacts = [pressing(3e-7), pressing(1e-7), WindowContact { overlap: -1e-7, mode: Mode::Open }];
        let law = ContactLaw { stiffness: 1e10, overlap_ref: 1e-6, exponent, clearance: 1e-7, damping };
        let laws = [law, ContactLaw { stiffness: 2e10, ..law }, law];
        let window = Window { flights: &flights, balls: &balls, contacts: &contacts, laws: &laws };
        let (control, scale) = (Control::new(1e-12), velocity_scale(&window));
        let (mut plain, mut lasting) = (Series::default(), Series::default());
        let mut workspace = Workspace::default();
        plain.expand(&mut recurrences::Workspace::default(), &window, &control, scale);
        assert!((workspace.velocity_scale(&window) - scale).abs() <= 1e-15 * scale);
        lasting.expand_persistent(&mut workspace, &window, &control, scale, plain.converges_for());
        let until = plain.converges_for().min(lasting.converges_for());
        (plain, lasting, until)
    }

    #[test]
    fn the_motion_is_that_of_the_other_series() {
        let dampings = [
            Damping::None,
            Damping::KelvinVoigt { c: 100.0, pull: true },
            Damping::HuntCrossley { alpha: 0.3 },
            Damping::Viscoelastic { relaxation: 1e-6 },
        ];
        for exponent in [1.0, 1.5, 2.0, 2.3, 3.0, 5.0, 6.0, 7.0, 10.0] {
            for damping in dampings {
                for omega2 in [[5.0; 4], [5.0, 6.0, 5.0, 4.0]] {
                    let (plain, lasting, until) = expanded(exponent, damping, omega2);
                    let of = |series: &Series| {
                        let contact =
                            |j| [series.overlap(j, until).0, series.impulse(j, until), series.contact_loss(j, until)];
                        let ball = |j| {
                            let (moved, change) = series.moved(j, until);
                            let squares = series.squared_velocity_integral(j, until);
                            [moved, change, series.displacement_integral(j, until), squares]
                        };
                        let contacts: Vec<f64> = (0..2).flat_map(contact).collect();
                        [contacts, (0..4).flat_map(ball).collect()].concat()
                    };
                    for (k, (plain, lasting)) in of(&plain).into_iter().zip(of(&lasting)).enumerate() {
                        let error = (lasting - plain).abs() / plain.abs();
                        assert!(
                            plain == lasting || error < 1e-11,
                            "p = {exponent}, {damping:?}: {k} is off by {error:e}"
                        );
                    }
                    assert!(lasting.converges_for() > plain.converges_for(), "p = {exponent}");
                }
            }
        }
    }
}
