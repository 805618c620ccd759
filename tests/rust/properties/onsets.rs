//! No onset is missed or invented: grazing contacts, contacts that are closed or about to close at the start.

use newtons_cradle::engine::{Chain, Forecast, NEVER, Results, Unrecorded};
use newtons_cradle::model::{Inputs, Parameters};
use proptest::prelude::*;

use super::config;
use super::cradles::{ANY, Case, cradles, decades, ended_early, exponents};
use crate::runs::{assert_energy, energy, run_under, started};

/// Position of ball `i` at `t` as long as it touches nothing: undamped, under constant inputs.
fn flight(case: &Case, i: usize, t: f64) -> f64 {
    let (p, mass) = (&case.p, case.p.mass * case.p.mass_ratio[i]);
    let push = case.inputs.force[i] / mass - case.inputs.support_acceleration;
    let (x, v, omega) = (p.x_start[i], p.v_start[i], (p.gravity / (p.length * p.length_ratio[i])).sqrt());
    if omega == 0.0 {
        return x + v * t + 0.5 * push * t * t;
    }
    let rest = push / (omega * omega);
    rest + (x - rest) * (omega * t).cos() + v / omega * (omega * t).sin()
}

proptest! {
    #![proptest_config(config(400))]

    /// The first onset is where a search through the closed form finds the first overlap, and t_next is that time.
    #[test]
    fn onset_is_the_first_overlap(mut case in cradles(ANY)) {
        case.p.drag = 0.0;
        let n = case.p.balls();
        let apart = |i: usize| case.p.gap[i] + case.p.dead_band;
        let overlap = |i: usize, t: f64| flight(&case, i, t) - flight(&case, i + 1, t) - apart(i);
        // Where nothing is in touch at the start, so that it is clear what comes first.
        prop_assume!((0..n - 1).all(|i| overlap(i, 0.0) < -1e-12));
        let mut engine = case.start()?;
        // Look by look, if one does not show it.
        while !engine.next_onset().is_settled() && engine.next_onset().time() < case.time {
            let next = engine.next_onset().time();
            prop_assert!(next > engine.time());
            engine.advance(next, &mut Vec::new()).map_err(ended_early)?;
            prop_assert!((0..n - 1).all(|i| engine.pulses(i) == 0 || engine.last_onset(i) == next));
        }
        let foretold = engine.next_onset().time();
        let samples = 20_000;
        let found = (0..=samples)
            .map(|k| case.time * f64::from(k) / f64::from(samples))
            .find(|&t| (0..n - 1).any(|i| overlap(i, t) > 1e-13));
        if let Some(found) = found {
            prop_assert!(foretold <= found, "foretold {foretold}, found {found}");
        }
        if foretold <= case.time {
            let largest = (0..n - 1).map(|i| overlap(i, foretold)).fold(f64::NEG_INFINITY, f64::max);
            prop_assert!(largest.abs() < 1e-14, "overlap {largest:e} at {foretold}");
            engine.advance(foretold, &mut Vec::new()).map_err(ended_early)?;
            let onsets: u64 = (0..n - 1).map(|i| engine.pulses(i)).sum();
            prop_assert!(onsets >= 1);
            prop_assert!((0..n - 1).any(|i| (foretold - engine.last_onset(i)).abs() <= 1e-15 * foretold));
        }
    }

    /// A ball that swings up to its neighbour and just reaches it, or just does not.
    #[test]
    fn onset_of_grazing_balls_is_not_missed(
        amplitude in decades(-3.0, 0.0),
        depth in decades(-14.0, -2.0),
        touches in any::<bool>(),
        (stiffness, exponent) in (decades(3.0, 12.0), exponents()),
        mass in decades(-1.0, 1.0),
    ) {
        let mut p = Parameters::default_for(2);
        (p.stiffness, p.exponent, p.mass_ratio) = (stiffness, exponent, vec![1.0, mass]);
        p.x_start = vec![-amplitude, 0.0];
        let reach = amplitude * if touches { 1.0 - depth } else { 1.0 + depth };
        p.dead_band = reach;
        let mut engine = started(&p);
        let omega = (p.gravity / p.length).sqrt();
        let onset = libm::acos(-reach / amplitude) / omega;
        let foretold = engine.next_onset();
        let mut pulses = Vec::new();
        engine.advance(1.25 * std::f64::consts::PI / omega, &mut pulses).map_err(ended_early)?;
        if touches {
            prop_assert_eq!(engine.pulses(0), 1);
            prop_assert_eq!(pulses.len(), 1);
            // What rounding of the reach does to the time of the turning point.
            let unclear = 1e-15 / (2.0 * depth).sqrt() / omega + 1e-15;
            prop_assert!((engine.last_onset(0) - onset).abs() < 10.0 * unclear, "{} {onset}", engine.last_onset(0));
            prop_assert!((foretold.time() - engine.last_onset(0)).abs() <= f64::EPSILON * onset);
        } else {
            prop_assert_eq!((engine.pulses(0), foretold), (0, Forecast::Never));
        }
        prop_assert!(engine.energy_residual().abs() <= 1e-13 * engine.total_energy());
    }

    /// Contacts that are closed at the start are onsets then; those in touch and about to close are in the first step.
    #[test]
    fn onset_of_contacts_closed_at_the_start(
        mut case in cradles(ANY),
        overlaps in proptest::collection::vec(prop_oneof![2 => Just(0.0), 1 => decades(-12.0, -6.0)], 6),
    ) {
        (case.time, case.p.dead_band) = (0.1 * case.time, 0.0);
        case.p.gap.fill(0.0);
        let n = case.p.balls();
        case.p.x_start = (0..n).map(|i| -overlaps[..i].iter().sum::<f64>()).collect();
        let mut engine = case.start()?;
        let next = engine.next_onset();
        prop_assert!(next.time() > 0.0, "what is due now is not ahead");
        if next.is_settled() && next.time() < 1e3 {
            let mut later = engine.clone();
            later.advance(next.time(), &mut Unrecorded).unwrap();
            prop_assert!((0..n - 1).any(|i| later.last_onset(i) == next.time()), "{next:?}");
        }
        for i in 0..n - 1 {
            let overlap = case.p.x_start[i] - case.p.x_start[i + 1];
            prop_assert_eq!((engine.overlap(i), engine.in_contact(i)), (overlap, overlap > 0.0));
            let onset = (engine.pulses(i), engine.last_onset(i));
            prop_assert_eq!(onset, if overlap > 0.0 { (1, 0.0) } else { (0, -NEVER) }, "contact {}", i);
        }
        let touch_and_close = |i: &usize| {
            case.p.x_start[*i] == case.p.x_start[i + 1] && case.p.v_start[*i] > case.p.v_start[i + 1]
        };
        let start = engine.total_energy();
        engine.advance(1e-12, &mut Vec::new()).map_err(ended_early)?;
        for i in (0..n - 1).filter(touch_and_close) {
            prop_assert_eq!((engine.pulses(i), engine.last_onset(i)), (1, 0.0), "contact {}", i);
        }
        engine.advance(case.time, &mut Vec::new()).map_err(ended_early)?;
        let scale = start + energy(&engine);
        prop_assert!(engine.energy_residual().abs() <= 2e-13 * scale, "{:e}", engine.energy_residual() / scale);
    }
}

/// Three balls side by side that differ by rounding swing into a fourth: whether they are in touch then, their rates do
/// not tell.
#[test]
fn onset_of_balls_parted_by_rounding_does_not_stall() {
    let mut p = Parameters::default_for(4);
    (p.gravity, p.length) = (8.098359547511615, 1.0307861065392323);
    (p.stiffness, p.exponent, p.dead_band) = (1e5, 1.5, 0.0);
    p.x_start = vec![1.865174681370263e-17, 1.865174681370263e-17, -1.865174681370263e-17, 0.0019207991338309033];
    let inputs = Inputs { support_acceleration: -0.4507034507614346, ..Inputs::zero(4) };
    let engine = run_under(&p, &inputs, 2.0);
    assert_energy(&engine, 1e-13, "four balls");
    assert!(engine.pulses(2) > 2);
}
