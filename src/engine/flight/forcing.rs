//! The acceleration of a ball by the inputs: a polynomial of the time.

use crate::solver::dual::Scalar;
use crate::solver::oscillator::MAX_FORCE_ORDER;

/// Acceleration by the inputs, as derivatives at the anchor: `push[j]` in m/s^(2+j).
pub(crate) type Push<S = f64> = [S; MAX_FORCE_ORDER + 1];

/// Highest derivative of the push that is not zero.
#[inline]
pub(crate) fn degree(push: &Push) -> usize {
    // Most inputs are constant: one comparison in place of three.
    if push[1..].iter().fold(0.0, |sum, p| sum + p.abs()) == 0.0 {
        return 0;
    }
    (1..=MAX_FORCE_ORDER).rev().find(|&j| push[j] != 0.0).unwrap_or(0)
}

/// Its value `tau` (s) after the anchor, m/s2.
pub(crate) fn push_at(push: &Push, tau: f64) -> f64 {
    (0..=degree(push)).rev().fold(0.0, |sum, k| push[k] + sum * tau / (k + 1) as f64)
}

/// The same polynomial seen from `tau` (s) later.
pub(crate) fn shifted<S: Scalar>(push: &Push<S>, tau: S) -> Push<S> {
    let mut later = *push;
    if push[1..].iter().all(|p| p.value() == 0.0 && p.tangent() == 0.0) {
        return later;
    }
    for (j, later) in later.iter_mut().enumerate() {
        let mut power = S::from(1.0);
        for (k, &p) in push.iter().enumerate().skip(j + 1) {
            power = power * (tau / S::from((k - j) as f64));
            *later += p * power;
        }
    }
    later
}
