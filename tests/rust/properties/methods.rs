//! The method of Adams on the cradles of the engine.

use newtons_cradle::engine::Simulation;
use newtons_cradle::model::{Parameters, SolverMethod};
use proptest::prelude::*;

use super::config;
use super::cradles::{ANY, Case, Family, cradles, distance, ended_early};
use crate::runs::{energy, state};

/// Errors grow with every click; after this many a comparison is still meaningful.
const CLICKS: usize = 10;

/// Where the largest displacement and speed of a run are looked for.
const POINTS: usize = 20;

/// To ten digits of the largest displacement and nine of the largest speed, fewer only where the result depends that
/// much on the rounding of the start. Adams's method ignores where forces are not analytic; its error falls with its
/// tolerance. BDF at a hundred times the tolerance, to six digits; both energy balances hold.
pub fn agrees_with_adams(mut case: Case) -> Result<(), TestCaseError> {
    let (_, pulses) = case.run()?;
    prop_assume!(!pulses.is_empty());
    case.time = pulses.get(CLICKS).map_or(case.time, |pulse| pulse.release);
    let n = case.p.balls();
    let own = case.state()?;
    let (spread, (own_x, own_v)) = (case.spread(&own)?, own);
    for (method, tolerance, parts) in
        [(SolverMethod::Adams, 1e-12, [1e-10, 1e-9]), (SolverMethod::Bdf, 1e-10, [1e-6, 1e-6])]
    {
        let p = Parameters { method, tolerance, ..case.p.clone() };
        let mut run = Simulation::new(&p, &case.inputs, 0.0).map_err(ended_early)?;
        let (mut x, mut v, mut most, before) = (Vec::new(), Vec::new(), [0.0; 2], run.total_energy());
        for point in 1..=POINTS {
            run.advance(case.time * point as f64 / POINTS as f64, &mut Vec::new()).map_err(ended_early)?;
            (x, v) = state(&*run, n);
            most = [largest(&x).max(most[0]), largest(&v).max(most[1])];
        }
        for (truth, own, most, spread, part) in
            [(x, &own_x, most[0], spread.0, parts[0]), (v, &own_v, most[1], spread.1, parts[1])]
        {
            let (off, allowed) = (distance(own, &truth), part * (most + spread / f64::EPSILON));
            prop_assert!(off <= allowed, "{own:?}, not {truth:?}: {method:?} off by {off:e}, {allowed:e} allowed");
        }
        let residual = run.energy_residual().abs() / energy(&*run).max(before);
        prop_assert!(residual <= 1e5 * tolerance, "{method:?}: energy off by {residual:e}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(40))]

    #[test]
    fn adams_follows_random_powers_as_the_engine_does(case in cradles(Family { powers: true, ..ANY })) {
        agrees_with_adams(case)?;
    }
}

fn largest(values: &[f64]) -> f64 {
    distance(values, &vec![0.0; values.len()])
}
