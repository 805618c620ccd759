//! The methods that integrate the whole chain, on the cradles of the engine.

use newtons_cradle::engine::Simulation;
use newtons_cradle::model::{Parameters, SolverMethod};
use proptest::prelude::*;

use super::config;
use super::cradles::{ANY, Case, Family, cradles, distance, ended_early};

const TOLERANCE: f64 = 1e-10;

/// The balances hold, and the end is where the engine says as far as the cradle can tell.
fn agrees(case: &Case, method: SolverMethod) -> Result<(), TestCaseError> {
    let n = case.p.balls();
    let p = Parameters { method, tolerance: TOLERANCE, ..case.p.clone() };
    let mut run = Simulation::new(&p, &case.inputs, 0.0).map_err(ended_early)?;
    let (energy, momentum) = (run.total_energy(), run.momentum());
    run.advance(case.time, &mut Vec::new()).map_err(ended_early)?;

    let scale = energy.max(run.total_energy()) + run.dissipated_energy() + run.external_work().abs();
    prop_assert!(
        run.energy_residual().abs() <= 1e5 * TOLERANCE * scale,
        "energy off by {:e}",
        run.energy_residual() / scale
    );

    let pushed = (case.inputs.force.iter().sum::<f64>() - case.inputs.support_acceleration * case.mass()) * case.time;
    let from_support = run.support_force_mean() * case.time;
    let off = run.momentum() - momentum - pushed + from_support;
    let scale = case.mass() * (2.0 * scale / case.mass()).sqrt() + pushed.abs() + from_support.abs();
    prop_assert!(off.abs() <= 1e3 * TOLERANCE * scale, "momentum off by {:e}", off / scale);

    // Errors of the tolerance grow as those of epsilon do; speeds are of the order of 1 m/s.
    let allowed = |spread: f64| 1e4 * TOLERANCE * (1.0 + spread / f64::EPSILON);
    let ((x, v), spread) = (case.state()?, case.spread()?);
    let (own_x, own_v): (Vec<f64>, Vec<f64>) = (0..n).map(|i| (run.x(i), run.v(i))).unzip();
    prop_assert!(distance(&x, &own_x) <= allowed(spread.0), "{own_x:?}, not {x:?}: {spread:?}");
    prop_assert!(distance(&v, &own_v) <= allowed(spread.1), "{own_v:?}, not {v:?}: {spread:?}");
    Ok(())
}

proptest! {
    #![proptest_config(config(100))]

    #[test]
    fn adams_agrees_with_the_engine(case in cradles(ANY)) {
        agrees(&case, SolverMethod::Adams)?;
    }

    #[test]
    fn bdf_agrees_with_the_engine(case in cradles(ANY)) {
        agrees(&case, SolverMethod::Bdf)?;
    }
}

/// Balls click on and on, and errors grow with every click: after so many a comparison still tells something.
const CLICKS: usize = 10;

/// Where the largest displacement and speed of a run are looked for.
const POINTS: usize = 20;

/// To ten digits of the largest displacement and nine of the largest speed, and less only where the result depends that
/// much on the rounding of the start. Adams's method knows nothing of where forces are not analytic; what it is off by
/// goes down with its tolerance.
pub fn agrees_with_adams(mut case: Case) -> Result<(), TestCaseError> {
    let (_, pulses) = case.run()?;
    prop_assume!(!pulses.is_empty());
    case.time = pulses.get(CLICKS).map_or(case.time, |pulse| pulse.release);
    let n = case.p.balls();
    let p = Parameters { method: SolverMethod::Adams, tolerance: 1e-12, ..case.p.clone() };
    let mut run = Simulation::new(&p, &case.inputs, 0.0).map_err(ended_early)?;
    let (mut x, mut v, mut most) = (Vec::new(), Vec::new(), [0.0; 2]);
    for point in 1..=POINTS {
        run.advance(case.time * point as f64 / POINTS as f64, &mut Vec::new()).map_err(ended_early)?;
        (x, v) = (0..n).map(|i| (run.x(i), run.v(i))).unzip();
        most = [largest(&x).max(most[0]), largest(&v).max(most[1])];
    }
    let ((own_x, own_v), spread) = (case.state()?, case.spread()?);
    for (truth, own, most, spread, part) in [(x, own_x, most[0], spread.0, 1e-10), (v, own_v, most[1], spread.1, 1e-9)]
    {
        let (off, allowed) = (distance(&own, &truth), part * (most + spread / f64::EPSILON));
        prop_assert!(off <= allowed, "{own:?}, not {truth:?}: off by {off:e}, {allowed:e} allowed");
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(40))]

    #[test]
    fn powers_are_followed_as_by_adams(case in cradles(Family { powers: true, ..ANY })) {
        agrees_with_adams(case)?;
    }
}

fn largest(values: &[f64]) -> f64 {
    distance(values, &vec![0.0; values.len()])
}
