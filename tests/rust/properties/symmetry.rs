//! Runs that are equal by a symmetry of the equations: of any cradle, and of equal free balls that touch, struck at one
//! end.

use newtons_cradle::engine::{Chain, Engine, Results};
use newtons_cradle::model::Parameters;
use proptest::prelude::*;

use super::config;
use super::cradles::{ANY, Case, cradles, decades, distance, ended_early, exponents, rigid};
use crate::runs::{run, state, struck_chain};

/// The same cradle seen from behind.
fn mirrored(case: &Case) -> Case {
    let mut mirror = case.clone();
    let p = &mut mirror.p;
    p.vectors_mut().into_iter().chain([&mut mirror.inputs.force]).for_each(|vector| vector.reverse());
    for vector in [&mut p.x_start, &mut p.v_start, &mut mirror.inputs.force] {
        vector.iter_mut().for_each(|value| *value = -*value);
    }
    mirror.inputs.support_acceleration = -mirror.inputs.support_acceleration;
    mirror
}

/// Positions and velocities.
type State = (Vec<f64>, Vec<f64>);

/// Checks that the balls are where they are expected, to what the rounding of the start allows.
fn assert_same(got: &State, expected: &State, spread: (f64, f64)) -> Result<(), TestCaseError> {
    let scale = |values: &[f64]| values.iter().fold(1e-3, |most: f64, value| most.max(value.abs()));
    let allowed = (1e-11 * scale(&expected.0), 1e-11 * scale(&expected.1));
    let (dx, dv) = (distance(&got.0, &expected.0), distance(&got.1, &expected.1));
    prop_assert!(dx <= allowed.0 + 100.0 * spread.0, "x off by {dx:e}, spread {:e}", spread.0);
    prop_assert!(dv <= allowed.1 + 100.0 * spread.1, "v off by {dv:e}, spread {:e}", spread.1);
    Ok(())
}

/// A run from the mirrored start, and one that starts later (s), are those of the case.
fn mirrored_and_later_runs_are_the_same(case: &Case, start: f64) -> Result<(), TestCaseError> {
    let expected = case.state()?;
    let spread = case.spread(&expected)?;
    prop_assume!(spread.0 < 1e-9 && spread.1 < 1e-9);
    let (mut x, mut v) = mirrored(case).state()?;
    for vector in [&mut x, &mut v] {
        vector.reverse();
        vector.iter_mut().for_each(|value| *value = -*value);
    }
    assert_same(&(x, v), &expected, spread)?;
    let mut engine = Engine::new(&case.p, &case.inputs, start).map_err(ended_early)?;
    engine.advance(start + case.time, &mut Vec::new()).map_err(ended_early)?;
    // The time itself is rounded at the later date.
    let late = 1e-3f64.max(start) * f64::EPSILON;
    let n = case.p.balls();
    let fastest = expected.1.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let rate = (0..n).map(|i| engine.a(i).abs()).fold(0.0, f64::max);
    let spread = (spread.0 + late * fastest, spread.1 + late * rate);
    assert_same(&state(&engine, n), &expected, spread)
}

proptest! {
    #![proptest_config(config(300))]

    #[test]
    fn symmetry_of_mirrored_and_later_starts(case in cradles(ANY), start in 0u32..1000) {
        mirrored_and_later_runs_are_the_same(&case, start.into())?;
    }

    #[test]
    fn symmetry_of_mirrored_starts_of_rigid_balls(case in rigid()) {
        mirrored_and_later_runs_are_the_same(&case, 0.0)?;
    }
}

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
    fn symmetry_of_collisions_in_scale_and_time(
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
