//! Linear maps of changes; a tape is a chain of them.
//!
//! Changes of a state, or derivatives by it, are one row of numbers, [`STATE`] for each ball; those of the coefficients
//! another, [`COEFFICIENTS`] for each ball and one for the support. The last ball has no contact at its right.

use std::ops::{Add, Range};

use crate::model::{ContactLaw, Cradle, Damping, Inputs};
use crate::solver::{DoubleDouble, Dual, Scalar};

/// Position and velocity of a ball, and the impulse of the contact at its right.
pub(super) const STATE: usize = 3;
pub(super) const X: usize = 0;
pub(super) const V: usize = 1;
pub(super) const IMPULSE: usize = 2;

/// Mass, `omega2`, `gamma` of a ball and the external force on it.
pub(super) const OF_BALL: usize = 4;

/// Stiffness, reference overlap, exponent and clearance of a contact, and the coefficients of the damping laws: Kelvin
/// and Voigt's, Hunt and Crossley's, and the relaxation time of viscoelastic contacts.
pub(super) const OF_CONTACT: usize = 7;
/// Place of the clearance among those of a contact.
pub(super) const CLEARANCE: usize = 3;

pub(super) const COEFFICIENTS: usize = OF_BALL + OF_CONTACT;

/// Numbers of a state of this many neighbours.
pub(super) fn numbers_of_state(balls: usize) -> usize {
    (balls * STATE).saturating_sub(1)
}

/// Their coefficients, with that of the support.
pub(super) fn numbers_of_coefficients(balls: usize) -> usize {
    (balls * COEFFICIENTS).saturating_sub(OF_CONTACT) + 1
}

/// Changes of the coefficients along a direction in which the inputs change by `inputs`.
pub(super) fn changes(along: &Cradle<Dual>, inputs: &Inputs) -> Vec<f64> {
    let mut changes = Vec::with_capacity(numbers_of_coefficients(along.balls.len()));
    for (i, (ball, force)) in along.balls.iter().zip(&inputs.force).enumerate() {
        changes.extend([ball.mass.tangent(), ball.omega2.tangent(), ball.gamma.tangent(), *force]);
        if let Some(law) = along.contacts.get(i) {
            changes.extend([law.stiffness, law.overlap_ref, law.exponent, law.clearance].map(Dual::tangent));
            changes.extend(match law.damping {
                Damping::None => [0.0; 3],
                Damping::KelvinVoigt { c, .. } => [c.tangent(), 0.0, 0.0],
                Damping::HuntCrossley { alpha } => [0.0, alpha.tangent(), 0.0],
                Damping::Viscoelastic { relaxation } => [0.0, 0.0, relaxation.tangent()],
            });
        }
    }
    changes.push(inputs.support_acceleration);
    changes
}

/// The sum of the products. Changes along a direction are mostly zeros.
pub(super) fn dot(by: &[DoubleDouble], changes: &[f64]) -> DoubleDouble {
    let products = by.iter().zip(changes).filter(|(_, change)| **change != 0.0);
    products.fold(DoubleDouble::ZERO, |sum, (by, change)| sum + *by * *change)
}

/// Derivatives of the force of a contact by the coefficients at constant overlap and rate, from force and slope.
pub(super) fn law_derivatives(law: &ContactLaw, overlap: f64, rate: f64, force: f64, slope: f64) -> [f64; OF_CONTACT] {
    if overlap <= 0.0 {
        return [0.0; OF_CONTACT];
    }
    let by_exponent = force * libm::log(overlap / law.overlap_ref);
    let by_reference = (1.0 - law.exponent) * force / law.overlap_ref;
    [force / law.stiffness, by_reference, by_exponent, 0.0, rate, force * rate, slope * rate]
}

/// Linear functions of the state of some neighbours and of the coefficients; for a part of a run, its change.
#[derive(Clone, Debug)]
pub(super) struct Map {
    first: usize,
    balls: usize,
    pub tuning: usize,
    by: Vec<f64>,
}

