//! Finite numbers of any magnitude, for the fuzz targets.

/// From the smallest double to the largest, with numbers whose products and squares are in range, and others.
const EXTREMES: [f64; 16] = [
    5e-324,
    1e-310,
    1e-300,
    1e-200,
    1e-150,
    1e-100,
    1e-30,
    1e-12,
    1e8,
    2e11,
    1e30,
    1e100,
    1e150,
    1e200,
    1e300,
    f64::MAX,
];

/// One of [`EXTREMES`]; negative for odd codes.
pub fn extreme(code: u8) -> f64 {
    let sign = if code.is_multiple_of(2) { 1.0 } else { -1.0 };
    sign * EXTREMES[usize::from(code / 2) % EXTREMES.len()]
}
