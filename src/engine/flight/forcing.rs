//! The acceleration of a ball by the inputs: a polynomial of the time.

use crate::solver::dual::Scalar;
use crate::solver::oscillator::MAX_FORCE_ORDER;

/// Acceleration by the inputs, as derivatives at the anchor: `forcing[j]` in m/s^(2+j).
pub(crate) type Forcing<S = f64> = [S; MAX_FORCE_ORDER + 1];

/// Highest derivative of the forcing that is not zero.
#[inline]
pub(crate) fn degree(forcing: &Forcing) -> usize {
    // Most inputs are constant: one comparison in place of three.
    if forcing[1..].iter().fold(0.0, |sum, p| sum + p.abs()) == 0.0 {
        return 0;
    }
    (1..=MAX_FORCE_ORDER).rev().find(|&j| forcing[j] != 0.0).unwrap_or(0)
}

/// Its value `tau` (s) after the anchor, m/s2.
pub(crate) fn forcing_at(forcing: &Forcing, tau: f64) -> f64 {
    (0..=degree(forcing)).rev().fold(0.0, |sum, k| forcing[k] + sum * tau / (k + 1) as f64)
}

/// The same polynomial seen from `tau` (s) later.
pub(crate) fn shifted<S: Scalar>(forcing: &Forcing<S>, tau: S) -> Forcing<S> {
    let mut later = *forcing;
    if forcing[1..].iter().all(|p| p.value() == 0.0 && p.tangent() == 0.0) {
        return later;
    }
    for (j, later) in later.iter_mut().enumerate() {
        let mut power = S::from(1.0);
        for (k, &p) in forcing.iter().enumerate().skip(j + 1) {
            power = power * (tau / S::from((k - j) as f64));
            *later += p * power;
        }
    }
    later
}