impl Map {
    /// Of a part of a run.
    pub fn zero(first: usize, balls: usize, tuning: usize) -> Self {
        Self::of_rows(numbers_of_state(balls), first, balls, tuning)
    }

    pub fn of_rows(rows: usize, first: usize, balls: usize, tuning: usize) -> Self {
        let columns = numbers_of_state(balls) + numbers_of_coefficients(balls);
        Self { first, balls, tuning, by: vec![0.0; rows * columns] }
    }

    /// Numbers in the map of a part with this many balls.
    pub fn numbers_of(balls: usize) -> usize {
        let rows = numbers_of_state(balls);
        rows * (rows + numbers_of_coefficients(balls))
    }

    /// The rows: the numbers of the state, the coefficients, and that of the support.
    fn rows(&self) -> std::slice::ChunksExact<'_, f64> {
        self.by.chunks_exact(numbers_of_state(self.balls) + numbers_of_coefficients(self.balls))
    }

    /// A row: by the numbers of the state, and by the coefficients, the last one that of the support.
    pub fn row(&mut self, number: usize) -> [&mut [f64]; 2] {
        let states = numbers_of_state(self.balls);
        let columns = states + numbers_of_coefficients(self.balls);
        self.by[number * columns..][..columns].split_at_mut(states).into()
    }

    /// The places of its balls among the numbers of the state and among the coefficients.
    fn places(&self) -> [Range<usize>; 2] {
        let (states, coefficients) = (numbers_of_state(self.balls), numbers_of_coefficients(self.balls) - 1);
        let [state, coefficient] = [self.first * STATE, self.first * COEFFICIENTS];
        [state..state + states, coefficient..coefficient + coefficients]
    }

    /// The changes of its functions from those of the state and of the coefficients.
    pub fn apply(&self, changes: &[f64], state: &[DoubleDouble]) -> Vec<DoubleDouble> {
        let [own, coefficients] = self.places();
        let changes = changes[coefficients].iter().chain(changes.last()).copied().enumerate();
        let changes: Vec<(usize, f64)> = changes.filter(|(_, change)| *change != 0.0).collect();
        let state = &state[own];
        let of_row = |row: &[f64]| {
            let (of_state, of_coefficients) = row.split_at(state.len());
            let product = |(k, change): &(usize, f64)| DoubleDouble::product(of_coefficients[*k], *change);
            changes.iter().map(product).fold(dot(state, of_state), Add::add)
        };
        self.rows().map(of_row).collect()
    }

    /// Adds the derivatives by the state and by the coefficients, from those by its functions.
    pub fn apply_transposed(
        &self,
        by: &[DoubleDouble],
        by_coefficients: &mut [DoubleDouble],
        by_state: &mut [DoubleDouble],
    ) {
        let [own, coefficients] = self.places();
        let (by_balls, by_support) = by_coefficients.split_at_mut(by_coefficients.len() - 1);
        let (by_state, by_balls) = (&mut by_state[own], &mut by_balls[coefficients]);
        for (row, by) in self.rows().zip(by) {
            let sums = by_state.iter_mut().chain(&mut *by_balls).chain(&mut *by_support);
            sums.zip(row).for_each(|(sum, of)| *sum += *by * *of);
        }
    }

    /// Turns changes of the state before this part of a run into those after it.
    pub fn forward(&self, changes: &[f64], state: &mut [DoubleDouble]) {
        let growth = self.apply(changes, state);
        state[self.first * STATE..].iter_mut().zip(growth).for_each(|(to, growth)| *to += growth);
    }

    /// Turns derivatives by the state after this part of a run into those by the state before and the coefficients.
    pub fn backward(&self, by_coefficients: &mut [DoubleDouble], by_state: &mut [DoubleDouble]) {
        let [own, _] = self.places();
        let by_after = by_state[own].to_vec();
        self.apply_transposed(&by_after, by_coefficients, by_state);
    }
}
