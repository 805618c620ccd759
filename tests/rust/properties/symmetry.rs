//! Two runs that are equal by a symmetry of the equations.

use newtons_cradle::engine::{Chain, Engine};
use proptest::prelude::*;

use super::config;
use super::cradles::{ANY, Case, cradles, distance, ended_early, rigid};
use crate::runs::state;

/// The same cradle seen from behind.
fn mirrored(case: &Case) -> Case {
    let mut mirror = case.clone();
    let p = &mut mirror.p;
    for vector in [&mut p.mass_ratio, &mut p.length_ratio, &mut p.stiffness_ratio, &mut p.gap] {
        vector.reverse();
    }
    for vector in [&mut p.x_start, &mut p.v_start, &mut mirror.inputs.force] {
        vector.reverse();
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
    fn a_mirrored_or_later_start_gives_the_same_run(case in cradles(ANY), start in 0u32..1000) {
        mirrored_and_later_runs_are_the_same(&case, start.into())?;
    }

    #[test]
    fn a_mirrored_start_gives_the_same_run_of_rigid_balls(case in rigid()) {
        mirrored_and_later_runs_are_the_same(&case, 0.0)?;
    }
}
