//! The corrector polynomials of the multistep methods and their error constants, for steps of any lengths.
//!
//! Points lie at distances `xi`, in steps, before the end of a step; the variable `s` is that of
//! [`NordsieckStep`](super::path::NordsieckStep).

/// Highest order of any method.
pub(super) const MAX_ORDER: usize = 12;

pub(super) type Polynomial = [f64; MAX_ORDER + 2];

const ONE: Polynomial = {
    let mut one = [0.0; MAX_ORDER + 2];
    one[0] = 1.0;
    one
};

/// `p(s) (a + b s)`.
fn times(p: &Polynomial, a: f64, b: f64) -> Polynomial {
    std::array::from_fn(|j| a * p[j] + if j > 0 { b * p[j - 1] } else { 0.0 })
}

/// Integral of `s^power p(s)` over `[-1, 0]`.
fn integral(p: &Polynomial, power: usize) -> f64 {
    let term = |(j, c): (usize, &f64)| {
        let k = j + power + 1;
        if k.is_multiple_of(2) { -c / k as f64 } else { c / k as f64 }
    };
    p.iter().enumerate().map(term).sum()
}

pub(super) struct MethodCoefficients {
    /// The corrector polynomial L.
    pub corrector: Polynomial,
    /// Error of the step over the correction `e`.
    pub error: f64,
    /// Error at the order below, over the highest coefficient; without meaning for order 1.
    pub lower: f64,
    /// Error at the order above, over the change of `e` from step to step.
    pub higher: f64,
    /// Changes of `e` are taken as those of `e / spread`, a divided difference.
    pub spread: f64,
}

/// Distances, over `unit`, of a point at `first` and of one more for each of `steps` further back.
pub(super) fn distances(first: f64, steps: &[f64], unit: f64) -> [f64; MAX_ORDER + 1] {
    let mut sum = first;
    let mut distances = [first / unit; MAX_ORDER + 1];
    for (distance, step) in distances[1..].iter_mut().zip(steps) {
        sum += step;
        *distance = sum / unit;
    }
    distances
}

/// The product of `s + d` over the distances d.
pub(super) fn roots(distances: &[f64]) -> Polynomial {
    distances.iter().fold(ONE, |p, d| times(&p, *d, 1.0))
}

/// The product of `1 + s / d` over the distances d.
fn scaled_roots(distances: &[f64]) -> Polynomial {
    distances.iter().fold(ONE, |p, d| times(&p, 1.0, 1.0 / d))
}

/// Adams-Moulton: L' vanishes at the points at which the rates are kept, L at the start of the step.
pub(super) fn adams(order: usize, xi: &[f64]) -> MethodCoefficients {
    let kept = scaled_roots(&xi[..order - 1]);
    let area = integral(&kept, 0);
    let mut corrector = ONE;
    (1..=order).for_each(|j| corrector[j] = kept[j - 1] / (j as f64 * area));
    // The divided difference of the rates over these points and one more, and the integral of its factor.
    let spread = area * xi[..order].iter().product::<f64>();
    MethodCoefficients {
        corrector,
        // Shorter steps would make it too small where the rates jump, so it is at least that of equal steps.
        error: (integral(&kept, 1) / (area * xi[order - 1].min(order as f64))).abs(),
        lower: order as f64 * integral(&roots(&xi[..order.saturating_sub(2)]), 1).abs(),
        higher: (integral(&roots(&xi[..order]), 1) / (xi[order] * spread)).abs(),
        spread,
    }
}

/// Backward differentiation: L vanishes at the points that are kept, the last of them moved so that L' at the end of
/// the step is as for equal steps. The error constants are those of Brown, Byrne and Hindmarsh.
pub(super) fn bdf(order: usize, xi: &[f64]) -> MethodCoefficients {
    let q = order as f64;
    let leading: f64 = (1..=order).map(|j| 1.0 / j as f64).sum();
    let (points, last) = (&xi[..order - 1], 1.0 / xi[order - 1]);
    let of_points: f64 = points.iter().map(|xi| 1.0 / xi).sum();
    let moved = leading - of_points;
    let corrector = times(&scaled_roots(points), 1.0, moved);
    let highest = corrector[order];
    let a1 = 1.0 + (of_points + last) - leading;
    let a2 = 1.0 + q * a1;
    let lower = if order == 1 {
        0.0
    } else {
        let (a3, a4) = (1.0 / q - leading, -of_points);
        moved / highest * (1.0 - a4 + a3) / a3
    };
    let higher = {
        let (a5, a6) = (-leading - 1.0 / (q + 1.0), -of_points - last - 1.0 / xi[order]);
        (1.0 - a6 + a5) / a2 * xi[order] / ((q + 2.0) * a5)
    };
    MethodCoefficients {
        corrector,
        error: (a1 / (leading * a2)).abs(),
        lower: lower.abs(),
        higher: higher.abs(),
        spread: (a2 * moved / (highest * last)).abs(),
    }
}
