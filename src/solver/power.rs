//! Powers of many numbers at once, with exponents between -1 and 1.
//!
//! libm's `pow` takes one number at a time. These loops have only `+ - * /` and operations on bits, so compilers
//! vectorise them, with the same result on every platform. A number is `2^k m` with m between `1 / sqrt 2` and `sqrt
//! 2`, and
//!
//! ```text
//! (2^k m)^e = 2^(e k) exp(e log m),     log m = 2 artanh((m - 1) / (m + 1))
//! ```
//!
//! The two functions are approximated as in Sun's fdlibm (`e_log.c` and `e_exp.c`, 1993), to within 2^-58.

use std::f64::consts::{FRAC_1_SQRT_2, LN_2, LOG2_E};

/// `log m = 2 s + s z (c_0 + c_1 z + ...)`, `z = s^2`, `s = (m - 1) / (m + 1)`.
const LOGARITHM: [f64; 7] = [
    6.666_666_666_666_735e-1,
    3.999_999_999_940_942e-1,
    2.857_142_874_366_239e-1,
    2.222_219_843_214_978_4e-1,
    1.818_357_216_161_805e-1,
    1.531_383_769_920_937_3e-1,
    1.479_819_860_511_658_6e-1,
];

/// `exp x = 1 + 2 x / (2 - c)`, `c = x - z (c_0 + c_1 z + ...)`, `z = x^2`, for `|x| <= log 2 / 2`.
const EXPONENTIAL: [f64; 5] = [
    1.666_666_666_666_660_2e-1,
    -2.777_777_777_701_559_3e-3,
    6.613_756_321_437_934e-5,
    -1.653_390_220_546_525_2e-6,
    4.138_136_797_057_238_5e-8,
];

const MANTISSA: u32 = f64::MANTISSA_DIGITS - 1;

/// Added to a much smaller number, this leaves that number, rounded to an integer, in the last bits.
const TO_INTEGER: f64 = 1.5 * (1_u64 << MANTISSA) as f64;

/// Added to any k, it gives a positive number.
const BIAS: u64 = 2048;

/// Whether a number from 0 on is whole; cheaper than by its fractional part.
pub fn is_whole(value: f64) -> bool {
    value as usize as f64 == value
}

/// `value^exponent`, both 0 or more. Quarters in the exponent are taken by square roots, which take less time.
pub fn power(value: f64, exponent: f64) -> f64 {
    let whole = exponent as usize;
    let part = match exponent - whole as f64 {
        0.25 => value.sqrt().sqrt(),
        0.5 => value.sqrt(),
        0.75 => value.sqrt() * value.sqrt().sqrt(),
        _ => return libm::pow(value, exponent),
    };
    (0..whole).fold(part, |power, _| power * value)
}

/// The k and `log m` of numbers `2^k m`. Processors overlap two short loops better than a long one.
#[inline(always)]
fn logarithms<const N: usize>(values: &[f64; N]) -> [[f64; N]; 2] {
    let [mut k, mut logarithms] = [[0.0; N]; 2];
    for i in 0..N {
        let bits = values[i].to_bits().wrapping_add(BIAS << MANTISSA);
        let biased = bits.wrapping_sub(FRAC_1_SQRT_2.to_bits()) >> MANTISSA;
        k[i] = f64::from_bits(TO_INTEGER.to_bits() | biased) - (TO_INTEGER + BIAS as f64);
        let m = f64::from_bits(bits.wrapping_sub(biased << MANTISSA));
        let s = (m - 1.0) / (m + 1.0);
        let z = s * s;
        let w = z * z;
        let [c0, c1, c2, c3, c4, c5, c6] = LOGARITHM;
        let series = z * (c0 + w * (c2 + w * (c4 + w * c6))) + w * (c1 + w * (c3 + w * c5));
        logarithms[i] = s * (2.0 + series);
    }
    [k, logarithms]
}

/// The `values`, finite and not negative, to an `exponent` between -1 and 1, with a relative error below 4e-16. Values
/// below the smallest normal number give 0; values that are not finite give arbitrary numbers.
#[inline(never)] // it is long, and called by several loops
pub fn powers<const N: usize>(values: &[f64; N], exponent: f64) -> [f64; N] {
    // The products of `high` with the k are exact.
    let high = f64::from_bits(exponent.to_bits() & !0xff_ffff);
    let (low, factor) = (exponent - high, exponent * LOG2_E);
    let [k, logarithms] = logarithms(values);
    let mut results = [0.0; N];
    for i in 0..N {
        let rest = k[i] * low + factor * logarithms[i];
        let rounded = (k[i] * high + rest) + TO_INTEGER;
        let x = ((k[i] * high - (rounded - TO_INTEGER)) + rest) * LN_2;
        let z = x * x;
        let w = z * z;
        let [c0, c1, c2, c3, c4] = EXPONENTIAL;
        let c = x - (z * (c0 + w * (c2 + w * c4)) + w * (c1 + w * c3));
        let power = 1.0 + 2.0 * x / (2.0 - c);
        let scaled = f64::from_bits(power.to_bits().wrapping_add(rounded.to_bits() << MANTISSA));
        results[i] = if values[i] >= f64::MIN_POSITIVE { scaled } else { 0.0 };
    }
    results
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_by_roots_are_those_of_libm() {
        for exponent in [-0.9, -1e-4, f64::MIN_POSITIVE, 1e-9, 0.1, 0.25, 0.3, 0.5, 0.7, 0.9, 1.0 - f64::EPSILON] {
            for k in -1022..1024 {
                let mantissa = 1.0 + 0.618_033_988_749_895 * f64::from(k + 1022) % 1.0;
                // Also on both sides of where k changes.
                let values = [1.0, mantissa, 2.0 * FRAC_1_SQRT_2, 2.0 - f64::EPSILON].map(|m| libm::scalbn(m, k));
                for (value, power) in values.into_iter().zip(powers(&values, exponent)) {
                    let expected = libm::pow(value, exponent);
                    assert!((power - expected).abs() <= 4e-16 * expected, "{value:e}^{exponent}: {power:e}");
                }
            }
            assert_eq!(powers(&[0.0, 1e-310, 1.0], exponent), [0.0, 0.0, 1.0]);
        }
    }
}
