//! How the motion of a group on a segment changes with its start and with the coefficients: the variational equations.
//!
//! With positions `y = x + v t + h^2 Q2 g` at the nodes of collocation (see [`gauss`](crate::solver::gauss)), the
//! changes of the accelerations there are
//!
//! ```text
//! g = C y - 2 gamma (v + h Q1 g) + what the coefficients do,   (C y)_i = (f_(i-1) - f_i) / m_i - omega_i^2 y_i,
//! f_j = slope_j (y_j - y_(j+1)),
//! ```
//!
//! so that `g = known + L g`. Backwards, the derivatives by the accelerations obey the same equation with `L`
//! transposed. The numbers in `L` are the same, and both are solved to far more digits than a double has: the two
//! directions differ by the rounding of the result.

use super::coefficients::{CLEARANCE, Coefficients, OfBall, OfContact};
use super::segment::{Progress, Segment};
use super::slots::Slots;
use crate::model::{BallModel, Cradle};
use crate::solver::double_double::{DoubleDouble, Linear};
use crate::solver::gauss::{NODES, Nodes, Table, combine, weighted};

/// Iterations after which a solution is taken as it is.
const MOST: usize = 60;

/// Change over the size, both summed, at which the iteration is at its end. What a solution leaves is solved for once
/// more: the error is the square of this.
const CONVERGED: f64 = 1e-10;

/// Values of each ball or contact, at the nodes.
type All<T> = Vec<Nodes<T>>;

#[derive(Clone, Copy)]
enum Sense {
    Forward,
    Transposed,
}

/// The equations on a segment.
pub(super) struct Variation<'a> {
    segment: &'a Segment,
    cradle: &'a Cradle,
    models: &'a [BallModel],
    /// Inverse masses, 1/kg.
    lightness: Vec<f64>,
    table: &'static Table,
    /// Its length (s), and the square of that.
    h: f64,
    h2: f64,
}

impl<'a> Variation<'a> {
    pub fn new(segment: &'a Segment, cradle: &'a Cradle) -> Self {
        let models = &cradle.balls[segment.first..segment.first + segment.balls.len()];
        let lightness = models.iter().map(|model| 1.0 / model.mass).collect();
        let h = segment.length;
        Self { segment, cradle, models, lightness, table: segment.stretching.table(), h, h2: h * h }
    }

    /// Changes of the state at the end from those at the start.
    pub fn forward(&self, change: &Coefficients, slots: &mut Slots) {
        let (table, first, count) = (self.table, self.segment.first, self.models.len());
        let (x, v) = (slots.x[first..first + count].to_vec(), slots.v[first..first + count].to_vec());
        let free = |i: usize| table.times.map(|part| x[i] + v[i] * (self.h * part));
        let free: All<DoubleDouble> = (0..count).map(free).collect();
        let of_contact = |j: usize| changed(&self.of_contact(j), &change.contacts[first + j]);
        let forces: All<DoubleDouble> = (0..count - 1).map(of_contact).collect();
        let mut known = self.accelerations(&free);
        for (i, known) in known.iter_mut().enumerate() {
            let sources = changed(&self.of_ball(i), &change.balls[first + i]);
            let steady = v[i] * (-2.0 * self.models[i].gamma) + -change.support;
            known.iter_mut().zip(sources).for_each(|(known, source)| *known += source + steady);
        }
        forces.iter().enumerate().for_each(|(j, force)| self.push(&mut known, j, force));
        let g = self.solve(Sense::Forward, &known);
        let moved = |(free, g): (&Nodes<DoubleDouble>, &Nodes<DoubleDouble>)| {
            let moved = combine(&table.positions, g);
            std::array::from_fn(|m| free[m] + moved[m] * self.h2)
        };
        let moved: All<DoubleDouble> = free.iter().zip(&g).map(moved).collect();
        for (j, by_coefficients) in forces.iter().enumerate() {
            let slope = &self.segment.contacts[j].slope;
            let force = std::array::from_fn(|m| (moved[j][m] - moved[j + 1][m]) * slope[m] + by_coefficients[m]);
            slots.impulse[first + j] += weighted(&table.of_rate, &force) * self.h;
        }
        for i in 0..count {
            slots.x[first + i] += v[i] * self.h + weighted(&table.of_position, &g[i]) * self.h2;
            slots.v[first + i] += weighted(&table.of_rate, &g[i]) * self.h;
        }
    }

