//! Chains of equal free balls that touch, struck at one end: laws of their outcome, for any exponent.

use newtons_cradle::engine::Results;
use newtons_cradle::model::Parameters;
use proptest::prelude::*;

use super::config;
use super::cradles::{decades, distance, exponents};
use crate::runs::{run, state, struck_chain};

/// What is left when everything has come apart, by `time` (s).
struct Outcome {
    velocities: Vec<f64>,
    impulses: Vec<f64>,
    last_release: f64,
}

fn outcome(p: &Parameters, time: f64) -> Outcome {
    let n = p.balls();
    let engine = run(p, time);
    Outcome {
        velocities: state(&engine, n).1,
        impulses: (0..n - 1).map(|i| engine.impulse(i)).collect(),
        last_release: (0..n - 1).map(|i| engine.last_release(i)).fold(0.0, f64::max),
    }
}

proptest! {
    #![proptest_config(config(100))]

    /// Seen from the centre of mass of the strikers, and mirrored, s strikers on n - s balls are n - s strikers on s. A
    /// common velocity changes nothing else. Velocities scale with v, impulses with m v, times with
    /// `(m / (k v^(p-1)))^(1/(p+1))`.
    #[test]
    fn collisions_have_the_symmetries_of_their_equations(
        (n, strikers) in (2..=8usize).prop_flat_map(|n| (Just(n), 1..n)),
        exponent in exponents(),
        common in -10.0..10.0,
        (stiffness, overlap_ref) in (decades(-2.0, 14.0), decades(-8.0, 0.0)),
        (mass, velocity) in (decades(-3.0, 3.0), decades(-3.0, 1.0)),
    ) {
        let unit = outcome(&struck_chain(n, strikers, exponent), 200.0);
        let other = outcome(&struck_chain(n, n - strikers, exponent), 200.0);
        let expected: Vec<f64> = other.velocities.iter().rev().map(|v| 1.0 - v).collect();
        let off = distance(&unit.velocities, &expected);
        prop_assert!(off < 1e-11, "exchanged: off by {off:e}");

        let mut p = struck_chain(n, strikers, exponent);
        p.v_start.iter_mut().for_each(|v| *v += common);
        let moving = outcome(&p, 200.0);
        let velocities: Vec<f64> = moving.velocities.iter().map(|v| v - common).collect();
        let off = distance(&velocities, &unit.velocities).max(distance(&moving.impulses, &unit.impulses));
        prop_assert!(off < 1e-10, "moving: off by {off:e}");

        let mut p = struck_chain(n, strikers, exponent);
        (p.stiffness, p.overlap_ref, p.mass) = (stiffness, overlap_ref, mass);
        p.v_start.iter_mut().for_each(|v| *v *= velocity);
        let coefficient = stiffness * overlap_ref.powf(1.0 - exponent);
        let time = (mass / (coefficient * velocity.powf(exponent - 1.0))).powf(1.0 / (exponent + 1.0));
        let scaled = outcome(&p, 200.0 * time);
        let velocities: Vec<f64> = scaled.velocities.iter().map(|v| v / velocity).collect();
        let impulses: Vec<f64> = scaled.impulses.iter().map(|j| j / (mass * velocity)).collect();
        let off = distance(&velocities, &unit.velocities).max(distance(&impulses, &unit.impulses));
        prop_assert!(off < 1e-11, "scaled: off by {off:e}");
        // Balls that part slowly part at a time as unclear.
        let slowest = unit.velocities.windows(2).map(|v| v[1] - v[0]).fold(1.0, f64::min).max(f64::EPSILON);
        let off = (scaled.last_release / time - unit.last_release).abs();
        prop_assert!(off < 1e-12 + 1e-13 / slowest, "time off by {off:e}, slowest {slowest:e}");
    }
}
