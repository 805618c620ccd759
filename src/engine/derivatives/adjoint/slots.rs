//! What varies from one part of a run to the next.

/// One number for each position, velocity and impulse at one time: how much it changes, or how much something changes with it.
#[derive(Clone, Debug, Default)]
pub(super) struct Slots {
    pub x: Vec<f64>,
    pub v: Vec<f64>,
    pub impulse: Vec<f64>,
}

impl Slots {
    pub fn zero(balls: usize) -> Self {
        Self { x: vec![0.0; balls], v: vec![0.0; balls], impulse: vec![0.0; balls.saturating_sub(1)] }
    }

    /// The sum of the products with others.
    pub fn dot(&self, other: &Self) -> f64 {
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        sum(&self.x, &other.x) + sum(&self.v, &other.v) + sum(&self.impulse, &other.impulse)
    }
}