    /// The derivatives by the state at the start, and by the coefficients, from those by the state at the end.
    pub fn backward(&self, gradient: &mut Coefficients<DoubleDouble>, slots: &mut Slots) {
        let (table, first, count) = (self.table, self.segment.first, self.models.len());
        let (x, v) = (slots.x[first..first + count].to_vec(), slots.v[first..first + count].to_vec());
        let of_end = |i: usize| -> Nodes<DoubleDouble> {
            let (of_x, of_v) = (x[i] * self.h2, v[i] * self.h);
            std::array::from_fn(|m| of_x * table.of_position[m] + of_v * table.of_rate[m])
        };
        let mut known: All<DoubleDouble> = (0..count).map(of_end).collect();
        let of_impulse = |impulse: &DoubleDouble| table.of_rate.map(|weight| *impulse * self.h * weight);
        let by_impulse: All<DoubleDouble> = slots.impulse[first..first + count - 1].iter().map(of_impulse).collect();
        let mut by_places = vec![[DoubleDouble::ZERO; NODES]; count];
        by_impulse.iter().enumerate().for_each(|(j, by_force)| self.press(&mut by_places, j, by_force));
        if slots.impulse[first..first + count - 1].iter().any(|impulse| impulse.value() != 0.0) {
            for (known, by_place) in known.iter_mut().zip(&by_places) {
                let of_places = transposed(&table.positions, by_place);
                known.iter_mut().zip(of_places).for_each(|(known, of)| *known += of * self.h2);
            }
        }
        let by_g = self.solve(Sense::Transposed, &known);
        for (sums, by_place) in by_places.iter_mut().zip(self.transposed_accelerations(&by_g)) {
            sums.iter_mut().zip(by_place).for_each(|(sum, by_place)| *sum += by_place);
        }
        for i in 0..count {
            let by_place = &by_places[i];
            let total = sum(&by_g[i]);
            let damping = total * (-2.0 * self.models[i].gamma);
            slots.x[first + i] += sum(by_place);
            slots.v[first + i] += x[i] * self.h + damping + weighted(&table.times.map(|part| self.h * part), by_place);
            add(&mut gradient.balls[first + i], &self.of_ball(i), &by_g[i]);
            gradient.support = gradient.support - total;
        }
        for (j, by_impulse) in by_impulse.iter().enumerate() {
            let by_force = self.by_force(&by_g, j);
            let by_force = std::array::from_fn(|m| by_impulse[m] + by_force[m]);
            add(&mut gradient.contacts[first + j], &self.of_contact(j), &by_force);
        }
    }

    /// Derivatives of the accelerations of ball `i` by its coefficients; those by the external force are the same at
    /// all nodes.
    fn of_ball(&self, i: usize) -> OfBall<Nodes> {
        let (ball, lightness) = (&self.segment.balls[i], self.lightness[i]);
        [
            ball.force.map(|force| -force * (lightness * lightness)),
            ball.x.map(|x| -x),
            ball.v.map(|v| -2.0 * v),
            [lightness; NODES],
        ]
    }

    /// Derivatives of the force of contact `j` by its coefficients.
    fn of_contact(&self, j: usize) -> OfContact<Nodes> {
        let (contact, law) = (&self.segment.contacts[j], &self.cradle.contacts[self.segment.first + j]);
        let mut of = [[0.0; NODES]; 7];
        for m in 0..NODES {
            let at_node = contact.derivatives(law, m);
            of.iter_mut().zip(at_node).for_each(|(of, at_node)| of[m] = at_node);
        }
        of[CLEARANCE] = contact.slope.map(|slope| -slope);
        of
    }

    /// The solution of `g = known + L g`.
    fn solve(&self, sense: Sense, known: &All<DoubleDouble>) -> All<DoubleDouble> {
        let rounded: All<f64> = known.iter().map(|known| known.map(DoubleDouble::value)).collect();
        let mut solution: All<DoubleDouble> =
            self.iterate(sense, &rounded).iter().map(|rough| rough.map(DoubleDouble::from)).collect();
        let image = self.image(sense, &solution);
        let rest = |i: usize| std::array::from_fn(|m| (known[i][m] - solution[i][m] + image[i][m]).value());
        let rest: All<f64> = (0..known.len()).map(rest).collect();
        for (solution, correction) in solution.iter_mut().zip(self.iterate(sense, &rest)) {
            solution.iter_mut().zip(correction).for_each(|(solution, correction)| *solution += correction);
        }
        solution
    }

    /// The same by Picard's iteration.
    fn iterate(&self, sense: Sense, known: &All<f64>) -> All<f64> {
        let (mut g, mut progress) = (known.clone(), Progress::default());
        for _ in 0..MOST {
            let mut image = self.image(sense, &g);
            for ((g, image), known) in g.iter_mut().zip(&mut image).zip(known) {
                image.iter_mut().zip(known).for_each(|(next, known)| *next += known);
                progress.renew(g, image);
            }
            if progress.is_done(CONVERGED) {
                break;
            }
        }
        g
    }

