//! Integrals of smooth functions.

/// Abscissas in (0, 1) and weights of the ten-point Gauss-Legendre rule on [-1, 1] (Abramowitz and Stegun, table 25.4).
const RULE: [(f64, f64); 5] = [
    (0.148_874_338_981_631_22, 0.295_524_224_714_752_87),
    (0.433_395_394_129_247_2, 0.269_266_719_309_996_35),
    (0.679_409_568_299_024_4, 0.219_086_362_515_982_04),
    (0.865_063_366_688_984_5, 0.149_451_349_150_580_6),
    (0.973_906_528_517_171_7, 0.066_671_344_308_688_14),
];

/// The same of the sixteen-point rule, which integrates polynomials of degree 31.
pub const SIXTEEN: [(f64, f64); 8] = [
    (0.095_012_509_837_637_44, 0.189_450_610_455_068_5),
    (0.281_603_550_779_258_9, 0.182_603_415_044_923_58),
    (0.458_016_777_657_227_37, 0.169_156_519_395_002_54),
    (0.617_876_244_402_643_8, 0.149_595_988_816_576_74),
    (0.755_404_408_355_003, 0.124_628_971_255_533_88),
    (0.865_631_202_387_831_8, 0.095_158_511_682_492_79),
    (0.944_575_023_073_232_6, 0.062_253_523_938_647_894),
    (0.989_400_934_991_649_9, 0.027_152_459_411_754_096),
];

/// Integral of `f` over `[a, b]`, the interval split into `panels` equal parts (at least 1).
///
/// Exact to rounding where `f` varies little on a panel, for instance by a quarter of a wave.
pub fn gauss_legendre(f: impl Fn(f64) -> f64, a: f64, b: f64, panels: usize) -> f64 {
    let half = 0.5 * (b - a) / panels as f64;
    let panel = |p: usize| {
        let middle = a + (2 * p + 1) as f64 * half;
        RULE.iter().map(|&(x, w)| w * (f(middle - half * x) + f(middle + half * x))).sum::<f64>()
    };
    half * (0..panels).map(panel).sum::<f64>()
}

#[cfg(test)]
mod tests {
    #[test]
    fn integrates_a_wave() {
        let integral = super::gauss_legendre(|t| libm::sin(t).powi(2), 0.0, std::f64::consts::PI, 2);
        assert!((integral - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    }

    #[test]
    fn sixteen_points_integrate_polynomials() {
        for degree in (0..=30).step_by(2) {
            let sum: f64 = super::SIXTEEN.iter().map(|(x, weight)| 2.0 * weight * x.powi(degree)).sum();
            assert!((sum - 2.0 / f64::from(degree + 1)).abs() < 1e-15, "degree {degree}: {sum}");
        }
    }
}
