//! Hertz contacts of unlike spheres against closed forms (K. L. Johnson, Contact Mechanics, 1985, sections 4.2 and
//! 11.4).

use newtons_cradle::engine::{Chain, Pulse, Results};
use newtons_cradle::model::Parameters;

use crate::runs::{cradle, run, started, state, touching};

/// Two spheres, each with its radius (m), Young's modulus (Pa) and mass (kg).
struct Pair([[f64; 3]; 2]);

/// Steel on steel, on lead, on a small ball of glass, and balls that differ by nine powers of ten.
const PAIRS: [Pair; 4] = [
    Pair([[0.0313, 2.1e11, 1.0], [0.0313, 2.1e11, 1.0]]),
    Pair([[0.011, 2.1e11, 0.0438], [0.011, 1.6e10, 0.0632]]),
    Pair([[0.02, 2.1e11, 0.263], [0.004, 7e10, 6.7e-4]]),
    Pair([[1e-6, 3e9, 5e-15], [2e3, 4e12, 9e13]]),
];

const POISSON: f64 = 0.3;
const GAP: f64 = 1e-4;

impl Pair {
    /// Free and [`GAP`] apart, the left one with the velocity `v` (m/s).
    fn at(&self, v: f64) -> Parameters {
        let Self([left, right]) = self;
        let mut p = touching(2, &format!("gravity=0 contact.model=hertz ball.poissonRatio={POISSON}"));
        (p.gap, p.v_start) = (vec![GAP], vec![v, 0.0]);
        [p.radius, p.young_modulus, p.mass] = *left;
        let ratios = [&mut p.radius_ratio, &mut p.young_modulus_ratio, &mut p.mass_ratio];
        ratios.into_iter().enumerate().for_each(|(k, ratio)| ratio[1] = right[k] / left[k]);
        p
    }

    /// `R*` (m), `E*` (Pa) and the reduced mass (kg).
    fn reduced(&self) -> [f64; 3] {
        let Self([left, right]) = self;
        let harmonic = |k: usize| 1.0 / (1.0 / left[k] + 1.0 / right[k]);
        [harmonic(0), harmonic(1) / (1.0 - POISSON * POISSON), harmonic(2)]
    }
}

/// The only pulse of a run until `time` (s).
fn pulse(p: &Parameters, time: f64) -> Pulse {
    let (mut engine, mut pulses) = (started(p), Vec::<Pulse>::new());
    engine.advance(time, &mut pulses).unwrap();
    assert_eq!(pulses.len(), 1);
    pulses[0]
}

#[test]
fn spheres_impacts_have_the_peak_and_the_duration_of_hertz() {
    let off = |found: f64, expected: f64| (found / expected - 1.0).abs();
    for pair in &PAIRS {
        for v in [1e-6, 0.05, 0.7, 10.0] {
            let [radius, modulus, mass] = pair.reduced();
            // Equations 11.23 and 11.24, whose factor is rounded to 2.94 there.
            let deepest = libm::pow(15.0 * mass * v * v / (16.0 * radius.sqrt() * modulus), 0.4);
            let factor = 0.8 * std::f64::consts::PI.sqrt() * libm::tgamma(0.4) / libm::tgamma(0.9);
            let duration = factor * deepest / v;
            let peak = 4.0 / 3.0 * modulus * radius.sqrt() * deepest * deepest.sqrt();
            let Pulse { onset, release, peak: found, impulse, .. } = pulse(&pair.at(v), 3.0 * GAP / v + 2.0 * duration);
            assert!(off(onset, GAP / v) < 1e-15, "onset {onset} at {v} m/s");
            assert!(off(found.force, peak) < 1e-13, "peak {found:?}, not {peak}, at {v} m/s");
            // Half way, as a difference of two times of the size of the onset.
            let half = found.time - onset - 0.5 * duration;
            assert!(half.abs() < 1e-13 * duration + f64::EPSILON * release, "{found:?}");
            // The difference of two times of the size of the onset.
            let allowed = 1e-13 * duration + f64::EPSILON * release;
            assert!((release - onset - duration).abs() < allowed, "{} s, not {duration} s", release - onset);
            assert!(off(impulse, 2.0 * mass * v) < 1e-13, "impulse {impulse} at {v} m/s");
        }
    }
}

/// However radii and moduli are shared between the common value and the ratios, in powers of two.
#[test]
fn spheres_of_equal_size_keep_their_bits() {
    for pendulum in ["linear", "circular"] {
        let text = format!("contact.model=hertz contact.deadBand=0 pendulum.model={pendulum}");
        let plain = cradle(5, &text);
        let mut shared = plain.clone();
        (shared.radius, shared.radius_ratio) = (plain.radius / 4.0, vec![4.0; 5]);
        (shared.young_modulus, shared.young_modulus_ratio) = (plain.young_modulus * 8.0, vec![0.125; 5]);
        let [plain, shared] = [plain, shared].map(|p| run(&p, 3.0));
        assert_eq!(state(&plain, 5), state(&shared, 5), "{pendulum}");
        assert!(plain.pulses(0) > 1);
        assert_eq!(plain.total_energy().to_bits(), shared.total_energy().to_bits());
    }
}

/// Pivots are the two radii and the gap apart, whatever the contacts: hanging balls are apart by the gap, and one that
/// is lifted by a right-angled triangle.
#[test]
fn spheres_pivots_are_as_far_apart_as_their_radii() {
    let radii = [0.02, 0.005, 0.03];
    for model in ["powerLaw", "hertz", "rigid"] {
        let text = "pendulum.model=circular pendulum.length=0.5 x_start=-0.3,0,0 contact.deadBand=0 contact.gap=0,1e-3";
        let mut p = cradle(3, &format!("{text} contact.model={model}"));
        (p.radius, p.radius_ratio) = (radii[0], radii.iter().map(|radius| radius / radii[0]).collect());
        let engine = started(&p);
        // 3, 4, 5: the left ball is 0.1 m higher.
        let lifted = radii[0] + radii[1] - (radii[0] + radii[1] + 0.3).hypot(0.1);
        assert!((engine.overlap(0) - lifted).abs() < 1e-15, "{model}: {}", engine.overlap(0));
        assert!((engine.overlap(1) + 1e-3).abs() < 1e-17, "{model}: {}", engine.overlap(1));
    }
}