    /// `L g`, or the product with `L` transposed.
    fn image<T: Linear>(&self, sense: Sense, g: &All<T>) -> All<T> {
        let damping = |i: usize| -2.0 * self.models[i].gamma * self.h;
        let (mut image, tables): (All<T>, _) = match sense {
            Sense::Forward => {
                let moved = |g: &Nodes<T>| combine(&self.table.positions, g).map(|moved| moved * self.h2);
                let moved: All<T> = g.iter().map(moved).collect();
                (self.accelerations(&moved), combine as fn(&_, &_) -> _)
            }
            Sense::Transposed => {
                let places = self.transposed_accelerations(g);
                let by_g = |place: &Nodes<T>| transposed(&self.table.positions, place).map(|of| of * self.h2);
                (places.iter().map(by_g).collect(), transposed as fn(&_, &_) -> _)
            }
        };
        for (i, image) in image.iter_mut().enumerate().filter(|(i, _)| self.models[*i].gamma > 0.0) {
            let rates: Nodes<T> = tables(&self.table.rates, &g[i]);
            image.iter_mut().zip(rates).for_each(|(image, rate)| *image = *image + rate * damping(i));
        }
        image
    }

    /// `C y`.
    fn accelerations<T: Linear>(&self, y: &All<T>) -> All<T> {
        let mut accelerations = self.pulled(y);
        for (j, contact) in self.segment.contacts.iter().enumerate() {
            let force = std::array::from_fn(|m| (y[j][m] - y[j + 1][m]) * contact.slope[m]);
            self.push(&mut accelerations, j, &force);
        }
        accelerations
    }

    /// The product of derivatives by the accelerations with `C` transposed: derivatives by the positions.
    fn transposed_accelerations<T: Linear>(&self, by_g: &All<T>) -> All<T> {
        let mut places = self.pulled(by_g);
        (0..self.segment.contacts.len()).for_each(|j| self.press(&mut places, j, &self.by_force(by_g, j)));
        places
    }

    /// Times `-omega^2`.
    fn pulled<T: Linear>(&self, values: &All<T>) -> All<T> {
        values.iter().zip(self.models).map(|(values, model)| values.map(|value| value * -model.omega2)).collect()
    }

    /// Adds the accelerations by the force of contact `j`.
    fn push<T: Linear>(&self, accelerations: &mut All<T>, j: usize, force: &Nodes<T>) {
        let (left, right) = (self.lightness[j], self.lightness[j + 1]);
        for m in 0..NODES {
            accelerations[j][m] = accelerations[j][m] - force[m] * left;
            accelerations[j + 1][m] = accelerations[j + 1][m] + force[m] * right;
        }
    }

    /// Derivatives by the force of contact `j` from those by the accelerations.
    fn by_force<T: Linear>(&self, by_g: &All<T>, j: usize) -> Nodes<T> {
        let (left, right) = (self.lightness[j], self.lightness[j + 1]);
        std::array::from_fn(|m| by_g[j + 1][m] * right - by_g[j][m] * left)
    }

    /// Adds the derivatives by the positions, from those by the force of contact `j`.
    fn press<T: Linear>(&self, places: &mut All<T>, j: usize, by_force: &Nodes<T>) {
        let slope = &self.segment.contacts[j].slope;
        for m in 0..NODES {
            let by_overlap = by_force[m] * slope[m];
            places[j][m] = places[j][m] + by_overlap;
            places[j + 1][m] = places[j + 1][m] - by_overlap;
        }
    }
}

/// `sum_l columns[m][l] values[l]`: the transposed of [`combine`].
fn transposed<T: Linear>(columns: &[Nodes; NODES], values: &Nodes<T>) -> Nodes<T> {
    std::array::from_fn(|m| weighted(&columns[m], values))
}

/// What changes of coefficients do at the nodes, where these are the derivatives by them.
fn changed(of: &[Nodes], changes: &[f64]) -> Nodes<DoubleDouble> {
    let mut sums = [DoubleDouble::ZERO; NODES];
    for (of, change) in of.iter().zip(changes).filter(|(_, change)| **change != 0.0) {
        sums.iter_mut().zip(of).for_each(|(sum, of)| *sum += DoubleDouble::product(*of, *change));
    }
    sums
}

/// Adds to the derivatives by coefficients: those of the values at the nodes by them, times the derivatives by these
/// values.
fn add(gradient: &mut [DoubleDouble], of: &[Nodes], by_nodes: &Nodes<DoubleDouble>) {
    gradient.iter_mut().zip(of).for_each(|(sum, of)| *sum += weighted(of, by_nodes));
}

fn sum(values: &Nodes<DoubleDouble>) -> DoubleDouble {
    values.iter().fold(DoubleDouble::ZERO, |sum, value| sum + *value)
}
