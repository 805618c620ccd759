//! Sine and cosine of an angle that is known to more digits than a double holds.
//!
//! The phase of a pendulum after an hour is 1e4 rad: as a double it would lose four digits that the swing has. The
//! angle is reduced to an eighth of a turn with pi / 2 in parts short enough for exact products (Cody and Waite,
//! Software Manual for the Elementary Functions, 1980), and both functions are summed up to the term that no longer
//! counts.

use crate::solver::double_double::DoubleDouble;

/// pi / 2 as a sum: three parts of 33 bits.
const PARTS: [f64; 3] = [
    f64::from_bits(0x3ff9_21fb_5440_0000),
    f64::from_bits(0x3dd0_b461_1a60_0000),
    f64::from_bits(0x3ba3_198a_2e00_0000),
];

/// Quarter turns up to which their products with the parts are exact.
const EXACT_TURNS: f64 = 1_048_576.0;

/// `1 / n!` with alternating signs, of the odd and of the even `n` from 3 and 4 on.
const SINE: [f64; 8] = coefficients(3);
const COSINE: [f64; 8] = coefficients(4);

const fn coefficients<const N: usize>(first: usize) -> [f64; N] {
    let mut terms = [0.0; N];
    let mut i = 0;
    while i < N {
        // Factorials up to 19! are sums of few bits: no rounding before the division.
        let (mut factorial, mut k) = (1.0, 2);
        while k <= first + 2 * i {
            factorial *= k as f64;
            k += 1;
        }
        terms[i] = if (first / 2 + i) & 1 == 0 { 1.0 } else { -1.0 } / factorial;
        i += 1;
    }
    terms
}

/// Sine and cosine of `angle` (rad), to the last digit or two.
#[inline]
pub fn sin_cos(angle: DoubleDouble) -> (f64, f64) {
    let turns = nearest(angle.value() * std::f64::consts::FRAC_2_PI);
    if turns.abs() > EXACT_TURNS || turns.is_nan() {
        let (sine, cosine) = libm::sincos(angle.value());
        return (sine + angle.rest() * cosine, cosine - angle.rest() * sine);
    }
    let rest = DoubleDouble::from(angle.value() - turns * PARTS[0]) + -(turns * PARTS[1]);
    let rest = rest + (angle.rest() - turns * PARTS[2]);
    let (sine, cosine) = reduced(rest.value(), rest.rest());
    match turns as i32 & 3 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// The nearest whole number, for magnitudes far below 2^51.
fn nearest(x: f64) -> f64 {
    const SHIFT: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52: what is added to it is rounded to whole numbers.
    (x + SHIFT) - SHIFT
}

/// For `|x| <= pi / 4`, with the small correction `dx`.
fn reduced(x: f64, dx: f64) -> (f64, f64) {
    let z = x * x;
    let z2 = z * z;
    // By halves (Estrin 1960), which processors evaluate side by side.
    let sum = |c: &[f64; 8]| {
        let (low, high) = ((c[0] + c[1] * z) + z2 * (c[2] + c[3] * z), (c[4] + c[5] * z) + z2 * (c[6] + c[7] * z));
        low + z2 * z2 * high
    };
    let half = 0.5 * z;
    let sine = x + (x * z * sum(&SINE) + dx * (1.0 - half));
    // 1 - z / 2 with what its rounding leaves.
    let top = 1.0 - half;
    let cosine = top + ((1.0 - top - half) + (z2 * sum(&COSINE) - x * dx));
    (sine, cosine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_library() {
        for k in -4000..4000 {
            let angle = 0.377 * f64::from(k) * f64::from(k % 7 + 1);
            let (sine, cosine) = sin_cos(angle.into());
            let (expected_sine, expected_cosine) = libm::sincos(angle);
            assert!((sine - expected_sine).abs() <= f64::EPSILON * expected_sine.abs(), "sin {angle}");
            assert!((cosine - expected_cosine).abs() <= f64::EPSILON * expected_cosine.abs(), "cos {angle}");
        }
        assert_eq!(sin_cos(DoubleDouble::default()), (0.0, 1.0));
        assert!(sin_cos(f64::INFINITY.into()).0.is_nan());
    }

    #[test]
    fn uses_the_second_double() {
        // 1e5 turns of pi / 2: what a double cannot hold of the angle decides on the sine.
        let right = DoubleDouble::product(PARTS[0], 4e5) + 4e5 * PARTS[1] + 4e5 * PARTS[2];
        let (sine, cosine) = sin_cos(right);
        assert!(sine.abs() < 1e-25, "{sine:e}");
        assert_eq!(cosine, 1.0);
        let (sine, _) = sin_cos(right + 3e-20);
        assert!((sine - 3e-20).abs() < 1e-25, "{sine:e}");
    }

    #[test]
    fn goes_on_beyond_the_exact_range() {
        let (sine, cosine) = sin_cos(1e9.into());
        assert_eq!((sine, cosine), libm::sincos(1e9));
    }
}
